"""A random mesh problem, its lower bound, and the best time that anybody finds for it.

Each problem is solved by the planner's core from three starts and by IPOPT; the bound is the planner's. Everything is
counted as the mesh problem counts time, the sum over its nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed import ipopt
from testbed.jets import harmonics, path_of
from testbed.mesh_problem import mesh_problem, objective
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.planning.bound.relaxation import lower_bound
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import Stalled, solve, start_from

STARTS = (0.4, 0.1, 0.8)
"""Shares of the guess at which the core starts; the planner's own first."""
ROUNDING = 1e-9


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
        if note in ipopt.ANSWERED:
            theirs = objective(problem, c)
            break
    return Check(seed, joints, cells, float(bound), tuple(times), theirs)
