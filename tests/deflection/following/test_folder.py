"""A plan in a folder is followed as the plan itself."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
from testbed.followed.two_tools import fitted
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Status
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.results.write import PlanResult, write_folder

LENGTHS = [0.12, 0.1975]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A case with two tools, its plan with all limits and with a reserve, and the folder of the latter."""
    case, toolpath, path, reserved, machine = fitted(3, "xyzac-trunnion", "m428", LENGTHS, 12)
    trajectory = tp.plan(path, reserved, bound=False)
    folder = tmp_path_factory.mktemp("plans") / "two"
    options = ReadOptions.of(None, case.controller, setup_of_text(case.sheet))
    result = PlanResult(
        trajectory=trajectory, machine=reserved, setpoints=trajectory.sample(1e-3), toolpath=toolpath, path=path,
        program=Path("case.ngc"), program_bytes=case.text.encode(), options=options,
    )  # fmt: skip
    write_folder(folder, result, report=False)
    return case, trajectory, machine, folder


def test_what_is_loaded_is_what_was_planned(written):
    case, trajectory, machine, folder = written
    loaded = tp.Trajectory.load(folder)
    assert loaded.duration == pytest.approx(trajectory.duration, abs=1e-12)
    assert loaded.usage() == trajectory.usage() and loaded.planner == trajectory.planner
    points = tp.SetPoints.load(folder / "setpoints.npz")
    before = points.t < trajectory.duration
    assert np.array_equal(loaded.at(points.t[before]).q, points.q[before])
    t = np.random.default_rng(1).uniform(0.0, trajectory.duration, 5000)
    one, other = trajectory.at(t), loaded.at(t)
    assert np.abs(one.q - other.q).max() <= 1e-8 and np.abs(one.qd - other.qd).max() <= 1e-5
    assert (np.abs(other.qd) <= machine.limits.velocity).all()
    assert np.abs(loaded.at(trajectory.duration).qd).max() <= 1e-15
    # where no tool is changed the tip is that of the tool in the spindle, by own kinematics
    assert set(loaded.axis_path.tool_lengths) == set(LENGTHS)
    blocks = np.array([points.block[np.searchsorted(points.t, each, side="right") - 1] for each in t])
    for cut in case.cuts:
        some = (blocks > cut.lines[0]) & (blocks < cut.lines[1])
        assert some.sum() > 100
        assert loaded.tip(t[some])[0] == pytest.approx(case.chain.forward(other.q[some], cut.length)[0], abs=1e-12)


@pytest.mark.parametrize("period", [1e-3, 2.5e-3])
def test_a_follower_of_a_folder_keeps_the_limits_and_the_plan(written, period: float):
    _, trajectory, machine, folder = written
    follower = tp.Follower.from_folder(folder, machine, period=period)
    assert follower.pace == 1.0 and follower.off_the_plan <= 3e-6
    q, at = [trajectory.at(0.0).q] * 3, []
    for k in range(int(2.0 * trajectory.duration / period)):
        point = follower.step(feed=0.0 if k * period < 0.1 or 2.0 < k * period < 3.0 else 1.0)
        q.append(point.q)
        at.append(min(point.path_time, trajectory.duration))
        if point.status & Status.ENDED:
            break
    off = np.abs(np.array(q[3:]) - trajectory.at(np.array(at)).q).max()
    assert point.status & Status.ENDED and off <= follower.off_the_plan + 1e-9
    limits = machine.limits
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        used = np.abs(np.diff(np.array(q), order, axis=0)).max(axis=0) / period**order / limit
        assert used.max() <= 1.0 + 1e-4


def test_its_feed_is_that_of_the_program(written):
    from toolpace.deflection.following.samples import followed_joints_of, samples_of

    case, _, machine, folder = written
    loaded = tp.Trajectory.load(folder)
    samples = samples_of(loaded, followed_joints_of(machine, machine.joints), 1e-3, 1.0)
    assert samples.step == 1e-3
    some = np.isfinite(samples.feed)
    assert some.sum() > 1000 and samples.feed[some] == pytest.approx(case.feed, rel=1e-3)
    assert len(samples.tools) == 2


def test_without_a_machine_the_folder_s_own_is_taken_and_slowed_for_the_reserve(written):
    folder = written[3]
    follower, used = tp.Follower.from_folder(folder, reserve=0.1), tp.Trajectory.load(folder).usage()
    shares = [max(kind.values()) * follower.pace**k for k, kind in enumerate((used.velocity, used.acceleration), 1)]
    shares.append(max(used.jerk.values()) * follower.pace**3)
    assert max(shares) == pytest.approx(0.9, rel=1e-6) and follower.off_the_plan <= 3e-6


def test_set_points_further_apart_than_the_follower_s_are_refused(written):
    """Between them the path has been made up: no limit would be sure."""
    with pytest.raises(UsageError, match=r"set-points of the plan are 1 ms apart.* period of 0.4 ms; .* --dt 0.4ms"):
        tp.Follower.from_folder(written[3], period=4e-4)


def test_a_folder_that_is_none_or_was_changed_is_refused(written, tmp_path):
    import shutil

    folder = written[3]
    with pytest.raises(UsageError, match="no such folder; give the one that `toolpace plan --out` wrote"):
        tp.Trajectory.load(tmp_path / "none")
    with pytest.raises(UsageError, match=r"seal at the end of plan\.json is missing"):
        tp.Trajectory.load(tmp_path)
    for name, words in (("machine.toml", "was changed after"), ("program.ngc", "was changed"), ("plan.json", "seal")):
        other = tmp_path / name
        shutil.copytree(folder, other)
        (other / name).write_text((other / name).read_text().replace("1", "2", 1))
        with pytest.raises(UsageError, match=f"{name}.*{words}|{words}.*{name}"):
            tp.Follower.from_folder(other)
    with pytest.raises(UsageError, match=r"a folder, not a law; Follower\.from_folder takes"):
        tp.Follower.load(folder)
    other = tmp_path / "bare"
    shutil.copytree(folder, other)
    (other / "setpoints.npz").unlink()
    with pytest.raises(UsageError, match=r"setpoints.npz: no such file; `toolpace plan` writes it"):
        tp.Trajectory.load(other)
    assert json.loads((folder / "plan.json").read_text())["program_file"] == "program.ngc"


@pytest.mark.sweep
def test_from_the_command_line_to_a_follower(tmp_path):
    from toolpace.cli import main

    program = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z11 F900\nX13 Y-3 A2 C3 F500\nG4 P0.1\nX5 F700\nM2\n"
    (tmp_path / "p.ngc").write_text(program)
    order = ["plan", str(tmp_path / "p.ngc"), "--machine", "linuxcnc-xyzac-trt", "--effort", "low"]
    assert main([*order, "--dt", "0.25ms", "--out", str(tmp_path / "out")]) == 0
    follower = tp.Follower.from_folder(tmp_path / "out", reserve=0.05)
    assert follower.off_the_plan <= 5e-8
    while not (point := follower.step()).status & Status.ENDED:
        assert point.t < 3.0
    assert point.q[:3] == pytest.approx([0.005, -0.003, 0.011], abs=1e-9)
