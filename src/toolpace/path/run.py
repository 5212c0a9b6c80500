"""One smooth run of a path between two stops: positions, derivatives, breaks."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from math import comb
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints, frozen, gate_methods
from toolpace.common.value_objects import counted, one_line
from toolpace.programs.speed_profile import SpeedProfile


def no_entries() -> Ints:
    """None."""
    return np.zeros(0, dtype=np.int64)


PLACED = ("evaluate", "tip_slope", "block_at", "block_index")
"""Methods of a run that take parameters (n,)."""


class PathJet(NamedTuple):
    """Value and derivatives 1 to 3 along the parameter: index 0 is the order of the derivative."""

    tip: Floats
    """(4, n, 3) tool tip [m]."""
    axis: Floats | None
    """(4, n, 3) unit tool axis; None where the path is given in rotary joints."""
    rotary: Floats | None
    """(4, n, 2) rotary joints [rad]; None where the path is given in tool axes."""

    # a tuple of arrays would raise where tuples compare them: a jet is equal to itself alone

    def __eq__(self, other: object) -> bool:
        return self is other

    def __ne__(self, other: object) -> bool:
        return self is not other

    def __hash__(self) -> int:
        return id(self)

    def __repr__(self) -> str:
        form = "rotary joints" if self.axis is None else "tool axes"
        return one_line(self, counted(self.tip.shape[1], "place"), f"tip and {form}")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class PathRun(ABC):
    """A stretch that is planned from rest to rest. The parameter s grows by about a tip length and an axis turn."""

    breaks: Floats
    """(k,) ascending parameters, both ends among them, between which the run is analytic."""
    block_start: Floats
    """(b + 1,) parameters at which the blocks begin; the last one is the end of the run."""
    block: Ints
    """(b,) line numbers of the blocks."""
    feed: Floats
    """(b,) most speed of the tip in each block [m/s]; inf where the program asks for none."""
    least_time: Floats
    """(b,) least time of each block [s]."""
    dwell: float = 0.0
    """Time to wait at the end of the run [s]."""
    tool_length: float = math.nan
    """Of the tool in the spindle [m]; nan: as long as the machine's own."""
    entry: Ints = field(default_factory=no_entries)
    """(b,) point of the tool path that each block leads to; (0,) where the path is of no tool path."""
    speed_profile: SpeedProfile | None = None
    """Most speed of the tip along the run, beside the feeds of its blocks; None: these alone hold."""

    def __init_subclass__(cls) -> None:
        """Have arrays of parameters that a caller gives go through the gate."""
        gate_methods(cls, PLACED, "s")

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __repr__(self) -> str:
        blocks, pieces = counted(len(self.block), "block"), counted(len(self.breaks) - 1, "piece")
        return one_line(self, f"s {self.s0:.6g} to {self.s1:.6g}", pieces, blocks)

    @property
    def s0(self) -> float:
        """First parameter."""
        return float(self.breaks[0])

    @property
    def s1(self) -> float:
        """Last parameter."""
        return float(self.breaks[-1])

    @property
    def third_jumps(self) -> bool:
        """Whether the third derivative may jump at the breaks."""
        return True

    def block_index(self, s: Floats) -> Ints:
        """(n,) index of the block at s; at a border that of the next."""
        at = np.searchsorted(self.block_start, s, side="right") - 1
        return np.clip(at, 0, len(self.block) - 1).astype(np.int64)

    def block_at(self, s: Floats) -> Ints:
        """(n,) line number of the block at s."""
        line: Ints = self.block[self.block_index(s)]
        return line

    @abstractmethod
    def evaluate(self, s: Floats) -> PathJet:
        """Position and derivatives 1 to 3 at s (n,): at a break those of its right side, at s1 those of its left."""

    def tip_slope(self, s: Floats) -> Floats:
        """(n, 3) the first derivative of the tip at s (n,), as `evaluate` has it."""
        slope: Floats = self.evaluate(s).tip[1]
        return slope

    def second_derivative_bounds(self) -> Floats | None:
        """(k - 1,) most |P''| of the tip between each two breaks; None where only samples could tell."""
        return None

    def deviations(self) -> tuple[Floats, Floats, Floats] | None:
        """Breaks (k,), and between each two the largest distance of the tip [m] and angle of the tool axis [rad] from
        the program (k - 1,); None where none was fitted to."""
        return None


gate_methods(PathRun, PLACED, "s")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SplineRun(PathRun):
    """A piecewise polynomial of degree five, four times continuously differentiable: what a fit returns."""

    coefficients: Floats
    """(k - 1, 6, 5 or 6) Taylor coefficients at the left end of each piece: tip (3), then rotary joints (2) or axis."""
    tip_off: Floats = field(default_factory=lambda: np.zeros(0))
    """(k - 1,) largest distance of the tip from the program found in each piece [m]; (0,) where it is not known."""
    axis_off: Floats = field(default_factory=lambda: np.zeros(0))
    """(k - 1,) the same of the tool axis [rad]."""

    @property
    def third_jumps(self) -> bool:
        """A spline of degree five with single knots is four times continuously differentiable."""
        return False

    def deviations(self) -> tuple[Floats, Floats, Floats] | None:
        """Breaks (k,), and between each two the largest deviations (k - 1,) that the fit found."""
        return (self.breaks, self.tip_off, self.axis_off) if len(self.tip_off) else None

    def evaluate(self, s: Floats) -> PathJet:
        """Position and derivatives at s (n,); the axis of unit length, with exact derivatives."""
        from toolpace.kernels.fit.quintic_spline import jets

        out = jets(self.breaks, self.coefficients, frozen(s))
        if out.shape[2] == 5:
            return PathJet(out[:, :, :3], None, out[:, :, 3:])
        return PathJet(out[:, :, :3], unit_jets(out[:, :, 3:]), None)

    def second_derivative_bounds(self) -> Floats:
        """(k - 1,) most |P''| of the tip in each piece, by its control points."""
        return second_derivative_bounds(self.coefficients[:, :, :3], np.diff(self.breaks))


def unit_jets(v: Floats) -> Floats:
    """Jets (4, n, 3) of v / |v| from those of v, by Leibniz' rule on u |v| = v and on |v|^2 = v.v."""
    dot = [np.einsum("nc,nc->n", v[0], v[0]), 2.0 * np.einsum("nc,nc->n", v[0], v[1])]
    dot.append(2.0 * np.einsum("nc,nc->n", v[0], v[2]) + 2.0 * np.einsum("nc,nc->n", v[1], v[1]))
    dot.append(2.0 * np.einsum("nc,nc->n", v[0], v[3]) + 6.0 * np.einsum("nc,nc->n", v[1], v[2]))
    r = [np.sqrt(dot[0])]
    r.append(0.5 * dot[1] / r[0])
    r.append((0.5 * dot[2] - r[1] ** 2) / r[0])
    r.append((0.5 * dot[3] - 3.0 * r[1] * r[2]) / r[0])
    u = np.empty_like(v)
    u[0] = v[0] / r[0][:, None]
    u[1] = (v[1] - r[1][:, None] * u[0]) / r[0][:, None]
    u[2] = (v[2] - 2.0 * r[1][:, None] * u[1] - r[2][:, None] * u[0]) / r[0][:, None]
    u[3] = (v[3] - 3.0 * r[1][:, None] * u[2] - 3.0 * r[2][:, None] * u[1] - r[3][:, None] * u[0]) / r[0][:, None]
    return u


def second_derivative_bounds(powers: Floats, width: Floats) -> Floats:
    """(n,) most |P''| on each of n pieces (n, degree + 1, 3), in powers of u from 0 to `width` (n,).

    The largest control point of P'' in Bernstein form.
    """
    degree = powers.shape[1] - 1
    if degree < 2:
        return np.zeros(len(powers))
    second = [k * (k - 1) * powers[:, k] * width[:, None] ** (k - 2) for k in range(2, degree + 1)]
    most = np.zeros(len(powers))
    for j in range(degree - 1):
        control = sum(comb(j, k) / comb(degree - 2, k) * second[k] for k in range(j + 1))
        most = np.maximum(most, np.linalg.norm(control, axis=1))
    return most
