"""A tip that keeps to one side of its program: plans of all efforts, the judge, programs that tell normals."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.heidenhain import read
from tests.support.table_table import MACHINE
from tests.support.tool_paths import tilted, toolpath_through
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.program_plan import plan_program

TIP, AXIS = 10e-6, math.radians(0.05)
ABOVE, OUTSIDE = tp.Tolerances(TIP, side="above"), tp.Tolerances(TIP, side="outside")
CHECK = "tip, on the wrong side"


def depth(verification):
    (check,) = [check for check in verification.checks if check.what == CHECK]
    return check.value


def wave(n=120):
    """A pass over waves, with corners that both sides of the tube would cut; the normals of the surface told."""
    x = np.linspace(0.0, 0.05, n)
    tip = np.stack([x, np.zeros(n), 2e-3 * np.abs(np.sin(120.0 * x))], axis=1)
    way = np.gradient(tip, axis=0)
    out = np.stack([-way[:, 2], np.zeros(n), way[:, 0]], axis=1)
    out /= np.linalg.norm(out, axis=1)[:, None]
    return replace(toolpath_through(tip, tilted(0.5, 0.3 + 10.0 * x), feed=np.inf), normal=out)


@pytest.mark.parametrize("effort", ["low", "normal", pytest.param("high", marks=pytest.mark.sweep)])
def test_a_plan_above_its_program_never_goes_below(effort, blade, machine):
    found = plan_program(blade, machine, ABOVE, AXIS, effort=effort)
    assert found.trajectory.usage().worst <= PROMISED and 0.9 * TIP < found.path.tip_deviation <= TIP
    judged = tp.verify(found.trajectory, machine, blade, ABOVE, AXIS)
    judged.raise_if_failed()
    assert depth(judged) <= 1e-3 * TIP


def test_one_side_costs_little_time(blade, machine):
    both, above = (plan_program(blade, machine, tip, AXIS).trajectory.duration for tip in (TIP, ABOVE))
    assert both < 1.001 * above < 1.1 * both


def test_a_plan_on_both_sides_is_no_plan_on_one(blade, machine):
    both = plan_program(blade, machine, TIP, AXIS)
    judged = tp.verify(both.trajectory, machine, blade, ABOVE, AXIS)
    assert not judged.ok and [check.what for check in judged.findings] == [CHECK] and depth(judged) > 0.1 * TIP


@pytest.mark.parametrize("lowered", [0.5e-6, 3e-6])
def test_the_judge_finds_how_deep_the_tip_is(lowered, machine):
    """A program that lies higher by so much, and is straight: the way out is the tool axis, across it."""
    x = np.linspace(0.0, 0.05, 20)
    zero = np.zeros(20)
    path = toolpath_through(np.stack([x, zero, zero], axis=1), tilted(0.4, 0.0 * x), feed=np.inf)
    found = plan_program(path, machine, TIP, AXIS, effort="low")
    higher = replace(path, tip=path.tip + lowered * path.axis)
    judged = tp.verify(found.trajectory, machine, higher, ABOVE, AXIS)
    assert not judged.ok and depth(judged) == pytest.approx(lowered, abs=2e-8)
    tp.verify(found.trajectory, machine, higher, TIP, AXIS).raise_if_failed()


@pytest.mark.parametrize("effort", ["normal", "high"])
def test_a_plan_outside_keeps_out_of_the_part_by_the_programs_normals(effort, machine):
    path = wave()
    found = plan_program(path, machine, OUTSIDE, AXIS, effort=effort)
    judged = tp.verify(found.trajectory, machine, path, OUTSIDE, AXIS)
    judged.raise_if_failed()
    inverted = replace(path, normal=-path.normal)
    assert depth(tp.verify(found.trajectory, machine, inverted, OUTSIDE, AXIS)) > 0.3 * TIP


def test_where_the_program_tells_no_normals_the_side_is_not_guessed(blade, machine):
    with pytest.raises(UsageError, match="tells no normals"):
        plan_program(blade, machine, OUTSIDE, AXIS)
    told = wave()
    some = replace(told, normal=np.where(np.arange(len(told))[:, None] > 20, told.normal, np.nan))
    along = OUTSIDE.outward_along(some)
    assert np.array_equal(along[21:], told.normal[21:]) and np.array_equal(along[:21], told.axis[:21])
    assert tp.Tolerances(TIP).outward_along(told) is None and ABOVE.outward_along(told) is told.axis


def test_ln_tells_the_way_out_of_the_part():
    """NX NY NZ, at any length; in the frame of the program; blocks without them tell none."""
    text = (
        "L M128\nL X+0 Y+0 Z+9 F100\nLN X+1 Y+2 Z+3 NX+0 NY+3 NZ+4 TX+0 TY+0 TZ+1 F100\n"
        "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nLN X+2 Y+2 Z+3 NX+1 NY+0 NZ+0 TX+0 TY+0 TZ+1\nL X+9"
    )
    path = read(text, MACHINE)
    ends = path.normal[np.append(np.diff(path.block) > 0, True)]
    told = ends[~np.isnan(ends[:, 0])]
    assert np.allclose(told, [(0.0, 0.6, 0.8), (0.0, 1.0, 0.0)]) and np.isnan(ends[[0, -1]]).all()
    assert np.allclose(np.linalg.norm(path.normal[~np.isnan(path.normal[:, 0])], axis=1), 1.0)


def test_the_command_keeps_to_a_side_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = wave(60)
    blocks = [
        f"{k + 3} LN " + " ".join(
            f"{word}{value:+.6f}"
            for word, value in zip(("X", "Y", "Z", "NX", "NY", "NZ", "TX", "TY", "TZ"), [*tip * 1e3, *out, *axis])
        ) + " F3000"
        for k, (tip, out, axis) in enumerate(zip(path.tip, path.normal, path.axis))
    ]  # fmt: skip
    head, tail = ["0 BEGIN PGM W MM", "1 TOOL CALL 1 Z S9000", "2 M128"], [f"{len(blocks) + 3} END PGM W MM"]
    (tmp_path / "wave.h").write_text("\n".join([*head, *blocks, *tail]) + "\n")
    given = ["wave.h", "-m", "xyzac-trunnion", "-o", "out", "--feed", "none"]
    assert main(["plan", *given, "--side", "outside", "--effort", "low"]) == 0
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["tip_tolerances"] == "10um,outside"
    assert main(["verify", "out"]) == 0
    assert "only out of the part" in (tmp_path / "out" / "report.html").read_text()
    told = capsys.readouterr().out
    assert "within tip 10um,outside" in told and CHECK in told
    assert main(["plan", *given, "--side", "outsid"]) == 2
    assert "did you mean 'outside'" in capsys.readouterr().err
