"""COPP (copp-py): conic programs for velocity, acceleration and jerk, the jerk rows linearised about a profile.

`solve` is one pass about the profile of its own second-order planner; `loop` is the repetition its guide describes,
about the profile just found, until the time settles. Even mesh of n cells, as in its examples.
"""

from __future__ import annotations

import copp_py as copp
import numpy as np

from benchmarks.peers import Outcome, Stopwatch, failed, resting, usage
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun

PASSES = 12
SETTLED = 1e-5
UNLIMITED = 1e6


def solve(axis_path: AxisPath, limits: Limits, n: int, *, passes: int = 1) -> Outcome:
    """One pass, or as many as it takes for the time to settle."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    s = np.linspace(run.s0, run.s1, n + 1)
    try:
        robot = model(run, limits, s)
        first = copp.solver.topp2_ra.solve(copp.solver.topp2_ra.Problem(robot.constraints, (0, n), (0.0, 0.0)))
        robot.constraints.amax_substitute(first, 0)
    except Exception as error:  # whatever a peer raises is its result
        return failed(watch(), f"second order: {error}")
    profile, duration, note = None, np.inf, ""
    for count in range(passes):
        try:
            problem = copp.solver.topp3_socp.Problem(
                robot.constraints,
                first if profile is None else profile.a,
                num_stationary_max=1,
                b_linearization=None if profile is None else profile.b,
            )
            found = copp.solver.topp3_socp.solve(problem)
            found.force_positive_a(s)
            total, _ = copp.interpolation.s_to_t_topp3(s, found)
        except Exception as error:
            if profile is None:
                return failed(watch(), str(error))
            note = f"pass {count + 1}: {error}"
            break
        settled = abs(duration - total) < SETTLED * total
        if total < duration:
            profile, duration = found, float(total)
        if settled:
            break
    seconds = watch()
    assert profile is not None
    at_nodes, between = judge(run, limits, s, profile)
    word = " ".join(note.split())[:120] or f"{count + 1} passes"
    return Outcome(duration, seconds, at_nodes, between, not note, word, np.nan, n + 1)


def loop(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """Linearised again about its own answer until the time settles."""
    return solve(axis_path, limits, n, passes=PASSES)


def model(run: AxisRun, limits: Limits, s: np.ndarray, order: int = 3) -> copp.Robot:
    """Path derivatives and limits at the stations s (n,), up to jerk, or to acceleration with `order` 2."""
    n = len(s)
    q = [np.ascontiguousarray(value) for value in run.evaluate(s)[: order + 1]]
    robot = copp.Robot(len(limits), capacity=n)
    robot.append_s(s)
    robot.set_q(q[0], q[1], q[2], 0, dddq=q[3] if order == 3 else None)
    for kind in ("velocity", "acceleration", "jerk")[:order]:
        limit = np.minimum(getattr(limits, kind), UNLIMITED)
        getattr(robot, f"add_{kind}_limits")(limit, -limit, start_idx_s=0, length=n)
    cap = run.speed_cap(s) ** 2
    if np.isfinite(cap).any():
        robot.constraints.add_constraint_1st(np.minimum(cap, UNLIMITED)[:, None], 0)
    return robot


def judge(run: AxisRun, limits: Limits, s: np.ndarray, profile: copp.Profile3rd) -> tuple[float, float]:
    """Usage of z as it interpolates it: quadratic in a cell; s has a constant third derivative next to rest."""
    a, b = profile.a, profile.b
    at_rest = profile.num_stationary
    step = np.diff(s)

    def state(cell: np.ndarray, x: np.ndarray, at: np.ndarray) -> np.ndarray:
        d = x * step[cell]
        curve = (b[cell + 1] - b[cell]) / step[cell]
        z = np.maximum(a[cell] + d * (2.0 * b[cell] + d * curve), 1e-15)
        out = np.stack([at, np.sqrt(z), b[cell] + d * curve, curve * np.sqrt(z)])
        if at_rest[0] > 0:
            inside = cell < at_rest[0]
            k = at_rest[0]
            out[:, inside] = resting(s[0], s[k] - s[0], a[k], at[inside], forth=True)
        if at_rest[1] > 0:
            k = len(s) - 1 - at_rest[1]
            inside = cell >= k
            out[:, inside] = resting(s[-1], s[-1] - s[k], a[k], at[inside], forth=False)
        return out

    return usage(run, limits, s, state)
