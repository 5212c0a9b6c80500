"""What may happen to a follower: its figures, what is measured and what is asked for, at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints

PERIODS = (5e-4, 1e-3, 2e-3, 4e-3)
TIP, AXIS, FORCE, BEND_WITH_COMMAND, DEFLECTION = 1, 2, 4, 8, 16
"""What is measured, as a sum; and whether the tip is off from the set-point rather than from the path."""
ODD = (np.nan, np.inf, -np.inf, 1e300, 1e160, 10.0, 1e-320)


@dataclass(frozen=True)
class Disturbed:
    """What happens at each of n steps."""

    override: Floats
    """(n,)"""
    what: Ints
    """(n,) what is measured; 0: nothing."""
    lag: Floats
    """(n,) how long ago it was measured [s]; below zero: in the future."""
    off: Floats
    """(n, 9) what tip [m], axis and force [N] are off by."""


def figures(random: np.random.Generator) -> dict[str, Any]:
    """Keyword arguments of a Follower."""

    def sometimes(value: Any, otherwise: Any = 0.0) -> Any:
        return value if random.random() < 0.4 else otherwise

    return {
        "reserve": float(10.0 ** random.uniform(np.log10(0.02), np.log10(0.4))),
        "cause": sometimes("displaced", "bending"),
        "period": float(random.choice(PERIODS)),
        "delay": float(random.uniform(0.0, 0.02)),
        "gain": float(10.0 ** random.uniform(-2.5, 0.2)),
        "rho": sometimes(float(random.uniform(0.0, 0.9))),
        "max_correction": float(10.0 ** random.uniform(-5.0, -2.5)),
        "max_turn": sometimes(float(10.0 ** random.uniform(-4.0, -1.5))),
        "deadband": sometimes(float(10.0 ** random.uniform(-6.0, -4.0))),
        "filter": sometimes(float(10.0 ** random.uniform(-3.0, -1.0))),
        "hold": float(random.uniform(0.0, 0.2)),
        "fade": float(10.0 ** random.uniform(-2.0, 0.0)),
        "patience": sometimes(float(random.uniform(0.0, 2.0)), np.inf),
        "wait": sometimes(float(10.0 ** random.uniform(-5.0, -3.0)), np.inf),
        "compliance": 1e-7 * random.normal(size=(3, 3)),
    }


def disturbed(random: np.random.Generator, count: int, period: float, most: float) -> Disturbed:
    """`count` steps of a period [s]; disturbances are of the size of the most correction [m]."""
    off = np.zeros((count, 9))
    size = most * 10.0 ** random.uniform(-1.5, 1.0)
    off[:, :3] = size * shape(random, count, period)
    off[:, 3:6] = 10.0 ** random.uniform(-4.0, -0.5) * shape(random, count, period)
    off[:, 6:] = size * 1e7 * shape(random, count, period)
    odd = random.random(count) < random.choice([0.0, 0.01, 0.3])
    off[odd] = random.choice(ODD, (int(odd.sum()), 9))
    what = np.full(count, random.choice([TIP, DEFLECTION, TIP | AXIS, FORCE, TIP | AXIS | FORCE, DEFLECTION | AXIS]))
    what += BEND_WITH_COMMAND if random.random() < 0.5 else 0
    what[dropped(random, count, period)] = 0
    what[random.random(count) < random.choice([0.0, 0.1, 0.9])] = 0
    return Disturbed(override(random, count, period), what, lags(random, count), off)


def shape(random: np.random.Generator, count: int, period: float) -> Floats:
    """(count, 3) noise, steps, bang-bang, waves, or all of them, of size one."""
    t = period * np.arange(count)[:, None]
    noise = random.normal(size=(count, 3))
    steps = held(random, count, period, random.uniform(-1.0, 1.0, (count, 3)))
    waves = np.sin(2.0 * np.pi * 10.0 ** random.uniform(-1.0, 2.3, 3) * t + random.uniform(0.0, 6.3, 3))
    kinds = (noise, steps, np.sign(waves), waves, np.ones((count, 3)) * (t > 0.3), steps + 0.2 * waves + 0.05 * noise)
    return kinds[random.integers(len(kinds))] * random.choice([0.0, 1.0, 1.0], 3)


def held(random: np.random.Generator, count: int, period: float, values: Floats) -> Floats:
    """Values (count, ...) each kept for a while, 3 ms to 3 s as a rule."""
    every = max(int(10.0 ** random.uniform(-2.5, 0.5) / period), 1)
    return np.repeat(values[: count // every + 1], every, axis=0)[:count]


def dropped(random: np.random.Generator, count: int, period: float) -> Bools:
    """(count,) where nothing is measured for a while."""
    return np.asarray(held(random, count, period, random.random(count)) < random.choice([0.0, 0.2, 0.6]))


def lags(random: np.random.Generator, count: int) -> Floats:
    """(count,) how old measurements are: as they should be, out of order, late, from the future, or no number."""
    lag = np.zeros(count)
    some = random.random(count) < random.choice([0.0, 0.05, 0.5])
    lag[some] = random.uniform(-0.01, 0.05, int(some.sum()))
    odd = random.random(count) < random.choice([0.0, 0.01])
    lag[odd] = random.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 10.0, -10.0], int(odd.sum()))
    return lag


def override(random: np.random.Generator, count: int, period: float) -> Floats:
    """(count,) the operator's: steady, steps, holds, a knob that trembles, or no number at times."""
    kinds = (
        np.full(count, random.choice([1.0, 1.2, 0.5])),
        held(random, count, period, random.uniform(0.0, 1.3, count)),
        held(random, count, period, (random.random(count) < 0.7) * 1.0),
        1.0 + 0.2 * random.normal(size=count),
        held(random, count, period, random.choice([0.0, 0.3, 1.0, 1.2, 5.0, -1.0, np.nan, np.inf], count)),
    )
    return np.asarray(kinds[random.integers(len(kinds))], dtype=float)
