"""Parameters of machines as a Fanuc control punches them, written from the definitions of its manuals."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np

from toolpace.common.units import DEGREE, INCH, MILLIMETRE
from toolpace.machine.machine import Machine

HOLDER = 25.0
"""Tool holder offset (19666) of machines with a head [mm]."""


def rotary_sides(machine: Machine) -> tuple[list[str], list[str]]:
    """Rotary joints that turn the workpiece and those that turn the tool, from the bed on."""
    joints, chain = machine.file.joints, machine.file.chain
    sides = ([name for name in side if joints[name].kind == "rotary"] for side in (chain.workpiece, chain.tool))
    table, head = sides
    return table, head


def machine_zero(machine: Machine, shifted: bool) -> np.ndarray:
    """(3,) [m] where the controlled point is with every joint at zero, in the frame of the bed.

    It is at the end of the tool, or on the first axis that turns the tool (19665#5 = 0).
    """
    _, head = rotary_sides(machine)
    nose = np.array(machine.file.chain.spindle_nose)
    return nose if shifted or not head else np.array(machine.file.joints[head[0]].point)


class _Writer:
    """Lines in the format of an old or a newer control."""

    def __init__(self, machine: Machine, form: str, inch: bool) -> None:
        self.new = form == "30i"
        self.joints = machine.file.joints
        self.length = INCH if inch else MILLIMETRE
        self.inch = inch
        self.lines: dict[int, str] = {}

    def number(self, value: float, kind: str, rotary: bool) -> str:
        """A number in the machine's units, as real number or in the least increments of IS-C."""
        if self.new:
            text = f"{value:.12f}".rstrip("0")
            return text + "0" if text.endswith(".") else text
        tenth = 0.1 if self.inch and not rotary else 1.0
        count = value / (tenth * (1e-4 if kind == "length" else 1.0))
        assert math.isclose(count, round(count), abs_tol=1e-6), value
        return str(round(count))

    def axes(self, number: int, texts: list[str]) -> None:
        q = "Q1" if self.new else ""
        self.lines[number] = f"N{number:05d}{q}" + "".join(f"A{k}P{text}" for k, text in enumerate(texts, 1) if text)

    def path(self, number: int, text: str) -> None:
        self.lines[number] = f"N{number:05d}{'Q1L1' if self.new else ''}P{text}"

    def vector(self, number: int, vector: np.ndarray) -> None:
        for k, part in enumerate(vector):
            self.path(number + k, self.number(part / self.length + 0.0, "length", rotary=False))


def parameters_text(
    machine: Machine,
    form: str = "30i",
    *,
    shifted: bool = True,
    inch: bool = False,
    changes: Mapping[int, str | None] | None = None,
) -> str:
    """The text that a control punches.

    form: "30i" with real numbers, or "16i" with whole ones. shifted: where the controlled point is (`machine_zero`).
    changes: lines in place of those of a parameter, or beside them; None leaves the parameter out.
    """
    writer = _Writer(machine, form, inch)
    _write_axes(writer)
    _write_mechanism(writer, machine, shifted)
    lines = writer.lines | dict(changes or {})
    return "%\n" + "".join(f"{line}\n" for _, line in sorted(lines.items()) if line is not None) + "%\n"


def _write_axes(writer: _Writer) -> None:
    names = list(writer.joints)
    rotary = [writer.joints[name].kind == "rotary" for name in names]
    units = [DEGREE if turns else writer.length for turns in rotary]
    writer.path(1001, f"0000000{writer.inch:d}")
    writer.axes(1006, [f"0000000{turns:d}" for turns in rotary])
    writer.axes(1013, ["00000010"] * len(names))
    writer.axes(1020, [str(ord(name)) for name in names])
    writer.axes(1022, [str("XYZ".find(name) + 1) for name in names])
    ends = [writer.joints[name].travel or (1.0, -1.0) for name in names]
    for number, side in ((1320, 1), (1321, 0)):
        values = [end[side] / unit if end[0] < end[1] else end[side] for end, unit in zip(ends, units)]
        writer.axes(number, [writer.number(v, "length", turns) for v, turns in zip(values, rotary)])
    rapid = [writer.joints[name].velocity / unit * 60.0 for name, unit in zip(names, units)]
    writer.axes(1420, [writer.number(v, "feed", turns) for v, turns in zip(rapid, rotary)])
    own = [writer.joints[name].acceleration / unit for name, unit in zip(names, units)]
    if writer.new:
        writer.axes(1660, [writer.number(v, "acceleration", turns) for v, turns in zip(own, rotary)])
        ramps = [writer.joints[name].acceleration / writer.joints[name].jerk for name in names]
        writer.axes(1769, [_milliseconds(ramp) for ramp in ramps])
    else:
        writer.axes(1620, [_milliseconds(v / 60.0 / a) for v, a in zip(rapid, own)])


def _milliseconds(seconds: float) -> str:
    """A time constant, where it is whole milliseconds."""
    count = round(seconds * 1e3)
    return str(count) if math.isclose(seconds * 1e3, count, rel_tol=1e-12) else ""


def _write_mechanism(writer: _Writer, machine: Machine, shifted: bool) -> None:
    """19665 to 19714."""
    table, head = rotary_sides(machine)
    zero = machine_zero(machine, shifted)
    points = {name: np.array(writer.joints[name].point) for name in (*table, *head)}
    writer.path(19680, {2: "12", 1: "21", 0: "2"}[len(table)])
    order = [*head, *table] if len(table) == 1 else table or head
    for name, base in zip(order, (19681, 19686)):
        writer.path(base, str(list(writer.joints).index(name) + 1))
        _write_direction(writer, np.array(writer.joints[name].direction), base, name in table)
    tool_axis = np.array(machine.file.chain.tool_axis)
    writer.path(19697, str(int(np.argmax(tool_axis)) + 1))
    if table:
        writer.vector(19700, points[table[0]] - zero)
    if len(table) == 2:
        writer.vector(19703, points[table[1]] - points[table[0]])
    if head:
        writer.path(19665, f"00{shifted:d}00000")
        writer.path(19666, writer.number(HOLDER * MILLIMETRE / writer.length, "length", rotary=False))
        point_d = np.array(machine.file.chain.spindle_nose) + HOLDER * MILLIMETRE * tool_axis
        writer.vector(19709, points[head[-1]] - point_d)
    if len(head) == 2:
        writer.vector(19712, points[head[0]] - points[head[1]])


def _write_direction(writer: _Writer, direction: np.ndarray, base: int, on_table: bool) -> None:
    """Axis, inclination and sense: tables by their usual sense 1 where the axis is inclined."""
    unit = direction / np.linalg.norm(direction)
    along = int(np.argmax(np.abs(unit)))
    if np.count_nonzero(unit) == 1:
        code, angle, sense = along + 1, 0.0, int(unit[along] < 0.0)
    else:
        sense = int(on_table)
        unit = -unit if sense else unit
        first = next(k for k in range(3) if unit[k - 1] == 0.0)
        code, angle = first + 4, math.degrees(math.atan2(unit[(first + 1) % 3], unit[first]))
    writer.path(base + 1, str(code))
    writer.path(base + 2, writer.number(angle, "length", rotary=True))
    writer.path(base + 3, str(sense))


def without_lines(text: str, *numbers: int) -> str:
    """A text without the lines of some parameters."""
    return re.sub(rf"^N({'|'.join(f'{number:05d}' for number in numbers)})[^0-9].*\n", "", text, flags=re.MULTILINE)
