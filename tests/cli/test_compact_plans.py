"""A plan with compact set-points is that with full ones to every command, and what is changed in it is found."""

from __future__ import annotations

import json
import shutil
from dataclasses import fields, replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.limited_plans import SLOT, limited_slot
from tests.support.tampering import Tamper, fails
from toolpace.cli import demo_programs, main
from toolpace.cli.commands.verify import other_feed
from toolpace.judge import seen_motion
from toolpace.motion import sampling, set_point_files
from toolpace.motion.laws import SplineLaw
from toolpace.motion.setpoints import STREAMED_COPIES, SetPoints
from toolpace.motion.trajectory_file import write_trajectory
from toolpace.path.follow_run import FollowRun

PLAN = ["-m", "xyzac-trunnion", "--effort", "low"]


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    """The same plan twice: with full set-points, and with compact ones."""
    folder = tmp_path_factory.mktemp("plans")
    program = folder / "blade.ngc"
    lines = demo_programs.spiral_program(120).splitlines()
    lines.insert(len(lines) // 2, "G4 P0.3")
    program.write_text("\n".join(lines) + "\n")
    for form in ("full", "compact"):
        assert main(["plan", str(program), *PLAN, "--npz", form, "--out", str(folder / form), "--csv"]) == 0
    return folder


@pytest.fixture
def again(plans, tmp_path):
    """A copy of the compact one, and how to change it."""
    folder = tmp_path / "copy"
    shutil.copytree(plans / "compact", folder)
    (folder / "setpoints.csv").unlink()
    return Tamper(folder)


@pytest.mark.sweep
def test_both_forms_hold_the_same_bits(plans):
    full, compact = (tp.read_set_points(plans / form) for form in ("full", "compact"))
    for each in fields(SetPoints):
        np.testing.assert_array_equal(getattr(full, each.name), getattr(compact, each.name), strict=True)
    assert not (plans / "full" / "setpoints.compact").exists()
    assert not (plans / "compact" / "setpoints.npz").exists()


@pytest.mark.sweep
def test_the_full_file_is_told_by_default_and_by_the_words_of_before(plans, tmp_path, capsys):
    for words in ([], ["--npz", "all"], ["--npz", "none"]):
        assert main(["plan", str(plans / "blade.ngc"), *PLAN, *words, "--out", str(tmp_path / "out")]) == 0
        assert (tmp_path / "out" / "setpoints.npz").exists() == (words != ["--npz", "none"])
        assert "setpoints.compact" not in capsys.readouterr().out


def test_long_motions_are_compact_and_the_summary_says_how_to_have_arrays(plans, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("toolpace.motion.set_point_files.SMALL", 1e5)
    assert main(["plan", str(plans / "blade.ngc"), *PLAN, "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "plan.json, setpoints.compact, trajectory.compact, machine.toml" in said
    size = (tmp_path / "out" / "setpoints.compact").stat().st_size / 1e6
    assert f"setpoints.compact, {size:.3g} MB: tp.read_set_points reads it; --npz full writes setpoints.npz" in said


def without_times(folder):
    """What plan.json says, but for seconds that were spent."""
    said = json.loads((folder / "plan.json").read_text())
    for key in ("step_s", "seal", "solve_s", "fit_s"):
        del said[key]
    return said


def test_figures_and_tables_are_the_same(plans):
    full, compact = plans / "full", plans / "compact"
    assert without_times(full) == without_times(compact)
    assert (full / "setpoints.csv").read_bytes() == (compact / "setpoints.csv").read_bytes()


def test_files_and_verdict_are_the_same_in_blocks_of_any_length(plans, tmp_path, monkeypatch, capsys):
    """A motion of one block is judged and written as in blocks whose borders lie on the way and in a dwell."""
    points, said = tp.read_set_points(plans / "compact"), without_times(plans / "compact")
    for module in (sampling, set_point_files):
        monkeypatch.setattr(module, "ROWS", 512)
    monkeypatch.setattr(seen_motion, "ROWS", 256)
    words = [str(plans / "blade.ngc"), *PLAN, "--npz", "compact", "--csv", "--out", str(tmp_path / "out")]
    assert len(points) > 3 * 512 and main(["plan", *words]) == 0
    again, figures = tp.read_set_points(tmp_path / "out"), without_times(tmp_path / "out")
    for each in fields(SetPoints):
        np.testing.assert_array_equal(getattr(again, each.name), getattr(points, each.name), strict=True)
    assert figures.pop("path_length_mm") == pytest.approx(said.pop("path_length_mm"), rel=1e-12) and figures == said
    assert (tmp_path / "out" / "setpoints.csv").read_bytes() == (plans / "compact" / "setpoints.csv").read_bytes()
    assert main(["verify", str(tmp_path / "out")]) == 0


def test_every_command_takes_both(plans, tmp_path, capsys):
    rows = {}
    for form in ("full", "compact"):
        capsys.readouterr()
        assert main(["verify", str(plans / form)]) == 0
        # but for the seconds that it took
        verdict = capsys.readouterr().out.partition("check")[2]
        out = tmp_path / form
        assert main(["export", str(plans / form), "--to", "table", "--out", str(out)]) == 0
        tables = {each.name: each.read_bytes() for each in out.iterdir() if each.suffix != ".json"}
        rows[form] = verdict, tables
    assert rows["full"] == rows["compact"]
    page = tmp_path / "compared.html"
    assert main(["compare", str(plans / "full"), str(plans / "compact"), "--page", str(page)]) == 0


def test_a_motion_is_loaded_and_replanned_alike(plans):
    full, compact = (tp.Trajectory.load(plans / form) for form in ("full", "compact"))
    t = np.linspace(0.0, full.duration, 501)
    assert full.at(t) == compact.at(t)
    tip = full.tip(1.0)[0] + [0.0, 0.0, 2e-5]
    back = [tp.replan(each, 1.0, tip, each.axis_path.machine) for each in (full, compact)]
    assert back[0].at(t) == back[1].at(t)


def row(name, value):
    """A change of one row in the middle of a column."""

    def change(arrays):
        middle = len(arrays[name]) // 3
        arrays[name][middle] = value(arrays[name][middle])

    return change


def all_rows(change):
    """The change of the rows of every column."""

    def of_all(arrays):
        for name, values in arrays.items():
            if name != "joints" and len(values):
                arrays[name] = change(values)

    return of_all


def with_steps(dt):
    def change(arrays):
        arrays["t"] = dt * np.arange(len(arrays["t"]))

    return change


def renamed(arrays):
    arrays["joints"] = arrays["joints"][::-1]


CHANGES = {
    "t of one row": (row("t", lambda v: v + 1e-4), "time step"),
    "q of one row": (row("q", lambda v: v + 1e-7), "jerk"),
    "qd of one row": (row("qd", lambda v: v + 1e-3), "velocity column|acceleration column"),
    "qdd of one row": (row("qdd", lambda v: v + 1.0), "acceleration column"),
    "qddd of one row": (row("qddd", lambda v: v + 1e3), "jerk"),
    "tip of one row": (row("tip", lambda v: v + 1e-7), "tip column"),
    "axis of one row": (row("axis", lambda v: v + 1e-7), "axis column"),
    "block of one row": (row("block", lambda v: v + 3), "block column"),
    "joints": (renamed, "joints"),
    "a row is missing": (all_rows(lambda v: np.delete(v, len(v) // 3, 0)), "time step|velocity"),
    "a row twice": (all_rows(lambda v: np.insert(v, len(v) // 3, v[len(v) // 3], 0)), "time step|run forward"),
    "a row is missing at the end": (all_rows(lambda v: v[:-1]), "duration_s|set_points|rest at the end"),
    "rows exchanged": (all_rows(lambda v: v[[*range(90), 91, 90, *range(92, len(v))]]), "time"),
    "half of it": (all_rows(lambda v: v[: len(v) // 2]), "rest at the end|duration_s"),
    "a longer time step": (with_steps(1.1e-3), "dt_s|duration_s"),
    "a shorter time step": (with_steps(0.9e-3), "dt_s|duration_s|velocity"),
    "backwards": (all_rows(lambda v: v[::-1].copy()), "time"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_is_found_though_the_seal_is_right(again, capsys, name):
    change, words = CHANGES[name]
    again.compact_arrays(change)
    fails(again, capsys, words)


def test_nothing_changed_passes(again, capsys):
    again.compact_arrays(lambda arrays: None)
    code, said = again.verdict(capsys)
    assert code == 0 and "VERIFIED" in said


@pytest.mark.parametrize("name", ["setpoints.compact", "machine.toml", "program.ngc", "report.html"])
def test_a_changed_file_breaks_the_seal(again, capsys, name):
    path = again.folder / name
    data = path.read_bytes()
    path.write_bytes(data + b"\n")
    code, said = again.verdict(capsys)
    assert code in (1, 2) and (f"{name} was changed" in said or f"{name}: damaged" in said)


def test_a_file_that_was_cut_short_or_is_gone_is_refused(again, capsys):
    path = again.folder / "setpoints.compact"
    path.write_bytes(path.read_bytes()[:-1])
    again.seal()
    fails(again, capsys, "setpoints.compact: damaged")
    path.unlink()
    fails(again, capsys, "setpoints.compact was taken out of it")


def test_two_files_of_set_points_are_refused(again, plans, capsys):
    shutil.copy(plans / "full" / "setpoints.npz", again.folder)
    fails(again, capsys, "holds setpoints.npz and setpoints.compact")


def exact(folder):
    return tp.Trajectory.load(folder, exact=True)


def test_the_plan_itself_is_in_the_folder(plans):
    """Its set-points are those on disk, to the bit; its limits hold at any time, which those of set-points need not."""
    points, trajectory = tp.read_set_points(plans / "full"), exact(plans / "full")
    again = trajectory.sample(1e-3, on_grid=True)
    for each in fields(SetPoints):
        np.testing.assert_array_equal(getattr(again, each.name), getattr(points, each.name), strict=True)
    said = json.loads((plans / "full" / "plan.json").read_text())
    assert trajectory.duration == said["duration_s"] and trajectory.lower_bound == said["lower_bound_s"]
    told, found = trajectory.usage(), replace(trajectory, found_usage=None).usage()
    assert told == found and found.worst <= 1.0001 and trajectory.notes == ()


@pytest.mark.parametrize("name", ["nodes", "c", "breaks", "coefficients", "block", "feed", "least_time", "entry"])
def test_a_changed_path_or_law_is_found_though_the_seal_is_right(again, capsys, name):
    trajectory = exact(again.folder)
    run, law = trajectory.axis_path.runs[0], trajectory.laws[0]
    if name in ("nodes", "c"):
        arrays = {"nodes": law.nodes.copy(), "c": law.c.copy()}
        arrays[name][len(arrays[name]) // 2] *= 1.0 + 1e-6
        laws = (SplineLaw(**arrays, rest=law.rest), *trajectory.laws[1:])
        changed = replace(trajectory, laws=laws)
    else:
        values = getattr(run.run, name).copy()
        middle = len(values) // 2
        value = values[middle] + 3 if name in ("block", "entry") else values[middle] * (1.0 + 1e-7)
        values[middle] = 1e-3 if name == "least_time" else value
        other = FollowRun(replace(run.run, **{name: values}), run.machine, run.branch)
        path = replace(trajectory.axis_path, runs=(other, *trajectory.axis_path.runs[1:]))
        changed = replace(trajectory, axis_path=path)
    write_trajectory(again.folder / "trajectory.compact", changed.axis_path, changed.laws)
    again.seal()
    fails(again, capsys, "trajectory.compact")


def test_speeds_of_a_cut_are_held_against_those_beside_the_plan():
    plan = limited_slot()
    axis_path, toolpath = plan.plan.trajectory.axis_path, plan.fed(SLOT.toolpath())
    assert other_feed(axis_path, toolpath, bends=False) == ("", 0)
    run = next(each for each in axis_path.runs if each.profile is not None)
    profile = run.profile
    higher = replace(profile, speed=1.0001 * profile.speed)
    changes = (
        ({"speed_profile": higher}, "not the speeds that the cut"),
        ({"speed_profile": None}, "not the speeds that the cut"),
        ({"feed": 0.1 * run.run.feed}, "not the block, feed and least time"),
    )
    for change, words in changes:
        other = FollowRun(replace(run.run, **change), run.machine, run.branch)
        runs = tuple(other if each is run else each for each in axis_path.runs)
        assert other_feed(replace(axis_path, runs=runs), toolpath, bends=False)[0].startswith(words)
    assert other_feed(axis_path, SLOT.toolpath(), bends=False)[0]


def test_the_last_digit_of_a_speed_between_two_places_of_a_profile_may_differ():
    plan = limited_slot()
    axis_path, toolpath = plan.plan.trajectory.axis_path, plan.fed(SLOT.toolpath())
    for factor, same in ((1.0 - 1e-15, True), (1.0 - 1e-9, False)):
        runs = tuple(
            each
            if each.profile is None
            else FollowRun(replace(each.run, feed=factor * each.run.feed), each.machine, each.branch)
            for each in axis_path.runs
        )
        assert (other_feed(replace(axis_path, runs=runs), toolpath, bends=False)[0] == "") == same


def test_a_path_of_another_plan_or_damaged_is_found(again, plans, tmp_path, capsys):
    other = tmp_path / "other"
    words = ["--npz", "compact", "--no-report", "--feed", "50%", "--out", str(other)]
    assert main(["plan", str(plans / "blade.ngc"), *PLAN, *words]) == 0
    path = again.folder / "trajectory.compact"
    shutil.copy(other / path.name, path)
    again.seal()
    fails(again, capsys, "trajectory.compact")
    path.write_bytes(path.read_bytes()[:-1])
    again.seal()
    fails(again, capsys, "trajectory.compact: damaged")


def test_a_motion_whose_judgement_would_not_fit_into_memory_is_refused_by_its_own_duration(
    plans, tmp_path, monkeypatch, capsys
):
    """The feeds of the program alone tell half of that, and would let it pass."""
    count = json.loads((plans / "compact" / "plan.json").read_text())["set_points"]
    room = 0.75 * count * 8 * (1 + 4 * 5 + 6 + 1) * STREAMED_COPIES
    monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: room)
    words = ["--npz", "compact", "--no-report", "--out", str(tmp_path / "out")]
    assert main(["plan", str(plans / "blade.ngc"), *PLAN, *words]) == 2
    assert "set-points: the motion takes" in capsys.readouterr().err and not list(tmp_path.iterdir())
