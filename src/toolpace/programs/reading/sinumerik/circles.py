"""Arcs of G2, G3, CIP and CT, and polar ends AP and RP (Programming Manual Fundamentals, path commands)."""

from __future__ import annotations

import math

from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.reading.arcs import (
    PLANE_AXES,
    ROUNDING,
    Arc,
    ArcError,
    Tolerance,
    arc_about,
    centre_of_radius,
    plane_arc,
    tangent_centre,
)
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates.affine import cross
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.state import Point, State
from toolpace.programs.reading.sinumerik.syntax.values import Unread
from toolpace.programs.reading.sinumerik.word_values import Words, WordValue, bounded, number

MOST_TURNS = 999
UNSAID = 5e-6
"""Difference of radii that the decimals of a program explain [m]."""
MOST_MOVED = math.sqrt(0.001)
"""Shift of a centre, as a share of the radius (Diagnostics Guide, 14040)."""
CENTRE_MOVED = (
    "the radii of an arc differ at its start and its end: its centre is moved to the nearest place that is as far from "
    "both (MD21000, MD21010)"
)
_ENDLESS = "TURN counts whole turns: write a whole number from 0 to 999"
LETTERS = "XYZABCUVW"
NEAR = 1e-6
"""By what the place of the tool may differ from RP [m]."""


def circle(
    control: Control, state: State, words: Words, target: list[float], *, named: int = 0, polar: bool = False
) -> Arc:
    """Arc of G2 or G3 to the target, which AR may set; in the program's coordinates. Raises ArcError, BlockError.

    named: bits of the axes of the plane that the block names.

    Of an end in `polar` coordinates the pole is the centre, where no other is told (802D sl, Operation and Programming,
    8.3: "pole = circle center point").
    """
    clockwise = state.motion == "G2"
    start, plane = control.words, state.plane
    turn = number(words, "TURN", 0.0) or 0.0
    radius, opening = number(words, "CR"), number(words, "AR")
    if opening is not None and (radius is not None or (named and not words.keys().isdisjoint("IJK"))):
        raise BlockError("AR takes the end of the arc, or its centre, not both, nor CR (alarm 14900): remove one")
    if radius is not None:
        centre = centre_of_radius(start, target, radius * state.unit, plane, clockwise)
        _leave_out(words, "CR")
    elif opening is not None and not any(letter in words for letter in "IJK"):
        centre = _centre_of_opening(start, target, opening * DEGREE, plane, clockwise)
    else:
        about_pole = polar and words.keys().isdisjoint("IJK")
        centre = list(state.pole_in_force()) if about_pole else _centre(control, state, words)
        if opening is not None:
            _end_of_opening(start, target, centre, opening * DEGREE, plane, clockwise)
    made = plane_arc(start, target, centre, plane, clockwise, tolerance=_radii(control))
    if abs(made.r1 - made.r0) > ROUNDING:
        made = plane_arc(start, target, _moved_centre(control, made, (start, target), centre, plane), plane, clockwise)
    turns = _turns(control, made, turn)
    return made._replace(sweep=made.sweep + 2.0 * math.pi * (turns - 1))


def _radii(control: Control) -> Tolerance:
    """How far the radii of an arc's ends may differ (MD21000, MD21010)."""
    option = control.controller.option
    return Tolerance(option("arc_radii_mm", 0.01) * MILLIMETRE, option("arc_radii_percent", 0.1) / 100.0)


def _moved_centre(
    control: Control, arc: Arc, ends: tuple[list[float], list[float]], centre: list[float], plane: int
) -> list[float]:
    """The centre where it is as far from the start as from the end: controls move it (Parameter Manual, MD21010).

    It is the place nearest to the programmed one. Raises ArcError where that turns the radius by more than alarm 14040
    allows ("the root of 0.001"): of ends that lie close together a slight difference tells nothing of the centre.
    """
    first, second = PLANE_AXES[plane]
    start, target = ends
    along = target[first] - start[first], target[second] - start[second]
    chord = math.hypot(*along)
    shift = (arc.r1 - arc.r0) * (arc.r1 + arc.r0) / (2.0 * chord)
    if abs(shift) > MOST_MOVED * arc.r0:
        raise ArcError(
            f"the radii of the arc differ by {abs(arc.r1 - arc.r0) / MILLIMETRE:.4g} mm, and its ends are "
            f"{chord / MILLIMETRE:.4g} mm apart: its centre is not told (alarm 14040); correct the end or the centre"
        )
    if abs(arc.r1 - arc.r0) > UNSAID:
        control.findings.assumed(CENTRE_MOVED)
    moved = list(centre)
    moved[first] += shift * along[0] / chord
    moved[second] += shift * along[1] / chord
    return moved


def _turns(control: Control, arc: Arc, turn: float) -> int:
    """Turns for `plane_arc`: TURN whole ones, then on to the end.

    Where the end is the start nothing is left behind them: TURN=1 is one circle, as posts for thread mills mean it.
    """
    if not 0.0 <= turn <= MOST_TURNS:
        raise BlockError(f"{_ENDLESS}, not {turn:g}")
    circle_whole = arc.sweep > 2.0 * math.pi - ROUNDING
    if turn == int(turn):
        if circle_whole and turn:
            control.findings.assumed("TURN=n of a full circle is n circles in all")
        return max(int(turn), 1) if circle_whole else int(turn) + 1
    # some posts write the sweep itself, .5 of half a circle: then nothing is left open
    if abs((int(turn) + arc.sweep / (2.0 * math.pi)) - turn) > 1e-3:
        raise Unread(f"TURN={turn:g}", _ENDLESS)
    control.findings.assumed(f"TURN={turn:g} is the whole turn of its arc, whose end agrees with it")
    return int(turn) + 1


def _centre(control: Control, state: State, words: Words) -> list[float]:
    """Centre from I, J, K: distances from the start unless I=AC(...); what is left out is zero."""
    centre = control.words[:3]
    named = False
    for slot, letter in enumerate("IJK"):
        word = words.pop(letter, None)
        if word is None:
            continue
        if word.form not in ("", "AC", "IC"):
            raise BlockError(f"{letter}={word.form}() has no meaning: write {letter}=AC() or {letter}=IC()")
        if slot not in PLANE_AXES[state.plane]:
            if bounded(word, letter):
                plane = ("G17", "G18", "G19")[state.plane]
                raise BlockError(f"{letter} has no meaning for an arc in the plane of {plane}: check the plane")
            continue
        value = bounded(word, letter) * state.unit
        centre[slot] = value if word.form == "AC" else centre[slot] + value
        named = True
    if not named:
        raise BlockError("the arc lacks its centre: write I, J or K, or CR=")
    return centre


def _leave_out(words: Words, other: str) -> None:
    for letter in "IJK":
        if words.pop(letter, None) is not None:
            raise BlockError(f"an arc has {other}, or I, J, K, not both: remove one")


def _centre_of_opening(
    start: list[float], end: list[float], opening: float, plane: int, clockwise: bool
) -> list[float]:
    """Centre from the end and the opening angle AR [rad]."""
    _refuse_opening(opening)
    first, second = PLANE_AXES[plane]
    chord = math.hypot(end[first] - start[first], end[second] - start[second])
    radius = chord / (2.0 * math.sin(opening / 2.0))
    return centre_of_radius(start, end, math.copysign(radius, math.pi - opening), plane, clockwise)


def _end_of_opening(
    start: list[float], target: list[float], centre: list[float], opening: float, plane: int, clockwise: bool
) -> None:
    """Set the target from the centre and the opening angle [rad]."""
    _refuse_opening(opening)
    first, second = PLANE_AXES[plane]
    angle = -opening if clockwise else opening
    a, b = start[first] - centre[first], start[second] - centre[second]
    target[first] = centre[first] + a * math.cos(angle) - b * math.sin(angle)
    target[second] = centre[second] + a * math.sin(angle) + b * math.cos(angle)


def _refuse_opening(opening: float) -> None:
    if not 0.0 < opening < 2.0 * math.pi:
        raise BlockError(f"AR={opening / DEGREE:g} must lie between 0 and 360: a full circle needs I, J, K")


def through(control: Control, state: State, words: Words, target: list[float]) -> Arc | None:
    """Arc of CIP: through the point I1, J1, K1, in the plane of the three points.

    None where the point lies on the straight way to the end: "a straight line is generated" (Diagnostics Guide, 14920).
    """
    start = control.words[:3]
    between = list(start)
    for slot, letter in enumerate("IJK"):
        word = words.pop(letter + "1", None)
        if word is not None:
            value = bounded(word, letter + "1") * state.unit
            relative = word.form == "IC" or (not word.form and not state.absolute)
            between[slot] = start[slot] + value if relative else value
    a = [between[i] - start[i] for i in range(3)]
    b = [target[i] - start[i] for i in range(3)]
    normal = cross(a, b)
    size = math.hypot(*normal)
    if size < ROUNDING * max(math.hypot(*a) * math.hypot(*b), 1e-12):
        if 0.0 < sum(x * y for x, y in zip(a, b)) < sum(y * y for y in b) and "TURN" not in words:
            return None
        raise ArcError("the three points of CIP lie on a line: correct I1, J1, K1 or the end")
    normal = [value / size for value in normal]
    towards = cross([math.hypot(*a) ** 2 * b[i] - math.hypot(*b) ** 2 * a[i] for i in range(3)], cross(a, b))
    centre = [start[i] + towards[i] / (2.0 * size * size) for i in range(3)]
    return arc_about(start, target, centre, normal)


def tangent(control: Control, state: State, target: list[float]) -> Arc | None:
    """Arc of CT: it leaves in the direction of the last motion; None where that leads straight to the end."""
    first, second = PLANE_AXES[state.plane]
    if state.tangent is None:
        raise BlockError("CT needs a motion before it, whose direction it goes on in: write one, or G2 with I, J, K")
    start = control.words
    t, u = state.tangent[first], state.tangent[second]
    size = math.hypot(t, u)
    c, d = target[first] - start[first], target[second] - start[second]
    if size < ROUNDING or math.hypot(c, d) < ROUNDING:
        raise BlockError("CT needs a motion before it in its plane, and an end that is not its start: correct it")
    found = tangent_centre(start, target, (t / size, u / size), state.plane)
    if found is None:
        if t * c + u * d < 0:
            raise BlockError("CT cannot go straight back: correct its end")
        return None
    return plane_arc(start, target, found[0], state.plane, found[1])


def end_by_pole(state: State, words: Words, target: list[float]) -> int:
    """Set the end (3 + rotary) of a motion by AP and RP; bits of the axes that they set. Raises BlockError."""
    angle, radius = words.pop("AP", None), _radius(words, "14200")
    if state.polar_plane != state.plane:
        state.lose_pole()
        state.polar_plane, state.polar_angle = state.plane, None
    first, second = PLANE_AXES[state.plane]
    pole = state.pole_in_force()
    if radius is not None:
        state.polar_radius = radius * state.unit
    else:
        _need_radius(state, math.hypot(target[first] - pole[first], target[second] - pole[second]))
    if angle is not None:
        value = _angle(angle, "14210")
        if angle.form == "IC":
            value += _last_value(state.polar_angle, "AP=IC() counts from an AP, and none")
        state.polar_angle = value
    reach = _last_value(state.polar_radius, "RP is missing, and none")
    turn = _last_value(state.polar_angle, "AP is missing, and none") * DEGREE
    target[first] = pole[first] + reach * math.cos(turn)
    target[second] = pole[second] + reach * math.sin(turn)
    return 1 << first | 1 << second


def _last_value(value: float | None, missing: str) -> float:
    """AP lasts "until a new pole is defined or the working plane is changed", RP until another is written (NC
    Programming 12/2019, 2.9.3.2)."""
    if value is None:
        raise BlockError(f"{missing} was told since the pole and the plane: write it as an absolute value")
    return value


def _need_radius(state: State, distance: float) -> None:
    """BlockError where AP stands alone and the tool is not RP from the pole: of which the circle is, is not told."""
    if state.polar_radius is not None and abs(state.polar_radius - distance) > NEAR:
        is_now, was = distance / state.unit, state.polar_radius / state.unit
        raise BlockError(f"AP without RP: RP was {was:.4g}, and the tool is {is_now:.4g} from the pole; write RP too")


def set_pole(state: State, present: list[float], code: str, words: Words) -> None:
    """G110: from the present place (3 + rotary), G111: from the zero of the workpiece, G112: from the last pole."""
    x, y, z = present[:3] if code == "G110" else (0.0, 0.0, 0.0)
    if code == "G112":
        if state.polar_plane != state.plane:
            state.lose_pole()
        x, y, z = state.pole_in_force()
    pole = [x, y, z]
    first, second = PLANE_AXES[state.plane]
    beyond = [letter for letter in LETTERS if letter in words and letter not in ("XYZ"[first], "XYZ"[second])]
    if "AP" in words or "RP" in words:
        beyond += [letter for letter in "XYZ" if letter in words]
        word = words.pop("AP", None)
        angle = (0.0 if word is None else _angle(word, "14260")) * DEGREE
        radius = (_radius(words, "14250") or 0.0) * state.unit
        pole[first] += radius * math.cos(angle)
        pole[second] += radius * math.sin(angle)
    if beyond:
        raise BlockError(f"{code} with {beyond[0]} (alarm 14270): write two axes of the plane, or AP and RP")
    for slot, letter in enumerate("XYZ"):
        pole[slot] += (number(words, letter, 0.0) or 0.0) * state.unit
    made: Point = (pole[0], pole[1], pole[2])
    state.pole, state.pole_is_set, state.polar_plane, state.polar_angle = made, True, state.plane, None


def _radius(words: Words, alarm: str) -> float | None:
    radius = number(words, "RP")
    if radius is not None and radius < 0.0:
        raise BlockError(f"RP={radius:g} is below zero (alarm {alarm}): correct it")
    return radius


def _angle(word: WordValue, alarm: str) -> float:
    if word.form not in ("", "AC", "IC"):
        raise BlockError(f"AP={word.form}() has no meaning: write AP=AC() or AP=IC()")
    angle = bounded(word, "AP")
    if abs(angle) > 360.0:
        raise BlockError(f"AP={angle:g} is beyond 360 (alarm {alarm}): correct it")
    return angle
