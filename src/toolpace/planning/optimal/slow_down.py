"""Slow-down of a law about the places between its nodes that exceed a limit by little, or as a whole."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.workers import Workers
from toolpace.kernels.optimal import slow_down as kernel
from toolpace.machine.limits import Limits
from toolpace.machine.rows import Rows
from toolpace.motion.laws import SplineLaw
from toolpace.motion.usage import joint_motion
from toolpace.planning.limit_tolerances import GUARANTEE
from toolpace.planning.peaks import LimitCheck, largest

MOST_PLACES = 60
"""Cells above the guarantee with which slowing down about them is worth a thought."""
LEFT_ABOVE = 3e-5
"""Share of z above what a limit allows that is left at such a place."""
CLOSER_CELLS, CLOSER = 20, 1000
"""Cells that are looked at again, and how closely: what all is slowed down for shall not hide between probes."""


class SlowDown(NamedTuple):
    """What is taken from a law about the cells that exceed the guarantee."""

    left: Floats
    """(n + 2,) shares of the coefficients that are left; all of them at ends in motion."""
    cost: Floats
    """(n - 1,) time that it costs, by cell; cells slowed down together tell it at the first of them [s]."""
    above: Bools
    """(n - 1,) those cells."""

    def dear(self, allowance: float) -> Bools:
        """(n - 1,) the cells that are left when the cheapest of them are slowed down, for so much time at most [s]."""
        begins = np.flatnonzero(self.cost > 0.0)
        order = np.argsort(self.cost[begins])
        dear = np.zeros(len(begins) + 1, dtype=np.bool_)
        dear[1 + order] = np.cumsum(self.cost[begins][order]) > allowance
        together: Bools = dear[np.cumsum(self.cost > 0.0)]
        return together & self.above


def in_place(look: LimitCheck, law: SplineLaw, peak: Floats, ramp: float, strained: Bools | None = None) -> SlowDown:
    """How a law is slowed down about its peaks (cells, 3) above the guarantee.

    `ramp`: time in which an acceleration builds up [s]; on `strained` (cells,) ones it is done at its gentlest.
    """
    above = largest(peak) > GUARANTEE
    loss = np.zeros(len(peak))
    if not above.any():
        return SlowDown(np.ones(len(law.c)), loss, above)
    loss[above] = 1.0 - 1.0 / (slowing_by_cell(peak[above]) - LEFT_ABOVE)
    reach = ramp * np.maximum(kernel.WIDEST, loss[above] / kernel.LOSS_A_RAMP)
    cells = np.flatnonzero(above)
    first = np.searchsorted(law.times, law.times[np.maximum(cells - 1, 0)] - reach)
    last = np.searchsorted(law.times, law.times[np.minimum(cells + 2, len(loss))] + reach, side="right")
    steps = np.zeros(len(law.times) + 1, dtype=np.int64)
    np.add.at(steps, first, 1)
    np.add.at(steps, last, -1)
    near = np.cumsum(steps[:-1]) > 0
    # the joints' motion where a flank may lie: of a long run, at few of its nodes
    path, _ = look.path.cache.with_cap(np.clip(law.nodes[near], look.run.s0, look.run.s1))
    moments = law.at(law.times[near])
    state = joint_motion(path, moments)
    of_rows = [row_motion(rows, path, moments) for rows in look.limits.rows]
    motion = np.zeros((3, len(law.nodes), path.shape[2] + sum(part.shape[2] for part in of_rows)))
    motion[:, near] = np.abs(np.concatenate([(state.qd, state.qdd, state.qddd), *of_rows], axis=2))
    acceleration, jerk = limits_with_rows(look.limits)
    none = np.zeros(len(loss), dtype=np.bool_)
    left, cost = kernel.slow_down(
        law.times, loss, motion, acceleration, jerk, ramp, none if strained is None else strained
    )
    left[:2] = 1.0 if law.rest[0] == 0.0 else left[:2].min()
    left[-2:] = 1.0 if law.rest[1] == 0.0 else left[-2:].min()
    return SlowDown(left, cost, above)


def row_motion(rows: Rows, path: Floats, state: Floats) -> Floats:
    """(3, n, count) velocity, acceleration and jerk of joints that rows of one's own would be the limits of, 1 of
    acceleration or of jerk, as far as a slow-down changes them."""
    v, a, j = (state[i][:, None] for i in (1, 2, 3))
    shares = rows.shares(path)
    if rows.lines is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.nan_to_num(shares / rows.limits_at(path, state[1]).min(axis=0)[:, :, None])
    c0, c1, c2 = np.moveaxis(shares, 2, 0)
    if rows.order == 1:
        return np.stack([2.0 * c1 * v, c0 * v * v + 2.0 * c1 * a, np.zeros_like(c0)])
    first = 2.0 * c2
    return np.stack([first * v, c1 / 1.5 * v * v + first * a, c0 * v**3 + 2.0 * c1 * v * a + first * j])


def limits_with_rows(limits: Limits) -> tuple[Floats, Floats]:
    """Limits of acceleration and of jerk of the joints, and of those that rows of one's own stand for."""
    own = [np.full(rows.count, rows.order) for rows in limits.rows]
    order = np.concatenate([np.empty(0), *own])
    acceleration = np.append(limits.acceleration, np.where(order == 1, 1.0, np.inf))
    return acceleration, np.append(limits.jerk, np.where(order == 2, 1.0, np.inf))


def slowed_in_place(
    look: LimitCheck, law: SplineLaw, peak: Floats, ramp: float, workers: Workers, slow: SlowDown | None = None
) -> SplineLaw | None:
    """The law slowed down about its peaks (cells, 3) above the guarantee; None where that is not enough.

    `slow` is how, where that is worked out already.
    """
    if peak.max() <= GUARANTEE:
        return law
    for _ in range(2):
        slow = slow or in_place(look, law, peak, ramp)
        gently = SplineLaw(law.nodes, law.c * slow.left, law.rest)
        if gently.dips().any():
            return None
        used = look.confirmed(gently, look.peaks(gently, workers), workers).used
        if used.max() <= GUARANTEE:
            return gently
        slow = in_place(look, law, peak, ramp, largest(used) > GUARANTEE)
    return None


def closer(look: LimitCheck, law: SplineLaw, peak: Floats, workers: Workers) -> float:
    """By how much z must be divided as the cells with the highest peaks (cells, 3) show that are looked at closely."""
    used = np.stack([peak[:, 0] ** 2, peak[:, 1], peak[:, 2] ** (2.0 / 3.0)], axis=1).max(axis=1)
    highest = np.argsort(-used)[:CLOSER_CELLS]
    fine = SplineLaw(law.nodes, law.c, law.rest)
    fine.inside = np.linspace(0.0, 1.0, CLOSER)
    return max(slowing_factor(peak), slowing_factor(look.peaks_in(fine, highest, workers).used))


def slowing_by_cell(peak: Floats) -> Floats:
    """(cells,) by how much z must be divided for the peaks (cells, 3) of speed, acceleration and jerk to come to 1."""
    by: Floats = np.maximum(np.maximum(peak[:, 0] ** 2, peak[:, 1]), peak[:, 2] ** (2.0 / 3.0))
    return by


def slowing_factor(peak: Floats) -> float:
    """By how much z must be divided for the peaks (cells, 3) of speed, acceleration and jerk to come to 1."""
    speed, acceleration, jerk = (kind.max() for kind in peak.T)
    return float(max(speed**2, acceleration, jerk ** (2.0 / 3.0)))


def slowing(peak: Floats) -> float:
    """The same, where anything must be slowed down; else 1."""
    return max(1.0, slowing_factor(peak))


def worth(look: LimitCheck, law: SplineLaw, peak: Floats, ramp: float) -> tuple[float, SlowDown | None]:
    """About how long the motion takes once it is slowed down for the guarantee [s]; and how, where that is in place."""
    whole = law.duration * float(np.sqrt(slowing(peak)))
    if not np.isfinite(whole) or np.count_nonzero(largest(peak) > GUARANTEE) > MOST_PLACES:
        return whole, None
    slow = in_place(look, law, peak, ramp)
    return min(whole, law.duration + float(slow.cost.sum())), slow
