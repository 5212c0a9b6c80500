"""Several tools in one plan: each export holds with the tool in the spindle, stops for the next, or refuses."""

from __future__ import annotations

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from testbed.true_tip.cases import BUILTIN, MACHINES
from testbed.true_tip.chain import Chain
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.controls.export import PlannedMotion
from toolpace.controls.export.fifo import Fifo
from toolpace.controls.export.linuxcnc.inverse_time import InverseTime
from toolpace.controls.export.linuxcnc.streamer_files import Streamer
from toolpace.controls.export.program import Program
from toolpace.controls.export.rows import refuse_coarse, scale_of, tool_changes
from toolpace.controls.export.table import Table
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints

LENGTHS = [0.02, 0.035]
"""Of two tools on a machine whose own has none [m]."""
SHEET = '[units]\nlength = "mm"\nangle = "deg"\n[tools.1]\nlength = 20\n[tools.2]\nlength = 35\n'
PROGRAM = """\
G21 G90 G94 G17
T1 M6
G43 H1
M428
G0 X0 Y0 Z30 A0 C0
G1 Z10 F6000
X10 A5 C8
G0 Z30
M429
T2 M6
G43 H2
M428
G1 X4 Y6 Z22 A-6 C5 F6000
M429
M2
"""
SHOP = np.array([1e3, 1e3, 1e3, np.degrees(1.0), np.degrees(1.0)])
LEAD = 2 * 250
"""Blocks at rest before each section, for a second of two cycles of 1 ms."""


@pytest.fixture(scope="module")
def chain():
    """Kinematics of the test's own."""
    found = Chain((BUILTIN / "linuxcnc-xyzac-trt.toml").read_text())
    assert min(abs(found.own_length - length) for length in LENGTHS) > 5e-3
    return found


@pytest.fixture(scope="module")
def motion(tmp_path_factory):
    place = tmp_path_factory.mktemp("tools")
    (place / "part.ngc").write_text(PROGRAM)
    (place / "sheet.toml").write_text(SHEET)
    arguments = ["-m", "linuxcnc-xyzac-trt", "--setup", str(place / "sheet.toml"), "--controller", "linuxcnc"]
    arguments += ["--effort", "low", "--no-report", "--out", str(place / "plan")]
    assert main(["plan", str(place / "part.ngc"), *arguments]) == 0
    return PlannedMotion.load(place / "plan")


@pytest.fixture(scope="module")
def change(motion):
    """The first set-point with the second tool."""
    (row,) = np.flatnonzero(np.diff(motion.setpoints.tool_length)) + 1
    return int(row)


def one_tool(motion, change):
    """What is done with the first tool."""
    points = motion.setpoints
    columns = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block", "tool_length")
    cut = replace(points, **{name: getattr(points, name)[: change - 1].copy() for name in columns})
    return replace(motion, setpoints=cut, record=None, duration=float(cut.t[-1]))


HALF = 600
"""Set-points from one end of a motion there and back to the other."""


def there_and_back(machine, lengths):
    """A motion from rest to rest and back, each way with a tool of its own, well within the limits."""
    t = np.arange(2 * HALF + 1) * 1e-3
    seconds, limits = HALF * 1e-3, machine.limits
    most = (limits.velocity * seconds / 1.875, limits.acceleration * seconds**2 / 5.78, limits.jerk * seconds**3 / 60.0)
    low, high = np.clip(machine.travel, -0.3, 0.3).T
    way = np.minimum(0.4 * np.min(most, axis=0), 0.2 * (high - low))
    u = np.where(t <= seconds, t / seconds, 2.0 - t / seconds)[:, None]
    q = 0.5 * (low + high) - 0.3 * way + way * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    back = np.where(t <= seconds, 1.0, -1.0)[:, None]
    qd = back * way * 30.0 * u**2 * (1.0 - u) ** 2 / seconds
    qdd = way * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / seconds**2
    used = np.where(np.arange(len(t)) <= HALF, *lengths)
    tip, axis = machine.forward(q, used)
    block = np.ones(len(t), dtype=np.int64)
    points = SetPoints(t, q, qd, qdd, np.zeros_like(q), tip, axis, block, machine.joints, used)
    return PlannedMotion(points, machine, "there and back", "", float(t[-1]), sha256={"machine": "none"})


def sections(folder, joints="XYZAC"):
    """Words of the G1 blocks (n, m) behind each G93 of a stream."""
    found = []
    for line in (folder / "stream.ngc").read_text().splitlines():
        if line == "G93":
            found.append([])
        elif line.startswith("G1"):
            words = dict(re.findall(r"([A-Z])([-.0-9]+)", line.removeprefix("G1")))
            found[-1].append([float(words[joint]) for joint in joints])
    return [np.array(each) for each in found]


class TestChanges:
    def test_the_change_is_told_with_name_and_time(self, motion, change):
        (found,) = tool_changes(motion)
        assert found.tool == "2" and abs(found.time - motion.setpoints.t[change]) <= 1.1e-3
        assert np.abs(found.q - motion.setpoints.q[change]).max() < 1e-7

    def test_tools_of_one_length_are_told_by_their_names(self, motion):
        same = replace(motion, setpoints=replace(motion.setpoints, tool_length=np.full(len(motion.setpoints), 0.02)))
        assert [each.tool for each in tool_changes(same)] == ["2"]

    def test_tools_without_names_are_told_by_their_lengths(self, motion, change):
        (found,) = tool_changes(replace(motion, record=None))
        assert found.tool == "" and abs(found.time - motion.setpoints.t[change]) <= 2.1e-3

    def test_the_tool_that_it_begins_with_is_none(self, motion, change):
        assert tool_changes(one_tool(motion, change)) == []
        first = motion.record.operations[0]
        unnamed = msgspec.structs.replace(first, tool="", time_s=0.5)
        named = msgspec.structs.replace(first, time_s=first.time_s - 0.5)
        record = msgspec.structs.replace(motion.record, operations=[unnamed, named, *motion.record.operations[1:]])
        assert len(tool_changes(replace(motion, record=record))) == 1


class TestStream:
    @pytest.mark.parametrize("tip", [False, True])
    def test_each_block_brings_the_joints_where_the_plan_has_them(self, chain, motion, change, tmp_path, tip):
        """By the tip: kinematics of the test's own, with the tool of the sheet, make the same joints of its words."""
        InverseTime(tip=tip).write(motion, tmp_path)
        points = motion.setpoints
        parts = sections(tmp_path)
        assert len(parts) == 2
        rows = (points.q[2:change:2], points.q[change + (change % 2) :: 2])
        for words, right, length in zip(parts, rows, LENGTHS):
            q = words / SHOP
            if tip:
                turned = {name: q[:, chain.names.index(name)] for name in chain.rotary}
                q = chain.joints(q[:, :3], turned, length)
            # an end of the first section lies between two rows, and the second ends behind the last
            n = min(len(right), len(q) - LEAD)
            assert abs(len(right) - (len(q) - LEAD)) <= 1
            assert np.abs(q[LEAD : LEAD + n] - right[:n]).max() < 1e-9
            assert np.abs(q[:LEAD] - q[LEAD - 1]).max() < 1e-9

    def test_the_control_is_told_how_much_longer_each_tool_is_than_the_machines_own(self, chain, motion, tmp_path):
        InverseTime(tip=True).write(motion, tmp_path)
        lines = (tmp_path / "stream.ngc").read_text().splitlines()
        told = [float(line.removeprefix("G43.1 Z")) for line in lines if line.startswith("G43.1")]
        assert told == pytest.approx([(length - chain.own_length) * 1e3 for length in LENGTHS])
        assert lines.count("M428") == lines.count("M429") == 2
        # never while the tip is held: the joints would jump by the difference
        for k in (k for k, line in enumerate(lines) if line.startswith("G43.1")):
            held = [line for line in lines[:k] if line in ("M428", "M429")]
            assert not held or held[-1] == "M429"

    def test_it_stops_for_the_next_tool_with_the_guard_off(self, motion, tmp_path):
        written = InverseTime().write(motion, tmp_path)
        lines = (tmp_path / "stream.ngc").read_text().splitlines()
        at = lines.index("M0")
        assert lines[at - 1] == "(MSG,toolpace: put in tool 2, then go on)" and lines[at - 3] == "M65 P3"
        assert "M64 P3" in lines[at:] and "waiting for 1 further tool" in written.notes[0]

    def test_a_stream_of_the_machines_own_tool_tells_no_length(self, motion, change, tmp_path):
        first = one_tool(motion, change)
        own = replace(first.setpoints, tool_length=np.zeros(0))
        InverseTime(tip=True).write(replace(first, setpoints=own), tmp_path)
        text = (tmp_path / "stream.ngc").read_text()
        assert "G43.1" not in text and "\nG49\nM428\n" in text and "\nM0\n" not in text

    def test_the_kinematics_are_asked_whether_they_know_the_tool(self, motion, tmp_path):
        InverseTime(tip=True).write(motion, tmp_path)
        text = (tmp_path / "stream.ngc").read_text()
        assert [float(told) for told in re.findall(r"xyzac-trt-kins\.tool-offset\]> - \[(.*?)\]", text)] == [20.0, 35.0]
        assert text.count("#<told> = 0\n") == 2

    def test_a_head_whose_kinematics_do_not_tell_is_refused(self, tmp_path):
        """Joints are right for every tool, and so is the tip of the tool of the machine file."""
        machine = Machine.load("xyzbc-head")
        t, none = np.arange(401) * 1e-3, np.zeros((401, 5))
        q = none + np.array([0.0, 0.0, -0.1, 0.1, 0.2])
        for longer in (0.0, 0.03):
            lengths = np.full(len(t), machine.tool_length + longer)
            tip, axis = machine.forward(q, lengths)
            block = np.ones(len(t), dtype=np.int64)
            points = SetPoints(
                t, q.copy(), none.copy(), none.copy(), none.copy(), tip, axis, block, machine.joints, lengths
            )
            rest = PlannedMotion(points, machine, "rest", "", 0.4, sha256={"machine": "none"})
            InverseTime(pad=0.01).write(rest, tmp_path)
            if longer:
                with pytest.raises(
                    UsageError, match=r"30\.000 mm longer than .*\(120\.000 mm\), and B, C turn it.*leave --tip out"
                ):
                    InverseTime(tip=True, pad=0.01).write(rest, tmp_path)
            else:
                InverseTime(tip=True, pad=0.01).write(rest, tmp_path)

    @pytest.mark.parametrize("name", MACHINES)
    def test_words_of_the_tip_are_those_of_its_own_kinematics_on_every_machine(self, name, tmp_path):
        """Two tools, there and back by a polynomial; on heads both are as long as the machine's own."""
        machine, chain = Machine.load(name), Chain((BUILTIN / f"{name}.toml").read_text())
        head = any(joint in chain.tool for joint in chain.rotary)
        longer = (0.0, 0.0) if head else (-0.013, 0.027)
        planned = there_and_back(machine, [machine.tool_length + each for each in longer])
        InverseTime(tip=True, pad=0.01).write(planned, tmp_path)
        parts = sections(tmp_path, machine.joints)
        lead, points = 6, planned.setpoints
        parts = [part[lead:] for part in (parts if len(parts) == 2 else (parts[0], parts[0][:0]))]
        assert len(parts[1]) > 0 or head
        for words, rows, each in zip(parts, (points.q[2::2], points.q[HALF + 2 :: 2]), longer):
            units = np.array([1e3 if joint in chain.linear else np.degrees(1.0) for joint in machine.joints])
            # the chain has X, Y, Z of the tip in the columns of its linear joints
            tip = words[:, [machine.joints.index(axis) for axis in "XYZ"]] * 1e-3
            turned = {joint: (words / units)[:, machine.joints.index(joint)] for joint in chain.rotary}
            q = chain.joints(tip, turned, machine.tool_length + each)
            assert np.abs(q - rows[: len(q)]).max(initial=0.0) < 1e-9

    def test_a_joint_that_rests_at_the_ends_of_blocks_may_move_within_them(self, tmp_path):
        """C turns under a tip that goes along: X and Y rest, but straight from block to block they cannot."""
        machine = Machine.load("linuxcnc-xyzac-trt")
        turning = there_and_back(machine, [machine.tool_length] * 2).setpoints
        # a turn of a fifth of the limit of velocity, with X and Y at 0.3 m from the axis
        q = np.where(np.arange(5) == 4, turning.q, np.array([0.3, 0.0, 0.0, 0.0, 0.0]))
        tip, axis = machine.forward(q)
        rates = [np.where(np.arange(5) == 4, each, 0.0) for each in (turning.qd, turning.qdd, turning.qddd)]
        points = SetPoints(turning.t.copy(), q, *rates, tip, axis, turning.block.copy(), machine.joints)
        resting = PlannedMotion(points, machine, "turn", "", float(points.t[-1]), sha256={"machine": "none"})
        InverseTime(tip=True, pad=0.01, period=5e-3).write(resting, tmp_path)
        text = (tmp_path / "limits.hal").read_text()
        chain = Chain((BUILTIN / "linuxcnc-xyzac-trt.toml").read_text())
        middle, turn = 0.5 * (tip[10::10] + tip[:-10:10]), 0.5 * (q[10::10, 4] + q[:-10:10, 4])
        sag = chain.joints(middle, {"A": np.zeros(len(turn)), "C": turn}, 0.0)[:, 0] - 0.3
        fastest = np.abs(sag).max() * 1e3 / 5e-3
        told = float(re.search(r"velocity-window-0\.max (\S+)", text)[1])
        still = 1e-3 * machine.limits.velocity[0] * 1e3
        assert told >= 1.02 * fastest > still


class TestOthers:
    @pytest.mark.parametrize("target", [Streamer(), Fifo()])
    def test_rows_that_nothing_stops_are_refused_with_the_cure(self, motion, change, target, tmp_path):
        with pytest.raises(UsageError, match=r"changes its tool \(to tool 2 at .*\).*program of its own.*linuxcnc-g93"):
            target.write(motion, tmp_path)
        single = one_tool(motion, change)
        target.check(single, tmp_path, target.write(single, tmp_path))

    def test_a_table_tells_the_tip_of_the_tool_and_when_it_changes(self, chain, motion, change, tmp_path):
        target = Table(columns=("q", "tip"))
        notes = target.write(motion, tmp_path).notes
        assert any("changes its tool to tool 2 at" in note for note in notes)
        lines = (tmp_path / "table.csv").read_text().splitlines()
        rows = np.array([[float(v) for v in line.split(",")] for line in lines if re.match(r"[-\d]", line)])
        for part, length in ((slice(0, change), LENGTHS[0]), (slice(change, None), LENGTHS[1])):
            tip = chain.forward(rows[part, :5] / SHOP, length)[0]
            assert np.abs(tip - rows[part, 5:] * 1e-3).max() < 1e-9

    def test_rounding_to_increments_is_weighed_at_the_tip_of_each_tool(self, chain, motion, change):
        counts = {"X": "60/mm", "Y": "60/mm", "Z": "60/mm", "A": "9/deg", "C": "9/deg"}
        with pytest.raises(UsageError, match="moves the tip by up to") as told:
            refuse_coarse(motion, motion.setpoints, scale_of(motion, "mm,deg", counts))
        figure = float(re.search(r"tip by up to ([\d.]+) mm", str(told.value))[1])
        steps, q = np.array([60e3] * 3 + [np.degrees(9.0)] * 2), motion.setpoints.q
        rounded = np.rint(q * steps) / steps
        moved = []
        for part, length in ((slice(0, change), LENGTHS[0]), (slice(change, None), LENGTHS[1])):
            wanted, reached = (chain.forward(each[part], length)[0] for each in (q, rounded))
            moved.append(np.linalg.norm(reached - wanted, axis=1).max())
        assert figure == pytest.approx(max(moved) * 1e3, rel=1e-2)

    def test_the_program_keeps_its_tools(self, motion, tmp_path):
        target = Program()
        written = target.write(motion, tmp_path)
        target.check(motion, tmp_path, written)
        assert (tmp_path / written.files[0]).read_text().count(" M6") == 2
