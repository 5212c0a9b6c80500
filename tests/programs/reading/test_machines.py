"""Programs on the built-in machines, judged by the machines' own forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text


@pytest.mark.parametrize("name", Machine.names())
def test_joint_mode_follows_the_joints_and_tip_mode_the_tip(name):
    machine = Machine.load(name)
    first, second = (machine.joints[i] for i in machine.rotary)
    start = f"G0 X1 Y2 Z3 {first}5 {second}10\n"
    ways = f"G1 X10 {first}-20 {second}40 F500\nG1 Y-7 {second}38\n"

    joints = read_text(start + ways, machine, "gcode")
    linear = np.array([[1, 2, 3], [10, 2, 3], [10, -7, 3]]) * 1e-3
    rotary = np.radians([[5, 10], [-20, 40], [-20, 38]])
    q = np.zeros((3, len(machine.joints)))
    columns = [machine.joints.index(x) for x in "XYZ"]
    # without a set-up sheet the origin of the part is that of the work offset
    zero, _ = machine.forward(np.zeros((1, 5)))
    reach, _ = machine.forward(np.eye(5)[columns])
    q[:, columns] = linear - np.linalg.solve((reach - zero).T, zero[0])
    q[:, machine.rotary] = rotary
    tip, axis = machine.forward(q)
    ends = np.flatnonzero(np.diff(joints.block, append=-1))
    assert joints.tip[ends] == pytest.approx(tip, abs=1e-12)
    assert joints.axis[ends] == pytest.approx(axis, abs=1e-12)
    assert joints.rotary is not None and joints.rotary[ends] == pytest.approx(rotary)
    assert joints.rotary_joints == (first, second)

    tips = read_text("G43.4\n" + start + ways, machine, "gcode")
    ends = np.flatnonzero(np.diff(tips.block, append=-1))
    assert tips.tip[ends] == pytest.approx(linear, abs=1e-15)
    assert tips.axis[ends] == pytest.approx(axis, abs=1e-12)


@pytest.mark.parametrize("name", Machine.names())
def test_switching_modes_moves_no_machine(name):
    machine = Machine.load(name)
    first, second = (machine.joints[i] for i in machine.rotary)
    body = f"G0 X1 Y2 Z3 {first}5 {second}10\nG43.4\nG49\nM428\nM429\nG1 Z4 F100\nM2\n"
    p = read_text(body, machine, "gcode")
    assert len(p) == 2 and np.linalg.norm(p.tip[1] - p.tip[0]) == pytest.approx(1e-3)


@pytest.mark.sweep
def test_hundreds_of_turns_in_one_block_are_read():
    text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 C108000 F100000\n"
    toolpath = read_text(text, Machine.load("xyzac-trunnion"), "gcode")
    assert toolpath.rotary is not None
    turns = toolpath.rotary[-1, toolpath.rotary_joints.index("C")] / (2.0 * np.pi)
    assert abs(turns) == pytest.approx(300.0) and 3e4 < len(toolpath) < 3e5
