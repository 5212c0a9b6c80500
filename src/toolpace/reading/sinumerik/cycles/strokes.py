"""Depths of the strokes of CYCLE83."""

from __future__ import annotations

from toolpace.reading.sinumerik.syntax.values import ValueFault
from toolpace.units import MILLIMETRE


def strokes_of(whole: float, first: float, less: float) -> list[float]:
    """Depths [m] at which the strokes of CYCLE83 end: each is shorter by `less`, down to that; the last two are equal.

    Where `less` is zero all strokes but the last are as long as the first.
    """
    found: list[float] = []
    depth, stroke = 0.0, min(first, whole)
    if stroke <= 0.0 or whole / max(min(stroke, less or stroke), 1e-12) > 1e4:
        raise ValueFault("CYCLE83 takes more than 10000 strokes, or none: check its depths")
    while whole - depth > stroke * (1.0 + 1e-9):
        depth += stroke
        found.append(depth)
        if less:
            stroke = max(stroke - less, less)
            rest = whole - depth
            if stroke < rest < 2.0 * less:
                stroke = rest / 2.0
    return [*found, whole]


def stop_distance(whole: float) -> float:
    """How far above the last depth the rapid ends: 0.6 mm to 30 mm of depth, then a fiftieth, at most 7 mm."""
    return 0.6 * MILLIMETRE if whole <= 30.0 * MILLIMETRE else min(whole / 50.0, 7.0 * MILLIMETRE)
