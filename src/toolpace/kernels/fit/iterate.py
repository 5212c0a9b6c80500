"""The iterate of the interior-point method of a fit: state, step, convergence.

There are m samples of g coordinates and n free coefficients; see smoothest_steps.py for the symbols.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


class Iterate(NamedTuple):
    """Where the method stands."""

    off: Floats
    """(m, g) deviation of the samples."""
    force: Floats
    """(m, g) metric times deviation."""
    excess: Floats
    """(m,) half the square of the deviation less that of the radius."""
    slack: Floats
    """(m,)"""
    multiplier: Floats
    """(m,)"""
    gradient: Floats
    """(n g,) of the roughness; from `measure` on that of the Lagrangian."""
    work: Floats
    """(m, g) what each sample adds to the gradient."""
    rough: Floats
    """(cells,) roughness of each cell."""
    moment: Floats
    """(m, g, g) what each sample adds to the Newton matrix."""


class Step(NamedTuple):
    """What a step changes."""

    x: Floats
    """(len(x), g) coefficients."""
    move: Floats
    """(m, g) deviation of the samples."""
    slack: Floats
    """(m,)"""
    multiplier: Floats
    """(m,)"""
    right: Floats
    """(n g,) right side of the Newton system, then its solution."""
    work: Floats
    """(m, g) its share of each sample."""


class Measure(NamedTuple):
    """How far the method has come."""

    gap: float
    mu: float
    """Mean product of slack and multiplier."""
    outside: float
    """Largest excess over squared radius."""
    top: float
    """Largest entry of the gradient of the roughness."""
    residual: float
    """Largest entry of the gradient of the Lagrangian."""
    open_gap: float
    """Largest gap of a stretch over the roughness of it and its neighbours."""


@jit()
def new_iterate(m: int, g: int, n: int, cells: int) -> Iterate:
    """Room for m samples of g coordinates, n free coefficients."""
    return Iterate(
        np.empty((m, g)), np.empty((m, g)), np.empty(m), np.empty(m), np.empty(m), np.empty(n * g), np.empty((m, g)),
        np.zeros(cells), np.empty((m, g, g)),
    )  # fmt: skip


@jit()
def new_step(m: int, g: int, n: int, coefficients: int) -> Step:
    """Room for m samples of g coordinates, n free coefficients."""
    return Step(
        np.zeros((coefficients, g)), np.zeros((m, g)), np.zeros(m), np.zeros(m), np.empty(n * g), np.empty((m, g))
    )
