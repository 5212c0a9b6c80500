"""What a plan of a nasty path is worth: valid, refused with good reason, or wrong."""

from __future__ import annotations

import warnings

import numpy as np

from nasty_paths import ANSWER, REFUSAL, Nasty
from toolpace.errors import ToolpaceError
from toolpace.plan import plan
from toolpace.plan.endstate import AT_REST

GUARANTEE = 1.0 + 1e-4


def verdict(case: Nasty) -> tuple[str, float]:
    """ "answer", "refusal", or what is wrong; and the worst usage of an answer. A warning of numpy is wrong too."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            trajectory = plan(case.path, case.limits, **case.options)
        except ToolpaceError as error:
            return refusal(case, str(error)), 0.0
        worst = max(trajectory.usage().worst, dense_usage(case, trajectory))
        if case.expected == REFUSAL:
            return f"was planned, with usage {worst:.6f}; should be refused for {case.names}", worst
        return "; ".join(faults(case, trajectory, worst)) or "answer", worst


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
    if not worst <= GUARANTEE:
        found.append(f"usage {worst:.6f}")
    if not (np.isfinite(trajectory.duration) and trajectory.duration > 0.0):
        return [*found, f"duration {trajectory.duration}"]
    if not 0.0 <= trajectory.lower_bound <= trajectory.duration:
        found.append(f"bound {trajectory.lower_bound} above {trajectory.duration}")
    state = law.at(np.linspace(0.0, trajectory.duration, 2000))
    if not np.isfinite(state).all():
        found.append("nan")
    size = run.s1 - run.s0
    rounding = 4.0 * np.spacing(max(abs(run.s0), abs(run.s1)))
    if (np.diff(state[0]) < -rounding).any():
        found.append("s falls")
    for k, end, s in ((0, case.options.get("start", AT_REST), run.s0), (-1, case.options.get("end", AT_REST), run.s1)):
        off = abs(state[:3, k] - [s, end.speed, end.acceleration])
        if (off > [1e-9 * size + rounding, 1e-6 * state[1].max(), 1e-5 * abs(state[2]).max()]).any():
            found.append(f"state {state[:3, k]} where {(s, end.speed, end.acceleration)} is given")
    return found


def dense_usage(case: Nasty, trajectory) -> float:
    """Largest value over limit at many times, and closely about the places where something happens."""
    law, run, limits = trajectory.laws[0], trajectory.axis_path.runs[0], trajectory.limits
    t = np.sort(np.random.default_rng(0).uniform(0.0, trajectory.duration, 2000))
    if case.places:
        away = np.concatenate([[0.0], *(sign * np.logspace(-15, -2, 53) for sign in (1.0, -1.0))])
        s = np.add.outer(np.array(case.places), away * (run.s1 - run.s0)).ravel()
        t = np.unique(np.concatenate([t, *times_at(law, np.unique(np.clip(s, run.s0, run.s1)))]))
    motion, state = trajectory.at(t), law.at(t)
    shares = [
        np.abs(motion.qd) / limits.velocity,
        np.abs(motion.qdd) / limits.acceleration,
        np.abs(motion.qddd) / limits.jerk,
        state[1] / run.speed_cap(state[0]),
    ]
    return float(max(share.max() for share in shares))


def times_at(law, s):
    """Times just before and just after s (n,) is passed, by bisection."""
    low, high = np.zeros(len(s)), np.full(len(s), law.duration)
    for _ in range(60):
        middle = (low + high) / 2.0
        below = law.at(middle)[0] < s
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low, high
