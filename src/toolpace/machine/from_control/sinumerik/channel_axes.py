"""The axes of a channel: which machine axis is X, and what each is called.

A channel axis has a name (MD20080 AXCONF_CHANAX_NAME_TAB) and a machine axis (MD20070 AXCONF_MACHAX_USED), which has a
name of its own (MD10000 AXCONF_MACHAX_NAME_TAB). Three channel axes are X, Y, Z (MD20050 AXCONF_GEOAX_ASSIGN_TAB, named
by MD20060).
Function Manual Basic Functions, K2, "Axes".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from toolpace.machine.from_control.record import Origin
from toolpace.machine.from_control.sinumerik.machine_data import MachineData
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.from_control.unplaced_axes import TURNING

MOST = 31
"""Axes of a channel."""
DEFAULTS = 4
"""Places of MD20070 that have a machine axis by default."""
GUESSES = {3: "X, Y, Z", 4: "X, Y, Z, A"}
"""Names of axes that no file names, by their count; else X, Y, Z, A, C."""
LETTERS = "XYZ" + TURNING


@dataclass(frozen=True)
class ChannelAxis:
    """An axis of the channel that is read."""

    name: str
    """As programs call it."""
    words: tuple[str, ...]
    """What $MA data call it: AX1, the machine axis' name, the channel axis' name."""
    origin: Origin
    """Where it is named or assigned."""

    @property
    def letter(self) -> str:
        """X, Y, Z, A, B or C where the name is one with at most a number behind it; else empty."""
        return self.name[0] if self.name[:1] in LETTERS and not self.name[1:].strip("0123456789") else ""


def channel_axes(data: MachineData, answers: Answers) -> dict[int, ChannelAxis]:
    """Axes by their number in the channel, from 1. Raises ControlFileError where a name or an axis is there twice."""
    machine_names = _names(data, "MN_AXCONF_MACHAX_NAME_TAB")
    names = _names(data, "MC_AXCONF_CHANAX_NAME_TAB")
    used = _used(data)
    axes: dict[int, ChannelAxis] = {}
    for place in range(MOST):
        number = used.get(place, 0)
        of_machine = machine_names.get(number - 1)
        named = names.get(place, of_machine if not names else None)
        if named is None and names and place < len("XYZ"):
            named = "XYZ"[place], Origin(f"default of $MC_AXCONF_CHANAX_NAME_TAB[{place}]")
        if number > 0 and named is not None:
            words = (f"AX{number}", *([of_machine[0]] if of_machine is not None else []), named[0])
            axes[place + 1] = ChannelAxis(named[0] if names else _bare(named[0]), words, named[1])
    return axes or _by_their_data(data, answers) or _by_swivel_data(data)


def _used(data: MachineData) -> dict[int, int]:
    """The machine axis of each place in the channel; by default the first axes are in their order."""
    found: dict[int, int] = {}
    first: dict[int, Origin] = {}
    for place in range(MOST):
        datum = data.datum("MC_AXCONF_MACHAX_USED", place)
        number = 0 if datum is None else int(datum.number())
        if datum is not None:
            if number > 0 and number in first:
                raise datum.origin.error(f"= {number} is also {first[number]}; a machine axis is one axis of a channel")
            found[place], first[number] = number, datum.origin
    return {
        place: found.get(place, 0 if place + 1 in first or (first and place >= DEFAULTS) else place + 1)
        for place in range(MOST)
    }


def _names(data: MachineData, table: str) -> dict[int, tuple[str, Origin]]:
    """Names of a table by their place in it; none is there twice."""
    found: dict[int, tuple[str, Origin]] = {}
    first: dict[str, Origin] = {}
    for place in range(MOST):
        datum = data.datum(table, place)
        if datum is None or not datum.word():
            continue
        name = datum.word()
        if name in first:
            raise datum.origin.error(f'= "{name[:20]}" is also {first[name]}; an axis has a name of its own')
        first[name] = datum.origin
        found[place] = name, datum.origin
    return found


def _by_their_data(data: MachineData, answers: Answers) -> dict[int, ChannelAxis]:
    """Axes where no file names them: as axis data call them, or asked for by AX1, AX2, ..."""
    words = data.axis_words()
    named = [word for word in words if not word.startswith("AX")]
    if named:
        shown = {word: Origin(f"$MA_...[{word[:20]}]") for word in named}
        return {k: ChannelAxis(_bare(word), (word,), shown[word]) for k, word in enumerate(named, 1)}
    words = [word for word in words if not is_spindle(data, (word,))]
    if not words:
        return {}
    question = Question(
        f"names of the axes {', '.join(words[:MOST])} with commas between",
        GUESSES.get(len(words), "X, Y, Z, A, C"),
        "no file has $MC_AXCONF_CHANAX_NAME_TAB or $MN_AXCONF_MACHAX_NAME_TAB",
    )
    figure = answers.text(question)
    names = [part.strip().upper() for part in str(figure.value).split(",")]
    return {k: ChannelAxis(name, (word,), figure.origins[0]) for k, (word, name) in enumerate(zip(words, names), 1)}


def _by_swivel_data(data: MachineData) -> dict[int, ChannelAxis]:
    """X, Y, Z and the axes that swivel data name, where these are all that there is; none without them."""
    sets = [number for number in data.numbers("TC_CARR") if number > 0]
    found = {letter: Origin("default of $MC_AXCONF_CHANAX_NAME_TAB") for letter in "XYZ" if sets}
    for number in sets:
        for item in (21, 22, 35, 36):
            datum = data.datum(f"TC_CARR{item}", number)
            if datum is not None and datum.word() not in ("", "0"):
                found.setdefault(datum.word(), datum.origin)
    return {k: ChannelAxis(name, (name,), origin) for k, (name, origin) in enumerate(found.items(), 1)}


def is_spindle(data: MachineData, words: Sequence[str]) -> bool:
    """Whether the axis of these names is a spindle."""
    spindle = data.figure("MA_SPIND_ASSIGN_TO_MACHAX", 0, words)
    return spindle is not None and spindle.number != 0.0


def _bare(word: str) -> str:
    """A machine axis' name without its number, where that leaves a name."""
    return word.rstrip("0123456789") or word


def _check_names(data: MachineData) -> None:
    """Refuse geometry axes in another order than X, Y, Z (MD20060)."""
    for place, (name, origin) in _names(data, "MC_AXCONF_GEOAX_NAME_TAB").items():
        if name in LETTERS and name != "XYZ"[place : place + 1]:
            raise origin.error(f'= "{name}"; geometry axes are read in the order X, Y, Z')


def straight_axes(
    data: MachineData, axes: dict[int, ChannelAxis], inputs: Sequence[tuple[int, Origin]]
) -> list[ChannelAxis]:
    """The axes that are X, Y and Z; `inputs` are those of a transformation, with where they stand.

    Raises ControlFileError where one is missing, or the transformation has others.
    """
    found = []
    _check_names(data)
    for place, letter in enumerate("XYZ"):
        datum = data.datum("MC_AXCONF_GEOAX_ASSIGN_TAB", place)
        number = place + 1 if datum is None else int(datum.number())
        if datum is None and not inputs:
            number = next((k for k, axis in axes.items() if axis.letter == letter), number)
        origin = datum.origin if datum is not None else Origin(f"default of $MC_AXCONF_GEOAX_ASSIGN_TAB[{place}]")
        if inputs:
            taken, at = inputs[place]
            if datum is not None and taken != number:
                raise at.error(f"= {taken} contradicts {datum.origin} = {number}: which channel axis is {letter}?")
            number, origin = taken, at
        if number not in axes:
            raise origin.error(
                f"= {number} for {letter}, and the channel has no such axis; a machine here has X, Y and Z (no lathe)"
            )
        axis = axes[number]
        if axis.letter not in ("", letter):
            raise origin.error(f"= {number} for {letter} is the axis {axis.name} ({axis.origin}); correct one of both")
        found.append(axis)
    return found
