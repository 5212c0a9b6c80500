"""Path and speed laws of a plan come back from the disk to the bit; what is damaged is refused in one line."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import toolpace as tp
from tests.support.limited_plans import limited_slot
from toolpace.common.errors import UsageError
from toolpace.motion.packed_numbers import STRETCH, left_of_splines, splines_of
from toolpace.motion.trajectory_file import MAGIC, is_writable, read_trajectory, write_trajectory
from toolpace.path.follow_run import FollowRun

PLANNERS = ("optimal", "second-order", "genetic")


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("xyzac-trunnion")


@pytest.fixture(scope="module")
def toolpath(machine):
    """Two stretches with a stop and a dwell, in tool axes that turn."""
    lines = ["G21 G90 G94 G17", "G0 X0 Y0 Z0 A0 C0"]
    lines += [f"G1 X{0.8 * k:.3f} Y{0.05 * k * k:.3f} A{0.4 * k:.3f} C{1.5 * k:.3f} F2400" for k in range(1, 25)]
    lines += ["G4 P0.2", "G1 X0 Y0 Z5 F3000", "M30"]
    return tp.read_text("\n".join(lines) + "\n", machine, "gcode")


@pytest.fixture(scope="module", params=PLANNERS)
def trajectory(request, machine, toolpath):
    path = tp.Path.fit(toolpath, machine=machine)
    return tp.plan(path, machine, planner=request.param)


def loaded(path, trajectory):
    axis_path, laws = read_trajectory(path, trajectory.axis_path.machine)
    return replace(trajectory, axis_path=axis_path, laws=laws)


def test_the_motion_is_the_same_to_the_bit_at_any_time(trajectory, tmp_path):
    assert is_writable(trajectory.axis_path, trajectory.laws)
    write_trajectory(tmp_path / "law", trajectory.axis_path, trajectory.laws)
    again = loaded(tmp_path / "law", trajectory)
    t = np.random.default_rng(5).uniform(0.0, trajectory.duration, 3000)
    assert again.duration == trajectory.duration and (again.starts == trajectory.starts).all()
    assert again.at(t) == trajectory.at(t) and again.sample(1e-3) == trajectory.sample(1e-3)
    assert again.usage() == trajectory.usage() and again.limited_by() == trajectory.limited_by()


def test_speeds_that_a_cut_allows_come_back_with_the_motion(tmp_path):
    plan = limited_slot()
    trajectory = plan.plan.trajectory
    assert is_writable(trajectory.axis_path, trajectory.laws)
    write_trajectory(tmp_path / "law", trajectory.axis_path, trajectory.laws)
    again = loaded(tmp_path / "law", trajectory)
    assert again.limited_by() == trajectory.limited_by() and again.limited_by()["chip"] > 0.1
    profiles = [[run.profile for run in each.axis_path.runs] for each in (again, trajectory)]
    assert profiles[0] == profiles[1] and any(profile is not None for profile in profiles[0])
    t = np.linspace(0.0, trajectory.duration, 2000)
    assert again.at(t) == trajectory.at(t) and again.usage() == trajectory.usage()


def test_a_profile_that_is_none_is_refused(tmp_path):
    trajectory = limited_slot().plan.trajectory
    write_trajectory(tmp_path / "law", trajectory.axis_path, trajectory.laws)
    data = (tmp_path / "law").read_bytes()
    end = data.index(b"\n", len(MAGIC))
    head = msgspec.json.decode(data[len(MAGIC) : end])
    for change in ({"limits": []}, {"runs": [each | {"profile": each["profile"][:2]} for each in head["runs"]]}):
        other = MAGIC + msgspec.json.encode(head | change) + data[end:]
        refused(tmp_path / "law", other, trajectory.axis_path.machine)


def test_what_is_no_planned_program_is_not_written():
    machine = tp.Machine.load("paper-ab")
    trajectory = tp.plan(tp.Path.paper_arc(), machine, bound=False)
    assert not is_writable(trajectory.axis_path, trajectory.laws)


@pytest.mark.parametrize("pieces", [1, 2, STRETCH, STRETCH + 1, 3 * STRETCH - 1])
def test_coefficients_of_any_kind_come_back_to_the_bit(pieces):
    r = np.random.default_rng(pieces)
    coefficients = r.standard_normal((pieces, 6, 5)) * 10.0 ** r.integers(-300, 300, (pieces, 6, 5))
    coefficients[0, 0] = np.nan, np.inf, -0.0, 0.0, 5e-324
    lengths = r.random(pieces)
    left = left_of_splines(coefficients, lengths)
    assert splines_of(left, lengths).tobytes() == coefficients.tobytes()


def test_of_a_fitted_path_little_is_left(machine, toolpath):
    """Most of six coefficients are told by the piece before: ten bits of rounding, not 64, are left of the first."""
    run = tp.Path.fit(toolpath, machine=machine).runs[0]
    left = np.abs(left_of_splines(run.coefficients, np.diff(run.breaks))[:3])
    inner = np.arange(left.shape[2]) % STRETCH != 0
    assert inner.sum() > 20 and np.median(left[:, :, inner]) < 1 << 10


@pytest.fixture(scope="module")
def data(trajectory, tmp_path_factory):
    path = tmp_path_factory.mktemp("law") / "law"
    write_trajectory(path, trajectory.axis_path, trajectory.laws)
    return path.read_bytes()


def refused(path, data, machine):
    path.write_bytes(data)
    with pytest.raises(UsageError, match="damaged or not a trajectory") as caught:
        read_trajectory(path, machine)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("seed", range(15))
def test_a_changed_byte_behind_the_head_is_found(data, tmp_path, machine, seed):
    r = np.random.default_rng(seed)
    at = int(r.integers(data.index(b"\n", len(MAGIC)) + 1, len(data)))
    refused(tmp_path / "law", data[:at] + bytes([data[at] ^ int(r.integers(1, 256))]) + data[at + 1 :], machine)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_a_file_that_was_cut_short_or_goes_on_is_refused(data, tmp_path, machine, share):
    refused(tmp_path / "law", data[: int(share * len(data))], machine)
    refused(tmp_path / "law", data + b"\0", machine)


@pytest.mark.parametrize("change", ["path", "branch", "of_law"])
def test_lengths_that_do_not_go_together_are_refused_before_compiled_code_meets_them(data, tmp_path, machine, change):
    end = data.index(b"\n", len(MAGIC))
    head = msgspec.json.decode(data[len(MAGIC) : end])
    lengths = head["runs"][0][change]
    if not lengths:
        return
    for k in range(len(lengths)):
        other = [*lengths[:k], lengths[k] + 1, *lengths[k + 1 :]]
        runs = [head["runs"][0] | {change: other}, *head["runs"][1:]]
        refused(tmp_path / "law", MAGIC + msgspec.json.encode(head | {"runs": runs}) + data[end:], machine)


def test_what_is_no_file_is_told(tmp_path, machine):
    with pytest.raises(UsageError, match="no such file; `toolpace plan` writes it"):
        read_trajectory(tmp_path / "law", machine)
    with pytest.raises(UsageError, match="cannot read: is a directory"):
        read_trajectory(tmp_path, machine)


def test_a_file_in_the_format_of_another_version_is_told(data, tmp_path, machine):
    (tmp_path / "law").write_bytes(b"toolpace trajectory 1\n" + data[len(MAGIC) :])
    with pytest.raises(UsageError, match=r"law: is in a format of another version of toolpace.*; plan again"):
        read_trajectory(tmp_path / "law", machine)


def test_a_path_of_what_are_no_numbers_is_refused(trajectory, tmp_path, machine):
    run = trajectory.axis_path.runs[-1]
    coefficients = run.run.coefficients.copy()
    coefficients[-1, 0, 0] = np.nan
    other = FollowRun(replace(run.run, coefficients=coefficients), run.machine, run.branch)
    path = replace(trajectory.axis_path, runs=(*trajectory.axis_path.runs[:-1], other))
    write_trajectory(tmp_path / "law", path, trajectory.laws)
    refused(tmp_path / "law", (tmp_path / "law").read_bytes(), machine)
