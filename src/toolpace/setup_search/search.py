"""The search for a set-up by differential evolution, and the choice of diverse results.

search:
  the given clamping, and the same with the solution of the inverse kinematics left free
  directions, tools and solutions, at the place nearest to the given one           (the first DIRECTIONS of the trials)
  direction, tool and place about the best of these                                (the others)
  the best of all nearer to how the part is clamped now: what is as fast and simpler is better
  the best of diverse directions planned in full, and with them the given set-up
  a map of the time over x and y, all else as in the best

Storn and Price, Differential evolution, J. Global Optimization 11 (1997); scipy's. Other methods were tried on the same
trials: docs/notebook/clamping.md.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.cluster import Pool, open_pool
from toolpace.common.errors import ReachError, UsageError
from toolpace.common.workers import CallersProgress, Progress
from toolpace.machine.machine import Machine, check_machine
from toolpace.programs.toolpath import ToolPath, check_toolpath
from toolpace.setup_search.choices import Choices
from toolpace.setup_search.clamping import AS_GIVEN, Clamping
from toolpace.setup_search.found_set_up import FoundSetUp, PlannedSetUp, confirmed, given_as_written, map_places
from toolpace.setup_search.trial import BEYOND, FORBIDDEN, Task, Trial, as_tips_and_axes, centre_of, tried

if TYPE_CHECKING:
    from distributed import Client

DIRECTIONS = 0.6
"""Share of the trials for direction, tool and solution alone, where there is a place to be chosen too."""
POPULATIONS = (12, 8)
"""Of both stages."""
ABOUT = 0.06
"""Share of a range about the best direction within which the second stage looks."""
TURNS = ("turn", "tilt", "swing")
NEARER, AS_GOOD = (0.5, 0.0), 1e-3
"""Shares of the way from where the part is that are tried at the end; by which share longer is as fast."""
SHOWN, MOST_SHOWN = 10, 1000
"""Set-ups that are planned in full, and returned: where no number is given, and at most."""
TRIALS = 200
FEWEST = 20
"""Trials, where no number is given, and at least."""
MAPPED = 9
"""Places of the map along x, and along y."""
SEARCHED, CONFIRMED = 0.7, 0.85
"""Shares of the work, for progress."""
TURNED = math.radians(5.0)
"""From which turn on two directions differ [rad]."""
MOVED = 20e-3
"""From which distance on two places differ [m]; only where there are too few directions."""


def search_setup(
    toolpath: ToolPath,
    machine: Machine,
    choices: Choices | None = None,
    *,
    tip_tolerance: float = 10e-6,
    axis_tolerance: float = 1e-3,
    trials: int = TRIALS,
    seed: int = 0,
    shown: int = SHOWN,
    mapped: int = MAPPED,
    client: Client | str | int | None = 0,
    progress: Callable[[float], None] | None = None,
) -> FoundSetUp:
    """Where to clamp the part, and with which tool, so that a program is fastest within all travels of a machine.

    The machine has the part as it is clamped now, which is always one of the candidates: what is found is never slower.
    `choices` says what may be chosen; without it, see `Choices`. Tolerances [m], [rad] are those of the plans. `trials`
    is how many clampings are tried by a cheap plan, and `seed` chooses which; `shown` is how many are planned in
    full and returned at most, `mapped` how many places the map has along x and along y, 0 for no map. `client` does the
    trials: a Client of dask.distributed, the address of its scheduler, a number of processes here, None for one a core;
    0 is this process. `progress` is told the share done. Raises UsageError for arguments that make no sense, ReachError
    where no clamping fits, and ClusterError where the cluster is gone.
    """
    check_machine(machine, "search_setup")
    check_arguments(toolpath, trials, mapped, shown)
    choices = choices or Choices()
    refuse_two_lengths(toolpath, choices)
    began = time.perf_counter()
    free = as_tips_and_axes(toolpath)
    task = Task(
        free, machine, centre_of(free), choices.box(), tip_tolerance, axis_tolerance, choices.checked(machine).forbidden
    )
    share_done = CallersProgress(progress)
    with open_pool(client) as pool:
        search = Search(task, choices, pool, trials, share_done.part(0.0, SEARCHED))
        search.run(seed)
        present, why = as_it_is(task, toolpath)
        chosen = diverse_ones(search.best(), list(search.trials.values()), shown)
        best, faults = planned_in_full(task, pool, chosen, share_done.part(SEARCHED, CONFIRMED))
        if present is not None:
            best = [*(each for each in best if each.duration < present.duration), present]
        best = ranked(best)
        if not best:
            raise none_fits(search.trials, task, faults, why)
        places = None
        if mapped:
            places = map_places(task, choices, pool, best[0], mapped, share_done.part(CONFIRMED, 1.0))
    share_done(1.0)
    return FoundSetUp(
        toolpath, tuple(best[:shown]), present, why, places, len(search.trials), seed, time.perf_counter() - began
    )


def check_arguments(toolpath: ToolPath, trials: int, mapped: int, shown: int = SHOWN) -> None:
    """Raise UsageError for what makes no sense."""
    check_toolpath(toolpath, "search_setup")
    if len(toolpath) < 2:
        raise UsageError(f"{toolpath.source or 'tool path'}: nothing moves: fewer than two points")
    if trials < FEWEST:
        raise UsageError(f"search_setup: {trials} trials find nothing; give at least {FEWEST}")
    if not 1 <= shown <= MOST_SHOWN:
        raise UsageError(f"search_setup: {shown} set-ups to show; give 1 to {MOST_SHOWN}")
    if mapped < 0 or mapped == 1 or mapped > 100:
        raise UsageError(f"search_setup: a map of {mapped} places along x; give 2 to 100, or 0 for none")


def refuse_two_lengths(toolpath: ToolPath, choices: Choices) -> None:
    """Raise UsageError where the length of the tool is to be chosen, and the set-up sheet tells it."""
    if choices.tool_length is not None and not np.isnan(toolpath.tool_length).all():
        raise UsageError(
            "tool_length is to be chosen, and the set-up sheet gives the lengths of the program's tools; leave one of "
            "both out"
        )


class Search:
    """The trials of one search."""

    def __init__(self, task: Task, choices: Choices, pool: Pool, most: int, progress: Progress) -> None:
        self.task, self.choices, self.pool, self.most, self.progress = task, choices, pool, most, progress
        self.trials: dict[Clamping, Trial] = {}
        """By the clamping that was asked for: each is tried once."""
        self.slack = 1.0
        """Over the least cost, what counts as good as it."""

    def run(self, seed: int) -> None:
        """Make the trials of both stages."""
        direction, place = self.choices.direction, self.choices.position
        self.costs([AS_GIVEN])
        if direction:
            share = DIRECTIONS if place else 1.0
            self.evolve(direction, (0.0, 1.0), {}, int(share * self.most), POPULATIONS[0], seed)
        if place or any(not self.choices.named(name).is_listed for name in direction):
            best = self.best()
            values = self.choices.values_of(best.clamping) if best.fits else {}
            self.evolve((*direction, *place), (ABOUT, 1.0), values, self.most, POPULATIONS[1], seed + 1)
        self.simplify(self.best())

    def best(self) -> Trial:
        """The best so far; the simplest of those that are as good."""
        trials = self.trials.values()
        most = self.slack * min(trial.cost for trial in trials)
        return min((trial for trial in trials if trial.cost <= most), key=lambda trial: trial.clamping.effort)

    def simplify(self, best: Trial) -> None:
        """Try the best nearer to how the part is clamped now: the simpler of what takes as long counts as the best."""
        if not best.fits:
            return
        self.slack = 1.0 + AS_GOOD
        at_hand = {name for name in (*TURNS, "side") if 0.0 in self.choices.named(name)}
        values = self.choices.values_of(best.clamping)
        variants: list[dict[str, float]] = [{}, *({name: 0.0} for name in TURNS if name in at_hand)]
        if "side" in at_hand:
            variants += [{**variant, "side": 0.0} for variant in variants]
        simpler = [self.choices.clamping({**values, **variant}) for variant in variants]
        clampings = [
            replace(each, shift=self.nearer(each.shift, share)) for each in dict.fromkeys(simpler) for share in NEARER
        ]
        self.costs(clampings)

    def nearer(self, shift: tuple[float, float, float], share: float) -> tuple[float, float, float]:
        """A shift at a share of itself, within what is allowed [m]."""
        low, high = self.task.box[:, 0], self.task.box[:, 1]
        x, y, z = (float(each) for each in np.clip(share * np.array(shift), low, high))
        return x, y, z

    def evolve(
        self,
        names: tuple[str, ...],
        about: tuple[float, float],
        values: Mapping[str, float],
        until: int,
        population: int,
        seed: int,
    ) -> None:
        """Go on over the named choices until so many trials are made.

        Of those of direction the share `about[0]` of their range about `values` is looked at, where these are given.
        """
        from scipy.optimize import differential_evolution
        from scipy.stats import qmc

        generations = (until - len(self.trials)) // population - 1
        if generations < 0:
            return
        low, high = self.bounds(names, about, values)
        sobol = qmc.Sobol(len(names), rng=np.random.default_rng(seed))
        first = sobol.random_base2(math.ceil(math.log2(population)))[:population] * (high - low) + low
        first[0] = self.choices.shares_of(names, values or dict.fromkeys(names, 0.0))

        def costs(shares: Any, /) -> Any:
            clampings = [self.choices.clamping(self.choices.from_shares(names, column)) for column in shares.T]
            return self.costs(clampings)

        bounds: Any = list(zip(low.tolist(), high.tolist()))
        differential_evolution(
            costs, bounds, init=np.clip(first, low, high), maxiter=generations, tol=0.0, atol=0.0,
            polish=False, rng=np.random.default_rng(seed), updating="deferred", vectorized=True,
        )  # fmt: skip

    def bounds(
        self, names: tuple[str, ...], about: tuple[float, float], values: Mapping[str, float]
    ) -> tuple[Floats, Floats]:
        """(k,) lowest and highest shares that are looked at."""
        if not values:
            return np.zeros(len(names)), np.ones(len(names))
        centre = self.choices.shares_of(names, values)
        wide = np.array([
            about[1] if name in self.choices.position else 0.0 if self.choices.named(name).is_listed else about[0]
            for name in names
        ])  # fmt: skip
        low, high = np.clip(centre - wide, 0.0, 1.0), np.clip(centre + wide, 0.0, 1.0)
        return low, np.maximum(high, np.nextafter(low, 2.0))

    def costs(self, clampings: Sequence[Clamping]) -> Floats:
        """(n,) costs of clampings; each is tried once, at the same time as others."""
        new = [each for each in dict.fromkeys(clampings) if each not in self.trials]
        for outcome in self.pool.each(tried, self.task, new):
            if outcome.value is None:
                raise UsageError(f"search_setup: a trial failed: {outcome.error}")
            self.trials[outcome.item] = outcome.value
            self.progress(min(len(self.trials) / self.most, 1.0))
        return np.array([self.trials[each].cost for each in clampings])


def as_it_is(task: Task, toolpath: ToolPath) -> tuple[PlannedSetUp | None, str]:
    """The given set-up planned in full, with the program as it is written; or why it cannot be."""
    from toolpace.common.errors import ToolpaceError

    try:
        return given_as_written(task, toolpath), ""
    except ToolpaceError as error:
        return None, str(error)


def planned_in_full(
    task: Task, pool: Pool, chosen: Sequence[Trial], progress: Progress
) -> tuple[list[PlannedSetUp], list[str]]:
    """Those clampings that plans in full confirm; and what kept others from it."""
    found: list[PlannedSetUp] = []
    faults: list[str] = []
    for outcome in pool.each(confirmed, task, [trial.clamping for trial in chosen]):
        if outcome.value is not None:
            found.append(outcome.value)
        else:
            faults.append(outcome.error)
        progress((len(found) + len(faults)) / len(chosen))
    return found, faults


def ranked(found: Sequence[PlannedSetUp]) -> list[PlannedSetUp]:
    """The simplest of those that take as long as the fastest, then the others, fastest first."""
    in_order = sorted(found, key=lambda each: each.duration)
    as_fast = [each for each in in_order if each.duration <= (1.0 + AS_GOOD) * in_order[0].duration]
    first = min(as_fast, key=lambda each: each.clamping.effort, default=None)
    return [] if first is None else [first, *(each for each in in_order if each is not first)]


def none_fits(trials: Mapping[Clamping, Trial], task: Task, faults: Sequence[str], why: str) -> ReachError:
    """The error where no clamping fits: how near the nearest comes, and what is wrong with the given one."""
    nearest = min(trials.values(), key=lambda trial: trial.cost)
    short = nearest.cost / BEYOND - 1.0
    if nearest.fits:
        text = f"planned in full none of them holds: {faults[0] if faults else ''}"
    elif short <= FORBIDDEN:
        how_far = "in a forbidden zone or" if task.forbidden else f"{short * 1e3:.3g} mm"
        text = f"the nearest ({nearest.clamping.words(task.machine)}) is {how_far} beyond travel"
    else:
        text = "the rotary joints do not reach the tool axes with any of them"
    return ReachError(
        f"machine {task.machine.name}: none of {len(trials)} clampings that were tried fits; {text}; allow other "
        f"tilts, turns and places, or take another machine. As given: {why}"
    )


def diverse_ones(best: Trial, trials: Sequence[Trial], most: int) -> list[Trial]:
    """The best, and the next of trials that fit: of diverse directions or tools first, then of diverse places."""
    if not best.fits:
        return []
    ranked = sorted((trial for trial in trials if trial.fits), key=lambda trial: trial.cost)
    chosen = [best]
    for moved in (math.inf, MOVED):
        for trial in ranked:
            if len(chosen) == most:
                break
            if all(_differ(trial.clamping, other.clamping, moved) for other in chosen):
                chosen.append(trial)
    return sorted(chosen, key=lambda trial: trial.cost)


def _differ(a: Clamping, b: Clamping, moved: float) -> bool:
    if a.side != b.side or a.tool_length != b.tool_length:
        return True
    # the angle of the turn from one to the other
    cosine = 0.5 * (float(np.trace(a.rotation.T @ b.rotation)) - 1.0)
    return math.acos(min(max(cosine, -1.0), 1.0)) >= TURNED or math.dist(a.shift, b.shift) >= moved
