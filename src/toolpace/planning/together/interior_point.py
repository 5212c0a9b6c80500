"""The fastest change of a stretch: a primal-dual interior-point method on banded matrices.

    minimise    the time, sum of weight / sqrt(z)
    subject to  |used| <= 1 at the places of the rows,   deviations of tip and turn <= radius at those of the tube

The rows are bilinear in path and pace; each step takes them as they are linear about where it stands (the curvature
of their product is left out, that of the time and of the balls is kept), and a slack that it misses is put right by
the next one. Mehrotra's predictor and corrector. Each cell has six slots of six unknowns, so the Newton matrix has
36 diagonals.

    start     the pace taken back, so that limits are not reached; rows that are passed all the same have slack to lose
    repeat    Newton matrix from the slopes of the rows, factored; predict, centre, correct; go as far as slacks allow
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Bools, Floats
from toolpace.planning.together.stretch import GROUPS, SLOT, State, Stretch, sums_of_cells

RADIUS = 0.965
"""Share of the tolerance that the change may use where the tube is held; what lies between takes some of the rest."""
EASED = 0.12
"""Share of z that is taken away at the start."""
TAPER = 24
"""Cells in which that comes and goes at the ends."""
LEAST_SLACK = 0.05
"""Of a row at the start, whether it has it or not."""
FIRST_GAP, GAP = 0.1, 3e-3
"""Gap at the start and at the end, relative to the time."""
STEPS = 60
SHORT = 0.97
"""Share of the way to the nearest bound."""
NO_FASTER = 1.01
"""Time from which on what is found is none, in that of the motion at hand, which may pass limits a little."""
HELD = 1e-8
"""Weight of the squared coefficients, which keeps the matrix regular where nothing is near."""
WIDTH = SLOT * SLOT


@dataclass
class Side:
    """Constraints of one kind: how far each is from its bound, and its multiplier."""

    slack: Floats
    multiplier: Floats

    @property
    def gap(self) -> float:
        """Sum of their products."""
        return float((self.slack * self.multiplier).sum())

    @classmethod
    def from_room(cls, room: Floats, mu: float) -> Side:
        """With slacks of the room that there is, and products mu."""
        slack = np.maximum(room, LEAST_SLACK)
        return cls(slack, mu / slack)

    def share(self, mu: float, room: Floats, second: Floats | float) -> Floats:
        """What the multiplier becomes at products mu where the slack must meet the room."""
        return np.asarray((mu - second + self.multiplier * (self.slack - room)) / self.slack)

    def step(self, mu: float, room: Floats, moved: Floats, second: Floats | float) -> tuple[Floats, Floats]:
        """Changes of slack and multiplier where the room grows by `moved`."""
        slack = room - self.slack + moved
        return slack, (mu - second - self.slack * self.multiplier - self.multiplier * slack) / self.slack

    def advance(self, step: tuple[Floats, Floats], primal: float, dual: float) -> None:
        """Go so far."""
        self.slack = self.slack + primal * step[0]
        self.multiplier = self.multiplier + dual * step[1]

    def meet(self, room: Floats) -> None:
        """Take the room that there really is for slack, where it is not far less."""
        self.slack = np.where(room > 0.5 * self.slack, room, self.slack)


def reach(values: Floats, change: Floats) -> float:
    """How far positive values can go before one is zero, 1 at most."""
    falling = change < 0.0
    return min(1.0, float((-values[falling] / change[falling]).min())) if falling.any() else 1.0


def fastest(stretch: Stretch, x: Floats, free: Bools, share: float = 1.0) -> Floats | None:
    """Coefficients (slots, 6) of the fastest change from x on, of which only the slots marked `free` (slots,) move,
    within a `share` of the usual tube; None where the method does not get there."""
    # what is not finite ends the method, and is told by that
    with np.errstate(all="ignore"):
        work = Work(stretch, free, x, share)
        for _ in range(STEPS):
            if work.gap <= GAP * work.time:
                break
            if not work.step():
                return None
        found = work.time_now
    return work.x if found <= NO_FASTER * work.time and np.isfinite(work.x).all() else None


class Work:
    """Where the method stands."""

    def __init__(self, stretch: Stretch, free: Bools, x: Floats, share: float) -> None:
        self.stretch = stretch
        self.slots = slice(stretch.low, stretch.low + stretch.cells + SLOT - 1)
        self.fixed = np.repeat(~free[self.slots], SLOT)
        self.x = eased(x, free)
        now = stretch.at(x)
        deviation = np.sqrt(np.maximum(2.0 * now.excess(np.zeros(2)), 0.0))
        # what stays as it is may hold the path where it is
        bound = (~free[stretch.tube.first[:, None] + np.arange(SLOT)]).any(axis=1)[:, None]
        radius = share * RADIUS * stretch.tube.room
        self.radius = np.where(bound, np.maximum(radius, deviation + 1e-3), radius)
        self._look()
        rooms = self._rooms()
        self.count = sum(room.size for room in rooms)
        self.time = float(stretch.weight.sum())
        mu = FIRST_GAP * self.time / self.count
        self.sides = [Side.from_room(room, mu) for room in rooms]

    @property
    def gap(self) -> float:
        """Sum of the products of slacks and multipliers [s]."""
        return sum(side.gap for side in self.sides)

    @property
    def time_now(self) -> float:
        """That the stretch takes with the change [s]; the motion at hand takes `time`."""
        return float((self.stretch.weight / np.sqrt(self.now.z[0])).sum())

    def _look(self) -> None:
        self.now: State = self.stretch.at(self.x)
        self.used = self.stretch.used(self.now)

    def _rooms(self) -> tuple[Floats, Floats, Floats]:
        """How far rows are from both their limits, and deviations from the radius."""
        return 1.0 - self.used, 1.0 + self.used, -self.now.excess(self.radius)

    def step(self) -> bool:
        """Go one step; False where there is none."""
        from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

        self.slopes = self.stretch.slopes(self.now, self.used)
        try:
            factor = cholesky_banded(self._matrix(), lower=True, check_finite=False)
        except LinAlgError:
            return False
        rooms, gap = self._rooms(), self.gap
        mu = gap / self.count

        def toward(mu: float, second: list[Floats | float]) -> tuple[Floats, list[tuple[Floats, Floats]], float, float]:
            right = self._right(mu, rooms, second)
            right[self.fixed] = 0.0
            move = np.zeros_like(self.x)
            move[self.slots] = cho_solve_banded((factor, True), right, check_finite=False).reshape(-1, SLOT)
            changes = [
                side.step(mu, room, moved, each)
                for side, room, moved, each in zip(self.sides, rooms, self._moved(move), second)
            ]
            primal = min(reach(side.slack, change[0]) for side, change in zip(self.sides, changes))
            slower = self.stretch.at(move).z[0] - 1.0
            primal = min(primal, reach(0.5 * self.now.z[0], slower))
            return move, changes, primal, min(reach(s.multiplier, c[1]) for s, c in zip(self.sides, changes))

        _, changes, primal, dual = toward(0.0, [0.0, 0.0, 0.0])
        left = sum(
            float(((side.slack + primal * change[0]) * (side.multiplier + dual * change[1])).sum())
            for side, change in zip(self.sides, changes)
        )
        centring = max((left / gap) ** 3, 1e-3)
        second = [primal * dual * change[0] * change[1] for change in changes]
        move, changes, primal, dual = toward(centring * mu, list(second))
        self.x = self.x + SHORT * primal * move
        for side, change in zip(self.sides, changes):
            side.advance(change, SHORT * primal, SHORT * dual)
        self._look()
        for side, room in zip(self.sides, self._rooms()):
            side.meet(room)
        return True

    def _matrix(self) -> Floats:
        """(36, unknowns) the lower band of the Newton matrix; what is fixed has a unit of its own."""
        stretch, tube = self.stretch, self.stretch.tube
        above, below, ball = self.sides
        weight = above.multiplier / above.slack + below.multiplier / below.slack
        rows = self.slopes.reshape(stretch.cells, -1, WIDTH)
        blocks = np.matmul((rows * weight.reshape(stretch.cells, -1, 1)).transpose(0, 2, 1), rows)
        cells = blocks.reshape(-1, SLOT, SLOT, SLOT, SLOT)
        pace = stretch.pace[0].reshape(stretch.cells, -1, 4)
        bend = (0.75 * stretch.weight * self.now.z[0] ** -2.5).reshape(stretch.cells, -1)
        cells[:, 1:5, 5, 1:5, 5] += np.einsum("kpa,kp,kpb->kab", pace, bend, pace)
        pair = (tube.basis[:, :, None] * tube.basis[:, None, :])[:, :, :, None, None]
        for k, group in enumerate(GROUPS):
            force = self.now.force[:, group]
            moment = ball.multiplier[:, k, None, None] * tube.metric[:, group, group]
            moment += (ball.multiplier / ball.slack)[:, k, None, None] * force[:, :, None] * force[:, None, :]
            cells[:, :, group, :, group] += sums_of_cells(pair * moment[:, None, None], tube.start).transpose(
                0, 1, 3, 2, 4
            )
        return banded(blocks, HELD, self.fixed)

    def _right(self, mu: float, rooms: tuple[Floats, Floats, Floats], second: list[Floats | float]) -> Floats:
        """(unknowns,) the right side of the Newton system."""
        stretch, tube = self.stretch, self.stretch.tube
        above, below, ball = (side.share(mu, room, each) for side, room, each in zip(self.sides, rooms, second))
        local = np.einsum("nr,nrk->nk", above - below, self.slopes).reshape(-1, SLOT, SLOT)
        local[:, 1:5, 5] -= (0.5 * stretch.weight * self.now.z[0] ** -1.5)[:, None] * stretch.pace[0]
        cells = local.reshape(stretch.cells, -1, SLOT, SLOT).sum(axis=1)
        push = np.concatenate([ball[:, k, None] * self.now.force[:, group] for k, group in enumerate(GROUPS)], axis=1)
        cells[:, :, :5] += sums_of_cells(tube.basis[:, :, None] * push[:, None, :], tube.start)
        out = np.zeros((stretch.cells + SLOT - 1, SLOT))
        for k in range(SLOT):
            out[k : k + stretch.cells] -= cells[:, k]
        return out.ravel()

    def _moved(self, move: Floats) -> tuple[Floats, Floats, Floats]:
        """By how much the rooms of rows and balls grow with a move (slots, 6), to the first order."""
        stretch, tube = self.stretch, self.stretch.tube
        local = move[stretch.first[:, None] + np.arange(SLOT)].reshape(-1, WIDTH, 1)
        rows = (self.slopes @ local)[:, :, 0]
        off = np.einsum("nk,nkc->nc", tube.basis, move[tube.first[:, None] + np.arange(SLOT)][:, :, :5])
        out = np.stack([np.einsum("nc,nc->n", self.now.force[:, g], off[:, g]) for g in GROUPS], axis=1)
        return -rows, rows, -out


def eased(x: Floats, free: Bools) -> Floats:
    """Coefficients with the pace taken back where they are free, little at the ends."""
    inside = np.flatnonzero(free)
    far = np.minimum(inside - inside[0], inside[-1] - inside) / TAPER
    share = np.clip(far, 0.0, 1.0)
    out = x.copy()
    out[inside, 5] -= EASED * (1.0 + x[inside, 5]) * share**2 * (3.0 - 2.0 * share)
    return out


def banded(blocks: Floats, diagonal: float, fixed: Bools) -> Floats:
    """(36, unknowns) the lower band of the sum of the blocks (cells, 36, 36) of neighbouring cells, and a diagonal."""
    cells = len(blocks)
    band = np.zeros((WIDTH, SLOT * (cells + SLOT - 1)))
    for a in range(WIDTH):
        for b in range(a + 1):
            band[a - b, b : b + SLOT * cells : SLOT] += blocks[:, a, b]
    band[0] += diagonal
    at = np.flatnonzero(fixed)
    for k in range(WIDTH):
        band[k, at] = 0.0
        band[k, at[at >= k] - k] = 0.0
    band[0, at] = 1.0
    return band
