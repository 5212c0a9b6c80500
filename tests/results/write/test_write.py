"""A plan's folder: whole or not at all, by the contract, and enough to judge from."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support import motions
from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import whole_file, whole_folder
from toolpace.judge import verify
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.results import write

CONTRACT = {
    "duration_s": float,
    "lower_bound_s": float,
    "gap": float,
    "solve_s": float,
    "fit_s": float,
    "mesh_points": int,
    "blocks": int,
    "stops": int,
    "usage": dict,
    "limited_by": dict,
    "tip_deviation_mm": float,
    "axis_deviation_deg": float,
    "machine": str,
    "program": str,
    "toolpace_version": str,
    "continuous_bound_s": float,
    "open_places": list,
}
TRAJECTORY = motions.Trajectory()
POINTS = TRAJECTORY.sample()
PROGRAM = motions.program()
PATH = SimpleNamespace(tip_deviation=3e-6, axis_deviation=1e-4, fit_seconds=0.5)


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("G1 X1\n")
    return path


def everything(folder, program, *, toolpath=PROGRAM, trajectory=TRAJECTORY, csv=False, report=False, **known):
    result = write.PlanResult(
        trajectory=trajectory, machine=motions.machine(), setpoints=POINTS, toolpath=toolpath, path=PATH,
        program=program, **known,
    )  # fmt: skip
    return write.write_folder(folder, result, csv=csv, report=report)


def test_plan_json_keeps_the_contract(tmp_path, program):
    result = verify(POINTS, motions.machine(), motions.program())
    everything(tmp_path / "out", program, verification=result, feed="120%", tip_tolerance=1e-5, axis_tolerance=1e-3)
    plan = json.loads((tmp_path / "out" / "plan.json").read_text())
    for key, kind in CONTRACT.items():
        assert isinstance(plan[key], kind), key
    assert plan["open_places"] == [{"from_s": 0.5, "to_s": 0.7, "gain_s": 0.1, "block": 3}]
    assert set(plan["usage"]) == {"feed", "velocity", "acceleration", "jerk"}
    for kind in ("velocity", "acceleration", "jerk"):
        assert set(plan["usage"][kind]) == set(POINTS.joints)
    assert plan["gap"] == pytest.approx(plan["duration_s"] / plan["lower_bound_s"] - 1.0)
    assert plan["tip_deviation_mm"] == pytest.approx(result.tip_deviation * 1e3)
    assert plan["axis_deviation_deg"] == pytest.approx(np.degrees(result.axis_deviation))
    assert (plan["stops"], plan["program"], plan["program_file"]) == (1, "part.ngc", "program.ngc")
    assert (plan["feed"], plan["verified"]) == ("120%", True)
    assert plan["tip_tolerance_mm"] == pytest.approx(0.01)


def test_an_unknown_bound_is_null(tmp_path, program):
    record = everything(tmp_path / "o", program, toolpath=None, trajectory=motions.Trajectory(0.0))
    assert record.lower_bound_s is None
    assert record.gap is None
    assert write.read_plan(tmp_path / "o") == record


def test_all_files_appear_by_one_rename_plan_json_written_last(tmp_path, program, monkeypatch):
    """plan.json tells of the time that the other files took, and the folder is put in its place once."""
    moved, kept = [], (Path.replace, Path.rename)
    monkeypatch.setattr(Path, "replace", lambda own, to: (moved.append(Path(to).name), kept[0](own, to))[1])
    monkeypatch.setattr(Path, "rename", lambda own, to: (moved.append(Path(to).name), kept[1](own, to))[1])
    record = everything(tmp_path / "out", program, csv=True, step_s={"reading": 1.0})
    assert set(record.step_s) == {"reading", write.WRITING} and record.step_s[write.WRITING] > 0.0
    assert moved == ["setpoints.npz", "setpoints.csv", "plan.json", "out"]


def test_the_files_are_enough_to_judge_again(tmp_path, program):
    everything(tmp_path / "out", program)
    names = sorted(p.name for p in (tmp_path / "out").iterdir())
    assert names == ["machine.toml", "plan.json", "program.ngc", "setpoints.npz"]
    machine = Machine.load(tmp_path / "out" / "machine.toml")
    points = SetPoints.load(tmp_path / "out" / "setpoints.npz")
    assert verify(points, machine, motions.program()).ok
    assert (tmp_path / "out" / "program.ngc").read_text() == program.read_text()


def test_csv_has_units_and_full_digits(tmp_path):
    write.write_csv(tmp_path / "s.csv", POINTS, motions.machine())
    header = (tmp_path / "s.csv").read_text().splitlines()[0].split(",")
    assert header[:6] == ["t [s]", "X [mm]", "Y [mm]", "Z [mm]", "A [deg]", "C [deg]"]
    assert "A jerk [deg/s3]" in header
    assert header[-1] == "block"
    table = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)
    assert table.shape == (len(POINTS), len(header))
    np.testing.assert_allclose(table[:, 1] / 1e3, POINTS.q[:, 0], rtol=1e-14, atol=1e-18)
    np.testing.assert_allclose(np.radians(table[:, 4]), POINTS.q[:, 3], rtol=1e-14)
    np.testing.assert_array_equal(table[:, -1], POINTS.block)


def test_nothing_is_left_behind_where_it_fails(tmp_path, program):
    before = sorted(p.name for p in tmp_path.iterdir())
    with pytest.raises(UsageError, match="cannot read"):
        everything(tmp_path / "out", tmp_path / "missing.ngc")
    with pytest.raises(UsageError, match="is a file"):
        everything(program, program)
    assert sorted(p.name for p in tmp_path.iterdir()) == before
    assert program.read_text() == "G1 X1\n"


def test_an_old_plan_survives_a_failed_one(tmp_path, program):
    out = tmp_path / "out"
    everything(out, program)
    old = (out / "plan.json").read_bytes()
    with pytest.raises(RuntimeError), whole_folder(out) as folder:
        (folder / "plan.json").write_text("half")
        raise RuntimeError
    with pytest.raises(RuntimeError), whole_file(out / "plan.json") as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert (out / "plan.json").read_bytes() == old
    assert len(list(out.iterdir())) == 4
    assert len(list(tmp_path.iterdir())) == 2


def test_a_name_with_a_zero_byte_is_one_line(tmp_path):
    with pytest.raises(UsageError, match="zero byte"), whole_file(tmp_path / "law\0.bin"):
        raise AssertionError
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["", "{", "[]", '{"duration_s": "x"}', '{"duration_s": 1}', "\udcff"])
def test_a_damaged_plan_is_one_line(tmp_path, text):
    (tmp_path / "plan.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ToolpaceError) as caught:
        write.read_plan(tmp_path)
    assert "plan.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_plan_is_one_line(tmp_path):
    with pytest.raises(UsageError, match="no such file"):
        write.read_plan(tmp_path / "nowhere")
