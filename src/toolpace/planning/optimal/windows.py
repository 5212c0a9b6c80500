"""The solution of a long run: in one piece, in overlapping windows, or again in stretches."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.kernels.optimal import newton
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import Stalled, slower, solve, solve_whole

MEND_RAMPS = 3.0
"""How far a mended place may move its surroundings, in times in which an acceleration builds up."""
LEAST_LEFT = 0.7
"""Least share of a coefficient that mending leaves: limits move by little, and so must the motion."""
WIDER, MUCH_WIDER = 10.0, 70.0
"""How much wider a stretch is made that finds no way; and again, on a long run."""
WORTH_A_THREAD = 2_000
"""Nodes of all stretches together up to which one thread solves them: in as much time another has hardly begun."""
WINDOW = 8_000
"""Nodes that are solved in one piece, unless what joins two pieces would be wider."""
SEAM_RAMPS = 60.0
"""Half the width of the stretch over the seam between two windows."""
SEAM_LOSS = 0.1
"""Share of z by which the stretch over a seam is slowed down before it is solved: its ends are at their best."""


class Stretch(NamedTuple):
    """Nodes `low` to `high` that may move for the sake of the nodes `first` to `last` among them."""

    low: int
    high: int
    first: int
    last: int


def around(meshed: MeshedRun, first: Ints, last: Ints, ramps: float) -> list[Stretch]:
    """The stretches about the nodes from each `first` to each `last`, `ramps` ramp times wider on either side."""
    low, high = meshed.around(first, last, ramps)
    return [Stretch(*part) for part in zip(low.tolist(), high.tolist(), first.tolist(), last.tolist())]


def stretches(meshed: MeshedRun, cells: Bools, ramps: float = MEND_RAMPS) -> list[Stretch]:
    """The stretches around the marked cells, so much wider on either side as the motion takes `ramps` ramps for."""
    first = np.flatnonzero(cells)
    low, high = meshed.around(first, first + 1, ramps)
    high = np.maximum.accumulate(high)
    # those that meet are one
    begins = np.concatenate([np.ones(min(len(first), 1), dtype=np.bool_), low[1:] > high[:-1] + 1])
    begin = np.flatnonzero(begins)
    end = np.append(begin[1:], len(first))[: len(begin)] - 1
    parts = low[begin], high[end], first[begin], first[end] + 1
    return [Stretch(*part) for part in zip(*(each.tolist() for each in parts))]


def solve_run(
    meshed: MeshedRun,
    c: Floats,
    spread: float,
    workers: Workers,
    progress: Progress = UNTOLD,
    idle: float = 0.0,
) -> Floats:
    """The fastest z of a run, from the start c with a first gap of `spread`; a long run is solved window by window.

    `idle` is as `solve` has it.

    What happens at one place of a run is of no matter further away than the machine needs to stop and start again.
    So the windows are solved with their borders left as they start, slow; then a wide stretch over each border is
    solved, between nodes that are at their best already. Raises Stalled.
    """
    last = len(meshed.nodes) - 1

    count = int(np.ceil(last / WINDOW)) if meshed.is_long else 1
    while count > 1:
        border = np.linspace(0, last, count + 1).astype(np.int64)
        seams = around(meshed, border[1:-1], border[1:-1], SEAM_RAMPS)
        if all(left.high < right.low for left, right in itertools.pairwise(seams)):
            break
        count //= 2
    if count <= 1:
        return solve_whole(meshed.problem(0, last), c, spread, idle)
    windows = [Stretch(int(a), int(b), int(a), int(b)) for a, b in itertools.pairwise(border)]
    begin = c
    for parts, loss, gap, part in (
        (windows, 0.0, spread, progress.part(0.0, 0.85)), (seams, SEAM_LOSS, SEAM_LOSS, progress.part(0.85, 1.0)),
    ):  # fmt: skip
        c, stuck = mend(meshed, c, parts, loss, gap, workers, part, least=0.0)
        if stuck:
            # an end in motion may leave no way to so slow a border
            return solve_whole(meshed.problem(0, last), begin, spread)
    return c


def mend(
    meshed: MeshedRun,
    c: Floats,
    parts: list[Stretch],
    loss: float,
    spread: float,
    workers: Workers,
    progress: Progress = UNTOLD,
    least: float = LEAST_LEFT,
    give: float = 0.0,
    idle: float = 0.0,
) -> tuple[Floats, list[Stretch]]:
    """Solve again within the given stretches of nodes only, all other coefficients staying as they are.

    Each stretch starts from c, slowed down by the share `loss` in its middle, with limits that are higher by the
    share `give`. The stretches are solved on all cores; one that finds no way, or leaves less than the share
    `least` of a coefficient, is solved once more, wider, when the others are done, and on a long run a third time,
    much wider. `idle` is as `solve` has it. Returns the coefficients, and the stretches that found no way, which
    are as they were.
    """
    out = c.copy()

    def stuck_among(some: list[Stretch]) -> list[Stretch]:
        found = []
        for part in some:
            try:
                mend_one(meshed, c, out, part, loss, spread, least, give, idle, once=True)
            except Stalled:
                found.append(part)
        return found

    few = sum(part.high - part.low for part in parts) <= WORTH_A_THREAD
    shares = [parts] if few else [[part] for part in parts]
    stuck = [part for found in workers.each(stuck_among, shares, progress) for part in found]
    for wide in (WIDER * MEND_RAMPS, MUCH_WIDER * MEND_RAMPS):
        if not stuck or (wide > WIDER * MEND_RAMPS and not meshed.is_long):
            break
        first, last = np.array([(part.first, part.last) for part in stuck]).T
        still = []
        for part in around(meshed, first, last, wide):
            try:
                mend_one(meshed, out, out, part, max(loss, SEAM_LOSS), spread, least, give, 0.0, once=False)
            except Stalled:
                still.append(part)
        stuck = still
    return out, stuck


def mend_one(
    meshed: MeshedRun, c: Floats, out: Floats, part: Stretch, loss: float, spread: float, least: float, give: float,
    idle: float, once: bool,
) -> None:  # fmt: skip
    """Set the coefficients in `out` that lie inside one stretch of nodes, from those in c. Raises Stalled."""
    mine = c[part.low : part.high + 3]
    piece = meshed.problem(part.low, part.high).raised(give)
    taper = part.first - part.low, part.high - part.last
    mended = solve(piece, slower(piece, mine, loss, taper) if loss else mine, spread, once, idle)
    fallen = (least > 0.0) & (mended < least * mine)
    if not once:
        # ends so far away are met: a fall nearer to the place itself is what the limits there ask for
        fallen[taper[0] // 2 : len(fallen) - taper[1] // 2] = False
    if fallen.any():
        # the ends cannot be met within the limits: what the nodes show of it is a fall between them
        raise Stalled(float(piece.nodes[int(np.argmin(mended / mine).clip(0, len(piece.nodes) - 1))]), "some limit")
    first = 0 if piece.end[0] == newton.REST else 2
    last = len(mended) - (0 if piece.end[1] == newton.REST else 2)
    out[part.low + first : part.low + last] = mended[first:last]
