"""The genetic planner: preset speeds at reference points, interval times by a genetic algorithm (Wu et al. 2009).

Source: Wu, Li, Liu, Perez, "Local minimum time trajectory planning for five-axis machining with or without
deflection", ACC 2009, section II.C and Fig. 2. What it leaves open is said at each parameter of `Genetic`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.common.workers import Progress, Workers
from toolpace.kernels.planners import genetic
from toolpace.kernels.planners.quintic_interval import Interval
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion import closer_look
from toolpace.motion.laws import QUINTIC_STATES, QuinticLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import BRED
from toolpace.planning.mesh.initial_guess import guess
from toolpace.planning.options import Options, check_share, check_whole
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun, check_state

NODES = 33
"""Least points of an interval at which the genetic algorithm looks at the limits; the result is checked at more."""
NODES_A_HINT = 8
"""Points for each stretch between two hints of the run, inside which it is smooth."""
MOST_NODES = 257
HINTS_AN_INTERVAL = 3
"""Stretches between hints that an interval spans at most, where the number of intervals is not given."""
REPAIRS = 2000
"""Most rounds that lower preset speeds: on the 27 paths of the benchmark 30 are enough, 10 on eight of them."""
RESOLUTION = 600
"""Points of the ramps from which the speeds are taken."""
CHECKS = 12
"""Most looks between the nodes, each with less allowed at them: two at most on the 27 paths of the benchmark."""
ATTEMPTS = 5
"""Most reserves that are tried: one on each of these paths."""
LOWER = 0.9
"""Share of the reserve that is left for the next attempt."""
EVOLVE_SLACK = 2e-4
"""Share of the limits that stays unused while the preset speeds evolve, seen at the nodes."""
SLOWEST = 1.6
"""Longest period that a first population holds, as a multiple of that at the mean of both preset speeds."""
FASTEST = 0.7
"""The shortest such period, as the same multiple."""


MOST, MOST_SEED = 10**6, 2**62
"""Most generations, individuals and sweeps, and the largest seed, to which the numbers of intervals are added."""
LEAST_RESERVE = 1e-6
"""Less is no motion."""


class Intervals:
    """A run cut at its reference points (n + 1,), as the kernels take it: what each limit asks for at the nodes."""

    def __init__(self, run: AxisRun, limits: Limits, points: Floats, rest: tuple[bool, bool]) -> None:
        self.run, self.limits, self.points = run, limits, points
        n, m = len(points) - 1, len(limits)
        inside = np.diff(np.searchsorted(run.hints, points)) + 1
        nodes = int(np.clip(NODES_A_HINT * inside.max(initial=1) + 1, NODES, MOST_NODES))
        tau = np.linspace(0.0, 1.0, nodes)
        place = np.broadcast_to(tau, (n, nodes)).copy()
        # from rest the way grows with the cube of time
        place[0] = tau**3 * (4.0 - 3.0 * tau) if rest[0] else tau
        place[-1] = 1.0 - (1.0 - tau) ** 3 * (1.0 + 3.0 * tau) if rest[1] else tau
        h = np.diff(points)
        self.x = place * h[:, None]
        s = points[:-1, None] + self.x
        s[:, -1] = np.nextafter(points[1:], -np.inf)
        q = run.evaluate(s.ravel())
        v, a, j = (getattr(limits, kind) for kind in KINDS)
        table = np.stack([q[1] / v, q[2] / a, q[1] / a, q[3] / j, 3.0 * q[2] / j, q[1] / j], axis=1)
        self.share = np.ascontiguousarray(table.reshape(n, nodes, 6, m))
        self.pace = 1.0 / run.speed_cap(s.ravel()).reshape(n, nodes)

    def interval_name(self, k: int) -> str:
        """Where interval k lies, for messages."""
        low, high = self.points[k], self.points[k + 1]
        block = int(self.run.block_at(np.array([low]))[0])
        where = f" (block {block})" if block else ""
        return f"interval {k + 1} of {len(self.x)}, s = {low:.6g} to {high:.6g}{where}"

    def limit_name(self, which: int) -> str:
        """What a kernel means by the number of a limit."""
        if which < 0:
            return "running backwards"
        if which == 0:
            return "the feed cap"
        kind, joint = divmod(which - 1, len(self.limits))
        return f"the {KINDS[kind]} limit of {self.limits.joints[joint]}"


@dataclass(frozen=True)
class Preset:
    """Speeds and accelerations of s at the reference points (n + 1,), and periods (n,) that keep to the limits."""

    speed: Floats
    acceleration: Floats
    periods: Floats


@dataclass(frozen=True)
class Genetic(Options):
    """The parameters that the paper does not give ("simple GA with one generation"), with what is taken here."""

    generations: int = 1
    """Times that a population is replaced by its offspring."""
    population: int = 20
    bits: int = 15
    """Binary digits of a gene, at most 15."""
    selection: str = "tournament"
    """How parents are chosen: "tournament" (of two) or "roulette" (of the ranks)."""
    crossover: float = 0.8
    """Share of the children that come from two parents, cut at one point."""
    mutation: float = 0.02
    """Chance of each bit to flip."""
    elite: int = 1
    """Best individuals that live on unchanged."""
    seed: int = 2009
    reserve: float = 0.98
    """Most usage of any limit that the preset speeds and accelerations ask for; the rest is for the periods."""
    evolve: int = 0
    """Sweeps that, after the periods, evolve the preset speeds and accelerations too; the paper has none."""
    intervals: int | tuple[float, ...] | None = None
    """Least number of intervals of each run, or the reference points between them; None: see `reference_points`."""

    def __post_init__(self) -> None:
        if self.intervals is not None and type(self.intervals) is not int:
            object.__setattr__(self, "intervals", interval_points(self.intervals))
        for name, least, most in (
            ("generations", 0, MOST), ("population", 2, MOST), ("bits", 2, 15), ("seed", -MOST_SEED, MOST_SEED),
            ("evolve", 0, MOST),
        ):  # fmt: skip
            check_whole(self.name, name, getattr(self, name), least, most)
        check_whole(self.name, "elite", self.elite, 1, self.population - 1)
        for name in ("crossover", "mutation"):
            check_share(self.name, name, getattr(self, name), 0.0, 1.0)
        check_share(self.name, "reserve", self.reserve, LEAST_RESERVE, 1.0)
        if self.selection not in ("tournament", "roulette"):
            raise UsageError(f"genetic: selection is '{self.selection}'; known are tournament, roulette")

    @property
    def name(self) -> str:
        """Its short name."""
        return "genetic"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The paper's law of one run. Raises InfeasibleError where no individual keeps to the limits."""
        law = bred_law(run, limits, self, start=start, end=end)
        return PlannedRun(law, len(law.s))


def reference_points(run: AxisRun, intervals: int | npt.ArrayLike | None) -> Floats:
    """The points between which the law is one quintic: the breaks of the run, and equal steps between them.

    `intervals`: the least number of intervals, or the points themselves; by default 31, the paper's, or as many as the
    detail of the path asks for.
    """
    if intervals is None or isinstance(intervals, int | np.integer):
        count = max(31, len(run.hints) // HINTS_AN_INTERVAL) if intervals is None else int(intervals)
        if count < 2:
            raise UsageError(f"genetic: {count} intervals; there must be at least 2")
        ends = np.concatenate([[run.s0], run.breaks, [run.s1]])
        longest = (run.s1 - run.s0) / count
        pieces = np.maximum(np.ceil(np.diff(ends) / longest - 1e-9), 1).astype(int)
        steps = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(ends, ends[1:], pieces)]
        return np.concatenate([*steps, [run.s1]])
    points = np.asarray(intervals, dtype=float)
    inner = points[(points > run.s0) & (points < run.s1)]
    points = np.union1d(np.concatenate([[run.s0], inner, [run.s1]]), run.breaks)
    if len(points) < 3:
        raise UsageError(f"genetic: no reference point inside the run from {run.s0:g} to {run.s1:g}")
    return points


def preset(parts: Intervals, start: EndState, end: EndState, reserve: float) -> Preset:
    """Speeds at the reference points: those of jerk-limited ramps, lowered until each interval has a law, then raised.

    The paper sets them "in advance" and does not say how. The accelerations follow from the speeds.
    """
    run, points = parts.run, parts.points
    rough = guess(run, parts.limits, (start.speed**2, end.speed**2), RESOLUTION)
    z = np.interp(points, rough.s, rough.z)
    speed = np.sqrt(reserve * z)
    acceleration = np.zeros(len(points))
    speed[0], acceleration[0], speed[-1], acceleration[-1] = (
        start.speed, start.acceleration, end.speed, end.acceleration
    )  # fmt: skip
    fixed = np.zeros(len(points), dtype=np.int64)
    fixed[[0, -1]] = 1
    intervals = Interval(parts.x, parts.share, parts.pace)
    periods, bad, value, which = genetic.preset(intervals, speed, acceleration, fixed, reserve, REPAIRS)
    if bad >= 0:
        raise InfeasibleError(
            f"genetic: no preset speeds for {parts.interval_name(bad)}: its best law takes {value:.4g} of"
            f" {parts.limit_name(which)}; give more intervals, or start slower"
        )
    genetic.raise_speeds(intervals, speed, acceleration, fixed, reserve, periods)
    return Preset(speed, acceleration, periods)


def breeding_of(options: Genetic) -> genetic.Breeding:
    """The options as the kernels take them."""
    tournament = 2 if options.selection == "tournament" else 0
    return genetic.Breeding(
        options.population, options.generations, options.bits, float(options.crossover), float(options.mutation),
        options.elite, tournament,
    )  # fmt: skip


def interval_points(requested: npt.ArrayLike) -> int | tuple[float, ...]:
    """A number of intervals, or reference points, as they are kept. Raises UsageError where they are neither."""
    try:
        points = np.asarray(requested, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"genetic: intervals is {requested!r}; give a number of them, or reference points") from None
    if not np.isfinite(points).all() or points.size == 0 or (points.ndim == 0 and points != np.floor(points)):
        raise UsageError(f"genetic: intervals is {requested!r}; give a whole number of them, or reference points")
    return int(points) if points.ndim == 0 else tuple(points.ravel().tolist())


def shortest(parts: Intervals, start: Preset, options: Genetic, allowed: Floats, which: Ints) -> Floats:
    """The periods of the intervals `which`, as short as the genetic algorithm makes them."""
    periods = []
    for k in which:
        ends = np.array([start.speed[k], start.acceleration[k], start.speed[k + 1], start.acceleration[k + 1]])
        mean = 2.0 * parts.x[k, -1] / (ends[0] + ends[2])
        period, value, kind = genetic.shorten(
            Interval(parts.x[k], parts.share[k], parts.pace[k]), ends, breeding_of(options), start.periods[k],
            allowed[k], min(FASTEST * mean, start.periods[k]), SLOWEST * mean, options.seed + int(k),
        )  # fmt: skip
        if value > allowed[k]:
            raise InfeasibleError(
                f"genetic: no individual keeps to the limits in {parts.interval_name(int(k))}: the nearest takes"
                f" {value:.6g} of {parts.limit_name(kind)}; give a larger population, or less reserve"
            )
        periods.append(period)
    return np.array(periods)


def evolved(parts: Intervals, start: Preset, options: Genetic, allowed: Floats, sweep: int) -> Preset:
    """One sweep in which each inner point's speed and acceleration evolve with the periods on both its sides."""
    speed, acceleration, periods = start.speed.copy(), start.acceleration.copy(), start.periods.copy()
    n = len(periods)
    shrink = 0.7**sweep
    for k in range(1, n):
        ends = np.array(
            [speed[k - 1], acceleration[k - 1], speed[k], acceleration[k], speed[k + 1], acceleration[k + 1]]
        )
        reach = np.array([0.1, 0.15, 0.3 * speed[k] / min(periods[k - 1], periods[k])]) * shrink
        pair = slice(k - 1, k + 1)
        speed[k], acceleration[k], periods[k - 1], periods[k] = genetic.reset_point(
            Interval(parts.x[pair], parts.share[pair], parts.pace[pair]), ends, breeding_of(options), periods[pair],
            allowed[pair], reach, options.seed + 1000003 * (sweep + 1) + k,
        )  # fmt: skip
    return Preset(speed, acceleration, periods)


def bred_law(
    run: AxisRun,
    limits: Limits,
    options: Genetic,
    *,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
) -> QuinticLaw:
    """The law of one run; raises InfeasibleError naming interval and limit where no individual keeps to the limits."""
    check_state(run, limits, start, run.s0)
    check_state(run, limits, end, run.s1)
    parts = Intervals(run, limits, reference_points(run, options.intervals), (start.at_rest, end.at_rest))
    reserve = options.reserve
    for attempt in range(ATTEMPTS):
        try:
            now = with_bred_periods(parts, preset(parts, start, end, reserve), options)
            break
        except InfeasibleError:
            # the limits were passed between the nodes at which the presets were set: set them lower
            if attempt == ATTEMPTS - 1:
                raise
            reserve *= LOWER
    slack = EVOLVE_SLACK
    for sweep in range(options.evolve):
        while True:
            trial = evolved(parts, now, options, np.full(len(now.periods), 1.0 - slack), sweep)
            if interval_peaks(parts, trial).max() <= BRED:
                break
            slack *= 2.0
        now = trial
    return law_of(parts, now)


def law_of(parts: Intervals, preset: Preset) -> QuinticLaw:
    """The time law of these speeds, accelerations and periods."""
    return QuinticLaw(parts.points, preset.speed, preset.acceleration, preset.periods)


def interval_peaks(parts: Intervals, preset: Preset) -> Floats:
    """(n,) largest value over limit in each interval, seen on both sides of the points and densely between."""
    law = law_of(parts, preset)
    probe = law.probe()
    all_ratios, places, between = closer_look(parts.run, parts.limits, law, probe)
    ratios = all_ratios.max(axis=1)
    # a law that turns back is no law; at the reference points themselves rest is rounding
    speed = probe.state[1].reshape(len(preset.periods), QUINTIC_STATES)
    back = (speed[:, 1:-1] <= 0.0).any(axis=1)
    ratios = np.where(np.repeat(back, QUINTIC_STATES), np.inf, ratios)
    largest: Floats = ratios.reshape(len(preset.periods), QUINTIC_STATES).max(axis=1)
    if len(places):
        inside = np.clip(np.searchsorted(parts.points, places, side="right") - 1, 0, len(largest) - 1)
        np.maximum.at(largest, inside, between.max(axis=1))
    return largest


def with_bred_periods(parts: Intervals, first: Preset, options: Genetic) -> Preset:
    """The preset with periods by the genetic algorithm, interval by interval, held within the limits between nodes."""
    n = len(first.periods)
    allowed, which, now = np.ones(n), np.arange(n), first
    for _ in range(CHECKS):
        periods = now.periods.copy()
        periods[which] = shortest(parts, first, options, allowed, which)
        now = Preset(first.speed, first.acceleration, periods)
        peak = interval_peaks(parts, now)
        which = np.flatnonzero(peak > BRED)
        if len(which) == 0:
            return now
        allowed[which] -= 1.2 * np.minimum(peak[which] - 1.0, 0.1)
    raise InfeasibleError(
        f"genetic: between its nodes {parts.interval_name(int(which[0]))} takes {peak[which[0]]:.6g} of a limit;"
        " give more intervals"
    )
