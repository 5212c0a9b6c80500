"""Polar places: AP and RP about a pole, which G110, G111 and G112 set (NC Programming, 4.3)."""

from __future__ import annotations

import math

from toolpace.reading.sinumerik.contour.circles import AXES
from toolpace.reading.sinumerik.given import Given, Words, bounded, number
from toolpace.reading.sinumerik.state import Point, State
from toolpace.reading.sinumerik.syntax.values import ValueFault
from toolpace.units import DEGREE

LETTERS = "XYZABCUVW"


def end_by_pole(state: State, words: Words, target: list[float]) -> int:
    """Set the end (3 + rotary) of a motion by AP and RP; bits of the axes that they set. Raises ValueFault."""
    angle, radius = words.pop("AP", None), _radius(words, "14200")
    if angle is not None:
        value = _angle(angle, "14210")
        state.polar_angle = value + (state.polar_angle if angle.form == "IC" else 0.0)
    if radius is not None:
        state.polar_radius = radius * state.unit
    first, second = AXES[state.plane]
    turn = state.polar_angle * DEGREE
    target[first] = state.pole[first] + state.polar_radius * math.cos(turn)
    target[second] = state.pole[second] + state.polar_radius * math.sin(turn)
    return 1 << first | 1 << second


def set_pole(state: State, present: list[float], code: str, words: Words) -> None:
    """G110: from the present place (3 + rotary), G111: from the zero of the workpiece, G112: from the last pole."""
    x, y, z = present[:3] if code == "G110" else state.pole if code == "G112" else (0.0, 0.0, 0.0)
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
    state.pole = made


def _radius(words: Words, alarm: str) -> float | None:
    radius = number(words, "RP")
    if radius is not None and radius < 0.0:
        raise ValueFault(f"RP={radius:g} is below zero (alarm {alarm}): correct it")
    return radius


def _angle(given: Given, alarm: str) -> float:
    angle = bounded(given, "AP")
    if abs(angle) > 360.0:
        raise ValueFault(f"AP={angle:g} is beyond 360 (alarm {alarm}): correct it")
    return angle
