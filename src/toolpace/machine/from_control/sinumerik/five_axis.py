"""The vector chain that a control moves by: of its five-axis transformation, or of the swivel data of CYCLE800.

MD24100 TRAFO_TYPE_1 and following: 16 to 21 two axes in the head, 32 to 35 two in the table, 48 to 51 one in each, with
axes along X, Y, Z (Function Manual Transformations, F2, 06/2019, page 148); 24, 40, 56 the same with directions of
their own; 72 takes those of $TC_CARR (Commissioning Manual Operate IM9, 12/2017, page 572). TRAFO5 data are numbered by
five-axis transformations alone. Which of them is which vector is on that page; of types 48 to 51 JOINT_OFFSET leads
from machine zero to the axis of the table (MD24560). MD24520 ROT_SIGN_IS_PLUS = 0 turns a direction round; that the
table of an older type turns by the right-hand rule with 1 is read from MD24810, which says so of TRACYL (assumption:
swivel data decide where they are there). That MD24510 is the position from which turns count, as $TC_CARR24 is, is an
assumption too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.machine.from_control.record import Figure, Origin
from toolpace.machine.from_control.sinumerik.channel_axes import ChannelAxis
from toolpace.machine.from_control.sinumerik.machine_data import Datum, MachineData
from toolpace.machine.from_control.sinumerik.vector_chain import KINDS, ON_TABLE, SwivelAxis, VectorChain, is_direction
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.from_control.unplaced_axes import ALONG, TURNING

TYPES = {
    16: ("T", "AB"), 18: ("T", "BA"), 20: ("T", "CA"), 21: ("T", "CB"), 24: ("T", ""),
    32: ("P", "AB"), 33: ("P", "AC"), 34: ("P", "BA"), 35: ("P", "BC"), 40: ("P", ""),
    48: ("M", "AB"), 49: ("M", "AC"), 50: ("M", "BA"), 51: ("M", "BC"), 56: ("M", ""),
}  # fmt: skip
"""Kind, and the letters of both axes where the type has them."""
BY_CARRIER = 72
OTHERS = range(256, 4096)
"""Types that turn no tool: TRANSMIT, TRACYL, TRAANG, TRACON, ..."""
DATA = {
    "T": {"I1": "PART_OFFSET", "I2": "JOINT_OFFSET", "I3": "BASE_TOOL"},
    "P": {"I2": "BASE_TOOL", "I3": "JOINT_OFFSET", "I4": "PART_OFFSET"},
    "M": {"I1": "JOINT_OFFSET", "I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
}
OLD_MIXED = {"I2": "BASE_TOOL", "I3": "JOINT_OFFSET", "I4": "PART_OFFSET"}
"""TRAFO5 data of each vector."""
CARRIER = {"I1": 1, "I2": 4, "I3": 15, "I4": 18}
"""First $TC_CARR of each vector."""
START = 24
"""$TC_CARR of the position at which the vectors are measured."""
FINE = 40
"""By how many numbers fine offsets stand behind (W1, 08/2005, page 2-86)."""
FOREIGN = {"T": "I4", "P": "I1"}
"""Vectors that a kind does not have: a table's in a head, which the control passes over, and a head's in a table."""
TRANSFORMATIONS = 20
ALONG_Z = Figure((0.0, 0.0, 1.0), (Origin("the tool is along Z"),))


@dataclass(frozen=True)
class Transformation:
    """A five-axis transformation as TRAFO_TYPE names it."""

    kind: Datum
    number: int
    """In TRAFO_TYPE_n, TRAFO_AXES_IN_n."""
    count: int
    """In TRAFO5_..._n: among five-axis transformations."""

    @property
    def type(self) -> int:
        return int(self.kind.number())

    @property
    def is_by_letters(self) -> bool:
        """Whether the type itself names what its axes turn about."""
        return bool(TYPES[self.type][1])

    def names_axes(self, data: MachineData) -> bool:
        """Whether the files say which axes go into it."""
        return any(data.datum(f"MC_TRAFO_AXES_IN_{self.number}", place) is not None for place in range(5))

    def inputs(self, data: MachineData) -> list[tuple[int, Origin]]:
        """Numbers of its channel axes, X, Y, Z and the turning ones. Raises ControlFileError for one that is twice."""
        found: list[tuple[int, Origin]] = []
        for place in range(5):
            name = f"MC_TRAFO_AXES_IN_{self.number}"
            datum = data.datum(name, place)
            number = place + 1 if datum is None else int(datum.number())
            origin = datum.origin if datum is not None else Origin(f"default of ${name}[{place}]")
            for other, at in found:
                if number and number == other:
                    raise origin.error(f"= {number} is also {at}; each axis goes into a transformation once")
            found.append((number, origin))
        return found


def transformation(data: MachineData) -> tuple[Transformation | None, list[str]]:
    """The first five-axis transformation of the channel, and remarks on others. Raises ControlFileError."""
    found: list[Transformation] = []
    remarks = []
    for number in range(1, TRANSFORMATIONS + 1):
        datum = data.datum(f"MC_TRAFO_TYPE_{number}")
        if datum is None or not datum.number() or int(datum.number()) in OTHERS:
            continue
        if int(datum.number()) in TYPES or int(datum.number()) == BY_CARRIER:
            found.append(Transformation(datum, number, len(found) + 1))
            continue
        if not found:
            raise datum.origin.error(
                f"= {datum.number():g} is not read; types are {', '.join(map(str, TYPES))} and {BY_CARRIER}: give "
                "swivel data ($TC_CARR) in its place"
            )
        remarks.append(f"{datum.origin} = {datum.number():g} is another transformation, which is not read.")
    remarks += [f"{each.kind.origin} = {each.type}: the first transformation is taken." for each in found[1:]]
    return (found[0] if found else None), remarks


def chain_of_transformation(
    data: MachineData, found: Transformation, axes: Mapping[int, ChannelAxis], answers: Answers, length: str
) -> VectorChain:
    """Its vector chain; missing vectors are asked for. Raises ControlFileError."""
    kind, letters = TYPES[found.type]
    kind_figure = Figure(kind, (found.kind.origin,))
    names = OLD_MIXED if kind == "M" and letters else DATA[kind]
    vectors = {}
    for vector, name in names.items():
        shown = f"MC_TRAFO5_{name}_{found.count}"
        figure = data.vector([(shown, place) for place in range(3)])
        if figure is None:
            question = Question(f"${shown}, a vector [{length}]", "0, 0, 0", "the control's default")
            figure = answers.numbers(question, 3)
        vectors[vector] = figure
    foreign = data.vector([(f"MC_TRAFO5_JOINT_OFFSET_PART_{found.count}", place) for place in range(3)])
    if foreign is not None and any(foreign.vector) and "JOINT_OFFSET_PART" not in names.values():
        raise foreign.origins[0].error(
            f"is not 0, and {found.kind.origin} = {found.type} has {KINDS[kind]}: that vector is of type 56 alone"
        )
    both = []
    for place, (number, origin) in enumerate(found.inputs(data)[3:]):
        both.append(_axis(data, found, place, number, origin, axes, letters, answers) if number else None)
    check_names(both)
    base = data.vector([(f"MC_TRAFO5_BASE_ORIENT_{found.count}", place) for place in range(3)])
    tool = base if base is not None and is_direction(base) else ALONG_Z
    return VectorChain(kind_figure, (both[0], both[1]), vectors, tool)


def _axis(
    data: MachineData, found: Transformation, place: int, number: int, origin: Origin, axes: Mapping[int, ChannelAxis],
    letters: str, answers: Answers,
) -> SwivelAxis:  # fmt: skip
    """An axis of a transformation: direction and sense."""
    if number not in axes:
        raise origin.error(f"= {number}, and the channel has no such axis; give its channel data too")
    axis, kind = axes[number], TYPES[found.type][0]
    if axis.letter not in tuple(TURNING) and not found.names_axes(data):
        raise found.kind.origin.error(
            f"= {found.type} has axes that no file names ($MC_TRAFO_AXES_IN_{found.number}), and the channel's axis "
            f"{number} is {axis.name}; give the channel's data too"
        )
    if letters:
        letter = letters[place]
        if axis.letter in tuple(TURNING) and axis.letter != letter:
            raise origin.error(
                f"= {number} is the axis {axis.name} ({axis.origin}), and {found.kind.origin} = {found.type} turns "
                f"about {letter}'s; correct one of both"
            )
        direction = Figure(ALONG[letter], (found.kind.origin,))
    else:
        name = f"MC_TRAFO5_AXIS{place + 1}_{found.count}"
        stated = data.vector([(name, k) for k in range(3)])
        direction = _ask_direction(f"${name}", axis, ON_TABLE[kind][place], answers) if stated is None else stated
        if not is_direction(direction):
            raise direction.origins[0].error("is no direction; give its components, as 0, 0, 1")
    sign = data.datum(f"MC_TRAFO5_ROT_SIGN_IS_PLUS_{found.count}", place)
    if sign is not None and not sign.number():
        turned_round = tuple(-part + 0.0 for part in direction.vector)
        direction = Figure(turned_round, (*direction.origins, sign.origin))
    start = data.figure(f"MC_TRAFO5_ROT_AX_OFFSET_{found.count}", place)
    return SwivelAxis(joint_name(axis, direction), direction, start or Figure(0.0, ()), axis)


def _ask_direction(name: str, axis: ChannelAxis, on_table: bool, answers: Answers) -> Figure:
    """The direction of an axis that no file tells."""
    along = ALONG.get(axis.letter, ALONG["C"])
    usual = ", ".join(f"{(-part if on_table else part) + 0.0:g}" for part in along)
    return answers.numbers(Question(f"{name}, the direction of {axis.name}", usual, "as ISO 841 wants it"), 3)


def joint_name(axis: ChannelAxis, direction: Figure) -> str:
    """A, B or C: the letter of an axis, or of the direction that is nearest to its own."""
    if axis.letter in tuple(TURNING):
        return axis.letter
    return TURNING[int(np.abs(direction.vector).argmax())]


def check_names(axes: Sequence[SwivelAxis | None]) -> None:
    """Refuse two axes of one letter."""
    first, second = axes
    if first is not None and second is not None and first.name == second.name:
        raise second.direction.origins[0].error(
            f"is of the axis {second.name}, as is {first.direction.origins[0]}; which turns which is not clear"
        )


def carrier_numbers(data: MachineData) -> list[int]:
    """Swivel data sets whose axes the control turns."""
    return [number for number in _turning_sets(data) if _by_hand(data, number) is None]


def sets_by_hand(data: MachineData) -> list[str]:
    """Remarks on swivel data sets that are not read, as a person turns their axes."""
    found = (_by_hand(data, number) for number in _turning_sets(data))
    return [
        f"{datum.origin} = {datum.text[:20]}: a person turns axes of this swivel data set, which is not read."
        for datum in found
        if datum is not None
    ]


def _turning_sets(data: MachineData) -> list[int]:
    numbers = [number for number in data.numbers("TC_CARR") if number > 0]
    first = {number: data.vector([(f"TC_CARR{k}", number) for k in (7, 8, 9)]) for number in numbers}
    return [number for number, figure in first.items() if figure is not None and is_direction(figure)]


def _by_hand(data: MachineData, number: int) -> Datum | None:
    """$TC_CARR37 where it has an axis turned by hand: its tens are of axis 1, its hundreds of axis 2, 0 by the control.

    Commissioning Manual Operate IM9, 12/2017, page 574.
    """
    datum = data.datum("TC_CARR37", number)
    if datum is None:
        return None
    second = data.vector([(f"TC_CARR{k}", number) for k in (10, 11, 12)])
    digits = int(abs(datum.number())) // 10 % (100 if second is not None and is_direction(second) else 10)
    return datum if digits else None


def carrier_number(data: MachineData, found: Transformation | None, answers: Answers) -> int | None:
    """The swivel data set that is read: that of the transformation, or the only one, or what is answered."""
    sets = carrier_numbers(data)
    if found is not None and found.type == BY_CARRIER:
        datum = data.datum(f"MC_TRAFO5_TCARR_NO_{found.count}")
        number = 1 if datum is None else int(datum.number())
        if number not in sets:
            at = found.kind.origin if datum is None else datum.origin
            raise at.error(
                f"takes swivel data set {number}, which no file has ($TC_CARR7[{number}]) or a person turns "
                f"($TC_CARR37[{number}]); give it too"
            )
        return number
    if len(sets) < 2:
        return sets[0] if sets else None
    shown = [str(number) for number in sets]
    question = Question(f"number of the swivel data set ({', '.join(shown)})", shown[0], "the first that turns axes")
    return int(str(answers.choice(question, shown).value))


def chain_of_carrier(
    data: MachineData, number: int, axes: Mapping[int, ChannelAxis], answers: Answers, remarks: list[str]
) -> VectorChain:
    """The vector chain of a swivel data set. Raises ControlFileError."""
    datum = data.datum("TC_CARR23", number)
    kind = "T" if datum is None else datum.word()
    kind_origin = datum.origin if datum is not None else Origin(f"default of $TC_CARR23[{number}]")
    if kind not in DATA:
        raise kind_origin.error(f"= '{kind[:20]}'; give one of T, P, M")
    vectors = {}
    for name, first in CARRIER.items():
        figure = data.vector([(f"TC_CARR{first + k}", number) for k in range(3)])
        if figure is not None and any(figure.vector):
            if FOREIGN.get(kind) == name and kind != "T":
                raise figure.origins[0].error(
                    f"is not 0, and {kind_origin} = {kind} has {KINDS[kind]}: {name} is of the other side; correct one"
                )
            vectors[name] = figure
        _add_fine(data, vectors, name, number, remarks)
    if kind == "T" and (ignored := vectors.pop("I4", None)) is not None:
        remarks.append(
            f"{ignored.origin} is not 0: the control passes it over where both axes are in the head ({kind_origin}). "
            "Is T the right kind?"
        )
    both = [_carrier_axis(data, number, place, axes, answers, remarks) for place in (0, 1)]
    check_names(both)
    return VectorChain(Figure(kind, (kind_origin,)), (both[0], both[1]), vectors, ALONG_Z)


def _add_fine(data: MachineData, vectors: dict[str, Figure], name: str, number: int, remarks: list[str]) -> None:
    """Add the fine offset of a vector where the control does ($SC_TOCARR_FINE_CORRECTION)."""
    fine = data.vector([(f"TC_CARR{CARRIER[name] + FINE + k}", number) for k in range(3)])
    if fine is None or not any(fine.vector) or not _fine_counts(data, fine, remarks):
        return
    own = vectors.get(name, Figure((0.0, 0.0, 0.0), ()))
    total = tuple(one + other for one, other in zip(own.vector, fine.vector))
    vectors[name] = Figure(total, own.origins + fine.origins)


def _fine_counts(data: MachineData, fine: Figure, remarks: list[str]) -> bool:
    """Whether the control adds fine offsets; a remark where it does not."""
    switch = data.datum("SC_TOCARR_FINE_CORRECTION")
    counts = switch is not None and switch.number() != 0.0
    if not counts:
        remarks.append(f"{fine.origin} is a fine offset: it counts with $SC_TOCARR_FINE_CORRECTION = 1 alone.")
    return counts


def _carrier_start(data: MachineData, number: int, place: int, remarks: list[str]) -> Figure:
    """The position of an axis at which the vectors of a swivel data set are measured [deg]."""
    start = data.figure(f"TC_CARR{START + place}", number) or Figure(0.0, ())
    fine = data.figure(f"TC_CARR{START + FINE + place}", number)
    if fine is None or not fine.number or not _fine_counts(data, fine, remarks):
        return start
    return Figure(start.number + fine.number, start.origins + fine.origins)


def _carrier_axis(
    data: MachineData, number: int, place: int, axes: Mapping[int, ChannelAxis], answers: Answers, remarks: list[str]
) -> SwivelAxis | None:
    """An axis of a swivel data set; None where its direction is 0."""
    direction = data.vector([(f"TC_CARR{7 + 3 * place + k}", number) for k in range(3)])
    if direction is None or not is_direction(direction):
        return None
    start = _carrier_start(data, number, place, remarks)
    for item in (21 + place, 35 + place):
        datum = data.datum(f"TC_CARR{item}", number)
        if datum is None or datum.word() in ("", "0"):
            continue
        for axis in axes.values():
            if datum.word() == axis.name or datum.word() in axis.words:
                if axis.letter in tuple("XYZ"):
                    raise datum.origin.error(f"= {datum.word()[:20]}, which is linear; give the axis that turns")
                return SwivelAxis(joint_name(axis, direction), direction, start, axis)
        raise datum.origin.error(f"= {datum.word()[:20]}, and the channel has no such axis; give its channel data too")
    usual = TURNING[int(np.abs(direction.vector).argmax())]
    which = f"letter of axis {place + 1} of swivel data set {number} (A, B, C)"
    question = Question(which, usual, "by its direction; no datum names it")
    letter = str(answers.choice(question, tuple(TURNING)).value)
    named = [axis for axis in axes.values() if axis.letter == letter]
    axis = named[0] if named else ChannelAxis(letter, (letter,), direction.origins[0])
    return SwivelAxis(letter, direction, start, axis)
