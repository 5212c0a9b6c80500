"""What a detour uses of limits, feed and travel, against all of its times looked at one by one."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from toolpace.axispath.quintic import quintic_through
from toolpace.deflect.commanded import CommandedMotion
from toolpace.deflect.detour import DetourRun
from toolpace.deflect.feasibility import IN_TRAVEL, Feasibility
from toolpace.deflect.feed import FeedExcess, tip_velocity
from toolpace.machine.limits import KINDS
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.planning.guarantee import DETOUR
from toolpace.planning.planner import plan

MACHINE = Machine.load("paper-ab")


@cache
def motion():
    return plan(quintic_through(Path.paper_arc(), MACHINE), MACHINE, mesh=200, bound=False)


def a_detour(seed, *, feed=None, machine=MACHINE):
    """Feasibility of a random deflection of the joints, by a millimetre or milliradian, and a way back from it."""
    random = np.random.default_rng(seed)
    trajectory = motion()
    time = random.uniform(0.2, 0.6) * trajectory.duration
    offset = random.normal(size=5) * 1e-3
    found = Feasibility(CommandedMotion.of(trajectory, 0), trajectory.limits, machine, time, offset)
    if feed is not None:
        found.feed, found.excess = feed, FeedExcess(feed, 0.0, 0.0)
    carry = random.choice([0.0, random.uniform(0.0, 0.05)])
    period = random.uniform(0.1, 0.4)
    return found, found.detour(carry, period, time + random.uniform(0.8, 1.2) * (carry + period))


def all_of(detour, samples=20001):
    t = np.linspace(0.0, detour.duration, samples)
    return t, detour.motion(t)


@pytest.mark.parametrize("seed", range(8))
def test_usage_of_the_joints_is_that_of_all_times_of_the_quintic(seed):
    found, detour = a_detour(seed)
    t, q = all_of(detour)
    later = t >= detour.carry
    shares = [np.abs(value[later]) / getattr(motion().limits, kind) for value, kind in zip(q[1:], KINDS)]
    told = float(found.joint_usage(detour.carry, np.array([detour.rejoin]), np.array([detour.period]))[0])
    assert told == pytest.approx(max(share.max() for share in shares), rel=1e-3)


@pytest.mark.parametrize("seed", range(12))
def test_usage_of_the_feed_is_that_of_all_times(seed):
    """Where the tip is fastest may lie between samples; a parabola through three of them tells it."""
    feed = 0.05
    found, detour = a_detour(seed, feed=feed)
    _, q = all_of(detour)
    fastest = np.linalg.norm(tip_velocity(MACHINE, q[0], q[1]), axis=1).max()
    assert found.path_usage(detour) == pytest.approx(fastest / feed, rel=1e-5)


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("joint", range(5))
def test_a_joint_may_go_to_the_end_of_its_travel_and_no_further(joint, end):
    """The way back of a joint whose travel ends where it is found, and a micrometre or microradian before that."""
    narrow = Machine.from_toml(MACHINE.to_toml(), "narrow")
    _, probe = a_detour(3)
    _, q = all_of(probe)
    here = q[0, 0, joint]
    low, high = q[0, :, joint].min() - 1.0, q[0, :, joint].max() + 1.0
    sign = 1.0 if end else -1.0
    for beyond, fine in ((0.0, True), (1e-6, False)):
        # the joint stands exactly at the end of its travel at the start, or is out of it
        travel = narrow.travel.copy()
        travel[:] = -1e3, 1e3
        travel[joint] = (low, here - beyond) if end else (here + beyond, high)
        object.__setattr__(narrow, "travel", travel)
        found, detour = a_detour(3, machine=narrow)
        _, q = all_of(detour)
        within = (sign * (q[0, :, joint] - here) <= 0.5 * IN_TRAVEL).all()
        assert np.isinf(found.path_usage(detour)) == (not (fine and within))


@pytest.mark.parametrize(("usage", "fine"), [(DETOUR, True), (1.0, True), (1.00009, False), (1.01, False)])
def test_a_detour_passes_up_to_its_rung_of_the_guarantee(monkeypatch, usage, fine):
    for of, other in (("joints", "path"), ("path", "joints")):
        found, detour = a_detour(1)
        share = {of: usage, other: 0.5}
        monkeypatch.setattr(found, "path_usage", lambda detour, share=share: share["path"])
        monkeypatch.setattr(found, "joint_usage", lambda *given, share=share: np.array([share["joints"]]))
        assert found.passes(detour) == found.passes(detour, share["joints"]) == fine
        if not fine:
            assert found.nearest == usage
            assert found.nearest_of == ("the joints' limits" if of == "joints" else "feed or travel")
        else:
            assert found.nearest == np.inf


@pytest.mark.parametrize("seed", range(4))
def test_a_detour_knows_where_its_jerk_jumps_and_that_its_run_is_waited_behind(seed):
    """Where the joints cease to carry on; and the dwell at the end of the run that is rejoined."""
    found, detour = a_detour(seed)
    run = motion().axis_path.runs[0]
    run.dwell = 0.25
    try:
        made = DetourRun(detour, MACHINE, found.excess)
        assert made.dwell == 0.25
    finally:
        run.dwell = 0.0
    assert (detour.carry in made.kinks) == (detour.carry > 0.0)
    assert (made.kinks > 0.0).all() and (made.kinks < detour.duration).all()
    assert set(made.parameter(made.kinks)[0]) <= set(made.breaks)
