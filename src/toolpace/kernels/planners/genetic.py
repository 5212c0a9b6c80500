# ruff: noqa: NPY002 - the only generator that compiled code has
"""The simple genetic algorithm for quintic time laws: binary genes, one-point crossover, bit mutation.

Source: Wu, Li, Liu, Perez, ACC 2009, section II.C: the gene is the time period T of an interval.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.planners.quintic_interval import Interval, interval_of, usage


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
    interval: Interval, ends: Floats, breeding: Breeding, seed: float, allowed: float, low: float, high: float,
    seed: int,
) -> tuple[float, float, int]:  # fmt: skip
    """The shortest period of one interval that the genetic algorithm finds with usage at most `allowed`.

    `seed` is a period that joins the first population; others are drawn from [low, high]. Returns the period, its
    usage, and what that is of; where no individual keeps to the limits, the one nearest to them.
    """
    population, generations, bits = breeding.population, breeding.generations, breeding.bits
    genes = first_population(population, 1, bits, seed)
    fitness, period = np.empty(population), seed
    best, value, which = np.inf, np.inf, 0
    for generation in range(generations + 1):
        for k in range(population):
            # the seed takes part in the first population exactly, not rounded to a gene
            of_seed = generation == 0 and k == 0
            if of_seed:
                genes[0, 0] = encode(seed, bits, low, high)
            trial = seed if of_seed else decode(genes[k, 0], bits, low, high)
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
