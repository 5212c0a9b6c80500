"""Polar positions: AP and RP about the pole of G110, G111, G112."""

from __future__ import annotations

import math

from toolpace.common.units import DEGREE
from toolpace.programs.reading.sinumerik.contour.circles import AXES
from toolpace.programs.reading.sinumerik.state import Point, State
from toolpace.programs.reading.sinumerik.syntax.values import ValueFault
from toolpace.programs.reading.sinumerik.word_values import Given, Words, bounded, number

LETTERS = "XYZABCUVW"
NEAR = 1e-6
"""By what the place of the tool may differ from RP [m]."""


def end_by_pole(state: State, words: Words, target: list[float]) -> int:
    """Set the end (3 + rotary) of a motion by AP and RP; bits of the axes that they set. Raises ValueFault."""
    angle, radius = words.pop("AP", None), _radius(words, "14200")
    if state.polar_plane != state.plane:
        state.lose_pole()
        state.polar_plane, state.polar_angle = state.plane, None
    first, second = AXES[state.plane]
    pole = state.pole_in_force()
    if radius is not None:
        state.polar_radius = radius * state.unit
    else:
        _need_radius(state, math.hypot(target[first] - pole[first], target[second] - pole[second]))
    if angle is not None:
        value = _angle(angle, "14210")
        if angle.form == "IC":
            value += _known(state.polar_angle, "AP=IC() counts from an AP, and none")
        state.polar_angle = value
    reach = _known(state.polar_radius, "RP is missing, and none")
    turn = _known(state.polar_angle, "AP is missing, and none") * DEGREE
    target[first] = pole[first] + reach * math.cos(turn)
    target[second] = pole[second] + reach * math.sin(turn)
    return 1 << first | 1 << second


def _known(value: float | None, missing: str) -> float:
    """AP lasts "until a new pole is defined or the working plane is changed", RP until another is written (NC
    Programming 12/2019, 2.9.3.2)."""
    if value is None:
        raise ValueFault(f"{missing} was told since the pole and the plane: write it as an absolute value")
    return value


def _need_radius(state: State, distance: float) -> None:
    """ValueFault where AP stands alone and the tool is not RP from the pole: of which the circle is, is not told."""
    if state.polar_radius is not None and abs(state.polar_radius - distance) > NEAR:
        is_now, was = distance / state.unit, state.polar_radius / state.unit
        raise ValueFault(f"AP without RP: RP was {was:.4g}, and the tool is {is_now:.4g} from the pole; write RP too")


def set_pole(state: State, present: list[float], code: str, words: Words) -> None:
    """G110: from the present place (3 + rotary), G111: from the zero of the workpiece, G112: from the last pole."""
    x, y, z = present[:3] if code == "G110" else (0.0, 0.0, 0.0)
    if code == "G112":
        if state.polar_plane != state.plane:
            state.lose_pole()
        x, y, z = state.pole_in_force()
    pole = [x, y, z]
    first, second = AXES[state.plane]
    beyond = [letter for letter in LETTERS if letter in words and letter not in ("XYZ"[first], "XYZ"[second])]
    if "AP" in words or "RP" in words:
        beyond += [letter for letter in "XYZ" if letter in words]
        given = words.pop("AP", None)
        angle = (0.0 if given is None else _angle(given, "14260")) * DEGREE
        radius = (_radius(words, "14250") or 0.0) * state.unit
        pole[first] += radius * math.cos(angle)
        pole[second] += radius * math.sin(angle)
    if beyond:
        raise ValueFault(f"{code} with {beyond[0]} (alarm 14270): write two axes of the plane, or AP and RP")
    for slot, letter in enumerate("XYZ"):
        pole[slot] += (number(words, letter, 0.0) or 0.0) * state.unit
    made: Point = (pole[0], pole[1], pole[2])
    state.pole, state.pole_told, state.polar_plane, state.polar_angle = made, True, state.plane, None


def _radius(words: Words, alarm: str) -> float | None:
    radius = number(words, "RP")
    if radius is not None and radius < 0.0:
        raise ValueFault(f"RP={radius:g} is below zero (alarm {alarm}): correct it")
    return radius


def _angle(given: Given, alarm: str) -> float:
    if given.form not in ("", "AC", "IC"):
        raise ValueFault(f"AP={given.form}() has no meaning: write AP=AC() or AP=IC()")
    angle = bounded(given, "AP")
    if abs(angle) > 360.0:
        raise ValueFault(f"AP={angle:g} is beyond 360 (alarm {alarm}): correct it")
    return angle
