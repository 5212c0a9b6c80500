"""Axes of a Fanuc control with their kind, travel and limits.

Numbers after the parameter manual of 30i, 31i, 32i (B-63950EN, chapter 4) and those of 16i, 18i, 21i and 0i:
981 path of an axis, 1006 kind, 1020 letter, 1022 place among the basic axes, 1320 and 1321 travel, 1420 rapid traverse,
1660 acceleration before interpolation of cutting motions. Older controls have a time for a ramp in its place: 1770 over
1771 with look-ahead (A-63512EN, chapter 2.3), and 1420 over 1620 in rapid traverse. Jerk: see `_jerk`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.fanuc.parameters import Parameters
from toolpace.machine.from_control.record import Figure, Origin, lowest, travel

LETTERS = range(65, 91)
"""Codes of the letters A to Z in 1020."""
BASIC = {1: "X", 2: "Y", 3: "Z"}
"""By 1022: the axis of the basic coordinate system; 5 to 7 are parallel to these."""
TURNING = "ABC"
UNLIMITED = 99_999.0
"""A travel that ends no nearer is none: the largest figure of IS-C, to which unused limits are set [mm, in or deg]."""
LEAST_UNSET = 100_000.0
"""An acceleration that is not set: 1660 takes this for 0 [mm/s^2]."""
MILLISECONDS = 1e-3


@dataclass(frozen=True)
class Axis:
    """An axis of the first path."""

    number: int
    """Of the control: what stands behind A."""
    letter: str
    rotary: bool
    diameter: bool
    """Whether its positions are diameters (1006#3, of lathes)."""
    named: Origin
    """Where the letter is from."""
    kind: Origin


def read_axes(parameters: Parameters) -> list[Axis]:
    """The axes of the first path in the order of their numbers. Raises ControlFileError.

    An axis letter twice, or one at the place of another, is refused with both lines.
    """
    numbers = parameters.axes(1020)
    if not numbers:
        raise ControlFileError(
            "N01020 (letters of the axes) is missing; punch all parameters", file=parameters.files[0]
        )
    axes: list[Axis] = []
    for number in numbers:
        path = parameters.whole(981, number)
        if path is not None and path.number > 1:
            continue
        code = parameters.whole(1020, number)
        assert code is not None
        if code.number == 0:
            continue
        if code.number not in LETTERS:
            raise code.origins[0].error(f"= {code.number:g} is the code of no letter; X is 88, A is 65")
        axis = _axis(parameters, number, chr(int(code.number)), code.origins[0])
        for other in axes:
            if other.letter == axis.letter:
                raise axis.named.error(
                    f"= {code.number:g}: the letter {axis.letter} is that of {other.named} too; a machine here has "
                    "each once: give the slave of a gantry another one"
                )
        _check_basic(parameters, axis)
        axes.append(axis)
    return axes


def _axis(parameters: Parameters, number: int, letter: str, named: Origin) -> Axis:
    turns = parameters.bit(1006, 0, number)
    diameter = parameters.bit(1006, 3, number)
    by_letter = letter in TURNING
    if turns is None:
        return Axis(number, letter, by_letter, False, named, Origin(f"axis {letter} (assumption: N01006 is not there)"))
    if turns[0] != by_letter and letter in "XYZ" + TURNING:
        raise turns[1].error(
            f"= {turns[0]:d}, a {'rotary' if turns[0] else 'linear'} axis, and {named} calls it {letter}; correct one "
            "of both"
        )
    return Axis(number, letter, turns[0], diameter is not None and diameter[0], named, turns[1])


def _check_basic(parameters: Parameters, axis: Axis) -> None:
    """Refuse an axis X that is not the X of the basic coordinate system, and the like."""
    place = parameters.whole(1022, axis.number)
    if place is None or axis.rotary:
        return
    basic = BASIC.get(int(place.number), "")
    if (basic or axis.letter in "XYZ") and basic != axis.letter:
        raise place.origins[0].error(
            f"= {place.number:g}, {basic or 'none'} of the basic axes, and {axis.named} calls it {axis.letter}; "
            "correct one of both"
        )


def joint_figures(parameters: Parameters, axis: Axis) -> dict[str, Figure]:
    """Kind, limits and travel of an axis; keys are those of a machine file. What is not told is left out.

    Velocity and acceleration are in minutes and seconds with units of their own. Raises ControlFileError.
    """
    figures = {"kind": Figure("rotary" if axis.rotary else "linear", (axis.kind,))}
    unit = "deg" if axis.rotary else "in" if parameters.inch[0] else "mm"
    rapid = set_figure(parameters, 1420, axis)
    if rapid is not None:
        figures["velocity"] = Figure(rapid.value, rapid.origins, f"{unit}/min")
    acceleration = _acceleration(parameters, axis)
    if acceleration is not None:
        figures["acceleration"] = Figure(acceleration.value, acceleration.origins, f"{unit}/s2")
        jerk = _jerk(parameters, axis, acceleration)
        if jerk is not None:
            figures["jerk"] = Figure(jerk.value, jerk.origins, f"{unit}/s3")
    return figures | _reach(parameters, axis)


def set_figure(parameters: Parameters, number: int, axis: Axis) -> Figure | None:
    """A limit of an axis in the machine's units; zero is one that is not set. Raises ControlFileError below zero."""
    figure = parameters.figure(number, axis.number, rotary=axis.rotary)
    if figure is None or figure.number == 0.0:
        return None
    if figure.number < 0.0:
        raise figure.origins[0].error(f"= {figure.number:g}; give a number above zero, or 0 for none")
    return figure


def set_time(parameters: Parameters, number: int, index: int) -> Figure | None:
    """A time constant [s]; zero is one that is not set."""
    figure = parameters.whole(number, index)
    if figure is None or figure.number == 0.0:
        return None
    if figure.number < 0.0:
        raise figure.origins[0].error(f"= {figure.number:g} ms; give a time above zero, or 0 for none")
    return Figure(figure.number * MILLISECONDS, figure.origins)


def _acceleration(parameters: Parameters, axis: Axis) -> Figure | None:
    """Of cutting motions; else of ramps with look-ahead, else of rapid traverse [mm, in or deg per s^2]."""
    own = set_figure(parameters, 1660, axis)
    if own is not None and own.number < LEAST_UNSET:
        return own
    if not axis.rotary:
        feed, time = parameters.figure(1770, 0, rotary=False), set_time(parameters, 1771, 0)
        if feed is not None and feed.number > 0.0 and time is not None:
            return Figure(feed.number / 60.0 / time.number, feed.origins + time.origins)
    rapid = set_figure(parameters, 1671, axis)
    if rapid is not None and rapid.number < LEAST_UNSET:
        return rapid
    feed, time = set_figure(parameters, 1420, axis), set_time(parameters, 1620, axis.number)
    if feed is not None and time is not None:
        return Figure(feed.number / 60.0 / time.number, feed.origins + time.origins)
    return None


def _jerk(parameters: Parameters, axis: Axis, acceleration: Figure) -> Figure | None:
    """The acceleration over the time in which it builds up: 1772 before interpolation, 1769 after it.

    A bell shape is a ramp of the acceleration over 1772; a linear acceleration after interpolation is a moving average
    over 1769 of what comes out of it. One after the other, each limits the jerk to the acceleration over its own time.
    """
    times = [
        time
        for time in (set_time(parameters, 1772, 0), set_time(parameters, 1769, axis.number))
        if time is not None
    ]
    found = [Figure(acceleration.number / time.number, acceleration.origins + time.origins) for time in times]
    return lowest(found) if found else None


def _reach(parameters: Parameters, axis: Axis) -> dict[str, Figure]:
    """The travel of 1321 to 1320. Without end, where 1320 is below 1321, a rotary axis turns without end."""
    high = parameters.figure(1320, axis.number, rotary=axis.rotary)
    low = parameters.figure(1321, axis.number, rotary=axis.rotary)
    if high is None or low is None:
        return {}
    if high.number == low.number:
        raise high.origins[0].error(
            f"= {high.number:g} is not above {low.origin} = {low.number:g}; correct one of both on the control"
        )
    if high.number < low.number or (high.number >= UNLIMITED and low.number <= -UNLIMITED):
        return {"wrap": Figure(True, high.origins + low.origins)} if axis.rotary else {}
    if axis.diameter:
        low, high = (Figure(end.number / 2.0, end.origins) for end in (low, high))
    return {"travel": travel(low, high)}


def letters_of(axes: Sequence[Axis]) -> str:
    """Letters of the axes, in their order."""
    return "".join(axis.letter for axis in axes)
