"""What a plan of a nasty path is worth: valid, refused with good reason, or wrong."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from testbed.nasty_paths import ANSWER, REFUSAL, Nasty
from toolpace.common.errors import ToolpaceError
from toolpace.machine.limits import KINDS
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planned_run import AT_REST
from toolpace.planning.planner import plan


class Verdict(NamedTuple):
    """What came of a case."""

    words: str
    """Answer, refusal, or what is wrong."""
    usage: float = 0.0
    """Largest value over limit of an answer."""
    gap: float = 0.0
    """How far it may be from the best."""


def verdict(case: Nasty) -> Verdict:
    """What a plan of the case is worth. A warning of numpy is wrong too, and so is every other exception."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            trajectory = plan(case.path, case.limits, **case.options)
        except ToolpaceError as error:
            return Verdict(refusal(case, str(error)))
        except Exception as error:
            return Verdict(f"{type(error).__name__}: {error}")
        worst = float(np.maximum(trajectory.usage().worst, usage_at(trajectory, times(case, trajectory))))
        if case.expected == REFUSAL:
            return Verdict(f"was planned, with usage {worst:.6f}; should be refused for {case.names}", worst)
        return Verdict("; ".join(faults(case, trajectory, worst)) or "answer", worst, trajectory.gap)


def refusal(case: Nasty, words: str) -> str:
    """Whether a refusal is justified, one line, and names what it must name."""
    if case.expected == ANSWER:
        return f"refused: {words}"
    if case.names not in words or "\n" in words or ";" not in words:
        return f"refused, but not for {case.names}: {words}"
    return "refusal"


def faults(case: Nasty, trajectory, worst: float) -> list[str]:
    """What is wrong with an answer."""
    found = []
    law, run = trajectory.laws[0], trajectory.axis_path.runs[0]
    if not worst <= PROMISED:
        found.append(f"usage {worst:.6f}")
    if not (np.isfinite(trajectory.duration) and trajectory.duration > 0.0):
        return [*found, f"duration {trajectory.duration}"]
    if not 0.0 <= trajectory.lower_bound <= trajectory.duration:
        found.append(f"bound {trajectory.lower_bound} above {trajectory.duration}")
    state = law.at(np.linspace(0.0, trajectory.duration, 2000))
    if not np.isfinite(state).all():
        found.append("nan")
    if position_jumps(case, trajectory):
        found.append("the position jumps")
    size = run.s1 - run.s0
    rounding = 4.0 * np.spacing(max(abs(run.s0), abs(run.s1)))
    if (np.diff(state[0]) < -rounding).any():
        found.append("s falls")
    for k, end, s in ((0, case.options.get("start", AT_REST), run.s0), (-1, case.options.get("end", AT_REST), run.s1)):
        off = abs(state[:3, k] - [s, end.speed, end.acceleration])
        if (off > [1e-9 * size + rounding, 1e-6 * state[1].max(), 1e-5 * abs(state[2]).max()]).any():
            found.append(f"state {state[:3, k]} where {(s, end.speed, end.acceleration)} is given")
    return found


def position_jumps(case: Nasty, trajectory) -> bool:
    """Whether a joint goes further between two times than its velocity limit allows."""
    t = times(case, trajectory)
    q = trajectory.at(t).q
    most = np.diff(t)[:, None] * trajectory.limits.velocity * PROMISED + 1e-8 * (np.abs(q).max(axis=0) + 1e-12)
    return bool((np.abs(np.diff(q, axis=0)) > most).any())


def usage_at(trajectory, t, kinds=KINDS) -> float:
    """Largest value over limit at times t (n,) of a path of one run: limits of joints, and the cap on ds/dt."""
    law, run, limits = trajectory.laws[0], trajectory.axis_path.runs[0], trajectory.limits
    motion, state = trajectory.at(t), law.at(t)
    values = dict(zip(KINDS, (motion.qd, motion.qdd, motion.qddd)))
    shares = [np.abs(values[kind]) / getattr(limits, kind) for kind in kinds]
    return float(np.max([share.max() for share in (*shares, state[1] / run.speed_cap(state[0]))]))


def times(case: Nasty, trajectory):
    """Many times, close together about the places where something happens."""
    law, run = trajectory.laws[0], trajectory.axis_path.runs[0]
    t = np.sort(np.random.default_rng(0).uniform(0.0, trajectory.duration, 2000))
    if case.places:
        away = np.concatenate([[0.0], *(sign * np.logspace(-15, -2, 53) for sign in (1.0, -1.0))])
        s = np.add.outer(np.array(case.places), away * (run.s1 - run.s0)).ravel()
        t = np.unique(np.concatenate([t, *times_at(law, np.unique(np.clip(s, run.s0, run.s1)))]))
    return t


def times_at(law, s):
    """Times just before and just after s (n,) is passed, by bisection."""
    low, high = np.zeros(len(s)), np.full(len(s), law.duration)
    for _ in range(60):
        middle = (low + high) / 2.0
        below = law.at(middle)[0] < s
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low, high
