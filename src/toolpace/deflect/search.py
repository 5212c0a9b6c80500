"""The detour that costs least time: where to rejoin a known motion, and how long to take."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.deflect.detour import Detour, Excess, Known, tip_velocity
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.planning.guarantee import DETOUR

RATIOS = np.concatenate([np.linspace(0.5, 0.95, 10), [0.98, 0.99, 1.0, 1.002, 1.005, 1.01, 1.02, 1.04, 1.07],
                         1.1 * 1.12 ** np.arange(16), 8.0 * 1.6 ** np.arange(8)])  # fmt: skip
"""Period of the quintic over the time that the known motion takes for the same way."""
PERIODS = np.geomspace(5e-3, 60.0, 60)
"""Periods tried beside these, for the last time of rejoining: the time left to it may be next to nothing [s]."""
HORIZONS = 28
CARRIES = 20
CARRIED = 0.2
"""How far ahead the carrying on is looked at where nothing passes else [s]."""
PATIENCE = 2.0
"""Duration of a detour, as a multiple of what its offset needs, up to which no other is looked for."""
SHARPEST = 6.0
"""Most relative change of the parameter's speed over a detour, as a exponent; see DetourRun."""
HASTE = 0.25
"""What a second off the path counts against a second of the whole; no gain of time counts, lest it cut the path."""
LEAST_SPEED = 1e-6
"""Least way of the parameter in the period at its speed of rejoining, over the length of the run."""
TIP_SAMPLES = 81
CARRY_STEP = 2e-3
"""[s]"""
TRIES = 400
BISECTIONS = 12


class Judge:
    """Whether a detour keeps to the limits of joints and feed, and how far it is from that."""

    def __init__(
        self, known: Known, limits: Limits, machine: Machine | None, feed: float, time: float, offset: Floats
    ) -> None:
        self.known, self.machine, self.feed, self.time, self.offset = known, machine, feed, time, offset
        self.limits = np.stack([limits.velocity, limits.acceleration, limits.jerk])
        self.nearest, self.of = np.inf, "a limit"
        """Least usage seen of a detour that did not pass, and of what."""
        self.excess = Excess.at_start(machine, feed, known.motion(np.array([time])), offset)

    def relax(self) -> bool:
        """Allow what the tip passes the feed by if the joints just carry on for a while; whether that is more."""
        if self.machine is None or not np.isfinite(self.feed):
            return False
        motion = self.known.motion(self.time + np.linspace(0.0, CARRIED, TIP_SAMPLES))
        speed = np.linalg.norm(tip_velocity(self.machine, motion[0] + self.offset, motion[1]), axis=1)
        more = 1.1 * float(speed.max() - self.feed)
        if more <= self.excess.speed:
            return False
        self.excess = Excess(self.feed, more, self.excess.growth)
        return True

    def joint_usage(self, carry: float, rejoin: Floats, period: Floats) -> Floats:
        """(n,) usage of the quintics alone, to rejoin at times (n,) in periods (n,)."""
        from toolpace.kernels.planners.quintic_bridge import usages

        start = self.known.motion(np.array([self.time + carry]))[:3, 0]
        start[0] += self.offset
        order = np.argsort(rejoin, kind="stable")
        ends = np.empty((len(rejoin), 3, len(self.offset)))
        ends[order] = self.known.motion(rejoin[order])[:3].transpose(1, 0, 2)
        out: Floats = usages(np.ascontiguousarray(start), ends, np.ascontiguousarray(period), self.limits)
        return out

    def needed(self) -> float:
        """Time that a quintic from rest to rest over the offset takes within the limits [s]."""
        off = np.abs(self.offset)
        v, a, j = self.limits
        return float(max((1.875 * off / v).max(), np.sqrt(5.7735 * off / a).max(), np.cbrt(60.0 * off / j).max()))

    def path_usage(self, detour: Detour) -> float:
        """Usage of feed and travel along a detour: above 1 where the tip is too fast or a joint leaves its travel."""
        if self.machine is None:
            return 0.0
        even = detour.carry + detour.period * np.linspace(0.0, 1.0, TIP_SAMPLES)
        # closer at the start, where the tip may just touch the feed
        close = detour.carry + (even[2] - detour.carry) * np.linspace(0.0, 1.0, 9) ** 2
        t = np.concatenate([np.arange(0.0, detour.carry, CARRY_STEP), close[:-1], even[2:]])
        q, qd = detour.motion(t)[:2]
        low, high = self.machine.travel.T
        if (q < low - 1e-9).any() or (q > high + 1e-9).any():
            return np.inf
        if not np.isfinite(self.feed):
            return 0.0
        speed = np.linalg.norm(tip_velocity(self.machine, q, qd), axis=1)
        ratio = speed / self.excess.allowed(t, detour.carry, detour.period)
        left, middle, right = ratio[-TIP_SAMPLES + 2 : -2], ratio[-TIP_SAMPLES + 3 : -1], ratio[-TIP_SAMPLES + 4 :]
        # the peak between samples is that of the parabola through three of them
        bend = 2.0 * middle - left - right
        peak = (bend > 0.0) & (middle >= left) & (middle >= right)
        between = middle[peak] + (right[peak] - left[peak]) ** 2 / (8.0 * bend[peak])
        return float(max(ratio.max(), between.max(initial=0.0)))

    def passes(self, detour: Detour, joints: float | None = None) -> bool:
        """Whether the detour is within all limits; `joints` is its usage of theirs if it is known already."""
        if joints is None:
            joints = float(self.joint_usage(detour.carry, np.array([detour.rejoin]), np.array([detour.period]))[0])
        worst = joints if joints > DETOUR else max(joints, self.path_usage(detour))
        passed = worst <= DETOUR
        if not passed:
            self.note(worst, "the joints' limits" if joints > DETOUR else "feed or travel")
        return passed

    def note(self, usage: float, of: str) -> None:
        """Remember the nearest of what did not pass."""
        if usage < self.nearest:
            self.nearest, self.of = usage, of


def horizons(known: Known, time: float) -> Floats:
    """(n,) times of rejoining on the clock of the known law, after `time`; the end of the run is the last."""
    left = known.law.duration - time
    times = time + min(left, 12.0) * np.geomspace(2e-3, 1.0, HORIZONS)
    return np.unique(np.append(times[times < known.law.duration * (1.0 - 1e-9)], known.law.duration))


def gentle(known: Known, rejoin: Floats, period: Floats) -> npt.NDArray[np.bool_]:
    """(n,) whether the parameter's speed changes little enough from the rejoining backwards, or is zero there."""
    order = np.argsort(rejoin, kind="stable")
    state = np.empty((4, len(rejoin)))
    state[:, order] = known.law.at(rejoin[order])
    still = known.still(state[1])
    length = known.run.s1 - known.run.s0
    calm = np.abs(state[2]) * period <= SHARPEST * state[1]
    fine: npt.NDArray[np.bool_] = still | (calm & (state[1] * period >= LEAST_SPEED * length))
    return fine


def candidates(judge: Judge, carry: float, rejoin: Floats) -> Iterator[tuple[float, Detour, float]]:
    """Loss of time, detour, usage by the joints: all that the joints allow after a carry, least loss first."""
    start = judge.time + carry
    rejoin = rejoin[rejoin > start] if len(rejoin) > 1 else rejoin
    if len(rejoin) == 0:
        return
    at = np.concatenate([np.repeat(rejoin, len(RATIOS)), np.full(len(PERIODS), rejoin[-1])])
    way = np.maximum(np.abs(rejoin - start), 1e-6)
    period = np.concatenate([np.outer(way, RATIOS).ravel(), PERIODS])
    fine = gentle(judge.known, at, period + carry)
    at, period = at[fine], period[fine]
    if len(at) == 0:
        return
    used = judge.joint_usage(carry, at, period)
    judge.note(float(np.min(np.where(used > DETOUR, used, np.inf))), "the joints' limits")
    loss = np.maximum(carry + period - (at - judge.time), 0.0) + HASTE * (carry + period)
    good = np.flatnonzero(used <= DETOUR)
    for k in good[np.argsort(loss[good], kind="stable")][:TRIES]:
        detour = Detour(judge.known, judge.time, judge.offset, carry, float(period[k]), float(at[k]))
        yield float(loss[k]), detour, float(used[k])


def shortest_detour(judge: Judge, rejoin: float | None = None) -> Detour | None:
    """The detour of least loss that passes, to rejoin at a given time of the known law or wherever it is best.

    First with a quintic at once. Where none passes, or only one much longer than the offset itself asks for (a motion
    at its jerk limit leaves no room), also after carrying on for a while. None where nothing passes.
    """
    known, time = judge.known, judge.time
    left = known.law.duration - time
    carries = [0.0, *(min(left, 6.0) * np.geomspace(2e-3, 0.999, CARRIES))] if left > 0.0 else [0.0]
    best, least = None, np.inf
    for carry in map(float, carries):
        if HASTE * carry >= least:
            break
        times = horizons(known, time + carry) if rejoin is None else np.array([rejoin])
        for loss, detour, used in candidates(judge, carry, times):
            if loss >= least:
                break
            if judge.passes(detour, used):
                best, least = detour, loss
                break
        if best is not None and best.duration <= PATIENCE * judge.needed():
            break
    return None if best is None else sharpened(judge, best)


def sharpened(judge: Judge, detour: Detour) -> Detour:
    """The same detour in the shortest period that bisection below it finds to pass."""
    low, best = 0.8 * detour.period, detour
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + best.period)
        trial = Detour(detour.known, detour.time, detour.offset, detour.carry, middle, detour.rejoin)
        if judge.passes(trial):
            best = trial
        else:
            low = middle
    return best
