"""The detour that costs least time: where to rejoin the commanded motion, and how long to take.

search: what is feasible, after carrying on for no time and then for longer and longer
  for each time at which the commanded motion could be rejoined, and each period of a quintic to it:
      the joints' use of their limits along the quintic
  of those within the limits, by loss of time: the first that keeps to feed and travel too
  its period made as short as passes
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from toolpace.arrays import Bools, Floats
from toolpace.deflect.commanded import CommandedMotion
from toolpace.deflect.detour import Detour
from toolpace.deflect.feasibility import Feasibility
from toolpace.planning.guarantee import DETOUR

RATIOS = np.concatenate([np.linspace(0.5, 0.95, 10), [0.98, 0.99, 1.0, 1.002, 1.005, 1.01, 1.02, 1.04, 1.07],
                         1.1 * 1.12 ** np.arange(16), 8.0 * 1.6 ** np.arange(8)])  # fmt: skip
"""Period of the quintic over the time that the commanded motion takes for the same way: closest about 1, which is where
a small deflection is made up for, and up to 200 for ways of next to no time."""
PERIODS = np.geomspace(5e-3, 60.0, 60)
"""Periods tried beside these, for the last time of rejoining: the time left to it may be next to nothing [s]."""
HORIZONS, LATEST = 28, 12.0
"""Times of rejoining that are tried, a geometric row, and the last of them where more is left of the run [s]: of 2000
random deflections (benchmarks/deflections.py) the slowest way back took 3 s."""
CARRIES, LONGEST_CARRY = 20, 6.0
"""Times of carrying on that are tried, a geometric row, and the last of them where more is left of the run [s]."""
SOONEST = 2e-3
"""The first of either row, as a share of the last."""
BEFORE_THE_END = 0.999
"""Share of the last time of carrying on that is taken: some of the run must be left for a quintic."""
PATIENCE = 2.0
"""Duration of a detour, as a multiple of what its offset needs, up to which no other is looked for."""
SHARPEST = 6.0
"""Most relative change of the parameter's speed over a detour, as an exponent; see DetourRun."""
HASTE = 0.25
"""What a second off the path counts against a second of the whole; no gain of time counts, lest it cut the path."""
LEAST_SPEED = 1e-6
"""Least way of the parameter in the period at its speed of rejoining, over the length of the run."""
LEAST_WAY = 1e-6
"""Least time of the commanded motion to the rejoining that a ratio is taken of [s]; at rest there is none."""
TRIES = 400
"""Detours whose feed and travel are looked at after each time of carrying on, lest a search take for ever."""
BISECTIONS, SHORTEST_PERIOD = 12, 0.8
"""Halvings of what lies between the period found and this share of it; a 4096th of that is left, 5e-5 of the period."""


def horizons(commanded: CommandedMotion, time: float) -> Floats:
    """(n,) times of rejoining on the clock of the commanded law, after `time`; the end of the run is the last."""
    left = commanded.law.duration - time
    times = time + min(left, LATEST) * np.geomspace(SOONEST, 1.0, HORIZONS)
    return np.unique(np.append(times[times < commanded.law.duration * (1.0 - 1e-9)], commanded.law.duration))


def gentle(commanded: CommandedMotion, rejoin: Floats, period: Floats) -> Bools:
    """(n,) whether the parameter's speed changes little enough from the rejoining backwards, or is zero there."""
    order = np.argsort(rejoin, kind="stable")
    state = np.empty((4, len(rejoin)))
    state[:, order] = commanded.law.at(rejoin[order])
    still = commanded.still(state[1])
    length = commanded.run.s1 - commanded.run.s0
    calm = np.abs(state[2]) * period <= SHARPEST * state[1]
    fine: Bools = still | (calm & (state[1] * period >= LEAST_SPEED * length))
    return fine


def candidates(feasibility: Feasibility, carry: float, rejoin: Floats) -> Iterator[tuple[float, Detour, float]]:
    """Loss of time, detour, usage by the joints: all that the joints allow after a carry, least loss first."""
    start = feasibility.time + carry
    rejoin = rejoin[rejoin > start] if len(rejoin) > 1 else rejoin
    if len(rejoin) == 0:
        return
    at = np.concatenate([np.repeat(rejoin, len(RATIOS)), np.full(len(PERIODS), rejoin[-1])])
    way = np.maximum(np.abs(rejoin - start), LEAST_WAY)
    period = np.concatenate([np.outer(way, RATIOS).ravel(), PERIODS])
    fine = gentle(feasibility.commanded, at, period + carry)
    at, period = at[fine], period[fine]
    if len(at) == 0:
        return
    used = feasibility.joint_usage(carry, at, period)
    feasibility.note(float(np.min(np.where(used > DETOUR, used, np.inf))), "the joints' limits")
    loss = np.maximum(carry + period - (at - feasibility.time), 0.0) + HASTE * (carry + period)
    good = np.flatnonzero(used <= DETOUR)
    for k in good[np.argsort(loss[good], kind="stable")][:TRIES]:
        detour = feasibility.detour(carry, float(period[k]), float(at[k]))
        yield float(loss[k]), detour, float(used[k])


def shortest_detour(feasibility: Feasibility, rejoin: float | None = None) -> Detour | None:
    """The detour of least loss that passes, to rejoin at a given time of the commanded law or wherever it is best.

    First with a quintic at once. Where none passes, or only one much longer than the offset itself asks for (a motion
    at its jerk limit leaves no room), also after carrying on for a while. None where nothing passes.
    """
    commanded, time = feasibility.commanded, feasibility.time
    left = commanded.law.duration - time
    carries = [0.0]
    if left > 0.0:
        carries += (min(left, LONGEST_CARRY) * np.geomspace(SOONEST, BEFORE_THE_END, CARRIES)).tolist()
    best, least = None, np.inf
    for carry in carries:
        if HASTE * carry >= least:
            break
        times = horizons(commanded, time + carry) if rejoin is None else np.array([rejoin])
        for loss, detour, used in candidates(feasibility, carry, times):
            if loss >= least:
                break
            if feasibility.passes(detour, used):
                best, least = detour, loss
                break
        if best is not None and best.duration <= PATIENCE * feasibility.needed():
            break
    return None if best is None else sharpened(feasibility, best)


def sharpened(feasibility: Feasibility, detour: Detour) -> Detour:
    """The same detour in the shortest period that bisection below it finds to pass."""
    low, best = SHORTEST_PERIOD * detour.period, detour
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + best.period)
        trial = replace(detour, period=middle)
        if feasibility.passes(trial):
            best = trial
        else:
            low = middle
    return best
