"""A trajectory from a path, limits and a planner: the entry of all planners, their interface, checks of arguments.

plan: a path, a machine, a planner
  joints along the path: the path followed by the machine, where it is one of tip and axis
  for each run from stop to stop, side by side on all cores:
      the planner makes a law of it, and a lower bound of its duration if it has one
  the trajectory: the laws one after the other with the dwells between them, the bounds summed
"""

from __future__ import annotations

import importlib
import math
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UnitWarning, UsageError, did_you_mean
from toolpace.common.workers import Progress, Workers, side_by_side
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.machine.rows import Rows
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.path import Path
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun, total_bound
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.planning.genetic import Genetic
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.second_order import SecondOrder

LOOKED_AT = 65
"""Places of a run."""


@runtime_checkable
class Planner(Protocol):
    """Makes a law of motion of each run of a path; frozen, so that what it is asked for cannot change under way.

    A law s(t) of a run must keep, at any t, for every joint i with limits v, a, j, and with the feed's cap c on ds/dt:

        |dq_i/dt| <= v_i,   |d2q_i/dt2| <= a_i,   |d3q_i/dt3| <= j_i,   ds/dt <= c(s)

    (but for a planner that says it holds fewer), and meet the two given states.
    """

    @property
    def name(self) -> str:
        """As it is asked for in short, and named in plans."""
        ...

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of one run between two states. Raises InfeasibleError where there is none."""
        ...


HOMES = {
    "optimal": ("optimal.planner", "Optimal"),
    "genetic": ("genetic", "Genetic"),
    "second-order": ("second_order", "SecondOrder"),
}
"""Short names of the planners, and the module and class of each."""
PLANNERS = tuple(HOMES)


def plan(
    path: Path | AxisPath,
    machine: Machine | Limits,
    *,
    planner: str | Optimal | Genetic | SecondOrder | Planner = "optimal",
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    rows: Sequence[Rows] = (),
    progress: Callable[[float], None] | None = None,
    **options: object,
) -> Trajectory:
    """The fastest motion along a path within the limits of a machine.

    A Path needs a Machine; an AxisPath takes a Machine or bare Limits. `planner` is an object (`Optimal`, `Genetic`,
    `SecondOrder`, or one of your own: see `Planner`), or in short the name of one, whose `options` are then given here:
    plan(path, machine, planner="optimal", mesh=1000, bound=False) is plan(path, machine, planner=Optimal(mesh=1000,
    bound=False)). `start` and `end` are the states (ds/dt, d2s/dt2) in which the first run starts and the last ends.
    `rows` are limits of one's own beside those of the joints (planner `optimal` only: see `Rows`). `progress` is called
    with the share done. Raises UsageError for arguments that make no sense, and InfeasibleError
    where no motion within the limits exists.
    """
    from toolpace.kernels.ahead_of_time import ensure_warm

    began = time.perf_counter()
    chosen = planner_of(planner, options)
    for name, state in (("start", start), ("end", end)):
        if not isinstance(state, EndState):
            raise UsageError(f"plan: {name} is {state!r}; give an EndState(speed, acceleration)")
    axis_path = joints_along(path, machine)
    limits = machine.limits if isinstance(machine, Machine) else machine
    check_count(limits, axis_path)
    if rows:
        limits = replace(limits, rows=(*limits.rows, *rows))
    if chosen.name == PLANNERS[0]:
        limits = limits.over_speed()
    if limits.rows and chosen.name in PLANNERS[1:]:
        raise UsageError(f"plan: the planner {chosen.name} holds no rows of one's own; plan with 'optimal'")
    runs, last = axis_path.runs, len(axis_path.runs) - 1
    if not runs:
        raise UsageError("plan: the path has no motion; give one with a run at least")
    check_held(limits, axis_path)
    if isinstance(machine, Machine):
        ask_about_degrees(axis_path, machine)

    ensure_warm()

    def planned(chosen: Planner, limits: Limits) -> Trajectory:
        def one(k: int, workers: Workers, part: Progress) -> PlannedRun:
            states = start if k == 0 else AT_REST, end if k == last else AT_REST
            return chosen.plan_run(runs[k], limits, *states, workers, part)

        of_runs = side_by_side(one, [run.s1 - run.s0 for run in runs], progress)
        lower_bound, open_places = total_bound(axis_path, of_runs)
        return Trajectory(
            axis_path,
            limits,
            tuple(run.law for run in of_runs),
            planner=chosen.name,
            lower_bound=lower_bound,
            open_places=open_places,
            notes=tuple(note for run in of_runs for note in run.notes),
            mesh_points=sum(run.mesh_points for run in of_runs),
            solve_seconds=time.perf_counter() - began,
            pricing=prices_of,
        )

    found = planned(chosen, limits)
    if not limits.rows or chosen.name != PLANNERS[0]:
        return found
    from toolpace.planning.continuous_torque import within_ratings
    from toolpace.planning.optimal.planner import Optimal

    if not isinstance(chosen, Optimal):
        return found
    quick = replace(chosen, bound=False)
    return within_ratings(found, lambda eased: planned(quick, eased))


def prices_of(trajectory: Trajectory) -> dict[str, float]:
    """The prices of the limits of a plan; what works them out is imported where they are asked for."""
    from toolpace.planning.prices import prices

    return prices(trajectory)


def planner_of(planner: str | Planner, options: dict[str, object], caller: str = "plan") -> Planner:
    """The planner that is meant: an object as it is, or one made of a name and its options. Raises UsageError.

    `caller` names who asks for it, for messages.
    """
    if isinstance(planner, Planner) and not isinstance(planner, type):
        if options:
            options_in_words = ", ".join(f"{name}=..." for name in options)
            raise UsageError(f"{caller}: the planner is given as an object; give its options to it: {options_in_words}")
        return planner
    if not isinstance(planner, str):
        names = ", ".join(PLANNERS)
        raise UsageError(f"{caller}: {planner!r} is no planner; give one of {names}, or an object like Optimal()")
    if planner not in HOMES:
        raise UsageError(f"{caller}: unknown planner '{planner}'; {did_you_mean(planner, PLANNERS)}")
    module, name_of_class = HOMES[planner]
    kind = getattr(importlib.import_module(f"toolpace.planning.{module}"), name_of_class)
    allowed = [field.name for field in fields(kind)]
    for name in options:
        if name not in allowed:
            raise UsageError(f"{caller}: the planner {planner} has no option '{name}'; {did_you_mean(name, allowed)}")
    made: Planner = kind(**options)
    return made


def joints_along(path: Path | AxisPath, machine: Machine | Limits) -> AxisPath:
    """The joints along a path of either kind. Raises UsageError where something else is given."""
    if not isinstance(machine, Limits):
        check_machine(machine, "plan", "a Machine, or Limits")
    if isinstance(path, AxisPath):
        return path
    if isinstance(path, ToolPath):
        raise UsageError("plan: a tool path has corners; make it smooth first: Path.fit(toolpath, machine=machine)")
    if not isinstance(path, Path):
        raise UsageError(f"plan: {type(path).__name__} in place of a path; give a Path, or an AxisPath")
    if isinstance(machine, Limits):
        raise UsageError("plan: a path of tool tip and axis needs a machine; bare limits go with an AxisPath")
    return AxisPath.follow(path, machine)


def check_count(limits: Limits, path: AxisPath) -> None:
    """Raise UsageError where there are not as many limits as joints, or where they have the names in another order."""
    count = len(path.joints)
    if len(limits) == count:
        if limits.joints != path.joints and set(limits.joints) == set(path.joints):
            raise UsageError(
                f"plan: limits are of the joints {', '.join(limits.joints)}, the path's are {', '.join(path.joints)}; "
                "give limits in the order of path.joints"
            )
        return
    cure = f"give {count} figures of each kind"
    if len(limits) == 1:
        v, a, j = (f"{getattr(limits, kind)[0]:g}" for kind in KINDS)
        cure = f"for the same of all of them give Limits({v}, {a}, {j}, path.joints)"
    raise UsageError(
        f"plan: limits for {len(limits)} joint{'' if len(limits) == 1 else 's'}, path of {count} joints; {cure}"
    )


def check_held(limits: Limits, path: AxisPath) -> None:
    """Raise UsageError where no joint moves along a run, and where nothing at all holds the motion: in no time."""
    free = np.all([np.isinf(getattr(limits, kind)) for kind in KINDS], axis=0)
    for k, run in enumerate(path.runs):
        # runs of programs move: what does not was left out by the fit
        if run.blocks and len(path.runs) > 1 and not free.any():
            continue
        joints, cap = run.with_cap(places_along(run))
        moving = joints[1:].any(axis=(0, 1))
        if not moving.any():
            raise UsageError(
                f"plan: no joint moves along run {k}, from s = {run.s0:g} to s = {run.s1:g}; leave it out, or give "
                "positions that differ: a wait is a dwell of a program"
            )
        if not (moving & ~free).any() and not np.isfinite(cap).any():
            names = ", ".join(name for name, each in zip(path.joints, free) if each)
            raise UsageError(
                f"plan: run {k} moves only joints without any limit ({names}), and no feed or speed_cap holds it: it "
                "would take no time; give these joints finite limits"
            )


def ask_about_degrees(path: AxisPath, machine: Machine) -> None:
    """Warn where rotary joints leave their travel, and would keep it if their positions were degrees."""
    if path.machine is not None:
        return
    lowest, highest = np.full(len(path.joints), np.inf), np.full(len(path.joints), -np.inf)
    for run in path.runs:
        q = run.evaluate(places_along(run))[0]
        lowest, highest = np.minimum(lowest, q.min(axis=0)), np.maximum(highest, q.max(axis=0))
    for joint in np.flatnonzero(machine.is_rotary):
        low, high = machine.travel[joint]
        outside = lowest[joint] < low or highest[joint] > high
        if outside and math.radians(lowest[joint]) >= low and math.radians(highest[joint]) <= high:
            far = max(lowest[joint], highest[joint], key=abs)
            warnings.warn(
                f"plan: joint {machine.joints[joint]} of {machine.name} goes to {far:g} rad ({math.degrees(far):.0f} "
                f"deg), beyond its travel of {math.degrees(low):g} to {math.degrees(high):g} deg; is it {far:g} deg? "
                "Then give radians: np.radians(q)",
                UnitWarning,
                stacklevel=3,
            )


def places_along(run: AxisRun) -> Floats:
    """Parameters along a run, with its breaks and hints."""
    even = np.linspace(run.s0, run.s1, LOOKED_AT)
    found: Floats = np.unique(np.concatenate([even, run.breaks, run.hints]))
    return found
