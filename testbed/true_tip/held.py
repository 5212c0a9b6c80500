"""A plan held against the truth of its program: how far the real tip is off, and how fast it goes."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

import toolpace as tp
from toolpace.programs.reading.setup_file import setup_of_text


@dataclass
class Held:
    """The worst of a plan."""

    tip: float
    """Distance of the real tip from the program, both ways, over the cuts [m]."""
    speed: float
    """Largest speed of the real tip over F."""
    column: float
    """Largest distance of the set-points' `tip` from the real tip [m]."""
    verified: bool
    said: float
    """Deviation that the verdict tells [m]."""
    duration: float


def held(case, effort="low", dt=1e-3) -> Held:
    """Read, plan and judge a case as a user would, and measure the set-points."""
    machine = tp.Machine.load(case.machine)
    setup = setup_of_text(case.sheet)
    machine = machine.mounted(**setup.part) if setup.part else machine
    toolpath = tp.read_text(case.text, machine, setup=setup, controller=case.controller, name="case" + case.suffix)
    plan = tp.plan_program(toolpath, machine, tip_tolerance=10e-6, axis_tolerance=np.radians(0.05), effort=effort)
    points = plan.trajectory.sample(dt)
    verdict = tp.verify(points, machine, toolpath, 10e-6, np.radians(0.05), sheet=case.sheet)
    chain = case.chain
    tip = speed = column = 0.0
    for cut in case.cuts:
        rows = np.flatnonzero((points.block >= cut.lines[0]) & (points.block <= cut.lines[1]))
        assert len(rows) > 3
        real = chain.forward(points.q[rows], cut.length)[0]
        way = cut.tip if cut.joints is None else between(chain, cut)
        # a corner at an end of the cut is rounded within the blocks beside it, too
        beside = np.flatnonzero((points.block >= cut.lines[0] - 2) & (points.block <= cut.lines[1] + 2))
        tip = max(tip, farthest(real, way), farthest(way, chain.forward(points.q[beside], cut.length)[0]))
        column = max(column, float(np.linalg.norm(points.tip[rows] - real, axis=1).max()))
        steps = np.linalg.norm(np.diff(real, axis=0), axis=1)[np.diff(rows) == 1] / dt
        if cut.joints is None:  # else F is the speed of the joints X, Y, Z
            speed = max(speed, float(steps.max()) / case.feed)
    return Held(tip, speed, column, verdict.ok, verdict.tip_deviation, plan.trajectory.duration)


def between(chain, cut, parts=100):
    """(k, 3) the way of the tip while joints go straight from one block to the next."""
    share = np.linspace(0.0, 1.0, parts, endpoint=False)[:, None, None]
    q = cut.joints[None, :-1] + share * np.diff(cut.joints, axis=0)[None]
    q = np.concatenate([np.swapaxes(q, 0, 1).reshape(-1, cut.joints.shape[1]), cut.joints[-1:]])
    return chain.forward(q, cut.length)[0]


@numba.njit
def farthest(points, line):
    """The largest distance of points (n, 3) from a polyline (m, 3), of each from all of it."""
    worst = 0.0
    for p in points:
        least = np.inf
        for k in range(len(line) - 1):
            square = along = 0.0
            for c in range(3):
                d = line[k + 1, c] - line[k, c]
                square += d * d
                along += (p[c] - line[k, c]) * d
            share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
            off = 0.0
            for c in range(3):
                off += (p[c] - line[k, c] - share * (line[k + 1, c] - line[k, c])) ** 2
            least = min(least, off)
        worst = max(worst, least)
    return np.sqrt(worst)
