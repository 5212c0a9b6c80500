"""The sections of a G93 stream, tool by tool, and the text around their blocks: modes, approach, guard."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.controls.export.linuxcnc.guard import ARMED, PLAN, Guard
from toolpace.controls.export.rows import Rows, tool_changes, tool_lengths
from toolpace.controls.export.target import PlannedMotion, provenance, start_in_words

SAME = 1e-9
"""Relative difference of times that are one."""
SETTLE = "G4 P0.1\nM429\n"
"""A joint is the mean of three cycles: where the kinematics switch at once, the last micrometres are never driven."""
READ_AHEAD = 1.0
"""Time at rest in which the interpreter reads on, before anything is in the queue of the planner [s]."""
AT_START = 0.01
"""How far a joint may be from where the plan has it before the stream [mm, deg]."""
LEAST_LONGER = 1e-9
"""Difference of tool lengths below which they are one [m]."""
TOOL_PINS = ("xyzac-trt-kins.tool-offset", "xyzbc-trt-kins.tool-offset")
"""Of kinematics that are told the length of the tool: upright, no joint shows whether they were."""
PLANNER_PIN = "ini.traj_planner_type"
"""Of LinuxCNC from 2.10 on: which planner is in force."""
NEAR = 1e-5
"""How far what they are told may be from the tool's length [mm]."""


@dataclass(frozen=True, eq=False)
class Section:
    """What is done with one tool, from rest to rest."""

    tool: str
    """That is put in before; empty for the first, and where its name is not known."""
    length: float
    """Of the tool [m]."""
    q: Floats
    """(k + 1, m) joint positions [m, rad]: where the machine stands, then the end of each block."""

    def words(self, motion: PlannedMotion, tip: bool) -> Floats:
        """(k + 1, m) what blocks say [mm, deg]: joints, or X, Y, Z of the tip in their place."""
        positions: Floats = self.q * motion.shop_units[1]
        if tip:
            columns = [motion.joints.index(axis) for axis in "XYZ"]
            positions[:, columns] = motion.machine.forward(self.q, np.full(len(self.q), self.length))[0] * 1e3
        return positions

    def joints(self, motion: PlannedMotion, words: Floats, tip: bool) -> Floats:
        """(n, m) joint positions [mm, deg] of such words."""
        if not tip:
            return words
        machine = motion.machine
        places = words[:, [motion.joints.index(axis) for axis in "XYZ"]] * 1e-3
        q = machine.joints_at(places, np.radians(words[:, machine.rotary]), np.full(len(words), self.length))
        found: Floats = q * motion.shop_units[1]
        return found

    def sag(self, motion: PlannedMotion, words: Floats, tip: bool) -> Floats:
        """(n - 1, m) how far joints are beside the straight line [mm, deg] in the middle between words (n, m)."""
        if not tip:
            return np.zeros((0, words.shape[1]))
        ends = self.joints(motion, words, tip)
        middle = self.joints(motion, 0.5 * (words[:-1] + words[1:]), tip)
        beside: Floats = middle - 0.5 * (ends[:-1] + ends[1:])
        return beside


def sections_of(motion: PlannedMotion, rows: Rows) -> list[Section]:
    """Rows of a plan, cut where it changes its tool."""
    points = rows.points
    lengths = tool_lengths(motion, points)
    found, tool, base, first = [], "", points.q[0], 1
    for change in tool_changes(motion):
        end = max(int(np.searchsorted(points.t, change.time * (1.0 - SAME))), first)
        on_row = end < len(points) and points.t[end] <= change.time * (1.0 + SAME)
        behind = end + on_row
        if behind > first:
            q = np.concatenate([base[None], points.q[first:behind], *([] if on_row else [change.q[None]])])
            found.append(Section(tool, float(lengths[(first + behind) // 2]), q))
        tool, base, first = change.tool, points.q[end] if on_row else change.q, behind
    if first < len(points):
        q = np.concatenate([base[None], points.q[first:]])
        found.append(Section(tool, float(lengths[(first + len(points)) // 2]), q))
    return found


@dataclass
class StreamText:
    """Writes what stands before, between and behind the blocks of a stream."""

    motion: PlannedMotion
    guard: Guard
    tip: bool
    digits: int
    cycle: float
    """Servo period [s]."""
    _names: Iterator[int] = field(default_factory=lambda: itertools.count(1))

    def head(self) -> str:
        """Comments, and the modes of the stream."""
        what = "the tip in the workpiece frame and the rotary joints" if self.tip else "joint positions"
        kins = (
            "under the tool-centre-point kinematics of the machine: M428 and M429 must be remapped to switch "
            "them on and off"
            if self.tip
            else "so the kinematics must be the identity, with no offset and no tool length in force"
        )
        lines = [
            *provenance(self.motion, "G93 stream for LinuxCNC"),
            f"Positions are {what}, {kins}.",
            "Load guard.hal once, with the machine off, and limits.hal before each run: without both the program ends "
            "before it moves along the path.",
            f"Each block lasts two servo periods: SERVO_PERIOD must be {self._nanoseconds} ns.",
            "From LinuxCNC 2.10 on PLANNER_TYPE must be 0. The mode must stay exact stop (G61.1): in exact path (G61) "
            "blocks that turn no axis take one cycle, and are played at up to twice their speed.",
            "LinuxCNC's own limits stay as they are: guard.hal lifts them from M64 to M65, and watches each joint "
            "meanwhile.",
            "The plan keeps the limits of the machine by itself; LinuxCNC must not plan it again.",
            "Feed override at 100 %, no adaptive feed, no external offsets: each changes the time law.",
            f"The first move is a rapid to the start: {start_in_words(self.motion)} (joints). Stand next to it.",
            "Run it first without a workpiece and with the spindle off.",
        ]
        text = "".join(f"; {line}\n" for each in lines for line in _wrapped(each))
        return text + f"M65 P{self.guard.output}\nG21 G90 G17 G40 G49 G80 G61.1 G94\n"

    def begin(self, section: Section, words: Floats) -> str:
        """To where a section begins, and the guard on; `words` (m,) are its first position."""
        text = ""
        if self.tip:
            longer = longer_by(self.motion, section)
            text += (f"G43.1 Z{longer * 1e3:.{self.digits}f}\n" if longer else "G49\n") + "M428\n"
        rounded = np.round(words, self.digits) + 0.0
        at = " ".join(f"{axis}{value:.{self.digits}f}" for axis, value in zip(self.motion.joints, rounded))
        text += f"G0 {at}\nG4 P0.2\nM66 E0 L0\n" + self._checks(section)
        watching = f"M64 P{self.guard.output}\nG4 P0.5\nM66 E0 L0\n"
        armed = self._ends(f"#<_hal[{ARMED}]> NE 1", "guard.hal does not watch")
        return f"{text}{watching}{armed}G93\nG4 P{READ_AHEAD}\n"

    def between(self, section: Section) -> str:
        """The guard off, and a wait for the tool of the next section."""
        tool = f"tool {section.tool}" if section.tool else f"the tool of {section.length * 1e3:.3f} mm"
        return f"{self._off()}(MSG,toolpace: put in {_plain(tool)}, then go on)\nM0\n"

    def end(self) -> str:
        """Behind the last block."""
        return f"{self._off()}G49\nM2\n"

    @property
    def _nanoseconds(self) -> int:
        return round(self.cycle * 1e9)

    def _off(self) -> str:
        return (SETTLE if self.tip else "G4 P0.1\n") + f"G94\nM65 P{self.guard.output}\nM66 E0 L0\n"

    def _checks(self, section: Section) -> str:
        """What must hold before the guard is switched on; none of it is asked for in a preview."""
        text = self._ends(f"EXISTS[#<_hal[{PLAN}]>] EQ 0", "guard.hal is not loaded")
        text += self._ends(f"#<_hal[{PLAN}]> NE {self.guard.stamp}", "limits.hal is not that of this stream")
        name = next(self._names)
        planner = self._ends(f"#<_hal[{PLANNER_PIN}]> NE 0", "PLANNER_TYPE is not 0")
        text += f"o{name} if [EXISTS[#<_hal[{PLANNER_PIN}]>]]\n{planner}o{name} endif\n"
        if self.tip:
            text += self._tool_check(longer_by(self.motion, section) * 1e3)
        wanted = self._nanoseconds
        text += self._ends(f"#<_ini[EMCMOT]SERVO_PERIOD> NE {wanted}", f"SERVO_PERIOD is not {wanted} ns")
        start = section.q[0] * self.motion.shop_units[1] + 0.0
        for number, axis in enumerate(self.guard.axes):
            if axis in self.motion.joints:
                value = start[self.motion.joints.index(axis)]
                text += self._ends(
                    f"ABS[#<_hal[joint.{number}.pos-cmd]> - [{value:.6f}]] GT {AT_START}",
                    f"joint {number} {axis} stands beside {value:.4f}: offsets, tool length, kinematics, units",
                )
        return text

    def _tool_check(self, longer: float) -> str:
        """That the kinematics are told how much longer the tool is than the machine's own [mm]; where it is not, they
        need not be told."""
        text = f"#<told> = {0 if longer else 1}\n"
        for pin in TOOL_PINS:
            name = next(self._names)
            told = f"#<told> = [ABS[#<_hal[{pin}]> - [{longer:.6f}]] LT {NEAR:.6f}]\n"
            text += f"o{name} if [EXISTS[#<_hal[{pin}]>]]\n{told}o{name} endif\n"
        return text + self._ends("#<told> EQ 0", f"its kinematics are not told of the tool, {longer:.3f} mm longer")

    def _ends(self, wrong: str, message: str) -> str:
        """A program that ends with a message where something is wrong."""
        outer, inner = next(self._names), next(self._names)
        ends = f"(MSG,toolpace: {message})\nM65 P{self.guard.output}\nM2\n"
        return f"o{outer} if [#<_task> EQ 1]\no{inner} if [{wrong}]\n{ends}o{inner} endif\no{outer} endif\n"


def longer_by(motion: PlannedMotion, section: Section) -> float:
    """How much longer the tool of a section is than the machine's own [m]; 0 where they are one."""
    longer = section.length - motion.machine.tool_length
    return longer if abs(longer) > LEAST_LONGER else 0.0


def _plain(text: str) -> str:
    """Letters that may stand in a comment."""
    return "".join(c if c.isascii() and c.isprintable() and c not in "();" else "?" for c in text)[:60]


def _wrapped(text: str, width: int = 120) -> list[str]:
    """Lines of a comment: plain letters, since LinuxCNC reads at most 255 of them."""
    return textwrap.wrap(text.encode("ascii", "replace").decode(), width) or [""]
