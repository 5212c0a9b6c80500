"""A new trajectory from the instant at which the tool is found off its path."""

from __future__ import annotations

import time as clock
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.axispath.axispath import AxisPath
from toolpace.axispath.follow import FollowRun
from toolpace.axispath.run import AxisRun
from toolpace.deflect.detour import Detour, DetourRun, Known, tip_velocity
from toolpace.deflect.projection import project
from toolpace.deflect.search import Judge, shortest_detour
from toolpace.errors import InfeasibleError, ReachError, UsageError
from toolpace.laws.chain import ChainLaw, Piece
from toolpace.laws.law import TimeLaw
from toolpace.laws.quintic import QuinticLaw
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.planning.endstate import EndState
from toolpace.planning.guarantee import PROMISED
from toolpace.trajectory import Trajectory

PLANNERS = ("optimal", "genetic", "direct")


def replan(
    trajectory: Trajectory,
    time: float,
    deflection: npt.ArrayLike,
    machine: Machine | None = None,
    *,
    axis: npt.ArrayLike | None = None,
    planner: str = "optimal",
    rejoin: str | float = "fastest",
    interval: tuple[float, float] | None = None,
    **options: Any,
) -> Trajectory:
    """The motion from `time` [s] on, at which the tip is found at `deflection` (3,) [m] and the tool axis at `axis`.

    Without a machine `deflection` holds the joints (m,). The position is what was measured; velocities and
    accelerations of the joints go on as commanded, and everything from then on keeps to every limit. The tool rejoins
    the path where the whole takes least time ("fastest"), at the parameter `rejoin`, or, as in the paper, at the
    "projection" of the deflection on the path or on the `interval` (from s, to s) of it; from there it stays on it.

    `planner`: "optimal" times detour and rest of the run anew; "genetic" (the paper's) the detour and the way on to
    the next reference point, with `options` of `Genetic`; "direct" keeps to the motion from which both start. The
    feed holds for the tip on the detour; where the deflection itself has made the commanded joint velocities a faster
    tip, the excess fades. Raises InfeasibleError, with the figures, where no way back within limits and travel exists.
    """
    began = clock.perf_counter()
    if planner not in PLANNERS:
        raise UsageError(f"replan: unknown planner '{planner}'; known are {', '.join(PLANNERS)}")
    if not 0.0 <= time <= trajectory.duration:
        raise UsageError(f"replan: time {time:g} s is not within the trajectory's {trajectory.duration:.6g} s")
    if any(law.jumps.size for law in trajectory.laws):
        raise UsageError(
            f"replan: accelerations jump in a plan of planner {trajectory.planner}, so no way back from it can keep to"
            " jerk limits; plan with planner optimal"
        )
    machine = machine or trajectory.axis_path.machine
    index, local = moment(trajectory, time)
    known = Known(trajectory.axis_path.runs[index], trajectory.laws[index])
    q = known.motion(np.array([local]))[0, 0]
    offset = deflected_pose(trajectory, time, deflection, machine, axis=axis) - q
    feed = feed_at(known, machine, local)
    judge = Judge(known, trajectory.limits, machine, feed, local, offset)
    target = rejoin_time(known, trajectory.axis_path, index, deflection, rejoin, interval)
    detour = shortest_detour(judge, target)
    if detour is None and judge.relax():
        detour = shortest_detour(judge, target)
    if detour is None:
        raise InfeasibleError(
            f"deflection at {time:.6g} s: no way back to the path within limits and travel; the joints are off by"
            f" {described(trajectory, offset, machine)}, and the nearest detour takes {judge.nearest:.6g} of {judge.of}"
        )
    run = DetourRun(detour, machine, judge.excess, kinks(detour))
    runs: list[AxisRun] = [run]
    laws: list[TimeLaw] = [direct_law(run)]
    following = index + 1
    if run.ends_here and run.join <= known.run.s0:
        following = index
    elif not run.ends_here:
        rest = Piece(known.law, detour.rejoin, known.law.duration)
        laws[0] = ChainLaw([Piece(laws[0], 0.0, detour.duration), rest])
        if planner == "genetic":
            from toolpace.deflect.genetic import genetic_law

            laws[0] = genetic_law(run, trajectory.limits, laws[0], options)
        elif planner == "optimal":
            laws[0] = optimal_law(run, trajectory.limits, laws[0], options)
    runs += trajectory.axis_path.runs[following:]
    laws += trajectory.laws[following:]
    path = AxisPath(tuple(runs), trajectory.joints, machine)
    return Trajectory(path, trajectory.limits, tuple(laws), planner=planner, solve_seconds=clock.perf_counter() - began)


def moment(trajectory: Trajectory, time: float) -> tuple[int, float]:
    """Run and time on its law's clock at a time of the trajectory; in a dwell the end of the law."""
    index = int(np.clip(np.searchsorted(trajectory.starts, time, side="right") - 1, 0, len(trajectory.laws) - 1))
    return index, min(time - float(trajectory.starts[index]), trajectory.laws[index].duration)


def deflected_pose(
    trajectory: Trajectory,
    time: float,
    deflection: npt.ArrayLike,
    machine: Machine | None = None,
    *,
    axis: npt.ArrayLike | None = None,
) -> Floats:
    """(m,) joints at which the tip is at `deflection` (3,) [m] and the tool axis at `axis`, by default as commanded.

    Of both solutions the one nearest to the commanded joints is taken. Raises InfeasibleError where the pose is out
    of reach or travel.
    """
    machine = machine or trajectory.axis_path.machine
    index, local = moment(trajectory, time)
    q = Known(trajectory.axis_path.runs[index], trajectory.laws[index]).motion(np.array([local]))[0]
    point = np.asarray(deflection, dtype=float)
    size = len(trajectory.joints) if machine is None else 3
    if point.shape != (size,) or not np.isfinite(point).all():
        what = "joints" if machine is None else "coordinates of the tip in metres"
        raise UsageError(f"deflection: {deflection!r}; give {size} finite {what}")
    if machine is None:
        return point
    rotary = q[:, machine.rotary]
    if axis is not None:
        direction = np.asarray(axis, dtype=float)
        length = float(np.linalg.norm(direction)) if direction.shape == (3,) else 0.0
        if not (np.isfinite(length) and length > 0.0):
            raise UsageError(f"deflection: tool axis {axis}; give three numbers, not all zero")
        jets = np.zeros((4, 1, 3))
        jets[0, 0] = direction / length
        rotary = machine.rotary_jets(jets, rotary)[0]
        if not np.isfinite(rotary).all():
            raise InfeasibleError(
                f"deflection at {time:.6g} s: no rotary angles of {machine.name} give the tool axis"
                f" ({', '.join(f'{x:.6g}' for x in jets[0, 0])})"
            )
    try:
        pose = machine.joints_at(point[None, :], rotary)
        machine.check_travel(pose, trajectory.axis_path.runs[index].block_at(np.zeros(1)))
    except ReachError as error:
        raise InfeasibleError(f"deflection at {time:.6g} s: the pose cannot be commanded: {error}") from None
    out: Floats = pose[0]
    return out


def feed_at(known: Known, machine: Machine | None, local: float) -> float:
    """The feed [m/s] that holds for the tip at a time of the known law; inf where there is none."""
    if machine is None:
        return np.inf
    s = known.law.at(np.array([local]))[0]
    cap = float(known.run.speed_cap(s)[0])
    jets = known.run.evaluate(s)
    return cap * float(np.linalg.norm(tip_velocity(machine, jets[0], jets[1]))) if np.isfinite(cap) else np.inf


def rejoin_time(
    known: Known,
    axis_path: AxisPath,
    index: int,
    deflection: npt.ArrayLike,
    rejoin: str | float,
    interval: tuple[float, float] | None,
) -> float | None:
    """When the known law passes the wanted point of rejoining; None where it is free."""
    if rejoin == "fastest":
        return None
    if isinstance(rejoin, str):
        if rejoin != "projection":
            raise UsageError(f"replan: rejoin at '{rejoin}'; give 'fastest', 'projection' or a parameter")
        run = known.run
        if not isinstance(run, FollowRun):
            raise UsageError("replan: a projection needs a path of tip and axis; give the parameter to rejoin at")
        s = project(Path((run.run,)), deflection, interval=interval).s
    else:
        s = float(rejoin)
        if not known.run.s0 <= s <= known.run.s1:
            raise UsageError(f"replan: rejoin at s = {s:g}; the run goes from {known.run.s0:g} to {known.run.s1:g}")
    return passing_time(known.law, s)


def passing_time(law: TimeLaw, s: float) -> float:
    """When a law passes s, by bisection; its ends where s is at or beyond them."""
    low, high = 0.0, law.duration
    if s <= law.s0:
        return low
    if s >= law.s1:
        return high
    for _ in range(80):
        middle = 0.5 * (low + high)
        if law.at(np.array([middle]))[0, 0] < s:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def kinks(detour: Detour) -> Floats:
    """(k,) times since the deflection at which the jerk of the carry may jump."""
    if detour.carry == 0.0:
        return np.empty(0)
    law, run = detour.known.law, detour.known.run
    own = np.asarray(getattr(law, "times", np.empty(0))) if isinstance(law, QuinticLaw | ChainLaw) else np.empty(0)
    ends = law.at(np.array([detour.time, detour.time + detour.carry]))[0]
    passed = run.breaks[(run.breaks > ends[0]) & (run.breaks < ends[1])]
    times = np.concatenate([own, [passing_time(law, float(s)) for s in passed]]) - detour.time
    return np.unique(times[(times > 0.0) & (times < detour.carry)])


def direct_law(run: DetourRun) -> QuinticLaw:
    """The law under which the detour runs as made; a quintic of time, since the parameter is a cubic."""
    marks = np.unique(np.concatenate([[0.0], run.kinks, [run.detour.duration]]))
    p, v, a, _ = run.parameter(marks)
    p[-1] = run.join
    return QuinticLaw(p, v, a, np.diff(marks))


def optimal_law(run: DetourRun, limits: Limits, direct: TimeLaw, options: dict[str, Any]) -> TimeLaw:
    """The fastest law of detour and rest, or the direct one where that is as fast."""
    from toolpace.planning.optimal.planner import fastest_law

    _, v, a, _ = run.parameter(np.zeros(1))[:, 0]
    try:
        law, _ = fastest_law(run, limits, start=EndState(float(v), float(a)), **options)
    except InfeasibleError:
        return direct
    begin = law.at(np.zeros(1))[:3, 0]
    meets = np.allclose(begin[1:], [v, a], rtol=1e-9, atol=1e-9 * (float(v) + abs(float(a))))
    if not meets or law.duration >= direct.duration:
        return direct
    alone = AxisPath((run,), limits.joints, run.machine)
    return law if Trajectory(alone, limits, (law,)).usage().worst <= PROMISED else direct


def described(trajectory: Trajectory, offset: Floats, machine: Machine | None) -> str:
    """Offsets of the joints, for messages."""
    if machine is None:
        return ", ".join(f"{joint} {value:.4g}" for joint, value in zip(trajectory.joints, offset))
    return ", ".join(
        f"{joint} {np.degrees(value):.4g} deg" if rotary else f"{joint} {1e3 * value:.4g} mm"
        for joint, value, rotary in zip(trajectory.joints, offset, machine.is_rotary)
    )
