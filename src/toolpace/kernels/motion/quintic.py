"""Quintic intervals, and the chain rule from path to time (Wu et al. 2009, Eq. 7a to 7e).

Source: Wu, Li, Liu, Perez, "Local minimum time trajectory planning for five-axis machining with or without
deflection", ACC 2009, doi 10.1109/ACC.2009.5160578. What is misprinted there is put right here, and said.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit()
def coefficients(knots: Floats, value: Floats, first: Floats, second: Floats) -> Floats:
    """C0 to C5 of every interval between two reference points, Eq. (7b).

    knots (n + 1,) parameter of the points, increasing; value, first, second (n + 1, c): the coordinates and their
    derivatives by that parameter. Returns (n, 6, c), polynomials in u = (s - knots[k]) / (knots[k + 1] - knots[k]).

    As printed, with D3 = (r(k+1)'' - 2 C2) / 2: the paper leaves the half out, and then the second derivative at the
    end comes out as 2 r(k+1)'' - r(k)''.
    """
    n, c = len(knots) - 1, value.shape[1]
    out = np.empty((n, 6, c))
    for k in range(n):
        h = knots[k + 1] - knots[k]
        for i in range(c):
            c0, c1, c2 = value[k, i], first[k, i] * h, second[k, i] * h * h / 2.0
            d1 = value[k + 1, i] - c0 - c1 - c2
            d2 = first[k + 1, i] * h - c1 - 2.0 * c2
            d3 = second[k + 1, i] * h * h / 2.0 - c2
            out[k, 0, i], out[k, 1, i], out[k, 2, i] = c0, c1, c2
            out[k, 3, i] = 10.0 * d1 - 4.0 * d2 + d3
            out[k, 4, i] = -15.0 * d1 + 7.0 * d2 - 2.0 * d3
            out[k, 5, i] = 6.0 * d1 - 3.0 * d2 + d3
    return out


@jit()
def evaluate(knots: Floats, polynomials: Floats, s: Floats) -> Floats:
    """(4, len(s), c) coordinates and derivatives one to three by s; at a point the right side, at the last the left.

    Beyond the ends the end intervals go on.
    """
    n, c = len(knots) - 1, polynomials.shape[2]
    out = np.empty((4, len(s), c))
    for j in range(len(s)):
        k = min(max(np.searchsorted(knots, s[j], side="right") - 1, 0), n - 1)
        h = knots[k + 1] - knots[k]
        u = (s[j] - knots[k]) / h
        for i in range(c):
            c0, c1, c2, c3, c4, c5 = polynomials[k, :, i]
            out[0, j, i] = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
            out[1, j, i] = (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h
            out[2, j, i] = (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)
            out[3, j, i] = (6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)) / (h * h * h)
    return out


@jit()
def feed_rate(first: Floats, rate: Floats) -> Floats:
    """(n,) speed of the tip, Eq. (7c), of tip derivatives (n, 3) by the parameter and its rate (n,)."""
    out = np.empty(len(rate))
    for j in range(len(rate)):
        x, y, z = first[j]
        out[j] = np.sqrt(x * x + y * y + z * z) * abs(rate[j])
    return out


@jit()
def parameter_rates(first: Floats, second: Floats, speed: Floats, acceleration: Floats) -> Floats:
    """(2, n) du/dt and d2u/dt2, Eq. (7c) and (7d), where the tip moves with a speed and its rate of change (n,).

    first, second (n, 3): derivatives of the tip by the parameter.
    """
    out = np.empty((2, len(speed)))
    for j in range(len(speed)):
        x, y, z = first[j]
        square = x * x + y * y + z * z
        dot = x * second[j, 0] + y * second[j, 1] + z * second[j, 2]
        out[0, j] = speed[j] / np.sqrt(square)
        out[1, j] = acceleration[j] / np.sqrt(square) - speed[j] * speed[j] * dot / (square * square)
    return out


@jit()
def axis_motion(jets: Floats, rates: Floats) -> Floats:
    """(3, n, m) velocity, acceleration and jerk of the axes, Eq. (7e) with its missing third term w' u'''.

    jets (4, n, m): axis positions and derivatives by the parameter; rates (3, n): du/dt, d2u/dt2, d3u/dt3.
    """
    n, m = jets.shape[1], jets.shape[2]
    out = np.empty((3, n, m))
    for j in range(n):
        u1, u2, u3 = rates[0, j], rates[1, j], rates[2, j]
        for i in range(m):
            out[0, j, i] = jets[1, j, i] * u1
            out[1, j, i] = jets[2, j, i] * u1 * u1 + jets[1, j, i] * u2
            out[2, j, i] = jets[3, j, i] * u1**3 + 3.0 * jets[2, j, i] * u1 * u2 + jets[1, j, i] * u3
    return out
