"""A record from the parameters that a Fanuc control punches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from toolpace.machine.from_control.control_file import ControlFile, machine_name
from toolpace.machine.from_control.fanuc.axes import Axis, joint_figures, letters_of, read_axes, set_figure, set_time
from toolpace.machine.from_control.fanuc.chain import is_five_axis, place_five_axes
from toolpace.machine.from_control.fanuc.parameters import LINE, READ, Parameters, read_parameters
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin, lowest
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.from_control.unplaced_axes import ALONG, Unplaced, place_axes

CONTROL = "Fanuc"
TOLD_BY = "parameters as punched, as N01420 A1 P15000 A2 P15000"
LEAST_LINES = 3
"""Lines of parameters that are read, from which on a text counts as one: programs have an N and a P here and there."""
OF_AXES = {
    1430: ("greatest cutting feed", "{}/min"),
    1432: ("greatest cutting feed with look-ahead", "{}/min"),
    1671: ("acceleration of rapid traverse before interpolation", "{}/s^2"),
    1735: ("acceleration in circles", "{}/s^2"),
    1737: ("acceleration in curves of lines", "{}/s^2"),
    1783: ("difference of feed at corners", "{}/min"),
    1788: ("change of acceleration", "{}/s^2"),
    1789: ("change of acceleration between lines", "{}/s^2"),
}
"""Figures that the control keeps beside the joints' limits, by axis."""
TIMES_OF_AXES = {
    1620: "ramp of rapid traverse",
    1622: "ramp of cutting after interpolation",
    1672: "acceleration builds up in rapid traverse",
    1769: "ramp after interpolation with look-ahead",
}
"""[s]"""


def recognises(file: ControlFile) -> bool:
    """Whether a text has parameters that are read, as the control punches them."""
    found = (LINE.match(line.upper()) for line in file.lines)
    return sum(match is not None and int(match[1]) in READ for match in found) >= LEAST_LINES


def read(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The machine of the control's first path. Raises ControlFileError."""
    parameters = read_parameters(files)
    axes = read_axes(parameters)
    inch, told = parameters.inch
    length = Figure("in" if inch else "mm", (told,))
    record = MachineRecord(
        CONTROL, machine_name(files[0], CONTROL), parameters.files, length,
        Figure("deg", (Origin("rotary axes count degrees"),)),
    )  # fmt: skip
    used = _used(parameters, axes)
    for axis in used:
        record.joints[axis.letter] = joint_figures(parameters, axis)
        if axis.letter in "XYZ":
            record.joints[axis.letter]["direction"] = Figure(ALONG[axis.letter], (Origin(f"axis {axis.letter}"),))
    if is_five_axis(parameters):
        place_five_axes(parameters, axes, record, answers)
    else:
        kind = parameters.whole(19680)
        told = kind.origins[0] if kind is not None else axes[0].named
        place_axes(Unplaced(record, answers, "Fanuc without 19680", told, "N01020"), letters_of(used))
    for letter in "XYZ":
        record.machine_zero[letter] = Figure(0.0, (Origin("machine coordinates are positions of the joints"),))
    record.control_figures |= dict(_control_figures(parameters, used))
    record.controller = "fanuc"
    record.timing |= dict(_timing(parameters, used, record))
    _add_remarks(parameters, record, axes)
    return record


def _used(parameters: Parameters, axes: Sequence[Axis]) -> list[Axis]:
    """X, Y, Z and the rotary axes of the mechanism, or all where none is told. Raises ControlFileError."""
    letters = letters_of(axes)
    missing = [letter for letter in "XYZ" if letter not in letters]
    if missing:
        raise axes[-1].named.error(
            f"is the last of the axes {letters}, without {', '.join(missing)}; a machine here has X, Y and Z"
        )
    numbers = [parameters.whole(number) for number in (19681, 19686)] if is_five_axis(parameters) else []
    places = [int(figure.number) - 1 for figure in numbers if figure is not None]
    turning = [axes[place] for place in places if 0 <= place < len(axes) and axes[place].rotary]
    if not numbers:
        turning = [axis for axis in axes if axis.rotary]
    return [*(axes[letters.index(letter)] for letter in "XYZ"), *dict.fromkeys(turning)]


def _control_figures(parameters: Parameters, axes: Sequence[Axis]) -> Iterator[tuple[str, Figure]]:
    """What the control keeps beside the joints' limits, by a name with axes and unit."""
    length = "in" if parameters.inch[0] else "mm"
    for number, (words, unit) in OF_AXES.items():
        for rotary in (False, True):
            group = [axis for axis in axes if axis.rotary == rotary]
            found = {axis.letter: set_figure(parameters, number, axis) for axis in group}
            yield from _together(words, unit.format("deg" if rotary else length), found)
    for number, words in TIMES_OF_AXES.items():
        yield from _together(words, "s", {axis.letter: set_time(parameters, number, axis.number) for axis in axes})
    if (bell := set_time(parameters, 1772, 0)) is not None:
        yield "acceleration builds up before interpolation [s]", bell
    for number, words in ((1422, "greatest cutting feed"), (1732, "least feed of arcs that slow down")):
        feed = parameters.figure(number, 0, rotary=False)
        if feed is not None and feed.number > 0.0:
            yield f"{words} [{length}/min]", feed


def _together(words: str, unit: str, found: dict[str, Figure | None]) -> Iterator[tuple[str, Figure]]:
    """Figures of several axes as one, without axes that have none."""
    there = {letter: figure for letter, figure in found.items() if figure is not None}
    if there:
        values = tuple(figure.number for figure in there.values())
        origins = tuple(origin for figure in there.values() for origin in figure.origins)
        yield f"{words} of {', '.join(there)} [{unit}]", Figure(values, origins)


def _timing(
    parameters: Parameters, axes: Sequence[Axis], record: MachineRecord
) -> Iterator[tuple[str, Figure]]:
    """Figures of the model `fanuc` (controls/timing/figures.py); of several axes the one that slows down most."""
    millimetres = 25.4 if parameters.inch[0] else 1.0
    linear, turning = ([axis for axis in axes if axis.rotary == rotary] for rotary in (False, True))
    for number, key, group, scale in (
        (1783, "corner_difference", linear, millimetres),
        (1783, "corner_difference_rotary", turning, 1.0),
        (1788, "acceleration_change", linear, millimetres),
        (1789, "acceleration_change_lines", linear, millimetres),
    ):
        found = [figure for axis in group if (figure := set_figure(parameters, number, axis)) is not None]
        if found:
            least = lowest(found)
            yield f"fanuc.{key}", Figure(least.number * scale, least.origins)
    for number, key in ((1735, "arc_acceleration"), (1737, "curve_acceleration")):
        shares = []
        for axis in linear:
            figure, own = set_figure(parameters, number, axis), record.joints[axis.letter].get("acceleration")
            if figure is not None and own is not None:
                shares.append(Figure(figure.number / own.number, figure.origins + own.origins))
        if shares:
            yield f"fanuc.{key}", lowest(shares)
    least_feed = parameters.figure(1732, 0, rotary=False)
    if least_feed is not None and least_feed.number > 0.0:
        yield "fanuc.arc_least_feed", Figure(least_feed.number * millimetres, least_feed.origins)
    if (bell := set_time(parameters, 1772, 0)) is not None:
        yield "fanuc.bell_time", bell
    after = [figure for axis in axes if (figure := set_time(parameters, 1769, axis.number)) is not None]
    if after:
        yield "fanuc.after_interpolation", max(after, key=lambda figure: figure.number)


def _add_remarks(parameters: Parameters, record: MachineRecord, axes: Sequence[Axis]) -> None:
    """What a person should know who compares the machine with the file."""
    for name in parameters.cut:
        record.remarks.append(f"{name} does not end with %: is it whole?")
    if parameters.strange:
        count, first = len(parameters.strange), parameters.strange[0]
        lines = "1 line that is" if count == 1 else f"{count} lines that are"
        record.remarks.append(f"{lines} no parameter, passed over: {first}.")
    if parameters.real is None:
        record.remarks.append("Numbers without decimal point are in the least increments of 16i, 18i, 21i and 0i.")
    if len(parameters.paths) > 1:
        record.remarks.append(f"The control has {len(parameters.paths)} paths: this is the machine of path 1.")
    for axis in axes:
        if axis.letter not in record.joints:
            record.remarks.append(f"The axis {axis.letter} ({axis.named}) rests: it is no joint of this machine.")
        elif axis.diameter:
            record.remarks.append(f"{axis.letter} counts diameters ({axis.named}): its travel is that of the radius.")
    holder = parameters.figure(19666, 0, rotary=False)
    if holder is not None and holder.number and is_five_axis(parameters):
        record.remarks.append(f"{holder.origin} = {holder.number:g}: the tool's length counts from there (assumption).")
