"""A polyline at given parameters: straight between vertices, or along great circles."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit()
def straight(s: Floats, values: Floats, at: Floats) -> Floats:
    """The polyline through values (k, d) at s (k,), at the ascending parameters `at` (n,)."""
    d = values.shape[1]
    out = np.empty((len(at), d))
    i = 0
    for j in range(len(at)):
        while i < len(s) - 2 and at[j] >= s[i + 1]:
            i += 1
        u = (at[j] - s[i]) / (s[i + 1] - s[i])
        for c in range(d):
            out[j, c] = values[i + 1, c] if u == 1.0 else values[i, c] + u * (values[i + 1, c] - values[i, c])
    return out


@jit()
def circular(s: Floats, axis: Floats, at: Floats) -> Floats:
    """Unit vectors on the great circles between those (k, 3) at s (k,), at the ascending parameters `at` (n,)."""
    out = np.empty((len(at), 3))
    i = -1
    angle = 0.0
    for j in range(len(at)):
        before = i
        i = max(i, 0)
        while i < len(s) - 2 and at[j] >= s[i + 1]:
            i += 1
        if i != before:
            chord = 0.0
            for c in range(3):
                chord += (axis[i + 1, c] - axis[i, c]) ** 2
            angle = 2.0 * np.arcsin(min(1.0, 0.5 * np.sqrt(chord)))
        u = (at[j] - s[i]) / (s[i + 1] - s[i])
        a, b = 1.0 - u, u
        if angle > 1e-6:
            a, b = np.sin(a * angle), np.sin(b * angle)
        size = 0.0
        for c in range(3):
            out[j, c] = a * axis[i, c] + b * axis[i + 1, c]
            size += out[j, c] ** 2
        size = np.sqrt(size)
        for c in range(3):
            out[j, c] /= size
    return out


@jit()
def distance(a: Floats, b: Floats) -> Floats:
    """Distance (n,) of the points a (n, d) from the points b (n, d)."""
    out = np.empty(len(a))
    for j in range(len(a)):
        total = 0.0
        for c in range(a.shape[1]):
            total += (a[j, c] - b[j, c]) ** 2
        out[j] = np.sqrt(total)
    return out


@jit()
def metric_distance(a: Floats, b: Floats, metric: Floats) -> Floats:
    """Distance (n,) of the points a (n, d) from the points b (n, d), by metrics (n, d, d)."""
    out = np.empty(len(a))
    for j in range(len(a)):
        total = 0.0
        for c in range(a.shape[1]):
            for e in range(a.shape[1]):
                total += (a[j, c] - b[j, c]) * metric[j, c, e] * (a[j, e] - b[j, e])
        out[j] = np.sqrt(max(0.0, total))
    return out
