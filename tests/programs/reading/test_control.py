"""The virtual control: what its coordinates mean, by the joints that come of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.virtual_control import ALL, DEG, control, go, joints, place, turned
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import reference, straight_in_machine, turn_to_plane
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.coordinates.work_coordinates import INSIDE
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

TOWARDS = ("xyzac-trunnion", "xyzbc-nutating", "xyzbc-head", "xyzab-trunnion-inch", "xyzbc-millturn", "xyzbc-table")
"""Table-table, head-table with an axis at 45 degrees, head-head, in inches, mill-turn, and a table that moves in X."""
MACHINES = (*TOWARDS, "paper-ab")
"""On the paper's the joints X and Y count the way of the part, not that of the tool."""
ZERO = {"X": 0.4, "Y": 0.3, "Z": 0.2}


def angles(machine, k):
    """Rotary positions within travel, of which none is zero."""
    low, high = (np.clip(machine.travel[machine.rotary, end], -1.0, 1.0) for end in (0, 1))
    return (0.5 * (low + high) + 0.5 * (high - low) * np.array([0.5, 0.7]) * (-1) ** k).tolist()


@pytest.mark.parametrize("name", MACHINES)
def test_in_tip_mode_each_tool_is_as_long_as_the_sheet_says(name):
    machine = Machine.load(name)
    setup = SetUp(tools={"1": Tool(0.05), "2": Tool(0.21)})
    wanted = [[*place(1, 2, 3), *angles(machine, 0)], [*place(5, 2, 4), *angles(machine, 1)]]
    for tool, length in (("1", 0.05), ("2", 0.21)):
        made = control(machine, setup)
        made.change_tool(tool)
        made.set_length(tool)
        made.set_tip_mode(True)
        go(made, *wanted)
        path = made.toolpath()
        ends = [0, len(path) - 1]
        right = machine.with_tool(length).joints_at(np.array(wanted)[:, :3], np.array(wanted)[:, 3:])
        assert machine.joints_at(path.tip, path.rotary, path.tool_length)[ends] == pytest.approx(right, abs=1e-11)


@pytest.mark.parametrize("name", MACHINES)
def test_without_tip_mode_two_tools_differ_by_their_lengths_along_the_tool(name):
    machine = Machine.load(name)
    setup = SetUp(tools={"1": Tool(0.05), "2": Tool(0.21)})
    found = []
    for tool in ("1", "2"):
        made = control(machine, setup)
        made.set_length(tool)
        go(made, place(1, 2, 3, 0, 0), place(4, 6, 3, 0, 0))
        found.append(joints(made, machine))
    zeros = np.zeros((1, 2))
    lifted = [machine.joints_at(machine.axis_at(zeros) * lift, zeros) for lift in (0.0, 0.16)]
    assert found[1] - found[0] == pytest.approx(np.repeat(lifted[1] - lifted[0], 2, axis=0), abs=1e-12)


@pytest.mark.parametrize("name", TOWARDS)
@pytest.mark.parametrize("length", [None, 0.05, 0.3])
def test_with_the_rotary_joints_at_zero_tip_mode_changes_nothing(name, length):
    machine = Machine.load(name)
    offset = {"X": -0.11, "Y": -0.07, "Z": -0.3}
    setup = SetUp(offsets={"G54": offset}, machine_zero=ZERO, tools={"1": Tool(length)} if length is not None else {})
    found = []
    for tip_mode in (False, True):
        made = control(machine, setup)
        made.set_offset("G54")
        made.set_length("1")
        made.set_tip_mode(tip_mode)
        go(made, place(1, 2, 3, 0, 0), place(4, 6, -3, 0, 0))
        found.append(joints(made, machine))
    assert found[0] == pytest.approx(found[1], abs=1e-12)


def test_an_offset_counts_from_the_machines_zero_to_the_nose_or_with_its_length_to_the_tip():
    machine = Machine.load("xyzac-trunnion")
    setup = SetUp(offsets={"G54": {"X": -0.1, "Z": -0.25, "C": 30 * DEG}}, machine_zero=ZERO, tools={"7": Tool(0.08)})
    for compensated, lift in ((False, 0.0), (True, 0.08)):
        made = control(machine, setup)
        made.set_offset("G54")
        made.set_length("7" if compensated else None)
        go(made, turned(made, 10, 20, 5), turned(made, 10, 20, 5, C=10))
        found = joints(made, machine)
        assert found[-1] == pytest.approx([0.31, 0.32, -0.045 + lift, 0.0, 40 * DEG], abs=1e-12)
        assert found[0][-1] == pytest.approx(30 * DEG)


def test_an_offset_that_is_not_on_the_sheet_is_said():
    made = control(Machine.load("xyzac-trunnion"), SetUp(offsets={"G54": {"X": 0.1}}, tools={"1": Tool(0.1)}))
    made.set_offset("G55")
    made.set_length("9")
    told = " ".join(made.findings.assumptions)
    assert "G55 is not on the set-up sheet" in told and "tool 9 is not on the set-up sheet" in told
    assert list(made.findings.used.offsets) == ["G55"] and list(made.findings.used.tools) == ["9"]


def test_tools_are_found_however_their_numbers_are_written():
    setup = SetUp(tools={"5": Tool(0.1), "MILL D10": Tool(0.2)})
    assert [setup.tool(name) for name in ("05", "5", "006", "MILL D10")] == [
        Tool(0.1), Tool(0.1), None, Tool(0.2)
    ]  # fmt: skip


def test_where_tip_mode_is_fixed_where_it_was_switched_on_words_keep_the_directions_they_had():
    """On a table turned by 90 degrees, X of the program stays X of the machine, or is that of the part."""
    machine = Machine.load("xyzac-trunnion")
    names = list(machine.joints)
    for fixed, moves in ((True, "X"), (False, "Y")):
        made = control(machine, fixed_where_switched=fixed)
        go(made, turned(made, 0, 0, 0), turned(made, 30, 10, 0, C=90))
        made.set_tip_mode(True)
        before = list(made.words)
        if fixed:
            assert before[:3] == pytest.approx(place(30, 10, 0), abs=1e-12)
        made.straight([before[0] + 0.02, *before[1:]], ALL, rapid=True)
        found = joints(made, machine)
        change = found[-1] - found[-2]
        assert abs(change[names.index(moves)]) == pytest.approx(0.02, abs=1e-12)
        assert np.abs(np.delete(change, names.index(moves))).max() < 1e-12


def test_a_head_that_stands_tilted_when_tip_mode_is_switched_on_turns_no_words():
    """Only joints that carry the part do: with B of the head at 40 degrees X stays X."""
    machine = Machine.load("xyzbc-nutating")
    found = []
    for fixed in (True, False):
        made = control(machine, fixed_where_switched=fixed)
        slot = made.slot("B")
        start = place(10, 20, 30, 0, 0)
        start[slot] = 40 * DEG
        go(made, place(0, 0, 0, 0, 0), start)
        made.set_tip_mode(True)
        made.straight([0.02, 0.01, 0.0, *start[3:]], ALL, rapid=True)
        found.append(joints(made, machine)[-1])
    assert found[0] == pytest.approx(found[1], abs=1e-12)


def test_switching_modes_frames_and_lengths_moves_nothing():
    machine = Machine.load("xyzbc-trunnion")
    made = control(machine, SetUp(tools={"1": Tool(0.1), "2": Tool(0.2)}))
    go(made, turned(made, 0, 0, 0), turned(made, 30, 10, 5, B=20, C=50))
    here = joints(made, machine)
    changes = [
        lambda: made.set_tip_mode(True),
        lambda: made.set_length("1"),
        lambda: made.set_length("2"),
        lambda: made.set_frame(affine.product(affine.shift((0.1, 0, 0)), affine.rotation(0, 0.3))),
        lambda: made.set_frame(affine.rotation(2, 0.7), tilted=True),
        lambda: made.set_position({"X": 0.5, "Z": -0.2}),
        lambda: made.set_offset("G55"),
        lambda: made.set_tip_mode(False),
        lambda: made.set_frame(affine.IDENTITY),
        lambda: made.set_rotary_shift((0.1, -0.2)),
        lambda: made.set_tip_mode(True),
        lambda: made.set_length(None),
    ]
    for change in changes:
        change()
        assert joints(made, machine)[-1] == pytest.approx(here[-1], abs=1e-10)
        assert made.placement.place(made.words)[3:] == pytest.approx(turned(made, 0, 0, 0, B=20, C=50)[3:], abs=1e-12)


def test_after_a_change_of_tool_the_words_are_those_of_its_tip():
    """In tip mode another tool's tip is elsewhere, while the machine stands."""
    machine = Machine.load("xyzac-trunnion")
    made = control(machine, SetUp(tools={"1": Tool(0.1), "2": Tool(0.14)}))
    made.set_tip_mode(True)
    made.set_length("1")
    go(made, place(0, 0, 0, 0, 0), place(5, 0, 10, 0, 0))
    made.change_tool("2")
    made.set_length("2")
    assert made.words[:3] == pytest.approx(place(5, 0, 10 - 40), abs=1e-12)


def test_set_position_names_the_place_where_the_machine_is():
    made = control(Machine.load("xyzac-trunnion"))
    go(made, turned(made, 0, 0, 0), turned(made, 30, 10, 5, C=90))
    made.set_position({"X": 0.0, "C": 0.0})
    assert made.words == pytest.approx(place(0, 10, 5, 0, 0), abs=1e-12)
    made.straight(place(10, 10, 5, 0, 0), ALL, rapid=True)
    assert joints(made, made.poses.machine)[-1][:3] == pytest.approx(place(40, 10, 5), abs=1e-12)


def test_a_frame_shifts_and_turns_words_and_arcs_start_and_end_on_it():
    from toolpace.programs.reading.arcs import arc_about

    made = control(None)
    made.set_frame(affine.product(affine.shift((0.1, 0.0, 0.0)), affine.rotation(2, math.pi / 2)))
    go(made, place(10, 0, 0))
    assert made.placement.place(made.words) == pytest.approx(place(100, 10, 0), abs=1e-15)
    arc = arc_about((0.01, 0.0, 0.0), (-0.01, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    made.arc(place(-10, 0, 0), ALL, arc)
    path = made.toolpath()
    assert path.tip[-1] == pytest.approx(place(100, -10, 0), abs=1e-12)
    assert np.hypot(path.tip[:, 0] - 0.1, path.tip[:, 1]) == pytest.approx(np.full(len(path), 0.01), abs=1e-9)


@pytest.mark.parametrize("name", ["xyzac-trunnion", "xyzbc-trunnion", "xyzbc-nutating", "xyzbc-head"])
@pytest.mark.parametrize("follow", [False, True])
def test_on_a_tilted_plane_the_tool_stands_upright_and_z_goes_along_it(name, follow):
    machine = Machine.load(name)
    made = control(machine, SetUp(tools={"1": Tool(0.17)}))
    made.set_length("1")
    go(made, place(0, 0, 0, 0, 0), place(0, 0, 50, 0, 0))
    frame = affine.product(affine.shift((0.02, 0.01, 0.03)), affine.turns((2, 20 * DEG), (0, 25 * DEG)))
    made.set_frame(frame, tilted=True)
    before = list(made.words)
    turn_to_plane(made, follow=follow)
    normal = np.array(affine.direct(frame, (0.0, 0.0, 1.0)))
    assert made.poses.axis(made.placement.place(made.words)[3:]) == pytest.approx(normal, abs=1e-9)
    if follow:
        assert made.words[:3] == pytest.approx(before[:3], abs=1e-12)
    turned = made.words[3:]
    made.straight([0.0, 0.0, 0.02, *turned], ALL, rapid=True)
    made.straight([0.0, 0.0, 0.00, *turned], ALL, rapid=True)
    path = made.toolpath()
    assert path.tip[-2] - path.tip[-1] == pytest.approx(0.02 * normal, abs=1e-9)
    longer = machine.with_tool(0.17)
    tip, _ = longer.forward(longer.joints_at(path.tip[-1:], path.rotary[-1:]))
    assert tip[0] == pytest.approx([0.02, 0.01, 0.03], abs=1e-9)


def test_machine_coordinates_count_from_the_machines_zero_and_know_no_offsets():
    machine = Machine.load("xyzac-trunnion")
    made = control(machine, SetUp(machine_zero=ZERO, offsets={"G54": {"X": 0.05}}, tools={"1": Tool(0.1)}))
    made.set_offset("G54")
    made.set_length("1")
    go(made, turned(made, 0, 0, -100), turned(made, 30, 10, -100, C=40))
    made.stop()
    straight_in_machine(made, {"Z": -0.05})
    made.stop()
    straight_in_machine(made, {"X": -0.2, "C": 0.0})
    found = joints(made, machine)[made.toolpath().stop]
    assert found[-2][2] == pytest.approx(0.15, abs=1e-12) and found[-2][:2] == pytest.approx(found[-3][:2], abs=1e-12)
    assert found[-1][0] == pytest.approx(0.2, abs=1e-12) and found[-1][-1] == pytest.approx(0.0, abs=1e-12)
    assert made.findings.used.machine_zero and not any("machine coordinates" in a for a in made.findings.assumptions)


@pytest.mark.parametrize("tip_mode", [False, True])
def test_after_a_move_in_machine_coordinates_words_go_on_from_there(tip_mode):
    machine = Machine.load("xyzbc-trunnion")
    made = control(machine, SetUp(machine_zero=ZERO, tools={"1": Tool(0.1)}))
    made.set_length("1")
    made.set_tip_mode(tip_mode)
    go(made, place(0, 0, 10, 0, 0), place(30, 10, 10, 20, 40))
    straight_in_machine(made, {"Z": -0.1})
    made.straight([*made.words[:2], made.words[2] + 0.01, *made.words[3:]], ALL, rapid=True)
    made.straight(list(made.words), ALL, rapid=True)
    found = joints(made, machine)
    assert found[-2][2] == pytest.approx(0.1, abs=1e-12)
    moved = machine.forward(found)[0]
    assert np.linalg.norm(moved[-1] - moved[-2]) == pytest.approx(0.01, abs=1e-12)


def test_without_a_sheet_machine_coordinates_end_within_travel_and_that_is_said():
    machine = Machine.load("xyzac-trunnion")
    made = control(machine)
    go(made, turned(made, 0, 0, 0), turned(made, 30, 10, 0, C=40))
    straight_in_machine(made, {"Z": 0.0})
    straight_in_machine(made, {"X": 0.3})
    found = joints(made, machine)
    assert found[-2][2] == pytest.approx(machine.travel[2, 1] - INSIDE, abs=1e-12)
    assert found[-1][0] == pytest.approx(machine.travel[0, 1] - INSIDE, abs=1e-12)
    assert any("upper ends of the travel" in a for a in made.findings.assumptions)
    assert any("of X beyond its travel" in a for a in made.findings.assumptions)


def test_references_are_reached_with_the_axes_that_are_named_and_are_stops():
    machine = Machine.load("xyzac-trunnion")
    sheet = SetUp(machine_zero=ZERO, references={1: {"Z": -0.01}, 2: {"X": -0.3, "Y": -0.1, "Z": -0.02}})
    made = control(machine, sheet)
    go(made, turned(made, 0, 0, 0), turned(made, 30, 10, 0, C=40))
    reference(made, 1, ["Z"])
    reference(made, 2, ["X", "Y"])
    reference(made, 2, [])
    made.straight(place(0, 0, 0, 0, 0), ALL, rapid=True)
    path, found = made.toolpath(), joints(made, machine)
    at = [int(np.flatnonzero(np.abs(found[:, 2] - z) < 1e-12)[0]) for z in (0.19, 0.18)]
    assert found[at[0]][:2] == pytest.approx(place(30, 10, 0)[:2], abs=1e-12)
    assert found[at[1]][:3] == pytest.approx([0.1, 0.2, 0.18], abs=1e-12)
    assert path.stop[at].all() and path.rapid[at].all()
    assert list(made.findings.used.references) == [1, 2]


def test_a_start_on_the_sheet_is_where_the_path_begins():
    machine = Machine.load("xyzac-trunnion")
    made = control(machine, SetUp(machine_zero=ZERO, start={"X": -0.1, "Y": -0.1, "Z": -0.1, "C": 0.5}))
    made.straight([0.0, *made.words[1:]], 1, rapid=True)
    assert made.toolpath().block[0] == 1
    found = joints(made, machine)
    assert found[0] == pytest.approx([0.3, 0.2, 0.1, 0.0, 0.5], abs=1e-12)
    assert len(found) == 2 and found[1][1:] == pytest.approx(found[0][1:], abs=1e-12)


def test_operations_and_tools_are_those_of_the_moves_in_them():
    made = control(None)
    made.operations.begin(name="rough")
    made.change_tool("1")
    go(made, place(0, 0, 0), place(1, 0, 0))
    made.change_tool("2")
    made.operations.begin(name="finish")
    made.straight(place(2, 0, 0), ALL, rapid=False)
    made.dwell(0.5)
    path = made.toolpath()
    told = [(each.name, each.tool) for each in path.operations]
    assert [told[k] for k in path.operation] == [("rough", "1"), ("rough", "1"), ("finish", "2")]
    assert path.stop.tolist() == [True, True, True] and path.dwell[-1] == 0.5
    assert path.rapid.tolist() == [True, True, False]


def test_blocks_without_end_are_refused_with_the_cure():
    options = ReadOptions(most_blocks=10)
    made = Control(Source.from_text("G0\n"), None, Controller.load("iso"), options, Findings())
    with pytest.raises(ProgramError, match=r"more than 10 blocks.*--max-blocks"):
        for _ in range(11):
            made.begin_block(1)


def test_words_that_the_machine_lacks_are_refused_by_name():
    with pytest.raises(ProgramError, match="no axis W, its joints are X, Y, Z"):
        control(Machine.load("xyzac-trunnion")).slot("W")
    with pytest.raises(ProgramError, match="rotary word B needs the machine"):
        control(None).slot("B")
