"""The chain of a five-axis machine, from a Fanuc's parameters 19680 to 19714.

After "Tool center point control for 5-axis machining" of 30i (A-79348E, pages 59 to 84) and the connection manual of
30i (B-63943EN-1/02, chapter 9); those of 16i and 18i are alike (A-78712E). All vectors are in machine coordinates, with
all rotary axes at zero:

    19680            2: two axes turn the tool, 12: two turn the table, 21: the first turns the tool, the second the
                     table; of two on one side the first carries the second
    19681, 19686     numbers of the first and the second axis among those of the path
    19682, 19687     1, 2, 3: X, Y, Z; 4, 5, 6: from X to Y, from Y to Z, from Z to X by the angle of 19683, 19688
    19684, 19689     0: a positive command turns head or table right-handed about that direction, 1: left-handed
    19685, 19690     angle of an axis that does not exist (19696 bits 0 and 1)
    19697            1, 2, 3: the tool points to X, Y, Z
    19700 to 19702   from machine zero to the (first) axis of the table
    19703 to 19705   from there to the second axis of the table
    19709 to 19711   from D, on the tool's axis, to the tool's axis of rotation (the second one of two)
    19712 to 19714   from there to the first axis of the tool
    19666            from the end of the tool to D along the tool's axis

That 4, 5 and 6 of 19682 count from X to Y, from Y to Z and from Z to X is an assumption, which the written file says.
The machine's position is that of the controlled point. It is on the first axis of rotation of the tool, or at the end
of the tool where 19665#5 (SVC) shifts it there (19665#4 = 0); a shift of one's own (19667) is not read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.fanuc.axes import Axis
from toolpace.machine.from_control.fanuc.parameters import Parameters, Value
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin, moved
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.from_control.unplaced_axes import HELD, hold_at_rest

KINDS = {2: "tool", 12: "table", 21: "mixed"}
SIDES = {"tool": ("tool", "tool"), "table": ("table", "table"), "mixed": ("tool", "table")}
"""What the first and the second axis turn."""
VECTORS = {19700: "from machine zero to the table's first axis", 19703: "from the table's first axis to its second",
           19709: "from D on the tool's axis to the tool's axis of rotation",
           19712: "from the tool's second axis of rotation to its first"}  # fmt: skip
"""First parameters of vectors."""
USED = {"tool": (19709, 19712), "table": (19700, 19703), "mixed": (19700, 19709)}
"""Vectors of each kind; those of other kinds contradict it unless they are zero."""
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CENTRED = "the controlled point is on the first axis of rotation of the tool (19665#5 = 0)"
SHIFTED = "the controlled point is at the end of the tool (19665#5 = 1)"


@dataclass(frozen=True)
class RotaryAxis:
    """One of the two axes that turn tool or table."""

    letter: str
    side: str
    """"tool" or "table"."""
    direction: Figure
    """In which head or table turns right-handed."""


def is_five_axis(parameters: Parameters) -> bool:
    """Whether the parameters tell of a mechanism with rotary axes."""
    kind = parameters.whole(19680)
    return kind is not None and kind.number != 0.0


def place_five_axes(
    parameters: Parameters, axes: Sequence[Axis], record: MachineRecord, answers: Answers
) -> None:
    """Fill in [chain], and direction and point of the rotary joints. Raises ControlFileError.

    A kind with vectors of another kind, and an axis that is named twice or not rotary, are refused with both lines.
    """
    figure = parameters.whole(19680)
    assert figure is not None
    kind = KINDS.get(int(figure.number), "")
    if not kind:
        raise figure.origins[0].error(f"= {figure.number:g}; 2 (tool), 12 (table) and 21 (mixed) can be read")
    _check_unused(parameters, kind, figure)
    first, second = (_rotary_axis(parameters, axes, record, number, SIDES[kind][number]) for number in (0, 1))
    if first.letter == second.letter:
        raise _origin(parameters, 19686).error(
            f"names the axis {second.letter}, as {_origin(parameters, 19681)} does; correct one of both"
        )
    vectors = {number: _vector(parameters, number, answers) for number in USED[kind]}
    _place(parameters, record, (first, second), vectors, figure)


def _place(
    parameters: Parameters,
    record: MachineRecord,
    both: tuple[RotaryAxis, RotaryAxis],
    vectors: Mapping[int, Figure],
    kind: Figure,
) -> None:
    """Order of the joints, points on the rotary axes, nose and direction of the tool."""
    on_table = [axis for axis in both if axis.side == "table"]
    on_tool = [axis for axis in both if axis.side == "tool"]
    record.chain["workpiece"] = Figure(tuple(axis.letter for axis in on_table), kind.origins)
    record.chain["tool"] = Figure(("X", "Y", "Z", *(axis.letter for axis in on_tool)), kind.origins)
    tool_axis = _tool_axis(parameters)
    record.chain["tool_axis"] = tool_axis
    record.chain["tool_length"] = Figure(0.0, (Origin("tools have their lengths in the set-up sheet"),))
    for axis in both:
        record.joints[axis.letter]["direction"] = axis.direction
    if on_table:
        place = vectors[19700]
        record.joints[on_table[0].letter]["point"] = place
        if len(on_table) > 1:
            record.joints[on_table[1].letter]["point"] = moved(place, vectors[19703])
    nose, point_d = _nose(parameters, tool_axis, len(on_tool), vectors)
    record.chain["spindle_nose"] = nose
    if on_tool:
        point_e = moved(point_d, vectors[19709])
        record.joints[on_tool[-1].letter]["point"] = point_e
        if len(on_tool) > 1:
            record.joints[on_tool[0].letter]["point"] = moved(point_e, vectors[19712])
    for axis, number in zip(both, (19684, 19689)):
        _remark_sense(parameters, record, axis, number)


def _nose(
    parameters: Parameters, tool_axis: Figure, axes_of_tool: int, vectors: Mapping[int, Figure]
) -> tuple[Figure, Figure]:
    """The end of the tool without length, and D, both where the controlled point is at machine zero."""
    holder = parameters.figure(19666, 0, rotary=False)
    along = Figure(
        tuple(part * (0.0 if holder is None else holder.number) for part in tool_axis.vector),
        () if holder is None else holder.origins,
    )
    zero = Figure((0.0, 0.0, 0.0), (Origin("the nose is at X, Y, Z"),))
    if not axes_of_tool:
        return moved(zero, along, -1.0), zero
    shifted, own = parameters.bit(19665, 5), parameters.bit(19665, 4)
    if shifted is not None and shifted[0]:
        if own is not None and own[0]:
            raise own[1].error("= 1: a shift of the controlled point by 19667 is not read; write the file by hand")
        nose = Figure((0.0, 0.0, 0.0), (Origin(f"{shifted[1]}: {SHIFTED}"),))
        return nose, moved(nose, along)
    centre = Figure((0.0, 0.0, 0.0), (Origin(CENTRED if shifted is None else f"{shifted[1]}: {CENTRED}"),))
    point_e = moved(centre, vectors[19712], -1.0) if axes_of_tool > 1 else centre
    point_d = moved(point_e, vectors[19709], -1.0)
    return moved(point_d, along, -1.0), point_d


def _rotary_axis(
    parameters: Parameters, axes: Sequence[Axis], record: MachineRecord, which: int, side: str
) -> RotaryAxis:
    """The first (0) or second (1) axis with its direction."""
    number, direction, angle, sense = (base + 5 * which for base in (19681, 19682, 19683, 19684))
    absent = parameters.bit(19696, which)
    vector = _direction(parameters, direction, angle, sense)
    if absent is not None and absent[0]:
        named = parameters.whole(number)
        if named is not None and named.number:
            raise absent[1].error(
                f"= 1: the axis does not exist, and {named.origin} = {named.number:g} names one; correct one of both"
            )
        return RotaryAxis(_hypothetical(parameters, record, which, absent[1]), side, vector)
    figure = _needed(parameters, number)
    if not 1 <= figure.number <= len(axes):
        raise figure.origins[0].error(
            f"= {figure.number:g}: there is no such axis among {', '.join(axis.letter for axis in axes)}; correct it"
        )
    axis = axes[int(figure.number) - 1]
    if not axis.rotary:
        raise figure.origins[0].error(f"= {figure.number:g}, and {axis.kind} says that {axis.letter} is linear")
    return RotaryAxis(axis.letter, side, vector)


def _hypothetical(parameters: Parameters, record: MachineRecord, which: int, origin: Origin) -> str:
    """A name for an axis that is only counted with, and its joint, held at its angle."""
    letter = next(letter for letter in "ABC" if letter not in record.joints)
    hold_at_rest(record, letter)
    angle = parameters.figure(19685 + 5 * which, 0, rotary=True) or Figure(0.0, (origin,))
    joint = record.joints[letter]
    joint["travel"] = Figure((angle.number - HELD, angle.number + HELD), (origin, *angle.origins))
    record.remarks.append(f"{letter} is an axis that the control only counts with: it is held at {angle.number:g} deg.")
    return letter


def _direction(parameters: Parameters, number: int, angle_number: int, sense_number: int) -> Figure:
    """The direction about which head or table turns right-handed."""
    code, sense = _needed(parameters, number), _needed(parameters, sense_number)
    if code.number not in range(1, 7):
        raise code.origins[0].error(f"= {code.number:g}; give 1 to 6 (X, Y, Z, or inclined between two of them)")
    if sense.number not in (0.0, 1.0):
        raise sense.origins[0].error(f"= {sense.number:g}; give 0 (right-handed) or 1 (left-handed)")
    angle = parameters.figure(angle_number, 0, rotary=True)
    origins = code.origins + sense.origins
    if code.number < 4:
        if angle is not None and angle.number:
            raise angle.origins[0].error(
                f"= {angle.number:g} deg inclines the axis, and {code.origin} = {code.number:g} has none inclined; "
                "correct one of both"
            )
        vector = UNIT[int(code.number) - 1]
    else:
        start = int(code.number) - 4
        inclined = 0.0 if angle is None else math.radians(angle.number)
        origins += () if angle is None else angle.origins
        parts = [0.0, 0.0, 0.0]
        turn = f"{'XYZ'[start]} to {'YZX'[start]}"
        origins += (Origin(f"assumption: {code.number:g} inclines from {turn}"),)
        parts[start], parts[(start + 1) % 3] = math.cos(inclined), math.sin(inclined)
        vector = (parts[0], parts[1], parts[2])
    sign = -1.0 if sense.number else 1.0
    return Figure(tuple(sign * part + 0.0 for part in vector), origins)


def _tool_axis(parameters: Parameters) -> Figure:
    """Where the tool points with all axes at zero, from its end to the spindle."""
    for number in (19698, 19699):
        tilt = parameters.figure(number, 0, rotary=True)
        if tilt is not None and tilt.number:
            raise tilt.origins[0].error(
                f"= {tilt.number:g} deg: a tool that is tilted at zero is not read; write the machine file by hand"
            )
    code = parameters.whole(19697)
    if code is None or code.number == 0.0:
        origins = (Origin("assumption: N19697 is not set"),) if code is None else code.origins
        return Figure(UNIT[2], origins)
    if code.number not in (1.0, 2.0, 3.0):
        raise code.origins[0].error(f"= {code.number:g}; give 1, 2 or 3 (X, Y, Z)")
    return Figure(UNIT[int(code.number) - 1], code.origins)


def _check_unused(parameters: Parameters, kind: str, figure: Figure) -> None:
    """Refuse vectors of another kind of machine, with both lines."""
    for number in (first + k for first in VECTORS if first not in USED[kind] for k in range(3)):
        other = parameters.figure(number, 0, rotary=False)
        if other is not None and other.number:
            raise other.origins[0].error(
                f"= {other.number:g} is of another kind of machine than {figure.origin} = {figure.number:g} ({kind}); "
                "correct one of both"
            )


def _remark_sense(parameters: Parameters, record: MachineRecord, axis: RotaryAxis, number: int) -> None:
    """Tell of a sense that is not the usual one: a slip there mirrors the machine."""
    sense = _needed(parameters, number)
    usual = 1.0 if axis.side == "table" else 0.0
    if sense.number != usual:
        record.remarks.append(
            f"{sense.origin} = {sense.number:g}: {axis.letter} turns against the usual sense of a {axis.side} axis "
            f"({usual:g}). Is it right?"
        )


def _needed(parameters: Parameters, number: int) -> Figure:
    figure = parameters.whole(number)
    if figure is None:
        name = parameters.files[0]
        raise ControlFileError(f"N{number} is missing, and N19680 needs it; punch all parameters", file=name)
    return figure


def _origin(parameters: Parameters, number: int) -> Origin:
    value = parameters.value(number)
    assert isinstance(value, Value)
    return value.origin


def _vector(parameters: Parameters, number: int, answers: Answers) -> Figure:
    """Three parameters as a vector, asked for where none is there. Raises ControlFileError where some are missing."""
    parts = [parameters.figure(number + k, 0, rotary=False) for k in range(3)]
    present = [part for part in parts if part is not None]
    if not present:
        unit = "in" if parameters.inch[0] else "mm"
        shown = f"N{number} to N{number + 2}, {VECTORS[number]} [{unit}]"
        return answers.numbers(Question(shown, "0, 0, 0", "a full punch has them"), 3)
    if len(present) < 3:
        raise present[0].origins[0].error(f"is there without all of N{number} to N{number + 2}; punch all parameters")
    return Figure(tuple(part.number for part in present), tuple(origin for part in present for origin in part.origins))
