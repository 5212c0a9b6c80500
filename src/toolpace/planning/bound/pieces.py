"""The lower bound of a long run from multipliers of overlapping pieces.

Any nonnegative multipliers give a bound (docs/design/bound.md), so those of pieces do. Around the border of two pieces
the ones fade into the others: both are near those of the whole there, since what happens at one place of a run is of
no matter further away than the machine needs to stop and start again.
"""

from __future__ import annotations

import threading

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import dual
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.problem import Knots
from toolpace.planning.bound.relaxation import (
    IN_GAP,
    STANDS_STILL,
    Bound,
    bound_run,
    coefficients_of,
    highest_speed,
    relaxed,
    standstills,
)
from toolpace.planning.endstate import AT_REST, EndState
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.optimal.problem import OnMesh, discretise, weights

PIECE = 4_000
"""Nodes from border to border, unless the overlap would be wider."""
OVERLAP_RAMPS = 40.0
"""How far a piece reaches beyond its border, in times in which an acceleration builds up."""
LEAST_OVERLAP = 100
FADE = 0.5
"""Share of the overlap in which the multipliers of one piece fade into those of the next."""
WHOLE = 12_000
"""Nodes up to which a run is bounded in one piece: cheaper so, and exact."""
SAMPLES = 20_000
"""Nodes from which the highest steady speed of the run is taken."""


class JoinedPieces:
    """What is known of a run's knots, put together from its pieces."""

    def __init__(self, run: AxisRun, limits: Limits, law: SplineLaw, ends: tuple[EndState, EndState]) -> None:
        n = len(law.nodes)
        self.run, self.limits, self.law, self.ends = run, limits, law, ends
        self.highest = highest_speed(run, limits, law, law.nodes[:: max(n // SAMPLES, 1)])
        self.gathered, self.cap, self.wait = np.zeros((n, 8)), np.empty(n), np.zeros(n)
        self.terms = 4 * len(limits)
        self.lock = threading.Lock()

    def problem_ends(self, low: int, high: int) -> tuple[EndState, EndState]:
        """The states in which the piece between two nodes starts and ends."""
        law, n = self.law, len(self.law.nodes)
        start = self.ends[0] if low == 0 else EndState(np.sqrt(law.cells[low, 0]), law.cells[low, 1] / 2.0)
        end = self.ends[1] if high == n - 1 else EndState(np.sqrt(law.cells[high, 0]), law.cells[high, 1] / 2.0)
        return start, end

    def add(self, low: int, high: int, weight: Floats, first: int, last: int) -> int:
        """Add the multipliers of the piece of nodes `low` to `high`, times `weight`; caps and waits from first to last.

        Returns the number of steps it took.
        """
        law = self.law
        start, end = self.problem_ends(low, high)
        before, after = [self.run.s0] if start.at_rest else [], [self.run.s1] if end.at_rest else []
        nodes = law.nodes[low : high + 1]
        around = np.concatenate([before, nodes, after])
        knots = Knots(discretise(self.run, self.limits, around, start, end, self.highest))
        none = np.zeros(len(nodes))
        found = relaxed(knots, coefficients_of(nodes, law.cells[low:high]), none, knots.cap)
        mine = dual.gather(knots.as_knots(), none, found.dual, self.terms)
        with self.lock:
            self.gathered[low : high + 1] += weight[:, None] * mine
            self.cap[first : last + 1] = knots.cap[first - low : last + 1 - low]
            self.wait[first : last + 1] = found.wait[first - low : last + 1 - low]
        return found.steps

    def bound(self, steps: int) -> Bound:
        """The bound of the whole."""
        law = self.law
        mesh = OnMesh(law.nodes, law.rest, self.ends)
        weight = weights(law.nodes, law.rest)
        pace = 1.0 / np.sqrt(law.z_at_nodes())
        n = len(weight)
        # the rows have been gathered
        knots = dual.KnotRows(
            cubic_spline.basis_at_knots(law.nodes), np.zeros(n + 1, dtype=np.int64), weight, np.zeros(n + 2),
            np.empty((0, 2 * len(self.limits), 3)), mesh.as_ends(),
        )  # fmt: skip
        value, _, _ = dual.value_of(knots, np.zeros(n), self.cap, self.gathered, self.terms)
        mesh_duration = float(weight @ pace)
        places = standstills(law.nodes, self.wait > STANDS_STILL * pace, weight * self.wait)
        kept = places[places[:, 2] > IN_GAP * (mesh_duration - value)]
        return Bound(law.duration, mesh_duration, value, kept, steps)


def bound_long_run(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    workers: Workers | None = None,
    progress: Progress = UNTOLD,
) -> Bound:
    """The bound of a run's plan; that of a long run from pieces of it, on all cores."""
    border, over = borders(law, OVERLAP_RAMPS * min(ramp_time(limits), law.duration))
    if len(border) == 2:
        return bound_run(run, limits, law, start, end)
    joined = JoinedPieces(run, limits, law, (start, end))

    def one(k: int) -> int:
        first, last = int(border[k]), int(border[k + 1])
        low, high = first - int(over[k]), last + int(over[k + 1])
        place = np.arange(low, high + 1)
        share = np.ones(len(place))
        for at, reach, sign in ((first, over[k], 1.0), (last, over[k + 1], -1.0)):
            if reach:
                share *= np.clip(0.5 + sign * (place - at) / (2.0 * FADE * reach), 0.0, 1.0)
        return joined.add(low, high, share, first, last)

    steps = (workers or Workers()).each(one, range(len(border) - 1), progress)
    return joined.bound(max(steps))


def borders(law: SplineLaw, overlap: float) -> tuple[Ints, Ints]:
    """Nodes (k,) between which the pieces lie, and how many nodes pieces reach beyond them to cover a time."""
    last = len(law.nodes) - 1
    count = last // PIECE if last > WHOLE else 1
    while count > 1:
        border = np.linspace(0, last, count + 1).astype(np.int64)
        before, after = (np.searchsorted(law.times, law.times[border] + shift) for shift in (-overlap, overlap))
        over = np.maximum(np.maximum(border - before, after - border), LEAST_OVERLAP)
        over[[0, -1]] = 0
        if (border[:-1] + over[:-1] < border[1:] - over[1:]).all():
            return border, over
        count //= 2
    return np.array([0, last]), np.zeros(2, dtype=np.int64)
