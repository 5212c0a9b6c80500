"""Is the lower bound ever above the best that anybody finds on the same mesh? A thousand random problems.

    python -m benchmarks.bound_checks [count] [seed]

Each problem is solved by the planner's core from three starts and by IPOPT; the bound is the planner's. Everything is
counted as the mesh problem counts time, the sum over its nodes. Writes benchmarks/results/bound-checks.md.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.jets import harmonics, path_of
from benchmarks.machine import RESULTS, written_by
from benchmarks.peers import ipopt
from benchmarks.peers.ours import mesh_problem, objective
from benchmarks.tables import Table
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.planning.bound.relaxation import lower_bound
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import Stalled, solve, start_from

STARTS = (0.4, 0.1, 0.8)
"""Shares of the guess at which the core starts; the planner's own first."""
ROUNDING = 1e-9
CONVERGED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


@dataclass(frozen=True)
class Check:
    """One problem: bound, time from each of our starts (inf where stalled), and IPOPT's (inf where it failed) [s]."""

    seed: int
    joints: int
    cells: int
    bound: float
    ours: tuple[float, ...]
    ipopt: float

    @property
    def margin(self) -> float:
        """Best time that anybody found over the bound, less one."""
        return min(*self.ours, self.ipopt) / self.bound - 1.0

    @property
    def behind(self) -> float:
        """Time of the planner's own start over IPOPT's, less one: positive where IPOPT is better."""
        return self.ours[0] / self.ipopt - 1.0


def random_problem(seed: int) -> tuple[Problem, np.ndarray, np.ndarray, int, int]:
    """A smooth random path of one to seven joints on 20 to 100 cells; jerk tight or loose, a third with feed jumps."""
    rng = np.random.default_rng([seed, 20090610])
    joints, cells, modes = int(rng.integers(1, 8)), int(rng.integers(20, 101)), int(rng.integers(1, 6))
    jets = harmonics(rng, joints, modes)
    jerk = rng.uniform(10.0, 40.0, joints) * 10.0 ** rng.uniform(-1.5, 1.0)
    limits = Limits(rng.uniform(0.5, 2.0, joints), rng.uniform(1.5, 6.0, joints), jerk)
    options = {}
    if rng.random() < 1.0 / 3.0:
        low, high = np.sort(rng.uniform(0.1, 0.9, 2))
        slow, fast = 10.0 ** rng.uniform(-2.0, 0.0, 2)
        options = {"breaks": [low, high], "speed_cap": lambda s: np.where((s >= low) & (s < high), slow, fast)}
    problem, s, z = mesh_problem(path_of(jets, **options), limits, cells)
    return problem, s, z, joints, cells


def check(seed: int) -> Check:
    """The bound and everybody's answer for one problem."""
    problem, s, z, joints, cells = random_problem(seed)
    answers: list[np.ndarray | None] = []
    for share in STARTS:
        try:
            answers.append(solve(problem, start_from(problem, s, z, share), spread=1.0))
        except Stalled:
            answers.append(None)
    times = [np.inf if c is None else objective(problem, c) for c in answers]
    best = answers[int(np.argmin(times))]
    first = answers[0] if answers[0] is not None else best
    assert first is not None, f"no start of problem {seed} came to an end"
    bound = lower_bound(problem, SplineLaw(problem.nodes, first, problem.rest)).mesh_bound
    theirs = np.inf
    for share in ipopt.STARTS:
        c, note = ipopt.minimise(problem, start_from(problem, s, z, share))
        if note in CONVERGED:
            theirs = objective(problem, c)
            break
    return Check(seed, joints, cells, float(bound), tuple(times), theirs)


def main(count: int = 1000, seed: int = 0) -> None:
    """Check, print the tables, and write them."""
    began = time.process_time()
    done = [check(k) for k in range(seed, seed + count)]
    seconds = time.process_time() - began
    margin = np.array([one.margin for one in done])
    answered = [one for one in done if np.isfinite(one.ipopt)]
    both = [one for one in answered if np.isfinite(one.ours[0])]
    behind = np.array([one.behind for one in both])
    spread = np.array([one.ours[0] / min(one.ours) - 1.0 for one in done])
    table = Table(f"{count} random problems, seeds {seed} to {seed + count - 1}", ["what", "figure"])
    table.lines = [
        ["bound above the best found", f"{(margin < -ROUNDING).sum()}"],
        ["best found / bound - 1: smallest", f"{margin.min():.2e}"],
        ["median", f"{np.median(margin):.2e}"],
        ["share up to 1e-4", f"{(margin <= 1e-4).mean():.3f}"],
        ["largest", f"{margin.max():.2e}"],
        ["planner's start stalled", f"{sum(not np.isfinite(one.ours[0]) for one in done)}"],
        ["IPOPT failed from each of three starts", f"{count - len(answered)}"],
        ["IPOPT better than the planner by more than 1e-6", f"{(behind > 1e-6).sum()} of {len(both)}"],
        ["by more than 1e-4", f"{(behind > 1e-4).sum()}"],
        ["at most by", f"{behind.max():.2e}"],
        ["planner better than IPOPT by more than 1e-6", f"{(behind < -1e-6).sum()}"],
        ["at most by", f"{-behind.min():.2e}"],
        ["another start of ours better than the planner's by more than 1e-6", f"{(spread > 1e-6).sum()}"],
        ["at most by", f"{spread.max():.2e}"],
    ]
    heads = ["seed", "joints", "cells", "bound [s]", "ours / bound - 1", "IPOPT / bound - 1", "ours / IPOPT - 1"]
    worst = Table("Where IPOPT was ahead most, and where it was behind most", heads, words=3)
    ranked = sorted(both, key=lambda one: -one.behind)
    for one in ranked[:8] + ranked[-8:]:
        worst.lines.append([
            str(one.seed), str(one.joints), str(one.cells), f"{one.bound:.6f}", f"{one.ours[0] / one.bound - 1.0:.2e}",
            f"{one.ipopt / one.bound - 1.0:.2e}", f"{one.behind:.2e}",
        ])  # fmt: skip
    for shown in (table, worst):
        shown.show()
    head = (
        "# The lower bound against everybody's best\n\n"
        f"{written_by(f'python -m benchmarks.bound_checks {count} {seed}', f'{seconds:.0f} s of CPU time')}\n\n"
        "Random smooth paths of 1 to 7 joints on 20 to 100 cells, jerk limits over two and a half orders of\n"
        "magnitude, a third with jumps of the feed. Unguarded: what is compared is the sum over the nodes of the\n"
        "same mesh problem. Ours: the planner's core from 0.4 of its guess, its own start, and from 0.1 and 0.8.\n\n"
    )
    (RESULTS / "bound-checks.md").write_text(head + table.markdown() + "\n" + worst.markdown())
    if (margin < -ROUNDING).any():
        sys.exit("the bound is above a time that was found")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
