"""Finer cells at acceleration switches, for infinite or very high jerk limits.

The time-optimal motion without jerk limits jumps from one acceleration to another, and starts with one. A spline takes
some cells for that, and what it loses in each is a share of their time. So it is a matter of the mesh alone:

solve
repeat while it pays:
    cut the cells in which an acceleration changes by much although jerk limits ask for less time, and the cells at rest
    solve again from there
"""

from __future__ import annotations

import contextlib

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.workers import Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.mesh.initial_guess import quickest_ramp
from toolpace.planning.mesh.nodes import DEFAULT_CELLS, STEPS_A_RAMP, UNTOLD_RAMP, cut_cells, graded
from toolpace.planning.optimal.meshed_run import MeshedRun, too_short
from toolpace.planning.optimal.solve import Stalled, start_from
from toolpace.planning.optimal.windows import solve_run

SWITCH = 0.1
"""Change of an acceleration within a cell, as a share of its limit, from which the cell is cut."""
PARTS, REST_PARTS = 4, 16
"""Into how many such a cell is cut, and how much shorter a cell at rest becomes."""
FEWER_REST_PARTS = 4
"""The same where no way was found on the finer mesh: the path itself may stand at an end of the run."""
SHORTEST = 3e-6
"""Time of a cell, as a share of the duration, below which it is not cut: the loss in all switches is a few of these."""
LONGEST = 2.0
"""Time of a cell, in even shares of the duration, above which it is cut: the guess knows of no acceleration at all."""
MOST_ROUNDS = 6
WORTH = 1e-5
"""Share of the duration that a round must win for another one."""
START_SHARE, START_SPREAD = 0.9, 0.1
"""Share of the z before at which a round starts, and its first gap relative to the duration."""
LEAST_RAMP = 1e-3
"""Time, as a share of the duration, that the finer run takes as the time in which an acceleration builds up: around
which it is mended and eased."""


def may_switch(limits: Limits, law: SplineLaw) -> bool:
    """Whether some joint's acceleration may change by all of its limit in a small part of a cell of a law's mesh."""
    return quickest_ramp(limits) < UNTOLD_RAMP * law.duration / len(law.nodes)


def sharpened(meshed: MeshedRun, law: SplineLaw, workers: Workers) -> tuple[MeshedRun, SplineLaw]:
    """The run on a mesh that tells the switches of the acceleration, and the fastest law with its limits at the nodes.

    Where no finer mesh gives a faster one, they are as they were.
    """
    rest_parts = REST_PARTS
    for _ in range(MOST_ROUNDS):
        nodes = finer_nodes(meshed, law, rest_parts)
        if len(nodes) == len(law.nodes) + sum(rest > 0.0 for rest in law.rest):
            break
        finer = on_nodes(meshed, law, nodes)
        z = law.states_at(finer.nodes)[1] ** 2
        begin = start_from(finer, finer.nodes, z, START_SHARE)
        won = -np.inf
        with contextlib.suppress(Stalled):
            found = SplineLaw(finer.nodes, solve_run(finer, begin, START_SPREAD, workers), finer.rest)
            won = 1.0 - found.duration / law.duration
        if won > 0.0:
            meshed, law = finer, found
        if -WORTH <= won < WORTH or (won < 0.0 and rest_parts == FEWER_REST_PARTS):
            break
        if won < 0.0:
            rest_parts = FEWER_REST_PARTS
    return meshed, law


def on_nodes(meshed: MeshedRun, law: SplineLaw, nodes: Floats) -> MeshedRun:
    """The same run on the nodes (n,) from s0 to s1."""
    ramp = max(min(quickest_ramp(meshed.limits), law.duration), LEAST_RAMP * law.duration)
    return MeshedRun(meshed.run, meshed.limits, nodes, meshed.ends, meshed.highest, (law.nodes, law.times), ramp)


def finer_nodes(meshed: MeshedRun, law: SplineLaw, rest_parts: int) -> Floats:
    """The nodes from s0 to s1 with those cells cut in which an acceleration switches, or which take long.

    A cell at rest becomes `rest_parts` times shorter.
    """
    cut = switching(meshed.run, meshed.limits, law) | (np.diff(law.times) > LONGEST * law.duration / DEFAULT_CELLS)
    nodes = cut_cells(law.nodes, np.where(cut & ~too_short(law.nodes), PARTS, 1))
    before, after = [], []
    least = LONGEST * SHORTEST * law.duration
    if law.rest[0] > 0.0:
        closer = [law.s0 + law.rest[0] / rest_parts] if law.times[0] > least else []
        before = [law.s0, *closer]
    if law.rest[1] > 0.0:
        closer = [law.s1 - law.rest[1] / rest_parts] if law.duration - law.times[-1] > least else []
        after = [*closer, law.s1]
    finer = np.concatenate([before, nodes, after])
    return graded(finer) if len(finer) > len(law.nodes) + sum(rest > 0.0 for rest in law.rest) else finer


def switching(run: AxisRun, limits: Limits, law: SplineLaw) -> Bools:
    """(n - 1,) cells in which the acceleration of a joint changes by much, and those beside them.

    Not those that are short enough for the joint's own jerk limit.
    """
    state = law.at(law.times)
    slope = np.abs(run.evaluate(np.clip(law.nodes, run.s0, run.s1))[1])
    slope = np.maximum(slope[1:], slope[:-1])
    with np.errstate(invalid="ignore"):
        least = np.nan_to_num(limits.acceleration / limits.jerk) / STEPS_A_RAMP
    time = np.diff(law.times)[:, None]
    changed = slope * np.abs(np.diff(state[2]))[:, None] / limits.acceleration
    marked: Bools = ((changed > SWITCH) & (time > np.maximum(least, SHORTEST * law.duration))).any(axis=1)
    beside = marked.copy()
    beside[1:] |= marked[:-1]
    beside[:-1] |= marked[1:]
    return beside
