"""Truncated Taylor arithmetic to third order: sine, cosine and rotation of a vector about a fixed direction.

A jet is the array of Taylor coefficients f, f', f''/2, f'''/6 along some parameter. Products of jets are
convolutions, and a function that solves a linear differential equation gives its coefficients one after the
other (Moore 1966; Griewank and Walther, Evaluating Derivatives, 2008, chapter 13).
"""

from __future__ import annotations

from typing import Any

from toolpace.kernels.jit import jit

ORDERS = 4


@jit()
def sine_term(angle: Any, sine: Any, cosine: Any, k: int) -> None:
    """Write coefficient k >= 1 of the sine and cosine of a jet of angles (4,), given the ones below k."""
    s = 0.0
    c = 0.0
    for j in range(1, k + 1):
        s += j * angle[j] * cosine[k - j]
        c -= j * angle[j] * sine[k - j]
    sine[k] = s / k
    cosine[k] = c / k


@jit()
def split(direction: Any, vector: Any, along: Any, across: Any, turned: Any) -> None:
    """Split a vector (3,) for turning about a direction: R(t) v = along + cos(t) across + sin(t) turned."""
    dot = direction[0] * vector[0] + direction[1] * vector[1] + direction[2] * vector[2]
    for i in range(3):
        along[i] = dot * direction[i]
        across[i] = vector[i] - along[i]
    turned[0] = direction[1] * vector[2] - direction[2] * vector[1]
    turned[1] = direction[2] * vector[0] - direction[0] * vector[2]
    turned[2] = direction[0] * vector[1] - direction[1] * vector[0]


@jit()
def turn_constant(parts: Any, sine: Any, cosine: Any, out: Any) -> None:
    """Jet (4, 3) of a constant vector turned by a jet of angles; parts (3, 3) from `split`."""
    for k in range(4):
        for i in range(3):
            out[k, i] = cosine[k] * parts[1, i] + sine[k] * parts[2, i]
    for i in range(3):
        out[0, i] += parts[0, i]


@jit()
def turn_jet(direction: Any, sine: Any, cosine: Any, vector: Any, parts: Any, out: Any) -> None:
    """Jet (4, 3) of a vector jet (4, 3) turned by a jet of angles; parts (4, 3, 3) is scratch."""
    for k in range(4):
        split(direction, vector[k], parts[k, 0], parts[k, 1], parts[k, 2])
    for k in range(4):
        for i in range(3):
            total = parts[k, 0, i]
            for j in range(k + 1):
                total += cosine[j] * parts[k - j, 1, i] + sine[j] * parts[k - j, 2, i]
            out[k, i] = total
