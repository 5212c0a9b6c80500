# ruff: noqa: NPY002 - the only generator that compiled code has
"""Preset speeds at the reference points of the genetic planner, and its simple genetic algorithm for quintic time laws.

Source: Wu, Li, Liu, Perez, ACC 2009, section II.C: the gene is the time period T of an interval. Genes are binary, with
one-point crossover and bit mutation.

The paper sets speeds and accelerations "in advance" and does not say how. Here speeds are lowered until the most
comfortable law of every interval keeps to the limits, then raised again as long as that stays so; the accelerations
follow from the speeds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.planners.quintic_interval import Interval, comfortable, interval_of, usage


class Breeding(NamedTuple):
    """How the algorithm breeds."""

    population: int
    generations: int
    bits: int
    """Of a gene."""
    crossover: float
    """Probability that a child has genes of both parents."""
    mutation: float
    """Probability that a bit is flipped."""
    elite: int
    """How many of the best live on."""
    tournament: int
    """Size of a tournament; 0 for a roulette of the ranks."""


@jit()
def slopes(h: Floats, speed: Floats, acceleration: Floats, fixed: Ints) -> None:
    """Preset accelerations (n + 1,) in place: half the slope of the squared speed, without overshoot, if not fixed.

    The slope is that of a monotone cubic interpolant: the weighted harmonic mean of the neighbouring chords.
    """
    for k in range(1, len(speed) - 1):
        if fixed[k]:
            continue
        left = (speed[k] ** 2 - speed[k - 1] ** 2) / h[k - 1]
        right = (speed[k + 1] ** 2 - speed[k] ** 2) / h[k]
        if left * right <= 0.0:
            acceleration[k] = 0.0
        else:
            w1, w2 = 2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]
            acceleration[k] = 0.5 * (w1 + w2) / (w1 / left + w2 / right)


@jit()
def preset(
    intervals: Interval, speed: Floats, acceleration: Floats, fixed: Ints, reserve: float, most: int
) -> tuple[Floats, int, float, int]:
    """Lower the preset speeds (n + 1,) in place until every interval has a law with at most `reserve` usage.

    intervals: n of them; `fixed` (n + 1,) points stay as they are.
    Returns the periods (n,) of those laws, -1 or the interval where none was found, its usage and what it is of.
    """
    h = intervals.x[:, -1].copy()
    n = len(h)
    period, value, which = np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64)
    dirty = np.ones(n, dtype=np.bool_)
    ends = np.empty(4)
    before = np.empty(n + 1)
    bad = -1
    for _ in range(most):
        copy(acceleration, before)
        slopes(h, speed, acceleration, fixed)
        for k in range(n + 1):
            if acceleration[k] != before[k]:
                dirty[max(k - 1, 0)] = True
                dirty[min(k, n - 1)] = True
        bad = -1
        for k in range(n):
            if dirty[k]:
                ends[0], ends[1], ends[2], ends[3] = speed[k], acceleration[k], speed[k + 1], acceleration[k + 1]
                period[k], value[k], which[k] = comfortable(interval_of(intervals, k), ends, reserve)
                dirty[k] = False
            if value[k] > reserve and (bad < 0 or value[k] > value[bad]):
                bad = k
        if bad < 0:
            break
        moved = False
        for k in range(n):
            if value[k] <= reserve:
                continue
            excess = min(max(value[k] / reserve, 1.0), 8.0)
            factor = max(excess ** (-0.2), 0.85) * 0.999
            top = max(speed[k], speed[k + 1])
            for p in (k, k + 1):
                if not fixed[p] and speed[p] > 0.0 and (speed[p] > 0.8 * top or fixed[2 * k + 1 - p]):
                    speed[p] *= factor
                    moved = True
                    dirty[max(p - 1, 0)] = True
                    dirty[min(p, n - 1)] = True
        if not moved:
            break
    if bad < 0:
        return period, -1, 0.0, 0
    return period, bad, value[bad], which[bad]


@jit()
def raise_hill(speed: Floats, fixed: Ints, top: int, width: int, step: float) -> None:
    """Raise speeds (n + 1,) in place by a share `step` at point `top`, less and less over `width` points beside it."""
    for i in range(max(top - width + 1, 1), min(top + width, len(speed) - 1)):
        if not fixed[i]:
            speed[i] *= 1.0 + step * (1.0 - abs(i - top) / width)


@jit()
def all_comfortable(
    intervals: Interval, top: int, width: int, speed: Floats, acceleration: Floats, reserve: float, period: Floats
) -> bool:
    """Whether the intervals as far as `width` + 1 around a point have laws of at most `reserve` usage, and the periods.

    The nearest ones come first: where a hill is too high, it is so about its top.
    """
    n = len(period)
    ends = np.empty(4)
    for away in range(width + 1):
        for j in (top - 1 - away, top + away):
            if not 0 <= j < n:
                continue
            ends[0], ends[1], ends[2], ends[3] = speed[j], acceleration[j], speed[j + 1], acceleration[j + 1]
            period[j], value, _ = comfortable(interval_of(intervals, j), ends, reserve)
            if value > reserve:
                return False
    return True


@jit()
def raise_speeds(
    intervals: Interval, speed: Floats, acceleration: Floats, fixed: Ints, reserve: float, period: Floats
) -> None:
    """Raise preset speeds in place, single ones and hills of several, as long as every interval keeps a law.

    Arrays as in `preset`, whose result `period` is brought up to date.
    """
    h = intervals.x[:, -1].copy()
    n = len(h)
    trial_speed, trial_acceleration, trial_period = speed.copy(), acceleration.copy(), period.copy()
    rounds = max(2, min(12, 1200 // n))
    # what failed fails again, unless something has changed near by since
    changed, failed = np.zeros(n + 1, dtype=np.int64), np.zeros((4, n + 1), dtype=np.int64)
    clock = 0
    for step in (0.12, 0.06, 0.03, 0.015):
        failed[:] = -1
        for _ in range(rounds):
            raised = 0
            for i in range(4):
                width = 8 >> i
                for k in range(1, n):
                    low, high = max(k - width - 1, 0), min(k + width + 1, n)
                    clock += 1
                    if failed[i, k] > changed[max(low - 1, 0) : min(high + 2, n + 1)].max():
                        continue
                    copy(speed, trial_speed)
                    raise_hill(trial_speed, fixed, k, width, step)
                    copy(acceleration, trial_acceleration)
                    slopes(h, trial_speed, trial_acceleration, fixed)
                    if all_comfortable(intervals, k, width, trial_speed, trial_acceleration, reserve, trial_period):
                        raised += 1
                        copy(trial_speed, speed)
                        copy(trial_acceleration, acceleration)
                        copy(trial_period[low:high], period[low:high])
                        changed[low : high + 1] = clock
                    else:
                        failed[i, k] = clock
            if raised == 0:
                break


@jit()
def decode(gene: int, bits: int, low: float, high: float) -> float:
    """A binary gene as a number in [low, high]."""
    return low + (high - low) * gene / ((1 << bits) - 1)


@jit()
def encode(value: float, bits: int, low: float, high: float) -> int:
    """The gene next to a number in [low, high], rounded up."""
    top = (1 << bits) - 1
    return min(max(int(np.ceil((value - low) / (high - low) * top - 1e-9)), 0), top)


@jit()
def first_population(population: int, genes: int, bits: int, seed: int) -> Ints:
    """Random genes (population, genes); the stream of random numbers begins anew at the seed."""
    np.random.seed(seed)
    out = np.empty((population, genes), dtype=np.int64)
    for k in range(population):
        for i in range(genes):
            out[k, i] = np.random.randint(1 << bits)
    return out


@jit()
def select(fitness: Floats, tournament: int) -> int:
    """A parent: the best of a tournament, or with tournament 0 by a roulette of the ranks."""
    n = len(fitness)
    if tournament > 0:
        best = np.random.randint(n)
        for _ in range(tournament - 1):
            other = np.random.randint(n)
            if fitness[other] < fitness[best]:
                best = other
        return best
    order = np.argsort(fitness)
    spin = np.random.random() * n * (n + 1) / 2.0
    for rank in range(n):
        spin -= n - rank
        if spin <= 0.0:
            return int(order[rank])
    return int(order[n - 1])


@jit()
def breed(genes: Ints, fitness: Floats, breeding: Breeding) -> Ints:
    """The next generation (population, genes): elite kept, parents selected, one-point crossover, bits flipped."""
    _, _, bits, crossover, mutation, elite, tournament = breeding
    n, g = genes.shape
    out = np.empty_like(genes)
    order = np.argsort(fitness)
    for k in range(elite):
        out[k] = genes[order[k]]
    for k in range(elite, n):
        mother, father = select(fitness, tournament), select(fitness, tournament)
        cut = np.random.randint(1, g * bits) if np.random.random() < crossover else g * bits
        for i in range(g):
            keep = min(max(cut - i * bits, 0), bits)
            mask = (1 << keep) - 1
            child = (genes[mother, i] & mask) | (genes[father, i] & ~mask)
            for b in range(bits):
                if np.random.random() < mutation:
                    child ^= 1 << b
            out[k, i] = child
    return out


@jit()
def shorten(
    interval: Interval, ends: Floats, breeding: Breeding, first: float, allowed: float, low: float, high: float,
    seed: int,
) -> tuple[float, float, int]:  # fmt: skip
    """The shortest period of one interval that the genetic algorithm finds with usage at most `allowed`.

    `first` is a period that joins the first population; others are drawn from [low, high]. Returns the period, its
    usage, and what that is of; where no individual keeps to the limits, the one nearest to them.
    """
    population, generations, bits = breeding.population, breeding.generations, breeding.bits
    genes = first_population(population, 1, bits, seed)
    fitness, period = np.empty(population), first
    best, value, which = np.inf, np.inf, 0
    for generation in range(generations + 1):
        for k in range(population):
            # the first period takes part in the first population exactly, not rounded to a gene
            is_first = generation == 0 and k == 0
            if is_first:
                genes[0, 0] = encode(first, bits, low, high)
            trial = first if is_first else decode(genes[k, 0], bits, low, high)
            used, kind, _ = usage(interval, ends, trial, np.inf, -1)
            fitness[k] = trial if used <= allowed else 1e3 * high * (1.0 + used)
            if fitness[k] < best:
                best, period, value, which = fitness[k], trial, used, kind
        if generation < generations:
            genes = breed(genes, fitness, breeding)
    return period, value, which


@jit()
def reset_point(
    intervals: Interval, ends: Floats, breeding: Breeding, periods: Floats, allowed: Floats, reach: Floats, seed: int
) -> tuple[float, float, float, float]:
    """Evolve speed and acceleration of one reference point with the periods of the intervals on its both sides.

    intervals: both; ends (6,): speed and acceleration at the three points; periods (2,);
    allowed (2,) usage; reach (3,): shares by which speed and periods, and the amount by which the acceleration, may
    change. What is there takes part, so the sum of the periods never grows. Returns speed, acceleration, periods.
    """
    population, generations, bits = breeding.population, breeding.generations, breeding.bits
    before, after = interval_of(intervals, 0), interval_of(intervals, 1)
    low = np.array(
        [ends[2] * (1 - reach[0]), ends[3] - reach[2], periods[0] * (1 - reach[1]), periods[1] * (1 - reach[1])]
    )
    high = np.array([ends[2] * (1 + reach[0]), ends[3] + reach[2], periods[0], periods[1]])
    for k in range(2, 4):
        high[k] *= 1 + 0.5 * reach[1]
    genes = first_population(population, 4, bits, seed)
    now = np.array([ends[2], ends[3], periods[0], periods[1]])
    best, champion = now[2] + now[3], now.copy()
    fitness = np.empty(population)
    trial, both = np.empty(4), np.empty(4)
    for generation in range(generations + 1):
        for k in range(population):
            for i in range(4):
                trial[i] = decode(genes[k, i], bits, low[i], high[i])
            if generation == 0 and k == 0:
                for i in range(4):
                    genes[0, i] = encode(now[i], bits, low[i], high[i])
                copy(now, trial)
            both[0], both[1], both[2], both[3] = ends[0], ends[1], trial[0], trial[1]
            first, _, _ = usage(before, both, trial[2], np.inf, -1)
            both[0], both[1], both[2], both[3] = trial[0], trial[1], ends[4], ends[5]
            second, _, _ = usage(after, both, trial[3], np.inf, -1)
            excess = max(first / allowed[0], second / allowed[1])
            fitness[k] = trial[2] + trial[3] if excess <= 1.0 else 1e3 * (high[2] + high[3]) * (1.0 + excess)
            if fitness[k] < best:
                best = fitness[k]
                copy(trial, champion)
        if generation < generations:
            genes = breed(genes, fitness, breeding)
    return champion[0], champion[1], champion[2], champion[3]
