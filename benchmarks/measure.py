"""Runs every planner on every case, and keeps what came out as plain rows."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.peers import Outcome, copp, ipopt, lp, ours, ruckig, toppra
from benchmarks.tables import Row
from testbed.cases import Case
from testbed.mesh_problem import mesh_problem
from toolpace.common.errors import ToolpaceError
from toolpace.planning.optimal.planner import fastest_law

MESHES = (200, 1000, 5000)
VERY_FINE = 20_000
"""Cells on which the flank alone is planned, where COPP gives up on 5000 already."""
REPEATS = 7


@dataclass(frozen=True)
class Peer:
    """A planner, and up to which mesh it is asked: `most` for published paths, `most_random` for the others."""

    name: str
    solve: Callable[..., Outcome]
    most: int = 5000
    most_random: int = 1000


PEERS = (
    Peer("copp, one pass", copp.solve, VERY_FINE, 5000),
    Peer("copp, its loop", copp.loop, 5000, 1000),
    Peer("linear program", lp.solve, 1000, 1000),
    Peer("ruckig", ruckig.solve, 1000, 1000),
)


def measure(case: Case, n: int, quick: bool = False) -> Iterator[tuple[str, Outcome]]:
    """Name and outcome of each planner on a case over n cells; times of ours and toppra's taken in turn.

    On the finest mesh the slow ones are not asked.
    """
    path, limits = case.axis_path, case.limits
    first = ours.solve(path, limits, n), toppra.solve(path, limits, n)
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(3 if quick else REPEATS):
        seconds[0].append(ours.solve(path, limits, n, judge=False).seconds)
        seconds[1].append(toppra.solve(path, limits, n, judge=False).seconds)
    yield "toolpace", with_objective(case, n, timed(first[0], seconds[0]))
    yield "toolpace, guarded", ours.guarded(path, limits, n)
    yield "toppra", timed(first[1], seconds[1])
    if n < VERY_FINE:
        yield "IPOPT", ipopt.solve(path, limits, n)
    for peer in PEERS:
        most = peer.most if case.source != "fixed seed" else peer.most_random
        if n <= (200 if quick else most):
            yield peer.name, peer.solve(path, limits, n)


def timed(outcome: Outcome, seconds: list[float]) -> Outcome:
    """The outcome with the median of the times."""
    return Outcome(**{**vars(outcome), "seconds": statistics.median(seconds)})


def with_objective(case: Case, n: int, outcome: Outcome) -> Outcome:
    """The outcome with the time as the discretised problem sums it: what IPOPT minimises, too."""
    if not outcome.ok:
        return outcome
    try:
        law, _ = fastest_law(case.run, case.limits, cells=n, guard=False)
    except ToolpaceError:
        return outcome
    problem, _, _ = mesh_problem(case.axis_path, case.limits, n)
    last = law.nodes[-1] - law.nodes[-2]
    z = np.append(law.cells[:, 0], law.cells[-1] @ last ** np.arange(4))
    return Outcome(**{**vars(outcome), "objective": float((problem.weight / np.sqrt(z[problem.node])).sum())})


def row(case: Case, n: int, planner: str, outcome: Outcome) -> Row:
    """A line of the result file."""
    return {
        "case": case.name,
        "n": n,
        "planner": planner,
        "ok": outcome.ok,
        "duration_s": number(outcome.duration),
        "objective_s": number(outcome.objective),
        "cpu_s": number(outcome.seconds),
        "us_a_point": number(1e6 * outcome.seconds / n),
        "usage_at_nodes": number(outcome.at_nodes),
        "usage_between": number(outcome.between),
        "points": outcome.points,
        "note": outcome.note,
    }


def number(x: float) -> float | None:
    """A number that JSON knows; None for nan and infinity."""
    return float(f"{x:.10g}") if np.isfinite(x) else None
