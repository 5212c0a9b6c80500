"""The tool of the set-up sheet is the tool that is planned, judged and told: kinematics of their own say so."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from testbed.true_tip.cases import MACHINES, MODES, Maker
from testbed.true_tip.dialects import DIALECTS, off
from testbed.true_tip.held import held
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.setup_file import setup_of_text

TIP = 10.05e-6
"""Within which the real tip is found [m]: the tolerance, and its grace."""
LAID = 10.55e-6
"""The same of programs with arcs and turns, which points follow within half a micrometre."""
FEED = 1.0001
A_CLASS_EACH = ("xyzac-trunnion", "xyzbc-head", "xyzbc-nutating")
"""Machines that everybody waits for: table and table, head and head, and a tilted axis."""
COLUMN = 1e-9
HEAVY = ("iso", "millplus")
"""Dialects whose random programs take longest; their kin, fanuc and heidenhain, are tried in every sweep."""


def check(case, effort="low"):
    found = held(case, effort)
    assert found.verified
    # in words of joints the tip goes on curves
    assert found.tip <= (LAID if case.mode == "joints" else TIP) and found.said <= TIP
    assert found.speed <= FEED
    assert found.column <= COLUMN
    return found


@pytest.mark.parametrize(
    ("machine", "length"),
    [("xyzbc-head", 0.06), ("xyzbc-head", 0.2), ("xyzbc-head", 0.3), ("xyzbc-trunnion", 0.26)],
)
def test_a_sheet_whose_tool_is_not_the_machines(machine, length):
    check(Maker(1, machine, "g43.4", [length], points=100).make())


@pytest.mark.parametrize(
    ("number", "machine"),
    [pytest.param(*each, marks=() if each[1] in A_CLASS_EACH else pytest.mark.sweep) for each in enumerate(MACHINES)],
)
def test_two_tools_on_every_class_of_machine(number, machine):
    own = Maker(0, machine).chain.own_length
    check(Maker(number, machine, MODES[number % len(MODES)], [own, round(own * 1.3, 4)], points=25).make())


def test_the_oracle_notices_a_tool_of_another_length():
    """The tip of a tool that is told 1 mm too short is off by what the axis may be off, and judged by the sheet."""
    case = Maker(1, "xyzbc-head", "g43.4", [0.2], points=60).make()
    wrong = replace(case, sheet=re.sub(r"length = 200\.0+", "length = 199.0", case.sheet))
    assert wrong.sheet != case.sheet
    assert held(wrong).column == pytest.approx(1e-3)


@pytest.mark.sweep
def test_the_judge_reads_the_lengths_from_the_sheet():
    case = Maker(2, "xyzbc-trunnion", "m428", [0.15, 0.21], points=20).make()
    machine = tp.Machine.load(case.machine)
    toolpath = tp.read_text(case.text, machine, setup=setup_of_text(case.sheet), controller="linuxcnc")
    points = tp.plan(tp.Path.fit(toolpath, machine=machine), machine).sample(2e-3)
    assert tp.verify(points, machine, toolpath, sheet=case.sheet).ok
    other = case.sheet.replace("length = 210.", "length = 211.")
    found = tp.verify(points, machine, toolpath, sheet=other).findings
    assert [check.what for check in found] == ["tool length"]
    assert found[0].value == pytest.approx(1e-3)
    # the column of a motion that was planned with another tool, or that tells another one
    for lengths in (np.full(len(points), 0.15), np.where(points.tool_length == 0.21, 0.21, 0.16)):
        wrong = replace(points, tool_length=lengths)
        assert not tp.verify(wrong, machine, toolpath, sheet=case.sheet).ok


@pytest.mark.sweep
def test_where_a_tool_is_changed_the_joints_stay():
    case = Maker(3, "xyzac-trunnion", "g43.4", [0.1, 0.2], points=20, offsets=False).make()
    setup = setup_of_text(case.sheet)
    machine = tp.Machine.load(case.machine).mounted(**setup.part)
    toolpath = tp.read_text(case.text, machine, setup=setup, controller="fanuc")
    change = np.flatnonzero(np.diff(toolpath.tool_length))
    assert len(change) == 1 and toolpath.stop[change].all()
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine)
    points = trajectory.sample(1e-3)
    row = int(np.flatnonzero(np.diff(points.tool_length))[0])
    assert np.abs(np.diff(points.q[row : row + 2], axis=0)).max() < 1e-6
    assert np.linalg.norm(points.tip[row + 1] - points.tip[row]) == pytest.approx(0.1, abs=1e-6)
    assert points.tip_steps[row] < 1e-6
    assert trajectory.tip(points.t[row + 1])[0] == pytest.approx(points.tip[row + 1], abs=1e-12)


@pytest.mark.parametrize(
    "first",
    [pytest.param(first, marks=pytest.mark.thorough if first else pytest.mark.sweep) for first in range(0, 40, 10)],
)
def test_random_programs_and_sheets(first):
    cases = [case for case in (Maker(seed).make() for seed in range(first, first + 10)) if case is not None]
    assert len(cases) >= 7
    for case in cases:
        check(case)


def worst_of(dialect, seeds):
    distances = []
    for seed in seeds:
        try:
            distances.append(off(dialect, seed))
        except ToolpaceError as error:
            assert "would have to go to" in str(error)
    assert np.isfinite(distances).any()
    return np.nanmax(distances)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("number", "dialect"),
    [pytest.param(*each, marks=pytest.mark.thorough if each[1] in HEAVY else ()) for each in enumerate(DIALECTS)],
)
def test_a_random_program_of_every_dialect(number, dialect):
    assert worst_of(dialect, [201 if number == 5 else 200 + number % 6]) <= LAID


@pytest.mark.thorough
@pytest.mark.parametrize("dialect", DIALECTS)
def test_random_programs_of_every_dialect(dialect):
    assert worst_of(dialect, range(200, 225)) <= LAID


@pytest.mark.thorough
def test_five_hundred_programs_and_sheets():
    for seed in range(1000, 1500):
        case = Maker(seed).make()
        if case is not None:
            check(case)
