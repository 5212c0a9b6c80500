"""A machine that bends, followed in a compiled loop: drives that lag, a sensor with noise and dead time, runout.

The tip is where the joints are, and is bent by

    b = bending - rho * correction

since a command that goes further into the cut is bent further: rho is the stiffness of the cut over that of tool and
cut together.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.following import Follower
from toolpace.kernels.follow import layout as at
from toolpace.kernels.follow.correction_target import chain_of
from toolpace.kernels.follow.pace import place_on_path
from toolpace.kernels.follow.step import step
from toolpace.kernels.kinematics.chain import forward

INPUTS, OUTPUTS, OVERRIDE, TAU, NOW, Q, STATUS = (
    at.INPUTS, at.OUTPUTS, at.OVERRIDE, at.TAU, at.NOW, at.Q, at.STATUS,
)  # fmt: skip
SPINDLE = 100.0
"""Turns of the spindle a second."""
LARGE = 1e-10
"""For a small signal [m]."""
LONG = 4000
"""Set-points in which a signal grows or not."""


@dataclass(frozen=True)
class Plant:
    """What bends and how it is measured. Lengths in m, times in s."""

    bending: tuple[float, float, float] = (100e-6, 0.0, 0.0)
    rho: float = 0.3
    runout: float = 15e-6
    noise: float = 2e-6
    dead_time: float = 4e-3
    """From a measurement to when it arrives."""
    lag: float = 5e-3
    """Time constant of the drives."""
    transport: int = 0
    """Set-points by which the drives come late, beside their lag."""
    start: float = 0.5
    """When the tool begins to cut."""
    feed: float = 1.0
    """Override. At 0 the path stands at its start from the beginning."""
    kick: float = 0.0
    """What the first measurement is off by, for a loop that is left to itself."""


def followed(
    follower: Follower, plant: Plant, count: int, measured: bool = True, seed: int = 0
) -> tuple[Floats, Floats]:
    """(count, 3) error of the tip, (count, OUTPUTS) set-points; without `measured` the follower is left blind."""
    follower.reset()
    noise = plant.noise * np.random.default_rng(seed).normal(size=(count, 3))
    figures = np.array(
        [
            plant.rho,
            plant.runout,
            plant.dead_time,
            plant.lag,
            plant.transport,
            plant.start,
            plant.kick,
            plant.feed,
            measured,
        ]
    )
    error, out = np.empty((count, 3)), np.empty((count, OUTPUTS))
    _loop(follower.piece, follower.state, np.array(plant.bending), figures, follower.period, noise, error, out)
    return error, out


@numba.njit(error_model="numpy")
def _loop(
    piece: Floats,
    state: Floats,
    bending: Floats,
    figures: Floats,
    period: float,
    noise: Floats,
    error: Floats,
    out: Floats,
) -> None:
    rho, runout, dead_time, lag, transport, start, kick, feed, measured = figures
    chain, given, column = chain_of(piece), np.empty(INPUTS), np.empty(4)
    count, late, dead = len(error), int(transport), round(dead_time / period)
    path, own, tips = np.zeros((count + 1, 5)), np.zeros((count + 1, 5)), np.empty((count, 3))
    q, bent, tip, on_path, axis = np.empty(5), np.zeros(5), np.empty(3), np.empty(3), np.empty(3)
    for j in range(5):
        place_on_path(piece, 0.0, j, column)
        path[0, j] = q[j] = column[0]
    # so that a ramp comes late by just the lag
    share = period / (lag + period)
    for i in range(count):
        k = max(i - late, 0)
        # path and correction go through the drives alike
        for j in range(5):
            q[j] += share * (path[k, j] - q[j])
            bent[j] += share * (own[k, j] - bent[j])
        forward(chain, q.reshape((1, 5)), on_path.reshape((1, 3)), axis.reshape((1, 3)))
        forward(chain, (q + bent).reshape((1, 5)), tip.reshape((1, 3)), axis.reshape((1, 3)))
        t = i * period
        cuts = 1.0 if t >= start else 0.0
        turn = 2.0 * math.pi * SPINDLE * t
        for d in range(3):
            error[i, d] = (1.0 - rho) * (tip[d] - on_path[d]) + cuts * bending[d]
            if d < 2:
                error[i, d] += cuts * runout * (math.cos(turn) if d == 0 else math.sin(turn))
            tips[i, d] = on_path[d] + error[i, d] + noise[i, d] + (kick if i == 0 else 0.0)
        given[:] = np.nan
        given[OVERRIDE] = feed
        if measured > 0.0 and i >= dead:
            given[0] = (i - dead) * period
            given[1:4] = tips[i - dead]
        step(piece, state, given, out[i])
        for j in range(5):
            own[i + 1, j] = out[i, Q + 20 + j]
            path[i + 1, j] = out[i, Q + j] - own[i + 1, j]


def largest_root(gain: float, late: int, known: int, rho: float, told: float) -> float:
    """Largest modulus of the roots of the loop of small signals, from set-point to set-point,

        c[k+1] = (1 - gain) c[k] + gain / (1 - told) ((rho - 1) c[k - late] + (1 - told) c[k - known])

    with `late` set-points of delay, of which `known` are known, and `told` the rho that the follower was told.
    """
    size = max(late, known) + 1
    polynomial = np.zeros(size + 1)
    polynomial[0] = 1.0
    polynomial[1] -= 1.0 - gain
    polynomial[1 + late] -= gain * (rho - 1.0) / (1.0 - told)
    polynomial[1 + known] -= gain
    return float(np.abs(np.roots(polynomial)).max())


def critical(grows: Callable[[float], bool], low: float, high: float, steps: int = 12) -> float:
    """The gain from which a loop grows, between one at which it does not and one at which it does."""
    assert not grows(low) and grows(high)
    for _ in range(steps):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return 0.5 * (low + high)


def grows(follower: Follower, gain: float, late: int, known: int, rho: float, told: float) -> bool:
    """Whether a follower's kernel lets a signal of a picometre grow, where the drives are `late` set-points late.

    The path stands: where it moves, a delay that is not known shifts what is measured along it.
    """
    head = {at.GAIN: gain, at.DELAY: known * follower.period, at.RHO: told, at.FILTER: 0.0, at.DEADBAND: 0.0}
    for place, value in head.items():
        follower.piece[place] = value
    plant = Plant((0.0, 0.0, 0.0), rho, 0.0, 0.0, 0.0, 0.0, late, 0.0, 0.0, 1e-12)
    _, out = followed(follower, plant, LONG)
    size = np.abs(out[:, at.OUT_CORRECTION : at.OUT_CORRECTION + 5]).max(axis=1)
    first, last = size[LONG // 16 : LONG // 4].max(), size[-LONG // 4 :].max()
    # what has grown beyond what the tracker follows at once has grown
    return bool(last > LARGE or last > max(first, 1e-15))


def below(error: Floats, frequency: float, period: float) -> Floats:
    """The part of an error (n, 3) below a frequency [Hz], without lag."""
    from scipy.signal import butter, sosfiltfilt

    part: Floats = sosfiltfilt(butter(4, frequency, fs=1.0 / period, output="sos"), error, axis=0)
    return part
