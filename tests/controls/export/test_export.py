"""The folder of an export: whole or not at all, of a sound plan, and never in the place of somebody else's."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest

import toolpace as tp
from toolpace.cli import main
from toolpace.common.errors import UsageError, VerificationError
from toolpace.common.files import whole_folder
from toolpace.common.files.seal import foreign
from toolpace.controls.export import EXPORT, TARGETS, export, target_of, write_export
from toolpace.controls.export.target import ReadBack


@pytest.mark.parametrize("to", TARGETS)
def test_each_target_writes_a_sealed_folder_and_says_what_it_read_back(plan, tmp_path, capsys, to):
    out = tmp_path / "out"
    assert main(["export", str(plan), "--to", to, "--out", str(out)]) == 0
    assert foreign(out) == ""
    said = json.loads((out / EXPORT).read_text())
    assert said["target"] == to and said["read_back"] and set(said["sha256"]) == {"machine", "program"}
    assert all((out / name).is_file() for name in said["files"])
    printed = capsys.readouterr().out
    assert "read back" in printed and said["files"][0] in printed


def test_python_takes_a_trajectory_too(motion, tmp_path):
    machine = motion.machine
    path = tp.Path.fit(tp.read_text("G1 X0 Y0 Z0 A0 C0 F600\nX3\nM2\n", machine), machine=machine)
    found = tp.export(tp.plan(path, machine), "table", tmp_path / "out", dt=2e-3)
    assert found.files[0] == "table.csv" and len(found.checks) == 1
    with pytest.raises(UsageError, match="has no program beside it; take --to table"):
        tp.export(tp.plan(path, machine), "program", tmp_path / "other")
    limits = tp.Limits([1.0, 1.0], [1.0, 1.0], [1.0, 1.0])
    bare = tp.AxisPath.from_callable(
        lambda s, order: np.zeros((len(s), 2)) + (s[:, None] if order == 0 else order == 1)
    )
    with pytest.raises(UsageError, match="planned without a machine"):
        tp.export(tp.plan(bare, limits, mesh=20), "table", tmp_path / "other")


def test_what_toolpace_did_not_write_is_not_replaced(plan, tmp_path):
    out = tmp_path / "out"
    export(plan, "table", out, period=40e-3)
    export(plan, "linuxcnc-hal", out)
    assert not (out / "table.csv").exists()
    (out / "rows.txt").write_text("mine")
    with pytest.raises(UsageError, match=r"is not replaced, since its rows\.txt was changed"):
        export(plan, "table", out)
    assert (out / "rows.txt").read_text() == "mine"
    with pytest.raises(UsageError, match="it holds part"):
        export(plan, "table", plan.parent)


@pytest.mark.parametrize(
    "error", [VerificationError("bad"), KeyboardInterrupt(), OSError(28, "No space left on device")]
)
def test_what_ends_early_leaves_nothing(plan, tmp_path, monkeypatch, error):
    from toolpace.controls.export.table import Table

    def fails(self, motion, folder, written):
        assert (folder / "table.csv").is_file()
        raise error

    monkeypatch.setattr(Table, "check", fails)
    with pytest.raises((VerificationError, KeyboardInterrupt, UsageError)):
        export(plan, "table", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def copy(plan, tmp_path):
    """A copy of the plan, to be changed."""
    shutil.copytree(plan, tmp_path / "copy")
    return tmp_path / "copy"


def failed(folder):
    """A plan whose verification failed, sealed as toolpace would have it."""
    from toolpace.common.files.seal import KEY, write_seal

    said = json.loads((folder / "plan.json").read_text())
    del said[KEY]
    said["verified"] = False
    (folder / "plan.json").write_text(json.dumps(said, indent=2))
    write_seal(folder, "plan.json")


def grown(name):
    def change(folder):
        with (folder / name).open("ab") as stream:
            stream.write(b"\n")

    return change


PLANS = {
    "set-points changed": (grown("setpoints.npz"), r"setpoints\.npz was changed after toolpace wrote it; plan again"),
    "machine changed": (grown("machine.toml"), r"machine\.toml was changed"),
    "program changed": (grown("program.ngc"), r"program\.ngc was changed"),
    "figures changed": (grown("plan.json"), "the seal at the end of plan.json"),
    "no set-points": (lambda folder: (folder / "setpoints.npz").unlink(), r"setpoints\.npz was taken out of it"),
    "no machine": (lambda folder: (folder / "machine.toml").unlink(), r"holds no file machine\.toml"),
    "no plan": (lambda folder: (folder / "plan.json").unlink(), r"holds no file plan\.json"),
    "nothing": (shutil.rmtree, "no such folder; give the one that `toolpace plan` wrote"),
    "a plan that failed": (failed, "its verification failed, and a motion that exceeds a limit is not exported"),
}


@pytest.mark.parametrize("change, message", PLANS.values(), ids=PLANS)
def test_a_plan_that_is_not_sound_is_refused(copy, tmp_path, change, message):
    change(copy)
    with pytest.raises(UsageError, match=message):
        export(copy, "table", tmp_path / "out")
    assert not (tmp_path / "out").exists()


COMMANDS = {
    "no such target": (["--to", "tabel"], "--to tabel: there is no such target; did you mean 'table'?"),
    "an option of another": (
        ["--to", "table", "--split", "20ms"],
        "--split is no option of --to table; it has --period",
    ),
    "a time without unit": (["--to", "table", "--period", "4"], "--period: time '4' has no unit"),
    "no time": (["--to", "linuxcnc-g93", "--pad", "soon"], "--pad: 'soon' is not a time"),
    "counts without figure": (["--to", "table", "--counts", "X"], "--counts X: write each joint once"),
    "a joint twice": (["--to", "table", "--counts", "X=1/mm,X=2/mm"], "--counts X=2/mm: write each joint once"),
    "between set-points": (["--to", "beckhoff-fifo", "--period", "1.5ms"], "give --resample to interpolate"),
    "no target": ([], "--to"),
}


@pytest.mark.parametrize("arguments, message", COMMANDS.values(), ids=COMMANDS)
def test_wrong_input_gets_one_clear_error(plan, tmp_path, capsys, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(plan), *arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1 and message in said
    assert list(tmp_path.iterdir()) == []


def test_options_are_those_of_the_target():
    for name in TARGETS:
        assert target_of(name, {}).name == name
    with pytest.raises(
        UsageError, match=re.escape("--tipp is no option of --to linuxcnc-g93; it has --period, --tip,")
    ):
        target_of("linuxcnc-g93", {"tipp": True})


def test_a_difference_is_told_with_both_figures(tmp_path):
    found = ReadBack("largest difference [mm]", 2.5e-3, 1e-9)
    with pytest.raises(
        VerificationError, match=r"rows: read back .* largest difference \[mm\]: 0\.0025, allowed 1e-09"
    ):
        found.raise_if_failed(tmp_path / "rows")
    with pytest.raises(VerificationError):
        ReadBack("x", float("nan"), 1.0).raise_if_failed(tmp_path / "rows")


def test_a_plan_without_set_points_says_what_it_cannot_do(tmp_path, capsys):
    program = tmp_path / "part.ngc"
    program.write_text("G21 G90\nG1 X0 Y0 Z0 A0 C0 F600\nX3\nM2\n")
    out = tmp_path / "out"
    arguments = ["-m", "xyzac-trunnion", "--no-report", "--out", str(out)]
    assert main(["plan", str(program), *arguments, "--npz", "none"]) == 0
    assert "setpoints.npz" not in capsys.readouterr().out and not (out / "setpoints.npz").exists()
    assert json.loads((out / "plan.json").read_text())["verified"] is True
    for command in (["verify", str(out)], ["export", str(out), "--to", "table", "--out", str(tmp_path / "x")]):
        assert main(command) == 2
        assert "setpoints.npz was not written (--npz no)" in capsys.readouterr().err
    assert main(["plan", str(program), *arguments, "--npz", "some"]) == 2
    assert "--npz some: give auto, full, compact or no" in capsys.readouterr().err


def test_an_export_never_replaces_a_plan(motion, tmp_path):
    """Nor any result of another kind, though toolpace wrote all of it."""
    plan = tmp_path / "plan"
    with whole_folder(plan, seal="plan.json") as folder:
        (folder / "plan.json").write_text('{"a": 1}')
    before = (plan / "plan.json").read_bytes()
    with pytest.raises(UsageError, match=r"holds another result of toolpace, plan\.json"):
        write_export(motion, target_of("table", {}), plan)
    assert (plan / "plan.json").read_bytes() == before


def test_pieces_too_short_for_any_control_are_refused():
    with pytest.raises(UsageError, match="less than 1 ms"):
        target_of("program", {"split": 1e-6})
