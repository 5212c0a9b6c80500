"""The planners of the comparison, one a file, all with the same face: solve(axis_path, limits, n) -> Outcome."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.path.axis_run import AxisRun

INSIDE = 7


@dataclass(frozen=True)
class Outcome:
    """What a planner made of a path."""

    duration: float
    """[s]; nan where it failed."""
    seconds: float
    """CPU time from path and limits to the law of motion [s]."""
    at_nodes: float = np.nan
    """Largest value over limit at the nodes: feed, velocity, acceleration, jerk."""
    between: float = np.nan
    """The same anywhere between them."""
    ok: bool = True
    """Whether it says itself that it succeeded."""
    note: str = ""
    objective: float = np.nan
    """Time as the discretised problem sums it, where that is the project's own discretisation [s]."""
    points: int = 0


def failed(seconds: float, note: str) -> Outcome:
    """No answer, and why."""
    return Outcome(np.nan, seconds, ok=False, note=" ".join(note.split())[:120])


class Stopwatch:
    """CPU time of this process since it was made: what a busy machine disturbs least."""

    def __init__(self) -> None:
        self.began = time.process_time()

    def __call__(self) -> float:
        return time.process_time() - self.began


def usage(
    run: AxisRun, limits: Limits, nodes: Floats, state: Callable[[Floats, Floats, Floats], Floats]
) -> tuple[float, float]:
    """Peak value over limit at the nodes and between them.

    `state(cell (k,), x (k,), s (k,))` gives s, ds/dt, d2s/dt2, d3s/dt3 (4, k) at a share x of a cell; the nodes are
    judged from both sides.
    """
    cells = len(nodes) - 1
    peaks = []
    for share in (np.array([0.0, 1.0]), (np.arange(INSIDE) + 0.5) / INSIDE):
        cell = np.repeat(np.arange(cells), len(share))
        x = np.tile(share, cells)
        s = nodes[cell] + x * np.diff(nodes)[cell]
        s[x == 1.0] = nodes[cell + 1][x == 1.0]
        peaks.append(float(limit_ratios(run, limits, state(cell, x, s), np.where(x == 1.0, 0.0, 1.0)).max()))
    return peaks[0], peaks[1]


def usage_of_law(run: AxisRun, limits: Limits, law: object) -> tuple[float, float]:
    """Peak value over limit at the nodes of a SplineLaw, and between them, rest cells included."""
    from toolpace.motion.laws import SplineLaw

    assert isinstance(law, SplineLaw)
    cells = np.diff(law.nodes)

    def state(cell: Floats, x: Floats, s: Floats) -> Floats:
        c = law.cells[cell].T
        d = x * cells[cell]
        z = np.maximum(c[0] + d * (c[1] + d * (c[2] + d * c[3])), 1e-12 * c[0])
        slope, curve = c[1] + d * (2.0 * c[2] + 3.0 * d * c[3]), 2.0 * c[2] + 6.0 * d * c[3]
        return np.stack([s, np.sqrt(z), slope / 2.0, curve * np.sqrt(z) / 2.0])

    at_nodes, between = usage(run, limits, law.nodes, state)
    rest = [np.linspace(0.0, law.times[0], 40), np.linspace(law.times[-1], law.duration, 40)]
    for length, t in zip(law.rest, rest):
        if length > 0.0:
            ratios = limit_ratios(run, limits, law.at(t[1:-1]), np.ones(38))
            between = max(between, float(ratios.max()))
    return at_nodes, between


def resting(start: float, length: float, z: float, s: Floats, forth: bool) -> Floats:
    """States (4, n) in a cell from rest at `start` with a constant third derivative, z at its inner end."""
    third = 2.0 * z**1.5 / (9.0 * length**2)
    sign = 1.0 if forth else -1.0
    t = np.cbrt(6.0 * np.abs(s - start) / third)
    return np.stack([s, third * t**2 / 2.0, sign * third * t, np.full(len(s), third)])
