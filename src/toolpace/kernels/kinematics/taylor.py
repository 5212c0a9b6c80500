"""Truncated Taylor arithmetic to third order: sine, cosine and rotation of a vector about a fixed direction.

A jet is the array of Taylor coefficients f, f', f''/2, f'''/6 along some parameter. Products of jets are
convolutions, and a function that solves a linear differential equation gives its coefficients one after the
other (Moore 1966; Griewank and Walther, Evaluating Derivatives, 2008, chapter 13).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


class Angle(NamedTuple):
    """Jets (4,) of an angle and of its sine and cosine."""

    value: Floats
    sine: Floats
    cosine: Floats


@jit()
def new_angle() -> Angle:
    """Room for an angle."""
    return Angle(np.empty(4), np.empty(4), np.empty(4))


@jit()
def start_angle(angle: Angle, value: float) -> None:
    """Write coefficient 0 of all three jets."""
    angle.value[0] = value
    angle.sine[0] = math.sin(value)
    angle.cosine[0] = math.cos(value)


@jit()
def sine_term(angle: Angle, k: int) -> None:
    """Write coefficient k >= 1 of the sine and cosine, given the ones below k and coefficient k of the angle."""
    s = 0.0
    c = 0.0
    for j in range(1, k + 1):
        s += j * angle.value[j] * angle.cosine[k - j]
        c -= j * angle.value[j] * angle.sine[k - j]
    angle.sine[k] = s / k
    angle.cosine[k] = c / k


@jit(inline=True)
def split(direction: Floats, vector: Floats, parts: Floats) -> None:
    """Split a vector (3,) for turning about a direction: R(t) v = parts[0] + cos(t) parts[1] + sin(t) parts[2]."""
    dot = direction[0] * vector[0] + direction[1] * vector[1] + direction[2] * vector[2]
    for i in range(3):
        parts[0, i] = dot * direction[i]
        parts[1, i] = vector[i] - parts[0, i]
    parts[2, 0] = direction[1] * vector[2] - direction[2] * vector[1]
    parts[2, 1] = direction[2] * vector[0] - direction[0] * vector[2]
    parts[2, 2] = direction[0] * vector[1] - direction[1] * vector[0]


@jit()
def turn_constant(parts: Floats, angle: Angle, out: Floats) -> None:
    """Jet (4, 3) of a constant vector turned by a jet of angles; parts (3, 3) from `split`."""
    for k in range(4):
        for i in range(3):
            out[k, i] = angle.cosine[k] * parts[1, i] + angle.sine[k] * parts[2, i]
    for i in range(3):
        out[0, i] += parts[0, i]


@jit()
def turn_jet(direction: Floats, angle: Angle, vector: Floats, parts: Floats, out: Floats) -> None:
    """Jet (4, 3) of a vector jet (4, 3) turned by a jet of angles; parts (4, 3, 3) is scratch."""
    for k in range(4):
        split(direction, vector[k], parts[k])
    for k in range(4):
        for i in range(3):
            total = parts[k, 0, i]
            for j in range(k + 1):
                total += angle.cosine[j] * parts[k - j, 1, i] + angle.sine[j] * parts[k - j, 2, i]
            out[k, i] = total
