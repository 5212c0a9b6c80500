"""The vector chain of a transformation that is told by a kinematic chain: elements $NK_..., its ends $NT_...

from the root each element is followed by $NK_NEXT; $NK_PARALLEL begins where the element itself begins
tool chain, workpiece chain <- root to $NT_T_CHAIN_LAST_ELEM, root to $NT_P_CHAIN_LAST_ELEM, what both share taken off
vectors <- sums of the offsets before, between and behind the turning axes

Function Manual Special Functions, K7, 01/2015 (6FC5397-2BP40-5BA2), pages 195 to 202: a direction is told in world
coordinates and points the way in which what follows moves, for turns by the right-hand rule; $NK_A_OFF is added to an
axis' position. Which $NT_... is what: Commissioning Manual Operate IM9, 12/2017, pages 339 and 618. So a table that
carries the part to -X where the display of X rises has the direction (-1, 0, 0), which is checked.

Assumptions: $NK_PARALLEL as above; a chain that the control closes (bits 7 and 8 of $NT_CNTRL) is closed as swivel data
are, that of the tool at machine zero, that of the workpiece at its end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.sinumerik.channel_axes import ChannelAxis, is_spindle
from toolpace.machine.from_control.sinumerik.five_axis import check_names, joint_name
from toolpace.machine.from_control.sinumerik.machine_data import Datum, MachineData
from toolpace.machine.from_control.sinumerik.vector_chain import CLOSING, SwivelAxis, VectorChain, is_direction

TYPES = ("TRAORI_DYN", "TRAORI_STAT")
"""Transformations that turn a tool, that of five-axis programs first; others are TRANSMIT_K, TRACYL_K and TRAANG_K."""
KINDS = {(2, 0): "T", (0, 2): "P", (1, 1): "M", (1, 0): "T", (0, 1): "P"}
"""By the number of turning axes on the side of the tool and on that of the workpiece."""
CLOSE_WORKPIECE, CLOSE_TOOL, TOOL_BY_SPINDLE, TOOL_INVERTED = 7, 8, 19, 20
"""Bits of $NT_CNTRL."""
STRAIGHT = 1e-6
"""Components of a direction below which a linear axis is along X, Y or Z."""
SLANTING = 0.01
"""The same from which it is another axis' direction, and not the error of a machine."""


@dataclass(frozen=True)
class Element:
    """An element of the kinematic chain."""

    name: str
    kind: Datum
    """AXIS_LIN, AXIS_ROT, OFFSET, ROT_CONST, SWITCH"""
    vector: Figure
    """(3,) an offset, or the direction of an axis."""
    axis: Datum | None
    position: Figure
    """What is added to an axis' position, or the angle of a constant turn."""
    next: Datum | None
    parallel: Datum | None


@dataclass
class _Side:
    """What lies between the machine and one end of the chain."""

    straight: list[tuple[Element, ChannelAxis]]
    turning: list[SwivelAxis]
    vectors: list[Floats]
    """(3,) offsets before the first turning axis, behind each of them."""
    origins: list[list[Origin]]

    def figure(self, place: int, sign: float = 1.0) -> Figure:
        """One of the vectors with its lines."""
        return Figure(tuple(float(part) for part in sign * self.vectors[place] + 0.0), tuple(self.origins[place]))


@dataclass(frozen=True)
class KinematicTransformation:
    """A transformation and its vector chain."""

    kind: Datum
    chain: VectorChain
    inputs: list[tuple[int, Origin]]
    """Channel axes of X, Y and Z; empty where the chain lacks one."""


def kinematic_transformation(
    data: MachineData, axes: Mapping[int, ChannelAxis], record: MachineRecord
) -> KinematicTransformation | None:
    """The first transformation of a kinematic chain that turns a tool; None where there is none.

    Raises ControlFileError.
    """
    kinds = [(number, data.datum("NT_TRAFO_TYPE", number)) for number in data.numbers("NT_TRAFO_TYPE")]
    found = [(number, kind) for number, kind in kinds if kind is not None and kind.word() in TYPES]
    if not found:
        if data.has_kinematic_chain:
            record.remarks.append(
                "The kinematic chain ($NK_...) is not read: no $NT_TRAFO_TYPE = TRAORI_DYN says where tool and "
                "workpiece are."
            )
        return None
    (number, kind), *others = sorted(found, key=lambda each: TYPES.index(each[1].word()))
    record.remarks += [f"{each.origin} = {each.word()} is not read: {kind.origin} is taken." for _, each in others]
    elements = _elements(data)
    tool, workpiece = _ends(data, number, kind, elements)
    sides = [
        _side(data, path, axes, record, sign) for path, sign in zip(_without_shared(tool, workpiece), (1.0, -1.0))
    ]
    chain = _vector_chain(data, number, kind, sides, tool[-1] if tool else None)
    closed = _closed(data, number, chain, {"T": tool, "P": workpiece}, record)
    return KinematicTransformation(kind, closed, _inputs(sides, axes, record))


def _elements(data: MachineData) -> dict[str, Element]:
    """The elements by name. Raises ControlFileError where a name is there twice."""
    found: dict[str, Element] = {}
    for number in data.numbers("NK_NAME"):
        name = data.datum("NK_NAME", number)
        if name is None or not name.word():
            continue
        kind = data.datum("NK_TYPE", number)
        if kind is None:
            raise name.origin.error(f"= {name.text[:20]} has no $NK_TYPE[{number}]; give the whole chain")
        if name.word() in found:
            raise name.origin.error(f"= {name.text[:20]} is also {found[name.word()].kind.origin}; correct one")
        vector = data.vector([("NK_OFF_DIR", number, (str(k),)) for k in range(3)])
        found[name.word()] = Element(
            name.word(), kind, vector or Figure((0.0, 0.0, 0.0), (kind.origin,)), _named(data, "NK_AXIS", number),
            data.figure("NK_A_OFF", number) or Figure(0.0, (kind.origin,)), _named(data, "NK_NEXT", number),
            _named(data, "NK_PARALLEL", number),
        )  # fmt: skip
    return found


def _named(data: MachineData, name: str, number: int) -> Datum | None:
    """A datum that names something; None where it is empty."""
    datum = data.datum(name, number)
    return datum if datum is not None and datum.word() else None


def _ends(
    data: MachineData, number: int, kind: Datum, elements: Mapping[str, Element]
) -> tuple[list[Element], list[Element]]:
    """Elements from the root to the tool, and to the workpiece."""
    before: dict[str, tuple[Element, bool, Datum]] = {}
    for element in elements.values():
        for datum, follows in ((element.next, True), (element.parallel, False)):
            if datum is None:
                continue
            if datum.word() not in elements:
                raise datum.origin.error(f"= {datum.text[:20]} is the name of no element; give the whole chain")
            if datum.word() in before:
                raise datum.origin.error(f"= {datum.text[:20]} is also {before[datum.word()][2].origin}; correct one")
            before[datum.word()] = element, follows, datum
    paths: list[list[Element]] = []
    for name in ("NT_T_CHAIN_LAST_ELEM", "NT_P_CHAIN_LAST_ELEM"):
        last = _named(data, name, number)
        if last is None:
            paths.append([])
            continue
        if last.word() not in elements:
            raise last.origin.error(f"= {last.text[:20]} is the name of no element; give the whole chain")
        paths.append(_path(elements[last.word()], before, last))
    if not any(paths):
        raise kind.origin.error(f"= {kind.word()} has no $NT_T_CHAIN_LAST_ELEM[{number}]; give all of $NT_ too")
    return paths[0], paths[1]


def _path(end: Element, before: Mapping[str, tuple[Element, bool, Datum]], last: Datum) -> list[Element]:
    """From the root to an element: a parallel element stands beside the one that names it, not behind it."""
    path, at, passed = [end], end, {end.name}
    while at.name in before:
        at, follows, datum = before[at.name]
        if at.name in passed:
            raise datum.origin.error(f"= {datum.text[:20]} leads round in a circle; correct it")
        passed.add(at.name)
        if follows:
            path.append(at)
    if len(passed) == 1 and len(before) > 1:
        raise last.origin.error(f"= {last.text[:20]} is joined to no other element; give the whole chain")
    return path[::-1]


def _without_shared(tool: list[Element], workpiece: list[Element]) -> tuple[list[Element], list[Element]]:
    """Both paths from where they part: what carries tool and workpiece alike moves neither against the other."""
    shared = 0
    while shared < min(len(tool), len(workpiece)) and tool[shared].name == workpiece[shared].name:
        shared += 1
    return tool[shared:], workpiece[shared:]


def _side(
    data: MachineData, path: Sequence[Element], axes: Mapping[int, ChannelAxis], record: MachineRecord, sense: float
) -> _Side:
    """Axes and vectors of a side; `sense` is 1 where it carries the tool, -1 where it carries the workpiece."""
    side = _Side([], [], [np.zeros(3)], [[]])
    for element in path:
        kind = element.kind.word()
        if kind == "OFFSET":
            side.vectors[-1] = side.vectors[-1] + element.vector.vector
            side.origins[-1] += element.vector.origins if any(element.vector.vector) else ()
        elif kind in ("AXIS_LIN", "AXIS_ROT"):
            _add_axis(data, element, axes, side, record, sense)
        elif kind == "SWITCH":
            raise element.kind.origin.error("= SWITCH: chains that are switched over are not read; give one without")
        elif kind != "ROT_CONST":
            raise element.kind.origin.error(
                f"= {kind[:20]}; elements are AXIS_LIN, AXIS_ROT, OFFSET, ROT_CONST and SWITCH"
            )
        elif element.position.number:
            raise element.position.origins[0].error(
                f"= {element.position.number:g}: a constant turn is not read; give directions as they are with it"
            )
    return side


def _add_axis(
    data: MachineData, element: Element, axes: Mapping[int, ChannelAxis], side: _Side, record: MachineRecord,
    sense: float,
) -> None:  # fmt: skip
    """Enter a linear or turning axis; spindles are passed over."""
    if element.axis is None:
        raise element.kind.origin.error(f"= {element.kind.word()} has no $NK_AXIS; which axis is it?")
    axis = next((each for each in axes.values() if element.axis.word() in each.words), None)
    words = (element.axis.word(),) if axis is None else axis.words
    if element.kind.word() == "AXIS_ROT" and is_spindle(data, words):
        return
    if axis is None:
        raise element.axis.origin.error(
            f"= {element.axis.word()[:20]}, and the channel has no such axis; give its channel data too"
        )
    if not is_direction(element.vector):
        raise element.vector.origins[0].error(f"is no direction of {axis.name}; give its components, as 0, 0, 1")
    if element.kind.word() == "AXIS_ROT":
        start = Figure(-element.position.number + 0.0, element.position.origins)
        side.turning.append(SwivelAxis(joint_name(axis, element.vector), element.vector, start, axis))
        side.vectors.append(np.zeros(3))
        side.origins.append([])
        return
    if side.turning:
        raise element.kind.origin.error(
            f"moves {axis.name} behind the turning axis {side.turning[-1].name}; a machine here turns no slides"
        )
    along = _unit(element.vector)
    _check_straight(element, axis, along, record, sense)
    side.straight.append((element, axis))
    side.vectors[-1] = side.vectors[-1] + element.position.number * along
    side.origins[-1] += element.position.origins if element.position.number else ()


def _check_straight(
    element: Element, axis: ChannelAxis, along: Floats, record: MachineRecord, sense: float
) -> None:
    """Refuse linear axes that move what they carry the wrong way, or along none of X, Y, Z."""
    place = int(np.abs(along).argmax())
    letter = axis.letter if axis.letter in tuple("XYZ") else "XYZ"[place]
    wanted = sense * np.eye(3)["XYZ".index(letter)]
    off = float(np.abs(along - wanted).max())
    if off > SLANTING:
        carried = "tool to the positive side" if sense > 0.0 else "workpiece to the negative side"
        raise element.vector.origins[0].error(
            f"is {element.vector.words}, and {axis.name} carries the {carried} of {letter} where its display rises "
            f"({', '.join(f'{part + 0.0:g}' for part in wanted)}); correct it"
        )
    if off > STRAIGHT:
        record.remarks.append(
            f"{element.vector.origin} is {element.vector.words}: {axis.name} is taken to be along {letter}."
        )


def _unit(figure: Figure) -> Floats:
    vector = np.array(figure.vector)
    return np.asarray(vector / np.linalg.norm(vector))


def _vector_chain(
    data: MachineData, number: int, kind: Datum, sides: Sequence[_Side], last: Element | None
) -> VectorChain:
    """I1 to I4 as swivel data have them: in the head they lead from the tool to the slides."""
    tool, workpiece = sides
    count = len(tool.turning), len(workpiece.turning)
    if count not in KINDS:
        names = ", ".join(axis.name for side in sides for axis in side.turning) or "none"
        raise kind.origin.error(f"= {kind.word()} has the turning axes {names}; a machine here has two, or one")
    letter = KINDS[count]
    turning: list[SwivelAxis | None] = [*tool.turning, *workpiece.turning]
    both = (turning[0], turning[1] if len(turning) > 1 else None)
    check_names(both)
    if letter == "P":
        first = workpiece.figure(0)
        nose = tool.figure(0, -1.0)
        vectors = {"I2": _sum(first, nose)} | {f"I{3 + k}": workpiece.figure(1 + k) for k in range(count[1])}
    else:
        vectors = {f"I{1 + k}": tool.figure(k, -1.0) for k in range(1 + count[0])}
        if letter == "T":
            vectors["I1"] = _sum(vectors["I1"], workpiece.figure(0))
        else:
            vectors |= {"I3": workpiece.figure(0), "I4": workpiece.figure(1)}
    kept = {name: figure for name, figure in vectors.items() if figure.origins}
    return VectorChain(Figure(letter, (kind.origin,)), both, kept, _tool_axis(data, number, last, kind))


def _sum(one: Figure, two: Figure) -> Figure:
    parts = tuple(a + b + 0.0 for a, b in zip(one.vector, two.vector))
    return Figure(parts, one.origins + two.origins)


def _bits(data: MachineData, number: int) -> tuple[int, Origin]:
    control = data.datum("NT_CNTRL", number)
    return (0, Origin("")) if control is None else (int(control.number()), control.origin)


def _tool_axis(data: MachineData, number: int, last: Element | None, kind: Datum) -> Figure:
    """(3,) from the tip to the nose with all axes at zero."""
    bits, origin = _bits(data, number)
    if bits >> TOOL_BY_SPINDLE & 1:
        if last is None or last.kind.word() != "AXIS_ROT" or not is_direction(last.vector):
            raise origin.error("takes the tool's direction from the last element of its chain, which does not turn")
        sign = -1.0 if bits >> TOOL_INVERTED & 1 else 1.0
        return Figure(tuple(sign * part + 0.0 for part in last.vector.vector), (*last.vector.origins, origin))
    base = data.vector([("NT_BASE_ORIENT", number, (str(k),)) for k in range(3)])
    if base is not None and is_direction(base):
        return base
    return Figure((0.0, 0.0, 1.0), (Origin(f"default of $NT_BASE_ORIENT[{number}]"),))


def _closed(
    data: MachineData, number: int, chain: VectorChain, paths: Mapping[str, Sequence[Element]], record: MachineRecord
) -> VectorChain:
    """The chain with the vectors by which the control closes it."""
    bits, by_bits = _bits(data, number)
    vectors = dict(chain.vectors)
    for side, bit, closing in (("T", CLOSE_TOOL, "I1"), ("P", CLOSE_WORKPIECE, "I4")):
        at = _named(data, f"NT_CLOSE_CHAIN_{side}", number)
        if at is None and not bits >> bit & 1:
            continue
        if at is not None:
            _check_closing(at, paths[side], side)
        origin = by_bits if at is None else at.origin
        for name, others in CLOSING[str(chain.kind.value)]:
            if name == closing:
                total = -sum((chain.vector(other) for other in others), np.zeros(3))
                vectors[name] = Figure(tuple(float(part) for part in total + 0.0), (origin,))
                record.remarks.append(f"{origin} closes the chain with {name} = {vectors[name].words} (assumption).")
    return VectorChain(chain.kind, chain.axes, vectors, chain.tool)


def _check_closing(at: Datum, path: Sequence[Element], side: str) -> None:
    """Refuse a chain that is closed between its turning axes, or between them and the tool: arms change by that."""
    names = [element.name for element in path]
    turning = [k for k, element in enumerate(path) if element.kind.word() == "AXIS_ROT"]
    place = names.index(at.word()) if at.word() in names else -1
    if turning and (place >= turning[0] if side == "T" else place < turning[-1]):
        where = "before the first turning axis" if side == "T" else "behind the last turning axis"
        raise at.origin.error(f"= {at.text[:20]}: a chain that is not closed {where} is not read")


def _inputs(
    sides: Sequence[_Side], axes: Mapping[int, ChannelAxis], record: MachineRecord
) -> list[tuple[int, Origin]]:
    """The channel axes that are X, Y and Z; of two along one direction that which is called so."""
    numbers = {axis.name: number for number, axis in axes.items()}
    found: dict[int, tuple[Element, ChannelAxis]] = {}
    for element, axis in (pair for side in sides for pair in side.straight):
        place = int(np.abs(element.vector.vector).argmax())
        one, other = (element, axis), found.get(place)
        if other is not None:
            one, other = (one, other) if axis.letter == "XYZ"[place] else (other, one)
            resting = f"{other[1].name} ({other[0].kind.origin})"
            record.remarks.append(f"{resting} rests at zero: it moves as {one[1].name} does.")
        found[place] = one
    named = [(numbers[axis.name], element.kind.origin) for _, (element, axis) in sorted(found.items())]
    return named if len(named) == len("XYZ") else []
