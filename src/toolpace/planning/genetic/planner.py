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
from toolpace.machine.limits import Limits
from toolpace.motion import closer_look
from toolpace.motion.laws import QUINTIC_STATES, QuinticLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.endstate import AT_REST, EndState, check_state
from toolpace.planning.genetic.preset_speeds import Preset, preset
from toolpace.planning.genetic.problem import Intervals, reference_points
from toolpace.planning.limit_tolerances import BRED
from toolpace.planning.options import Options, check_share, check_whole
from toolpace.planning.planned_run import PlannedRun

CHECKS = 12
ATTEMPTS = 5
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


def breeding_of(options: Genetic) -> genetic.Breeding:
    """The options as the kernels take them."""
    tournament = 2 if options.selection == "tournament" else 0
    return genetic.Breeding(
        options.population, options.generations, options.bits, float(options.crossover), float(options.mutation),
        options.elite, tournament,
    )  # fmt: skip


def interval_points(given: npt.ArrayLike) -> int | tuple[float, ...]:
    """A number of intervals, or reference points, as they are kept. Raises UsageError where they are neither."""
    try:
        points = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"genetic: intervals is {given!r}; give a number of them, or reference points") from None
    if not np.isfinite(points).all() or points.size == 0 or (points.ndim == 0 and points != np.floor(points)):
        raise UsageError(f"genetic: intervals is {given!r}; give a whole number of them, or reference points")
    return int(points) if points.ndim == 0 else tuple(points.ravel().tolist())


def shortest(parts: Intervals, given: Preset, options: Genetic, allowed: Floats, which: Ints) -> Floats:
    """The periods of the intervals `which`, as short as the genetic algorithm makes them."""
    periods = []
    for k in which:
        ends = np.array([given.speed[k], given.acceleration[k], given.speed[k + 1], given.acceleration[k + 1]])
        mean = 2.0 * parts.x[k, -1] / (ends[0] + ends[2])
        period, value, kind = genetic.shorten(
            Interval(parts.x[k], parts.share[k], parts.pace[k]), ends, breeding_of(options), given.periods[k],
            allowed[k], min(FASTEST * mean, given.periods[k]), SLOWEST * mean, options.seed + int(k),
        )  # fmt: skip
        if value > allowed[k]:
            raise InfeasibleError(
                f"genetic: no individual keeps to the limits in {parts.interval_name(int(k))}: the nearest takes"
                f" {value:.6g} of {parts.limit_name(kind)}; give a larger population, or less reserve"
            )
        periods.append(period)
    return np.array(periods)


def evolved(parts: Intervals, given: Preset, options: Genetic, allowed: Floats, sweep: int) -> Preset:
    """One sweep in which each inner point's speed and acceleration evolve with the periods on both its sides."""
    speed, acceleration, periods = given.speed.copy(), given.acceleration.copy(), given.periods.copy()
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
