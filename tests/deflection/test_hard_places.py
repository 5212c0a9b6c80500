"""Replans where travel ends, the feed changes or cannot be kept, a run begins, or nothing is limited."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
import toolpace.machine
from testbed import replans
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.deflection.feed import sampled_feed_use
from toolpace.deflection.rejoin.stop import StopAlone, StopTogether
from toolpace.deflection.rejoin_motion import CommandedMotion, RejoinMotion

BUILTIN = Path(toolpace.machine.__file__).parent / "builtin"
HEAD = "%\nO1\nG21 G90 G94 G17 G40 G49 G80\nG54\nG43.4 H1\n"


def planned(text: str, machine: tp.Machine) -> tp.Trajectory:
    toolpath = tp.read_text(f"{HEAD}{text}M30\n%\n", machine, controller="fanuc")
    return tp.plan(tp.Path.fit(toolpath, machine=machine), machine, bound=False)


def tip_at(trajectory: tp.Trajectory, time: float, *aside: float) -> np.ndarray:
    return trajectory.tip([time])[0][0] + np.array(aside or (0.0, 0.0, 0.0))


@pytest.mark.parametrize("size", [1e-4, 2e-3])
def test_a_bending_that_would_lead_out_of_travel_is_refused_with_its_joint(size: float):
    text = (BUILTIN / "xyzac-trunnion.toml").read_text(encoding="utf-8")
    joint = text.index("[joints.X]")
    text = text[:joint] + re.sub(r"travel = \[([^,]*),[^\]]*\]", r"travel = [\1, 30.001]", text[joint:], count=1)
    machine = tp.Machine.from_toml(text)
    trajectory = planned("G0 X0 Y0 Z5 A0 C0\nG1 X5 Y1 F3000\nX10 Y3\nX20 Y0\nX30 Y5\n", machine)
    with pytest.raises(InfeasibleError, match=r"leaves the travel: .*joint X"):
        tp.replan(trajectory, 0.2, tip_at(trajectory, 0.2, -size, 0.0, 0.0), machine, cause="bending")
    inward = tp.replan(trajectory, 0.2, tip_at(trajectory, 0.2, size, 0.0, 0.0), machine, cause="bending")
    assert inward.at(np.linspace(0.0, inward.duration, 2000)).q[:, 0].max() < 30.001e-3


@pytest.mark.parametrize("later", [1e-7, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("cause", ["displaced", "bending"])
def test_a_place_just_behind_the_start_leaves_all_of_the_run_to_come(later: float, cause: str):
    old = replans.planned("arc", 6000.0)
    tip = tip_at(old, 0.0, 1e-6, 0.0, 2e-6)
    place = float(old.parameter([later])[0])
    new = tp.replan(old, 0.0, tip, replans.machine_of("arc"), cause=cause, rejoin=place)
    assert new.duration > old.duration - later
    assert new.at(new.duration).q == pytest.approx(old.at(old.duration).q, abs=1e-5)


SLOW_TURNS = [
    ("xyzbc-table", "BC", 60.0, 0.02, 10.0, 2.0835631847581695, [2.17042e-05, 0.000171248, -5.70126e-05]),
    ("xyzac-trunnion", "AC", 60.0, 0.02, 10.0, 0.4259251694327879, [-0.000114336, 0.000293819, -0.000126075]),
    ("xyzbc-nutating", "BC", 300.0, 0.05, 12.0, 0.5625806311997023, [-0.000408983, 0.00393075, 0.000494447]),
]
"""Machine, rotary axes, feed [mm/min], step [mm] and swing [deg] of a program; when the tool is found aside [m]."""


@pytest.mark.parametrize(("name", "rotary", "feed", "step", "swing", "time", "aside"), SLOW_TURNS)
def test_a_tool_that_is_carried_faster_than_its_feed_has_a_way_back(name, rotary, feed, step, swing, time, aside):
    """On a table that turns, at a feed so slow that no motion of the joints can hold it: by positions."""
    lines = [f"G0 X0 Y0 Z5 {rotary[0]}0 {rotary[1]}0"]
    for i in range(1, 80):
        lines.append(
            f"G1 X{step * i:.4f} Y{step * np.sin(i * 0.3):.4f} Z5 {rotary[0]}{swing * np.sin(i * 0.2):.4f}"
            f" {rotary[1]}{swing * np.sin(i * 0.27):.4f} F{feed:g}"
        )
    machine = tp.Machine.load(name)
    old = planned("\n".join(lines) + "\n", machine)
    new = tp.replan(old, time, tip_at(old, time, *aside), machine)
    assert re.match(r"start above feed by \d", new.notes[0])
    _, until = new.axis_path.runs[0].above
    step_of_time = 1e-4
    t = np.linspace(until, new.duration - step_of_time, 3000)
    moved = machine.forward(new.at(t + step_of_time).q)[0] - machine.forward(new.at(t).q)[0]
    assert np.linalg.norm(moved, axis=1).max() / step_of_time <= 1.0002 * feed / 60e3
    for order, kind in enumerate(("velocity", "acceleration", "jerk"), start=1):
        t = np.linspace(0.0, new.duration - 3e-3, 4000)
        change = np.diff(np.stack([new.at(t + 1e-3 * k).q for k in range(order + 1)]), order, axis=0)[0]
        assert (np.abs(change) <= 1e-3**order * 1.0002 * getattr(machine.limits, kind) + 1e-14).all()
    assert new.at(new.duration).q == pytest.approx(old.at(old.duration).q, abs=1e-9)


@dataclass(frozen=True, eq=False)
class Behind(RejoinMotion):
    """The commanded motion itself, said to be ahead of where it is."""

    commanded: CommandedMotion
    ahead: float
    times: np.ndarray
    left: float = 0.0
    rejoin: float = 0.0

    def clock(self, t):
        return t + self.ahead

    def motion(self, t):
        return self.commanded.motion(t)


@pytest.mark.parametrize("ahead", [0.01, 0.03, -0.02])
def test_the_feed_is_looked_at_where_it_changes_between_two_looks(ahead: float):
    """Against ten thousand looks: eight a step, of which each is longer than a block, would see nothing."""
    machine = tp.Machine.load("xyzbc-head")
    old = planned("".join(f"G1 X{2 * k} Y0 Z0 B0 C0 F{(3000, 600)[k % 2]}\n" for k in range(9)), machine)
    rejoin = Behind(CommandedMotion.of(old, 0), ahead, np.array([0.0, 0.6, 0.9]))
    t = np.linspace(0.0, 0.9, 10001)
    blocks = old.axis_path.runs[0].block_at(rejoin.abreast(t))
    feed = np.array([(3000.0, 600.0)[(line - 6) % 2] for line in blocks]) / 60e3
    seen = np.linalg.norm(np.diff(old.tip(t)[0], axis=0), axis=1) / np.diff(t) / feed[1:]
    assert sampled_feed_use(rejoin, machine)[1].max() == pytest.approx(seen.max(), rel=0.02)


def test_a_follower_refuses_a_motion_that_begins_on_its_way():
    old, machine = replans.planned("arc", 6000.0), replans.machine_of("arc")
    time = 0.5 * old.duration
    new = tp.replan(old, time, tip_at(old, time, 1e-4, 0.0, 0.0), machine)
    with pytest.raises(UsageError, match="begins in motion"):
        tp.Follower(new, machine)


@pytest.mark.parametrize("kind", [StopAlone, StopTogether])
@pytest.mark.parametrize("most", [(np.inf, 5.0), (np.inf, np.inf)])
@pytest.mark.filterwarnings("error")
def test_joints_without_limits_are_stopped_without_a_jump(kind, most):
    start = np.array([[0.0, 0.0], [0.3, 0.3], [0.0, 0.0]])
    limits = tp.Limits([most[0]] * 2, [most[1]] * 2, [50.0, 50.0])
    stop = kind(start, limits, 0.0)
    t = np.linspace(0.0, stop.duration, 2001)
    q = stop.motion(t)[0]
    speed = np.diff(q, axis=0) / np.diff(t)[:, None]
    assert speed[0] == pytest.approx(start[1], rel=1e-3) and np.abs(speed[-1]).max() < 1e-3
    assert np.abs(np.diff(speed, 2, axis=0)).max() / (t[1] - t[0]) ** 2 < 50.5
