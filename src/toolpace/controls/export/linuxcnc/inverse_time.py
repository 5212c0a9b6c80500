"""Target `linuxcnc-g93`: G1 blocks under G93, two servo cycles each, in step with the plan.

LinuxCNC plans no jerk and holds no joint to its limit where the tool centre point rules, but under G61.1 (exact stop) a
block that asks for more speed than it can have takes exactly two cycles of its servo thread, where the limits of the
machine are lifted; so positions two cycles apart play a time law. Under G61 only blocks that turn an axis do: others
that meet straight are run through in one cycle each. Blocks without displacement are dropped: where the plan rests,
before it and on the way, a linear axis swings by a tenth of a nanometre (measured: with 0.002 nm they are dropped, with
0.1 nm every block takes two cycles). Where the plan changes its tool the program waits (M0).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.controls.export.linuxcnc.guard import ABOVE, GUARD, LIMITS, MOST_JOINTS, Guard, stamp_of, stops_at
from toolpace.controls.export.linuxcnc.stream_text import Section, StreamText, longer_by, sections_of
from toolpace.controls.export.rows import CHUNK, Rows, refuse_no_cycle, rows_every
from toolpace.controls.export.target import PlannedMotion, ReadBack, Written, provenance

FILE = "stream.ngc"
AXES = "XYZABCUVW"
"""Axis words of LinuxCNC."""
SWING = 1e-7
"""By which an axis swings in mm while the plan rests."""
MOST_USE = 1.01
"""Of a limit, by differences of the positions as they are written, two cycles apart."""
DIGITS = (4, 12)
"""Decimals that can be asked for."""
AT_REST = (1e-2, 10.0)
"""Velocity and acceleration at which to stop for a joint that no plan moves [mm/s, mm/s^2 or deg]."""
LIMIT_DIGITS = 1e-8
"""Relative rounding of the guard's limits, which have nine digits."""
OUTPUTS = (0, 63)
"""Digital outputs that LinuxCNC may have."""
_WORD = re.compile(r"([XYZABCUVW])([-+]?[0-9.]+)")


@dataclass(frozen=True, kw_only=True)
class Stream(Written):
    """What was written, and the guard of it."""

    guard: Guard = field(repr=False)


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
    coordinates: str = ""
    """Axis letters of LinuxCNC's joints by number, as its KINEMATICS has them, such as XYYZ; empty: each axis once, in
    the order of AXES."""
    guard_output: int = 3
    """Number of the digital output (M64) that switches the guard on."""

    def __post_init__(self) -> None:
        refuse_no_cycle("--period", self.period)
        if not DIGITS[0] <= self.digits <= DIGITS[1]:
            raise UsageError(f"--digits {self.digits}: give {DIGITS[0]} to {DIGITS[1]} decimals; 9 are the usual")
        if not 0.0 <= self.pad <= 60.0:
            raise UsageError(f"--pad {self.pad:g} s: give a time up to 60 s; 1s is the usual")
        if not OUTPUTS[0] <= self.guard_output <= OUTPUTS[1]:
            raise UsageError(
                f"--guard-output {self.guard_output}: LinuxCNC's digital outputs are {OUTPUTS[0]} to {OUTPUTS[1]}"
            )
        if wrong := set(self.coordinates.upper()) - set(AXES):
            raise UsageError(f"--coordinates {self.coordinates[:40]}: LinuxCNC has no axis {', '.join(sorted(wrong))}")

    def write(self, motion: PlannedMotion, folder: Path) -> Stream:
        """Write stream.ngc, guard.hal and limits.hal. Raises UsageError where the plan cannot be played so."""
        self._refuse(motion)
        rows = self._rows(motion)
        sections = sections_of(motion, rows)
        self._refuse_tools(motion, sections)
        lead = self._lead(motion)
        blocks = [self._blocks(motion, each) for each in sections]
        parts = [each.joints(motion, words, self.tip) for each, words in zip(sections, blocks)]
        joints = np.concatenate(parts)
        sag = np.concatenate([each.sag(motion, words, self.tip) for each, words in zip(sections, blocks)])
        use = self._use(motion, np.concatenate([part[lead:] for part in parts]), rows.period)
        guard = self._guard(motion, joints, sag, rows.period)
        self._write_stream(folder / FILE, StreamText(motion, guard, self.tip, self.digits, rows.period / 2), sections)
        (folder / GUARD).write_text(guard.hal(self._guard_head(motion)), encoding="utf-8")
        (folder / LIMITS).write_text(guard.limits(self._limits_head(motion)), encoding="utf-8")
        what = "tip and rotary joints" if self.tip else "joints"
        stops = f", waiting for {counted(len(sections) - 1, 'further tool')}" if len(sections) > 1 else ""
        return Stream(
            [FILE, GUARD, LIMITS],
            [
                f"{len(joints) - len(sections)} blocks of two cycles of {format_time(rows.period / 2)}: {what}, "
                f"{self.digits} decimals, after {format_time(lead * rows.period)} for the queue to fill{stops}",
                f"straight from block to block it deviates from the motion by at most {motion.by_joint(rows.sag)}",
                f"highest use of a limit {100.0 * use:.2f} %, by differences of the written positions",
                f"{GUARD} and {LIMITS} stop LinuxCNC where a joint exceeds its highest planned velocity by "
                f"{100.0 * (ABOVE[0] - 1.0):.0f} % or its acceleration by {100.0 * (ABOVE[1] - 1.0):.0f} %; LinuxCNC's "
                "own limits are lifted only while they watch",
            ],
            guard=guard,
        )

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Every second set-point must be there, to the digits that were asked for and the swing at rest."""
        sections = sections_of(motion, self._rows(motion))
        lead, right = self._lead(motion), []
        for section in sections:
            words = section.words(motion, self.tip)
            right += [np.tile(words[0], (lead, 1)), words[1:]]
        positions = np.concatenate(right)
        file = folder / FILE
        allowed = 0.5 * 10.0**-self.digits + self._width + 8.0 * float(np.spacing(np.abs(positions).max()))
        worst, at, still = 0.0, 0, False
        before: tuple[str, ...] = ()
        with file.open(encoding="ascii") as stream:
            for line in stream:
                if not line.startswith("G1"):
                    before = ()
                    continue
                words_found = _WORD.findall(line)
                values = tuple(text for _, text in words_found)
                still = still or values == before or tuple(axis for axis, _ in words_found) != motion.joints
                before = values
                if at >= len(positions):
                    raise VerificationError(f"{FILE}: read back it has more blocks than the plan; nothing was written")
                worst = max(worst, float(np.abs(np.array(values, dtype=np.float64) - positions[at]).max()))
                at += 1
        worst = worst if at == len(positions) and not still else math.inf
        assert isinstance(written, Stream)
        return [
            ReadBack("largest difference of a position [mm, deg]", worst, allowed).raise_if_failed(file),
            self._check_guard(motion, folder, written.guard),
        ]

    def _check_guard(self, motion: PlannedMotion, folder: Path, guard: Guard) -> ReadBack:
        """guard.hal must be as it was written, and limits.hal hold every limit."""
        if (folder / GUARD).read_text(encoding="utf-8") != guard.hal(self._guard_head(motion)):
            raise VerificationError(f"{GUARD}: read back it is not what was written; nothing was written")
        worst = guard.difference((folder / LIMITS).read_text(encoding="utf-8"))
        return ReadBack("largest relative difference of a limit of the guard", worst, LIMIT_DIGITS).raise_if_failed(
            folder / LIMITS
        )

    def _write_stream(self, file: Path, text: StreamText, sections: list[Section]) -> None:
        motion, period = text.motion, 2.0 * text.cycle
        form = "G1" + "".join(f"{axis}%.{self.digits}f" for axis in motion.joints) + f"F{2.0 * 60.0 / period:.9g}\n"
        with file.open("w", encoding="ascii", newline="\n") as stream:
            stream.write(text.head())
            for number, section in enumerate(sections):
                words = self._blocks(motion, section)
                stream.write((text.between(section) if number else "") + text.begin(section, words[0]))
                for start in range(1, len(words), CHUNK):
                    part = words[start : start + CHUNK] + 0.0  # zero has no sign
                    stream.write((form * len(part)) % tuple(part.ravel().tolist()))
            stream.write(text.end())

    def _blocks(self, motion: PlannedMotion, section: Section) -> Floats:
        """(1 + k, m) where a section begins, and what its blocks say, as they are written: at rest, then the rows."""
        words = section.words(motion, self.tip)
        lead = np.tile(words[0], (self._lead(motion), 1))
        written = np.round(np.concatenate([lead, words[1:]]), self.digits)
        self._swing(motion, written, words[0])
        blocks: Floats = np.concatenate([np.round(words[:1], self.digits), written])
        return blocks

    def _guard(self, motion: PlannedMotion, joints: Floats, sag: Floats, period: float) -> Guard:
        """The guard of joint positions (n, m) [mm, deg] as they are written, `sag` (k, m) beside them within blocks."""
        factors = motion.shop_units[1]
        limits = motion.machine.limits
        most = stops_at(joints, sag, period, (limits.velocity * factors, limits.acceleration * factors))
        axes = self.coordinates.upper() or "".join(sorted(motion.joints, key=AXES.index))
        if missing := set(motion.joints) - set(axes):
            raise UsageError(f"--coordinates {axes}: lacks {', '.join(sorted(missing))}, which the plan moves")
        if len(axes) > MOST_JOINTS:
            raise UsageError(f"--coordinates {axes}: {len(axes)} joints, and the guard watches {MOST_JOINTS} at most")
        velocity, acceleration = (
            np.array([(dict(zip(motion.joints, each)) | {"": 0.0}).get(axis, rest) for axis in axes])
            for each, rest in zip(most, AT_REST)
        )
        return Guard(axes, velocity, acceleration, self.guard_output, stamp_of(joints))

    def _guard_head(self, motion: PlannedMotion) -> list[str]:
        return [
            *provenance(motion, "Guard of G93 streams in LinuxCNC")[:1],
            "Stops the machine (motion.enable) where a joint is commanded beyond limits.hal while a stream is played.",
            "Load it once after LinuxCNC has started, the machine off: POSTGUI_HALFILE = guard.hal in the INI file,",
            "or halcmd -i machine.ini -f guard.hal. It is the same for every plan on this machine; before each run:",
            "halcmd -f limits.hal, that of the plan. The INI file must have LINEAR_UNITS = mm, MAX_LINEAR_VELOCITY and",
            "MAX_LINEAR_ACCELERATION in [TRAJ], MAX_VELOCITY and MAX_ACCELERATION of each axis.",
            f"Streams switch it on by motion.digital-out-{self.guard_output:02d}. It does not watch following errors.",
            "motion.enable must not be connected by another file: join that signal to toolpace-allow.nor with and2.",
            "toolpace-passed-N.out shows which joint it was.",
        ]

    def _limits_head(self, motion: PlannedMotion) -> list[str]:
        return [
            *provenance(motion, "Limits of the guard of a G93 stream"),
            "Behind guard.hal: halcmd -f limits.hal. In mm, deg and s, a few per cent above what the stream uses.",
        ]

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
            raise UsageError(f"--to {self.name} --tip: the tip takes X, Y and Z, and the machine has not all of them")

    def _refuse_tools(self, motion: PlannedMotion, sections: list[Section]) -> None:
        """Raise UsageError where the tip is told, of a tool that the kinematics of a head do not show to know."""
        longest = max((longer_by(motion, each) for each in sections), key=abs)
        turned = set(motion.machine.file.chain.tool) & {j for j, turns in zip(motion.joints, motion.rotary) if turns}
        if self.tip and longest and turned:
            raise UsageError(
                f"--to {self.name} --tip: a tool of the plan is {longest * 1e3:.3f} mm longer than that of the machine "
                f"file ({motion.machine.tool_length * 1e3:.3f} mm), and {', '.join(sorted(turned))} turn it: whether "
                "LinuxCNC's kinematics of a head know its length cannot be seen from a program; leave --tip out (the "
                "joints are right for every tool), or plan with its length in the machine file"
            )

    def _rows(self, motion: PlannedMotion) -> Rows:
        period = self.period or motion.dt
        try:
            return rows_every(motion, 2.0 * period)
        except UsageError as error:
            raise UsageError(f"--to {self.name}: a block takes two periods of {format_time(period)}: {error}") from None

    def _lead(self, motion: PlannedMotion) -> int:
        """Blocks at rest before the motion; an even number, so that the swing ends where the motion begins."""
        return 2 * math.ceil(self.pad / (4.0 * (self.period or motion.dt)))

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

    def _use(self, motion: PlannedMotion, joints: Floats, period: float) -> float:
        """Largest share of a limit, by differences of joints as they are written. Raises UsageError above 1.01."""
        limits, factors = motion.machine.limits.largest, motion.shop_units[1]
        worst = (0.0, "")
        for order, kind in enumerate(("velocity", "acceleration", "jerk"), start=1):
            limit = getattr(limits, kind) * factors
            use = np.abs(np.diff(joints, n=order, axis=0)).max(axis=0, initial=0.0) / period**order / limit
            worst = max([worst, *((float(value), f"{kind} of {j}") for value, j in zip(use, motion.joints))])
        if worst[0] > MOST_USE:
            raise UsageError(
                f"--to {self.name}: with {self.digits} decimals and blocks of {format_time(period)} the "
                f"{worst[1]} is used to "
                f"{100.0 * worst[0]:.1f} % of its limit, more than {100.0 * MOST_USE:.0f} %: "
                + (f"give --digits 9, not {self.digits}" if self.digits < 9 else "plan with a longer --dt")
            )
        return worst[0]
