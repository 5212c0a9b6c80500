"""Vectors of X, Y, Z."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import Blocks


@jit()
def dot(a: Floats, b: Floats) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit()
def norm(a: Floats) -> float:
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@jit()
def across(a: Floats, b: Floats) -> Floats:
    """Cross product."""
    found = np.empty(3)
    found[0] = a[1] * b[2] - a[2] * b[1]
    found[1] = a[2] * b[0] - a[0] * b[2]
    found[2] = a[0] * b[1] - a[1] * b[0]
    return found


@jit()
def unit(a: Floats) -> Floats:
    """Direction; zero of a vector without length."""
    size = norm(a)
    return a / size if size > 0.0 else a.copy()


@jit()
def between(a: Floats, b: Floats) -> float:
    """Angle."""
    return math.acos(max(-1.0, min(1.0, dot(unit(a), unit(b)))))


@jit()
def on_circle(b: Blocks, j: int, angle: float) -> Floats:
    """Place of block j's arc at an angle from its start."""
    spoke = b.corner[j] - b.centre[j]
    aside = across(b.normal[j], spoke)
    return b.centre[j] + spoke * math.cos(angle) + aside * math.sin(angle) + b.rise[j] * (angle / b.sweep[j])
