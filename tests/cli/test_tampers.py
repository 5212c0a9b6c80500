"""`toolpace verify` believes nothing in the folder of a plan that it can find out, and says what it cannot."""

from __future__ import annotations

import copy
import json
import os
import re
import shutil
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from tests.support.tampering import Tamper, column, fails, part_of, put, times
from toolpace.cli import demo_programs, main
from toolpace.common.files.seal import KEY
from toolpace.jobs import plan_steps
from toolpace.judge.figures import AS_SAID, IN_THE_VERDICT, RECOMPUTED
from toolpace.results import write

COLUMNS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block", "joints")


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A folder with a plan of a part with two dwells and a stop."""
    folder = tmp_path_factory.mktemp("plan")
    program = folder / "blade.ngc"
    lines = demo_programs.spiral_program(120).splitlines()
    lines.insert(len(lines) // 2, "G4 P0.3")
    lines.insert(len(lines) // 3, "G4 P0.2")
    program.write_text("\n".join(lines) + "\n")
    out = folder / "out"
    assert main(["plan", str(program), "-m", "xyzac-trunnion", "--out", str(out), "--csv", "--no-report"]) == 0
    return out


@pytest.fixture
def again(plan, tmp_path):
    """A copy of it, and how to change it."""
    folder = tmp_path / "copy"
    shutil.copytree(plan, folder)
    (folder / "setpoints.csv").unlink()
    return Tamper(folder)


FIGURES = {
    "no program": (put("program_file", ""), "there is no program"),
    "program elsewhere": (put("program_file", "../out/program.ngc"), "program_file"),
    "program by its whole path": (put("program_file", "/etc/passwd"), "program_file"),
    "another file of the folder": (put("program_file", "machine.toml"), "program_file"),
    "no tip tolerance": (put("tip_tolerance_mm", None), "tip_tolerance_mm"),
    "no axis tolerance": (put("axis_tolerance_deg", None), "axis_tolerance_deg"),
    "tip tolerance below zero": (put("tip_tolerance_mm", -1.0), "tolerance"),
    "tip tolerance too narrow": (put("tip_tolerance_mm", 1e-4), "tip, "),
    "duration": (put("duration_s", times(1.01)), "duration_s"),
    "duration by a part in a thousand": (put("duration_s", times(0.999)), "gap|duration_s"),
    "bound above the duration": (put("lower_bound_s", times(1.2)), "lower_bound_s"),
    "bound without its gap": (put("lower_bound_s", times(0.99)), "gap"),
    "no bound": (put("lower_bound_s", None), "gap"),
    "gap": (put("gap", 0.0), "gap"),
    "continuous bound": (put("continuous_bound_s", 1e6), "continuous_bound_s"),
    "usage of a velocity": (put("usage/velocity/X", times(0.9)), "usage velocity of X"),
    "usage of a velocity, more": (put("usage/velocity/X", times(1.2)), "usage velocity of X"),
    "usage of an acceleration": (put("usage/acceleration/Z", times(0.5)), "usage acceleration of Z"),
    "usage of an acceleration, more": (put("usage/acceleration/C", times(1.02)), "usage acceleration of C"),
    "usage of a jerk": (put("usage/jerk/A", times(0.5)), "usage jerk of A"),
    "jerk above its limit": (put("usage/jerk/C", 1.01), "usage jerk of C"),
    "jerk unlimited": (put("usage/jerk/C", None), "usage jerk of C"),
    "usage of the feed": (put("usage/feed", 0.5), "usage feed"),
    "feed above its limit": (put("usage/feed", 1.01), "usage feed"),
    "a joint that is none": (lambda said: said["usage"]["jerk"].update(W=0.1), "usage jerk"),
    "shares of time": (put("limited_by/feed", times(0.5)), "limited_by"),
    "shares exchanged": (
        lambda said: said["limited_by"].update(feed=said["limited_by"]["nothing"], nothing=said["limited_by"]["feed"]),
        "limited_by",
    ),
    "a share of nothing known": (lambda said: said["limited_by"].update(magic=0.0), "limited_by"),
    "the share of dwells": (
        lambda said: said["limited_by"].update(
            dwell=said["limited_by"]["dwell"] * 0.9,
            nothing=said["limited_by"]["nothing"] + 0.1 * said["limited_by"]["dwell"],
        ),
        "limited_by dwell",
    ),
    "prices of another motion": (put("prices_s", {"feed": 1.0}), "prices_s"),
    "a price of nothing known": (put("prices_s", {"magic": 0.01}), "prices_s"),
    "tip deviation": (put("tip_deviation_mm", times(0.9)), "tip_deviation_mm"),
    "axis deviation": (put("axis_deviation_deg", None), "axis_deviation_deg"),
    "machine": (put("machine", "another"), "machine"),
    "blocks": (put("blocks", 7), "blocks"),
    "stops": (put("stops", 0), "stops"),
    "set-points": (put("set_points", 10), "set_points"),
    "time step": (put("dt_s", 2e-3), "dt_s"),
    "path length": (put("path_length_mm", times(1.001)), "path_length_mm"),
    "verdict of then": (put("verified", False), "verified"),
    "feed that is none": (put("feed", "fast"), "feed"),
    "feed of another plan": (put("feed", "200%"), "usage feed"),
    "feeds taken away": (put("feed", "none"), "usage feed"),
    "a lower feed": (put("feed", "50%"), "feed"),
    "bound of another problem": (put("lower_bound_of", "any motion"), "lower_bound_of"),
    "a key too many": (lambda said: said.update(fame=1.0), "fame"),
    "a time below zero": (put("solve_s", -1.0), "solve_s"),
    "a step's time below zero": (put("step_s/reading", -1.0), "step_s reading"),
    "no planner": (put("planner", ""), "planner"),
    "another controller": (put("controller", "haas"), "controller"),
    "an assumption": (put("assumed", ["the part is round"]), "assumed"),
    "a word passed over": (put("skipped", {"M8": 3}), "skipped"),
    "no controller file": (put("reading/controller_file", ""), "controller_file"),
    "a set-up sheet that is not there": (put("reading/setup_file", "setup.toml"), "setup_file"),
    "a file elsewhere": (put("reading/controller_file", "../controller.toml"), "controller_file"),
    "fewer blocks than were read": (put("reading/max_blocks", 3), "more than 3 blocks"),
    "no operations": (put("operations", []), "operations"),
    "an operation's tool": (put("operations/0/tool", "7"), "operations"),
    "an operation's stops": (put("operations/0/stops", 0), "operations"),
    "an operation's dwell": (put("operations/0/dwell_s", 0.4), "operations"),
    "time moved from cutting to rapids": (lambda said: moved(said, 0.5), "operations"),
    "cutting alone": (put("cutting_s", times(0.99)), "operations"),
}
"""What is changed in plan.json, and what the verdict names."""


def moved(said, seconds):
    """Time of the first operation told as rapid, with all sums right."""
    for of in (said, said["operations"][0]):
        of["cutting_s"] -= seconds
        of["rapid_s"] += seconds


SET_POINTS = {
    "joints renamed": (column("joints", lambda names: names[::-1].copy()), "joints"),
    "qddd of nothing": (column("qddd", lambda v: 0.0 * v), "jerk column"),
    "qddd turned round": (column("qddd", lambda v: -v), "jerk column"),
    "qddd of one joint": (column("qddd", lambda v: v * [1, 1, 1, 1, 0]), "jerk column of C"),
    "qddd of nothing for a while": (column("qddd", lambda v: part_of(v, lambda p: 0.0 * p)), "jerk column"),
    "qddd exchanged": (column("qddd", lambda v: v[:, ::-1].copy()), "jerk column"),
    "qdd of nothing": (column("qdd", lambda v: 0.0 * v), "acceleration column"),
    "qd turned round": (column("qd", lambda v: -v), "velocity column"),
    "block 1": (column("block", lambda v: 0 * v + 1), "block column"),
    "block by one": (column("block", lambda v: v + 1), "block column"),
    "block by one for a while": (column("block", lambda v: part_of(v, lambda p: p + 1)), "block column"),
    "block no number": (column("block", lambda v: v * np.nan), "block"),
    "block a fraction": (column("block", lambda v: v + 0.5), "block"),
    "time later": (column("t", lambda v: v + 1.0), "begin of time|duration_s"),
    "time stretched": (column("t", lambda v: v * 1.01), "duration_s"),
    "tip elsewhere": (column("tip", lambda v: v + 1e-6), "tip column"),
    "axis turned": (column("axis", lambda v: v[:, [1, 0, 2]].copy()), "axis column"),
    "q a little": (column("q", lambda v: v + 1e-7), "column|tip"),
    "a column too many": (lambda arrays: arrays.update(more=np.zeros(3)), "more"),
    "no tool": (lambda arrays: arrays.update(tip=np.zeros((0, 3)), axis=np.zeros((0, 3))), "tip|tool"),
}
"""What is changed in setpoints.npz, and what the verdict names."""


def test_what_was_planned_is_verified(again, capsys):
    code, said = again.verdict(capsys)
    assert code == 0 and "VERIFIED  within tip 0.01 mm, axis 0.05 deg, feeds of the program" in said
    assert "WIDER" not in said
    assert f"checked against the other figures only: {', '.join(AS_SAID)}" in said


@pytest.mark.parametrize("name", FIGURES)
def test_a_changed_figure_fails(again, capsys, name):
    change, words = FIGURES[name]
    again.figures(change)
    fails(again, capsys, words)


@pytest.mark.parametrize("name", SET_POINTS)
def test_a_changed_column_fails(again, capsys, name):
    change, words = SET_POINTS[name]
    again.arrays(change)
    fails(again, capsys, words)


def test_a_file_that_was_changed_breaks_the_seal(again, capsys):
    page = again.folder / "machine.toml"
    page.write_text(page.read_text() + "# changed\n")
    fails(again, capsys, "seal  machine.toml was changed|machine.toml was changed")


def test_wide_tolerances_show_in_the_verdict(again, capsys):
    again.figures(lambda said: said.update(tip_tolerance_mm=100.0, axis_tolerance_deg=0.1))
    _, said = again.verdict(capsys)
    assert "within tip 100 mm, axis 0.1 deg" in said
    assert "WIDER THAN THE DEFAULT: tip tolerance 100 mm, 1e+04 times 0.01 mm; axis tolerance 0.1 deg" in said


def test_a_changed_table_fails(plan, tmp_path, capsys):
    folder = tmp_path / "copy"
    shutil.copytree(plan, folder)
    capsys.readouterr()
    assert main(["verify", str(folder)]) == 0
    table = (folder / "setpoints.csv").read_text()
    lines = table.splitlines(keepends=True)
    middle = len(lines) // 2
    cells = lines[middle].split(",")
    cells[1] = repr(float(cells[1]) + 1e-9)
    for changed in (
        [*lines[:middle], ",".join(cells), *lines[middle + 1 :]],
        lines[:-1],
        [*lines, lines[-1]],
        [lines[0].replace("X [mm]", "Y [mm]"), *lines[1:]],
        [*lines[:-1], "a,b\n"],
    ):
        (folder / "setpoints.csv").write_text("".join(changed))
        Tamper(folder).seal()
        capsys.readouterr()
        assert main(["verify", str(folder)]) == 1
        assert "setpoints.csv" in capsys.readouterr().out.splitlines()[-1]


def test_every_key_is_judged_or_named():
    keys = {field.name for field in msgspec.structs.fields(write.PlanRecord)}
    listed = [*RECOMPUTED, *IN_THE_VERDICT, *AS_SAID]
    assert keys == set(listed) and len(listed) == len(set(listed))


def leaves(value, way=()):
    """All figures of plan.json, with the way to each."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from leaves(each, (*way, key))
    elif isinstance(value, list):
        for k, each in enumerate(value):
            yield from leaves(each, (*way, k))
    else:
        yield way, value


def changed(r, value):
    """Another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + int(r.choice([-3, -1, 1, 7, 1000]))
    if isinstance(value, float):
        return float(value * r.choice([0.0, 0.5, 0.9, 1.1, 2.0, -1.0]) + r.choice([0.0, 1e3]))
    return f"{value}x" if value is not None else 0.5


@pytest.mark.parametrize("seed", range(40))
def test_any_changed_figure_fails_or_is_named_as_not_checked(again, capsys, seed):
    r = np.random.default_rng(seed)
    said = json.loads((again.folder / "plan.json").read_text())
    said.pop(KEY)
    ways = list(leaves(said))
    way, value = ways[int(r.integers(len(ways)))]
    new = changed(r, value)
    if new == value:
        return
    now = copy.deepcopy(said)
    place = now
    for key in way[:-1]:
        place = place[key]
    place[way[-1]] = new
    again.figures(lambda of_plan: (of_plan.clear(), of_plan.update(now)))
    code, out = again.verdict(capsys)
    if code == 0:
        verdict = out.splitlines()[-2:]
        named = way[0] in AS_SAID or (way[0] in IN_THE_VERDICT and any("within" in line for line in verdict))
        hidden = way[0] == "usage" and way[1] == "jerk" and value <= new <= 1.0001
        assert named or hidden, (way, value, new)


@pytest.mark.parametrize("seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.sweep) for seed in range(10, 40))])
def test_any_changed_column_fails(again, capsys, seed):
    """A column scaled, shifted in time, exchanged or with a value that is far off, in part or as a whole."""
    r = np.random.default_rng(seed)
    name = COLUMNS[seed % len(COLUMNS)]

    def change(arrays):
        value = arrays[name]
        if name == "joints":
            arrays[name] = np.roll(value, int(r.integers(1, len(value))))
            return
        if value.dtype.kind == "i":
            arrays[name] = part_of(value, lambda p: p + int(r.choice([-2, -1, 1, 5])))
            return
        kind = r.integers(0, 3)
        largest = np.abs(value).max()
        if kind == 0:
            arrays[name] = value * r.choice([0.0, 0.5, -1.0, 2.0])
        elif kind == 1:
            arrays[name] = part_of(value, lambda p: p * r.choice([0.0, -1.0]) + 0.01 * largest)
        else:
            value[int(r.integers(len(value)))] += 4.0 * largest
            arrays[name] = value

    again.arrays(change)
    code, said = again.verdict(capsys)
    assert code == 1 and "FAILED" in said


@pytest.mark.parametrize("name", ["plan.json", "machine.toml", "setpoints.npz", "program.ngc", "setpoints.csv", "x"])
@pytest.mark.parametrize("device", ["/dev/zero", None])
def test_a_pipe_or_a_device_in_place_of_a_file_is_refused(again, name, device, capsys):
    """Reading it would not end."""
    path = again.folder / name
    path.unlink(missing_ok=True)
    path.symlink_to(device) if device else os.mkfifo(path)
    code, said = again.verdict(capsys)
    assert code == 2 and f"{name}: is a pipe or a device" in said and len(said.splitlines()) == 1


def test_a_plan_of_a_file_whose_ending_is_none_is_verified(tmp_path, capsys):
    """The copy of the program has no ending then, and is the right one all the same."""
    program = tmp_path / "part.n-c"
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X3 F3000\nM30\n")
    out = tmp_path / "out"
    options = ["--dialect", "gcode", "--no-report"]
    assert main(["plan", str(program), "-m", "xyzac-trunnion", "-o", str(out), *options]) == 0
    code, said = Tamper(out).verdict(capsys)
    assert code == 0 and "VERIFIED" in said


@pytest.mark.parametrize("planner", ["optimal", "second-order"])
def test_what_is_planned_without_jerk_limits_is_verified(planner, tmp_path, capsys):
    """On a machine that limits no jerk, none is used, and `null` says too much; nor does a plan fail of it."""
    machine = tmp_path / "free.toml"
    assert main(["machines", "xyzac-trunnion", "--toml"]) == 0
    machine.write_text(re.sub(r"jerk = \S+", "jerk = inf", capsys.readouterr().out))
    program = tmp_path / "part.ngc"
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X3 F3000\nG1 Y2 A2\nM30\n")
    out = tmp_path / "out"
    assert main(["plan", str(program), "-m", str(machine), "-o", str(out), "--no-report", "--planner", planner]) == 0
    again = Tamper(out)
    code, said = again.verdict(capsys)
    assert code == 0 and "VERIFIED" in said
    for value in (None, 1e-3, 0.9):
        again.figures(put("usage/jerk/A", value))
        fails(again, capsys, "usage jerk of A")


def test_exit_code_is_1_above_a_limit():
    """At a usage above what is promised, however well the set-points do; and where these do not."""
    usage = write.plan_json.UsageRecord(0.5, {"X": 0.5}, {"X": 0.5}, {"X": 1.0})
    for kind in ("feed", "velocity", "acceleration", "jerk"):
        for peak, code in ((1.00009, 0), (1.0002, 1), (np.inf, 1)):
            over = msgspec.structs.replace(usage, **{kind: peak if kind == "feed" else {"X": peak}})
            assert plan_steps.exit_code(SimpleNamespace(usage=over), SimpleNamespace(ok=True)) == code
            assert plan_steps.exit_code(SimpleNamespace(usage=over), SimpleNamespace(ok=False)) == 1
    unlimited = msgspec.structs.replace(usage, jerk={"X": None})
    assert plan_steps.exit_code(SimpleNamespace(usage=unlimited), SimpleNamespace(ok=True)) == 1
