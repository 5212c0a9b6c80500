"""Targets of LinuxCNC and of TwinCAT's FIFO: rows that are the plan's, and plans that they cannot hold."""

from __future__ import annotations

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from toolpace.common.errors import UsageError, VerificationError
from toolpace.controls.export.fifo import Fifo
from toolpace.controls.export.linuxcnc.inverse_time import SWING, InverseTime
from toolpace.controls.export.linuxcnc.streamer_files import Streamer
from toolpace.machine.machine import Machine

SHOP = np.array([1e3, 1e3, 1e3, np.degrees(1.0), np.degrees(1.0)])


def renamed(motion, old, new):
    """The motion on a machine one joint of which has another name."""
    file = motion.machine.file
    chain = msgspec.structs.replace(
        file.chain,
        workpiece=tuple(new if joint == old else joint for joint in file.chain.workpiece),
        tool=tuple(new if joint == old else joint for joint in file.chain.tool),
    )
    joints = {new if name == old else name: joint for name, joint in file.joints.items()}
    machine = Machine(msgspec.structs.replace(file, chain=chain, joints=joints))
    return replace(motion, machine=machine, setpoints=replace(motion.setpoints, joints=machine.joints))


def blocks(folder):
    """Positions of the G1 blocks of a stream (n, m)."""
    lines = (folder / "stream.ngc").read_text().splitlines()
    return np.array([[float(v) for v in re.findall(r"[XYZAC]([-.0-9]+)", line)] for line in lines if line[:2] == "G1"])


class TestStreamer:
    def test_each_row_of_the_plan_is_there_to_the_last_bit(self, motion, tmp_path):
        target = Streamer()
        written = target.write(motion, tmp_path)
        assert target.check(motion, tmp_path, written)[0].worst == 0.0
        rows = np.loadtxt(tmp_path / "rows.txt")
        lead = int(re.search(r"row ([0-9]+) is the first of the plan", (tmp_path / "rows.txt").read_text())[1]) - 1
        n = len(motion.setpoints)
        assert np.array_equal(rows[lead : lead + n], motion.setpoints.q * SHOP)
        assert not rows[:1000].any() and np.ptp(rows[lead + n :], axis=0).max() == 0.0

    def test_it_leads_from_zero_to_the_start_within_the_limits(self, brief, tmp_path):
        away = replace(brief, setpoints=replace(brief.setpoints, q=brief.setpoints.q + np.array([0.1, -0.2, 0, 1, -2])))
        Streamer().write(away, tmp_path)
        rows = np.loadtxt(tmp_path / "rows.txt") / SHOP
        limits = brief.machine.limits
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
            use = np.abs(np.diff(rows[:-1000], n=order, axis=0)).max(axis=0) / 1e-3**order / limit
            assert use.max() <= 1.0001

    def test_limit3_stands_just_above_what_the_rows_use(self, brief, tmp_path):
        Streamer().write(brief, tmp_path)
        rows, text = np.loadtxt(tmp_path / "rows.txt"), (tmp_path / "play.hal").read_text()
        for pin, order, above in (("maxv", 1, 1.0005), ("maxa", 2, 1.003)):
            preset = np.array([float(value) for value in re.findall(rf"limit3\.\d\.{pin} (\S+)", text)])
            used = np.abs(np.diff(rows, n=order, axis=0)).max(axis=0) / 1e-3**order
            assert np.allclose(preset, used * above, rtol=1e-8)
        assert "period1=1000000" in text and "cfg=fffff" in text and "every joint must stand at zero" in text

    def test_a_machine_that_cannot_stand_at_zero_is_refused(self, brief, tmp_path):
        joints = dict(brief.machine.file.joints)
        joints["Z"] = msgspec.structs.replace(joints["Z"], travel=(-0.4, -0.01))
        machine = Machine(msgspec.structs.replace(brief.machine.file, joints=joints))
        with pytest.raises(UsageError, match=r"joint Z cannot stand at zero.*-0\.4 to -0\.01.*linuxcnc-g93"):
            Streamer().write(replace(brief, machine=machine), tmp_path)

    def test_a_row_that_was_changed_is_found(self, brief, tmp_path):
        target = Streamer()
        written = target.write(brief, tmp_path)
        file = tmp_path / "rows.txt"
        lines = file.read_text().splitlines()
        first, *others = lines[4000].split()
        lines[4000] = " ".join([repr(float(first) + 7.0), *others])
        file.write_text("\n".join(lines) + "\n")
        with pytest.raises(VerificationError, match=r"largest difference of a position \[mm, deg\]: \S+, allowed 0;"):
            target.check(brief, tmp_path, written)


class TestInverseTime:
    @pytest.mark.parametrize("tip", [False, True])
    def test_blocks_are_two_cycles_apart_behind_a_padded_start(self, motion, tmp_path, tip):
        target = InverseTime(tip=tip)
        written = target.write(motion, tmp_path)
        target.check(motion, tmp_path, written)
        found, points = blocks(tmp_path), motion.setpoints
        right = points.q * SHOP
        if tip:
            right[:, :3] = points.tip * 1e3
        lead, n = 500, (len(points) - 1) // 2
        assert np.abs(found[lead : lead + n] - right[2 : 2 * n + 1 : 2]).max() <= SWING * 1.02
        assert np.abs(found[:lead] - right[0]).max() <= SWING * 1.02
        # No block without displacement: such blocks take no time.
        assert np.abs(np.diff(found, axis=0)).max(axis=1).min() >= 0.4 * SWING
        text = (tmp_path / "stream.ngc").read_text()
        assert text.count("F60000\n") == len(found) and ("M428" in text) == tip
        assert max(map(len, text.splitlines())) < 256 and text.isascii()

    def test_limits_are_kept_by_the_written_positions_from_the_first_block_on(self, motion, tmp_path):
        InverseTime().write(motion, tmp_path)
        found, limits = blocks(tmp_path) / SHOP, motion.machine.limits
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
            assert (np.abs(np.diff(found, n=order, axis=0)).max(axis=0) / 2e-3**order / limit).max() <= 1.002

    def test_too_few_decimals_are_refused_with_the_figure(self, motion, tmp_path):
        with pytest.raises(
            UsageError, match=r"with 4 decimals .* jerk of \w is used to \d{3,}\.\d % .* give --digits 9"
        ):
            InverseTime(digits=4).write(motion, tmp_path)
        InverseTime(digits=8).write(motion, tmp_path)

    @pytest.mark.parametrize(
        "old, new, message", [("X", "U1", "no axis U1"), ("A", "U", "U does not"), ("X", "B", "B does not")]
    )
    def test_joints_that_linuxcnc_has_not_are_refused(self, brief, tmp_path, old, new, message):
        with pytest.raises(UsageError, match=message):
            InverseTime().write(renamed(brief, old, new), tmp_path)

    @pytest.mark.parametrize(
        "options, message",
        [({"digits": 3}, "--digits 3"), ({"digits": 15}, "--digits 15"), ({"pad": 100.0}, "--pad 100")],
    )
    def test_wrong_options_are_refused(self, options, message):
        with pytest.raises(UsageError, match=message):
            InverseTime(**options)

    def test_a_servo_period_that_is_no_multiple_is_refused(self, brief, tmp_path):
        with pytest.raises(UsageError, match=r"a block takes two periods of 0\.75 ms.* is 1\.5 time steps"):
            InverseTime(period=0.75e-3).write(brief, tmp_path)

    @pytest.mark.parametrize(
        "change",
        [
            lambda lines: [*lines[:1500], lines[1500].replace("Y", "Y1", 1), *lines[1501:]],
            lambda lines: [*lines[:1500], *lines[1501:]],
            lambda lines: [*lines[:1500], lines[1500], *lines[1500:]],
        ],
        ids=["another position", "a block less", "a block twice"],
    )
    def test_a_block_that_was_changed_is_found(self, brief, tmp_path, change):
        target = InverseTime()
        written = target.write(brief, tmp_path)
        file = tmp_path / "stream.ngc"
        file.write_text("\n".join(change(file.read_text().splitlines())) + "\n")
        with pytest.raises(VerificationError, match="nothing was written"):
            target.check(brief, tmp_path, written)

    def test_the_stream_stops_at_each_block_and_says_what_must_hold(self, brief, tmp_path):
        InverseTime().write(brief, tmp_path)
        text = (tmp_path / "stream.ngc").read_text()
        modes = re.findall(r"^(?!;).*\bG6[14][.\d]*", text, re.MULTILINE)
        assert modes == ["G21 G90 G17 G40 G49 G80 G61.1"]
        # asked only where there is such a pin, which is from 2.10 on
        asked = r"o(\d+) if \[EXISTS\[#<_hal\[ini\.traj_planner_type\]>\]\]\n.*\n.*_planner_type\]> NE 0\]\n\(MSG,"
        assert re.search(asked + r".*PLANNER_TYPE is not 0\)\n(?:.*\n){4}o\1 endif\n", text)
        assert "SERVO_PERIOD must be 1000000 ns" in text and "PLANNER_TYPE must be 0" in text and "limits.hal" in text

    def test_each_gate_of_the_guard_has_as_many_inputs_as_are_wired_and_the_output_that_is(self, brief, tmp_path):
        """logic(9): the personality has the number of inputs in its low byte; a bit stands for each output."""
        InverseTime().write(brief, tmp_path)
        text = (tmp_path / "guard.hal").read_text()
        names, personalities = re.search(r"loadrt logic names=(\S+) personality=(\S+)", text).groups()
        outputs = {"and": 0x100, "or": 0x200, "xor": 0x400, "nand": 0x800, "nor": 0x1000}
        for name, personality in zip(names.split(","), personalities.split(","), strict=True):
            wired = set(re.findall(rf"{name}\.in-(\d\d)\b", text))
            used = sum(outputs[each] for each in set(re.findall(rf"{name}\.({'|'.join(outputs)})\b", text)))
            assert int(personality, 16) == used + len(wired), name
            assert wired == {f"{k:02d}" for k in range(len(wired))}

    @pytest.mark.parametrize(
        "name, change, message",
        [
            ("guard.hal", lambda text: text.replace("gain0 0.5", "gain0 0.4", 1), "guard.hal: read back"),
            ("limits.hal", lambda text: text.replace("window-1.max ", "window-1.max 1"), "largest relative difference"),
            ("limits.hal", lambda text: "\n".join(text.splitlines()[:-1]) + "\n", "largest relative difference"),
        ],
    )
    def test_a_guard_that_was_changed_is_found(self, brief, tmp_path, name, change, message):
        target = InverseTime()
        written = target.write(brief, tmp_path)
        file = tmp_path / name
        assert change(file.read_text()) != file.read_text()
        file.write_text(change(file.read_text()))
        with pytest.raises(VerificationError, match=message):
            target.check(brief, tmp_path, written)


class TestFifo:
    def test_rows_are_doubles_row_by_row_and_rest_at_the_end(self, motion, tmp_path):
        target = Fifo(period=2e-3, nc_cycle=2e-3, fifo_rows=250, fifo_axes=5)
        written = target.write(motion, tmp_path)
        target.check(motion, tmp_path, written)
        rows = np.fromfile(tmp_path / "rows.lreal", dtype="<f8").reshape(-1, 5)
        n = (len(motion.setpoints) - 1) // 2
        assert np.array_equal(rows[:n], motion.setpoints.q[: 2 * n : 2] * SHOP)
        assert len(rows) >= n + 50 and np.ptp(rows[-50:], axis=0).max() == 0.0
        text = (tmp_path / "how_to_use.txt").read_text()
        assert "1 X [mm], 2 Y [mm], 3 Z [mm], 4 A [deg], 5 C [deg]" in text and "T_f 0.002 s" in text
        assert "at most 125 rows" in text

    @pytest.mark.parametrize(
        "options, message",
        [
            ({"fifo_axes": 4}, "--fifo-axes 4: the plan has 5 columns"),
            ({"fifo_rows": 12}, "--fifo-rows 12: they last 12 ms, and a PLC that comes every 10 ms needs 20 rows"),
            ({"nc_cycle": 2e-3}, "--period 1 ms is shorter than the NC's cycle .2 ms."),
            ({"period": 3e-3, "nc_cycle": 2e-3}, "is 1.5 cycles of the NC"),
            ({"scale": "mm"}, "--scale mm"),
        ],
    )
    def test_what_the_channel_cannot_hold_is_refused_with_the_figure(self, brief, tmp_path, options, message):
        with pytest.raises(UsageError, match=message):
            Fifo(**options).write(brief, tmp_path)

    @pytest.mark.parametrize("change", [lambda data: data[:-8], lambda data: data[:8000] + b"\x01" + data[8001:]])
    def test_bytes_that_were_changed_are_found(self, brief, tmp_path, change):
        target = Fifo()
        written = target.write(brief, tmp_path)
        file = tmp_path / "rows.lreal"
        file.write_bytes(change(file.read_bytes()))
        with pytest.raises(VerificationError, match="largest difference of a position"):
            target.check(brief, tmp_path, written)
