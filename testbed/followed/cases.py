"""What is followed: motions on seven machines, and the feed that each place of them allows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

import toolpace as tp
from testbed import published
from toolpace.cli import demo_programs
from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.path import Path
from toolpace.programs.toolpath import ToolPath

RESERVES = (0.02, 0.1, 0.4)
"""Reserves that motions are planned with; a follower with another one slows the plan down, or leaves some unused."""
TIP_TOLERANCE, AXIS_TOLERANCE = 50e-6, 2e-3


@dataclass(frozen=True, eq=False)
class Case:
    """A motion planned with a reserve, on a machine."""

    name: str
    path: Path
    machine: Machine
    trajectory: Trajectory

    def feed(self, t: Floats) -> Floats:
        """(n,) feed of the program at times of the plan (n,) [m/s]; at the end of a block the higher of two."""
        starts = self.trajectory.starts
        s, allowed = self.trajectory.parameter(t), np.empty(len(t))
        for k in np.unique(which := np.clip(np.searchsorted(starts, t, side="right") - 1, 0, len(starts) - 1)):
            run, at = self.path.runs[k], which == k
            block = np.clip(np.searchsorted(run.block_start, s[at], side="right") - 1, 0, len(run.feed) - 1)
            allowed[at] = run.feed[block]
        return allowed


def arc() -> tuple[Path, Machine]:
    """The study's."""
    return Path.paper_arc(), Machine.load("paper-ab")


def impeller() -> tuple[Path, Machine]:
    """The bundled demo, with fewer blocks a blade."""
    machine = Machine.load("xyzac-trunnion")
    return fitted(tp.read_text(demo_programs.impeller_program(machine, blocks_per_blade=60), machine), machine)


def fitted(toolpath: ToolPath, machine: Machine) -> tuple[Path, Machine]:
    """The smoothest path near the program."""
    path = Path.fit(toolpath, tip_tolerance=TIP_TOLERANCE, axis_tolerance=AXIS_TOLERANCE, machine=machine)
    return path, machine


def wandering(name: str, seed: int) -> tuple[Path, Machine]:
    """A random polygon with turning axes, its corners rounded within the tolerance, its feed another in each block."""
    random, count = np.random.default_rng([seed, 13]), 25
    tip = np.cumsum(random.normal(size=(count, 3)) * [4e-3, 4e-3, 1e-3], axis=0)
    tilt, turn = 0.35 + 0.1 * random.random(count), np.cumsum(0.08 * random.normal(size=count))
    axis = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=1)
    stop = np.zeros(count, dtype=bool)
    stop[[0, -1]] = True
    toolpath = ToolPath(
        tip=tip,
        axis=axis,
        feed=random.uniform(0.01, 0.04, count),
        least_time=np.zeros(count),
        block=np.arange(1, count + 1),
        stop=stop,
        dwell=np.zeros(count),
    )
    return fitted(toolpath, Machine.load(name))


CASES: dict[str, Callable[[], tuple[Path, Machine]]] = {
    "arc on paper-ab": arc,
    "flank": published.flank,
    "fan": published.fan,
    "demo": impeller,
    "polygon on xyzbc-head": lambda: wandering("xyzbc-head", 1),
    "polygon on xyzac-head": lambda: wandering("xyzac-head", 2),
    "polygon on xyzbc-nutating": lambda: wandering("xyzbc-nutating", 3),
}


@cache
def case(name: str, reserve: float) -> Case:
    """A case by name, planned with a reserve."""
    path, machine = CASES[name]()
    return Case(name, path, machine, tp.plan(path, machine.reserved(reserve), bound=False))
