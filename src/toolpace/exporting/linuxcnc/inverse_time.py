"""Target `linuxcnc-g93`: a program of G1 blocks under G93 that LinuxCNC runs in step with the plan, two cycles a block.

LinuxCNC plans no jerk and holds no joint to its limit where the tool centre point rules, but a block that asks for more
speed than it can have takes exactly two cycles of its servo thread under G61, where the limits of the machine are
lifted; so positions two cycles apart play a time law. Blocks without displacement are dropped, and the first blocks run
early until the queue is full: where the plan rests, before it and on the way, a linear axis swings by a tenth of a
nanometre (measured: with 0.002 nm they are dropped, with 0.1 nm every block takes two cycles).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.arrays import Floats
from toolpace.errors import UsageError, VerificationError
from toolpace.exporting.motion import PlannedMotion
from toolpace.exporting.periods import refuse_no_cycle
from toolpace.exporting.provenance import provenance, start_in_words
from toolpace.exporting.rows import Rows, rows_every
from toolpace.exporting.target import ReadBack, Written
from toolpace.units import format_angle, format_length, format_time

FILE = "stream.ngc"
AXES = "XYZABCUVW"
"""Axis words of LinuxCNC."""
SWING = 1e-7
"""By which an axis swings in mm while the plan rests."""
MOST_USE = 1.01
"""Of a limit, by differences of the positions as they are written, two cycles apart."""
DIGITS = (4, 12)
"""Decimals that can be asked for."""
CHUNK = 20_000
"""Rows that are turned into text at once."""
LIFTED = ("MAX_LINEAR_VELOCITY and each MAX_VELOCITY 1e6", "MAX_LINEAR_ACCELERATION and each MAX_ACCELERATION 1e9")
"""Settings with which the stream was measured."""
SETTLE = "G4P0.1\nM429\n"
"""A joint is the mean of three cycles: where the kinematics switch at once, the last micrometres are never driven."""
_WORD = re.compile(r"([XYZABCUVW])([-+]?[0-9.]+)")


@dataclass(frozen=True, kw_only=True)
class InverseTime:
    """A G93 stream of joint positions, or of the tip with the rotary joints."""

    name: ClassVar[str] = "linuxcnc-g93"
    period: float | None = None
    """Servo period [s]; None: the plan's time step. A block lasts two."""
    tip: bool = False
    """Whether X, Y, Z are the tip in the workpiece frame, under tool-centre-point kinematics (M428), not joints."""
    digits: int = 9
    """Decimals of positions in mm and deg."""
    pad: float = 1.0
    """Time at rest before the motion [s], for the queue to fill."""

    def __post_init__(self) -> None:
        refuse_no_cycle("--period", self.period)
        if not DIGITS[0] <= self.digits <= DIGITS[1]:
            raise UsageError(f"--digits {self.digits}: give {DIGITS[0]} to {DIGITS[1]} decimals; 9 are the usual")
        if not 0.0 <= self.pad <= 60.0:
            raise UsageError(f"--pad {self.pad:g} s: give a time up to 60 s; 1s is the usual")

    def write(self, motion: PlannedMotion, folder: Path) -> Written:
        """Write stream.ngc. Raises UsageError where the plan cannot be played so."""
        self._refuse(motion)
        rows = self._rows(motion)
        positions = self._positions(motion, rows)
        lead = self._lead(motion)
        written = np.round(np.concatenate([np.tile(positions[0], (lead, 1)), positions[1:]]), self.digits)
        self._swing(motion, written, positions[0])
        use = self._use(motion, written[max(lead - 1, 0) :], rows.period)
        with (folder / FILE).open("w", encoding="ascii", newline="\n") as stream:
            stream.write(self._head(motion, positions[0], rows.period))
            form = "G1" + "".join(f"{axis}%.{self.digits}f" for axis in motion.joints)
            form += f"F{2.0 * 60.0 / rows.period:.9g}\n"
            for start in range(0, len(written), CHUNK):
                part = written[start : start + CHUNK] + 0.0  # zero has no sign
                stream.write((form * len(part)) % tuple(part.ravel().tolist()))
            stream.write((SETTLE if self.tip else "") + "G94\nM2\n")
        what = "tip and rotary joints" if self.tip else "joints"
        show = [format_angle if turns else format_length for turns in motion.rotary]
        sag = ", ".join(f"{joint} {text(value)}" for joint, text, value in zip(motion.joints, show, rows.sag))
        return Written(
            [FILE],
            [
                f"{len(written)} blocks of two cycles of {format_time(rows.period / 2)}: {what}, {self.digits} "
                "decimals, "
                f"after {format_time(lead * rows.period)} for the queue to fill",
                f"straight from block to block it leaves the motion by at most {sag}",
                f"a limit is used to {100.0 * use:.2f} % at most, by differences of the written positions",
                f"LinuxCNC's own limits must be lifted while it runs: {'; '.join(LIFTED)}",
            ],
        )

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Every second set-point must be there, to the digits that were asked for and the swing at rest."""
        positions = self._positions(motion, self._rows(motion))[1:]
        file, lead = folder / FILE, self._lead(motion)
        allowed = 0.5 * 10.0**-self.digits + self._width + 8.0 * float(np.spacing(np.abs(positions).max()))
        worst, at, still = 0.0, -lead, False
        before: tuple[str, ...] = ()
        with file.open(encoding="ascii") as stream:
            for line in stream:
                if not line.startswith("G1"):
                    continue
                words = _WORD.findall(line)
                values = tuple(text for _, text in words)
                still = still or values == before or tuple(axis for axis, _ in words) != motion.joints
                before = values
                if at >= 0:
                    if at >= len(positions):
                        raise VerificationError(
                            f"{FILE}: read back it has more blocks than the plan; nothing was written"
                        )
                    worst = max(worst, float(np.abs(np.array(values, dtype=np.float64) - positions[at]).max()))
                at += 1
        worst = worst if at == len(positions) and not still else math.inf
        return [ReadBack("largest difference of a position [mm, deg]", worst, allowed).raise_if_failed(file)]

    @property
    def _width(self) -> float:
        """Of the swing [mm]."""
        return max(SWING, 10.0**-self.digits)

    def _refuse(self, motion: PlannedMotion) -> None:
        wrong = [joint for joint in motion.joints if len(joint) != 1 or joint not in AXES]
        if wrong:
            raise UsageError(
                f"--to {self.name}: LinuxCNC has no axis {', '.join(wrong)}; it has {', '.join(AXES)}: name the "
                "joints so in "
                "the machine file, and plan again"
            )
        turning = [joint for joint, turns in zip(motion.joints, motion.rotary) if turns != (joint in "ABC")]
        if turning:
            raise UsageError(
                f"--to {self.name}: for LinuxCNC A, B and C turn and all others move straight, and "
                f"{', '.join(turning)} "
                "does not: rename it in the machine file, and plan again"
            )
        if self.tip and not motion.setpoints.has_tool:
            raise UsageError(f"--to {self.name} --tip: the plan has no tip; leave --tip out")
        if self.tip and not set("XYZ") <= set(motion.joints):
            raise UsageError(f"--to {self.name} --tip: the tip is told by X, Y, Z, and the machine has not all of them")

    def _rows(self, motion: PlannedMotion) -> Rows:
        period = self.period or motion.dt
        try:
            return rows_every(motion, 2.0 * period)
        except UsageError as error:
            raise UsageError(f"--to {self.name}: a block takes two periods of {format_time(period)}: {error}") from None

    def _lead(self, motion: PlannedMotion) -> int:
        """Blocks at rest before the motion; an even number, so that the swing ends where the motion begins."""
        return 2 * math.ceil(self.pad / (4.0 * (self.period or motion.dt)))

    def _positions(self, motion: PlannedMotion, rows: Rows) -> Floats:
        """(n, m) what the blocks say, in mm and deg."""
        points = rows.points
        positions: Floats = points.q * motion.shop_units[1]
        if self.tip:
            columns = [motion.joints.index(axis) for axis in "XYZ"]
            positions[:, columns] = points.tip * 1e3
        return positions

    def _swing(self, motion: PlannedMotion, written: Floats, first: Floats) -> None:
        """Let one linear axis swing wherever a block would have next to no displacement (in place)."""
        column = next(j for j, turns in enumerate(motion.rotary) if not turns)
        steps = np.diff(np.concatenate([first[None], written]), axis=0)
        rest = np.abs(steps).max(axis=1) < 0.5 * self._width
        heads = np.flatnonzero(rest & ~np.concatenate([[False], rest[:-1]]))
        for head in heads.tolist():
            end = head + int(np.argmin(np.append(rest[head:], False)))
            leaves = float(steps[end, column]) if end < len(steps) else 0.0
            out = np.arange(end - head) % 2 == 0
            # Away from where the axis goes next, so that the block behind the rest is none of no displacement.
            written[head:end, column] += np.where(out, -math.copysign(self._width, leaves), 0.0)

    def _use(self, motion: PlannedMotion, written: Floats, period: float) -> float:
        """Largest share of a joint's limit, by differences of the written positions. Raises UsageError above 1.01."""
        limits, factors = motion.machine.limits, motion.shop_units[1]
        if self.tip:
            written = self._joints_of(motion, written)
        worst = (0.0, "")
        for order, kind in enumerate(("velocity", "acceleration", "jerk"), start=1):
            limit = getattr(limits, kind) * factors
            use = np.abs(np.diff(written, n=order, axis=0)).max(axis=0, initial=0.0) / period**order / limit
            worst = max([worst, *((float(value), f"{kind} of {j}") for value, j in zip(use, motion.joints))])
        if worst[0] > MOST_USE:
            raise UsageError(
                f"--to {self.name}: with {self.digits} decimals and blocks of {format_time(period)} the "
                f"{worst[1]} is used to "
                f"{100.0 * worst[0]:.1f} % of its limit, more than {100.0 * MOST_USE:.0f} %: "
                + (f"give --digits 9, not {self.digits}" if self.digits < 9 else "plan with a longer --dt")
            )
        return worst[0]

    def _joints_of(self, motion: PlannedMotion, written: Floats) -> Floats:
        """Joint positions (n, m) [mm, deg] of blocks that tell the tip."""
        machine = motion.machine
        tip = written[:, [motion.joints.index(axis) for axis in "XYZ"]] * 1e-3
        q: Floats = machine.joints_at(tip, np.radians(written[:, machine.rotary])) * motion.shop_units[1]
        return q

    def _head(self, motion: PlannedMotion, first: Floats, period: float) -> str:
        rounded = np.round(first, self.digits) + 0.0
        words = " ".join(f"{axis}{value:.{self.digits}f}" for axis, value in zip(motion.joints, rounded))
        what = "the tip in the workpiece frame and the rotary joints" if self.tip else "joint positions"
        kins = (
            "under the tool-centre-point kinematics of the machine: M428 and M429 must be remapped to switch "
            "them on and off"
            if self.tip
            else "so the kinematics must be the identity, with no offset and no tool length in force"
        )
        lines = [
            *provenance(motion, "G93 stream for LinuxCNC"),
            f"Positions are {what}, {kins}.",
            f"Each block lasts two servo periods: SERVO_PERIOD must be {round(period * 0.5e9)} ns.",
            *(f"In the INI file while it runs: {line} (mm, deg, s); set them back afterwards." for line in LIFTED),
            "The plan keeps the limits of the machine by itself; LinuxCNC must not plan it again.",
            "Feed override at 100 %, no adaptive feed, no external offsets: each changes the time law.",
            f"The first move is a rapid to the start: {start_in_words(motion)} (joints). Stand next to it.",
            "Run it first without a workpiece and with the spindle off.",
        ]
        text = "".join(f"; {line}\n" for each in lines for line in _wrapped(each))
        text += "G21 G90 G17 G40 G49 G80 G61 G94\n" + ("M428\n" if self.tip else "")
        return text + f"G0 {words}\nG4 P0.5\nG93\n"


def _wrapped(text: str, width: int = 120) -> list[str]:
    """Lines of a comment: plain letters, since LinuxCNC reads at most 255 of them."""
    import textwrap

    return textwrap.wrap(text.encode("ascii", "replace").decode(), width) or [""]
