"""Figures of options that no control can have are refused, with the range and the reason."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import replace

import numpy as np
import pytest

from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.controls.export import TARGETS, target_of
from toolpace.controls.export.rows import refuse_coarse, scale_of
from toolpace.controls.export.table import Table

ABSURD = (0.0, -1e-3, np.nan, np.inf, 1e-300, 9e-7, 1.5, 1e9, "4ms")


CYCLES = [(name, "period") for name in TARGETS if name != "program"]
CYCLES += [("beckhoff-fifo", "nc_cycle"), ("beckhoff-fifo", "plc_cycle")]


@pytest.mark.parametrize("to, option", CYCLES)
def test_what_is_no_cycle_of_a_control_is_refused(to, option):
    for value in ABSURD:
        with pytest.raises(UsageError) as told:
            target_of(to, {option: value})
        named = f"--{option.replace('_', '-')} "
        assert str(told.value).startswith(named) and "from 0.001 ms to 1.00 s; no control" in str(told.value)
    for value in (1e-6, 4e-3, 1):
        target_of(to, {option: value})


@pytest.mark.parametrize(
    "to, option, text",
    [
        ("table", "--period", "0s"),
        ("table", "--period", "-4ms"),
        ("linuxcnc-hal", "--period", "nan"),
        ("linuxcnc-g93", "--period", "1e-300s"),
        ("beckhoff-fifo", "--nc-cycle", "1e9s"),
        ("beckhoff-fifo", "--plc-cycle", "1e-300s"),
        ("beckhoff-fifo", "--plc-cycle", "0ms"),
    ],
)
def test_the_command_refuses_it_in_one_line_and_writes_nothing(plan, tmp_path, capsys, to, option, text):
    out = tmp_path / "out"
    assert main(["export", str(plan), "--to", to, f"{option}={text}", "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {option}") and said.count("\n") == 1 and len(said) < 250
    assert list(tmp_path.iterdir()) == []


def test_a_plan_that_was_never_written_has_the_tolerances_that_are_usual(motion):
    """Those of `toolpace plan` where none are given."""
    assert motion.record is not None and motion.tolerances == pytest.approx((10e-6, np.radians(0.05)))
    assert replace(motion, record=None).tolerances == pytest.approx(motion.tolerances)


def test_increments_coarser_than_the_tolerance_are_refused_with_the_figure(motion, tmp_path):
    """5 increments a mm move X by up to 0.1 mm; the plan may stray by 0.01 mm."""
    fine = {"X": "10000/mm", "Y": "10000/mm", "Z": "10000/mm", "A": "1e5/deg", "C": "1e5/deg"}
    Table(counts=fine).write(motion, tmp_path)
    with pytest.raises(UsageError, match=r"^--counts: rounding .* tip by up to 0\.1\d* mm .* \(0\.01 mm, 0\.05 deg\)"):
        Table(counts=fine | {"X": "5/mm"}).write(motion, tmp_path)
    with pytest.raises(UsageError, match=r"the tool axis by 0\.\d+ deg, more than .* times finer"):
        Table(counts=fine | {"A": "1/deg"}).write(motion, tmp_path)


def test_the_cure_that_is_told_is_one(motion):
    coarse = {"X": "7/mm", "Y": "-9/mm", "Z": "8/mm", "A": "3/deg", "C": "2/deg"}
    with pytest.raises(UsageError) as told:
        refuse_coarse(motion, motion.setpoints, scale_of(motion, "mm,deg", coarse))
    times = int(re.search(r"at least ([0-9]+) times finer", str(told.value))[1])
    figures = {joint: text.split("/") for joint, text in coarse.items()}
    finer = {joint: f"{1.05 * times * float(number)}/{unit}" for joint, (number, unit) in figures.items()}
    refuse_coarse(motion, motion.setpoints, scale_of(motion, "mm,deg", finer))


def test_the_plans_own_tolerance_counts(motion, tmp_path):
    counts = {"X": "500/mm", "Y": "500/mm", "Z": "500/mm", "A": "1e5/deg", "C": "1e5/deg"}
    Table(counts=counts).write(motion, tmp_path)
    import msgspec

    strict = msgspec.structs.replace(motion.record, tip_tolerance_mm=0.001)
    with pytest.raises(UsageError, match=r"may stray \(0\.001 mm|may stray \(1 µm"):
        Table(counts=counts).write(dataclasses.replace(motion, record=strict), tmp_path)


NEGATIVE_ZERO = re.compile(r"(?<![0-9.eE])-0(?:\.0*)?(?![0-9.eE])")


@pytest.mark.parametrize(
    ("to", "file"), [("table", "table.csv"), ("linuxcnc-hal", "rows.txt"), ("linuxcnc-g93", "stream.ngc")]
)
def test_zero_has_no_sign(brief, tmp_path, to, file):
    points = brief.setpoints
    q = np.where(np.abs(points.q) < 1e-9, -0.0, -points.q)
    turned = dataclasses.replace(points, q=q, qd=-points.qd, qdd=-points.qdd, qddd=-points.qddd)
    motion = dataclasses.replace(brief, setpoints=turned)
    target = target_of(to, {})
    target.check(motion, tmp_path, target.write(motion, tmp_path))
    text = (tmp_path / file).read_text()
    assert not NEGATIVE_ZERO.findall(text)
    assert NEGATIVE_ZERO.search("1,-0,2") and NEGATIVE_ZERO.search("X-0.000 Y1") and not NEGATIVE_ZERO.search("-0.01")
