"""Small problems of the optimal planner on coarse meshes, by seed, with their solutions."""

from __future__ import annotations

from functools import cache

import numpy as np

from tests.support.random_paths import harmonics, random_limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.problem import discretise
from toolpace.planning.optimal.solve import solve, start_from
from toolpace.planning.planned_run import AT_REST, EndState


def ingredients(seed, joints=None, breaks=True):
    """A random path f, its limits and options of AxisPath, two of three without breaks."""
    rng = np.random.default_rng(seed)
    joints = joints or int(rng.integers(1, 7))
    options = {}
    if breaks and seed % 3 == 0:
        a, b = np.sort(rng.uniform(0.1, 0.9, 2))
        options = {"breaks": np.array([a, b]), "speed_cap": lambda s: np.where((s >= a) & (s < b), 0.1, 0.4)}
    f = harmonics(seed, joints, int(rng.integers(1, 6)))
    return f, random_limits(seed, joints, tight=bool(rng.integers(2))), options


def small(seed, cells=None, joints=None, breaks=True):
    """A run from rest to rest and its limits, its problem on a mesh, and the guess to start from."""
    f, limits, options = ingredients(seed, joints, breaks)
    run = AxisPath.from_callable(f, **options).runs[0]
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), cells or 12 + seed * 37 % 80)
    return run, limits, discretise(run, limits, nodes, AT_REST, AT_REST), rough


@cache
def solved(seed, cells=None, joints=None, breaks=True):
    """A small problem and its solution c."""
    _, _, problem, rough = small(seed, cells, joints, breaks)
    return problem, solve(problem, start_from(problem, rough.s, rough.z, 0.4), spread=1.0)


@cache
def moving(seed):
    """The same between states that a slowed-down motion along the whole path passes; one end may be at rest."""
    f, limits, options = ingredients(seed, breaks=False)
    run = AxisPath.from_callable(f, **options).runs[0]
    law, _ = fastest_law(run, limits, cells=80)
    rng = np.random.default_rng(seed)
    at = law.at(law.duration * np.array([rng.uniform(0.15, 0.4), rng.uniform(0.6, 0.85)]))
    slow = rng.uniform(0.5, 0.9)
    start, end = (EndState(slow * at[1, k], slow**2 * at[2, k]) for k in range(2))
    s0, s1 = at[0]
    if seed % 3 == 1:
        s0, start = run.s0, AT_REST
    if seed % 3 == 2:
        s1, end = run.s1, AT_REST
    run = AxisPath.from_callable(f, s0, s1).runs[0]
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), 40)
    problem = discretise(run, limits, nodes, start, end)
    return problem, solve(problem, start_from(problem, rough.s, rough.z, 0.4), spread=1.0)


def some_case(number):
    """Eight from rest to rest, four in motion."""
    return solved(200 + number, 20 + number) if number < 8 else moving(number)


def law_of(problem, c):
    return SplineLaw(problem.nodes, c, problem.rest)


def mesh_time(knots, c):
    return float(knots.weight @ knots.state(c)[:, 0] ** -0.5)
