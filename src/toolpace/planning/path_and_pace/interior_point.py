"""The fastest local change of a segment's path and speed: a banded primal-dual interior-point method.

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

from toolpace.common.arrays import Bools, Floats
from toolpace.kernels import path_and_pace as kernel
from toolpace.planning.path_and_pace.segment import GROUPS, SLOT, State, Stretch

RADIUS = 0.965
"""Share of the tolerance that the change may use where the tube is held; what lies between takes some of the rest."""
EASED = 0.06
"""Share of z that is taken away at the start."""
TAPER = 24
"""Cells in which that comes and goes at the ends."""
LEAST_SLACK = 0.05
"""Of a row at the start, whether it has it or not."""
FIRST_GAP = 1.0
"""Gap at the start, relative to the time."""
AT_ENDS = 1e-3
"""Room that rows and balls have at least in cells of which a slot stays as it is."""
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
    most = -float((change / values).min())
    return min(1.0, 1.0 / most) if most > 0.0 else 1.0


def fastest(stretch: Stretch, x: Floats, free: Bools, share: float = 1.0) -> Floats | None:
    """Coefficients (slots, 6) of the fastest change of a stretch from x on, of which only the slots marked `free`
    (slots,) move, within a `share` of the usual tube; None where the method does not get there."""
    # what is not finite ends the method, and is told by that
    with np.errstate(all="ignore"):
        work = Work(stretch, free, x, share)
        for _ in range(stretch.care.steps):
            if work.gap <= stretch.care.gap * work.time:
                break
            if not work.step():
                return None
        found = work.time_now
    return work.x if found <= NO_FASTER * work.time and np.isfinite(work.x).all() else None


class Work:
    """Where the method stands."""

    def __init__(self, stretch: Stretch, free: Bools, x: Floats, share: float) -> None:
        self.stretch = stretch
        fixed = np.repeat(~free[:, None], SLOT, axis=1)
        fixed[:, GROUPS[1]] |= stretch.still
        self.fixed = fixed.ravel()
        self.x = eased(x, free)
        now = stretch.at(x)
        deviation = np.sqrt(np.maximum(2.0 * now.excess(np.zeros(2)), 0.0))
        # what stays as it is may hold path and motion where they are
        held = np.asarray(~np.lib.stride_tricks.sliding_window_view(free, SLOT).all(axis=1))[:, None]
        radius = share * RADIUS * stretch.tube.room
        self.radius = np.where(held[stretch.tube.balls.first], np.maximum(radius, deviation + AT_ENDS), radius)
        self.limit = np.where(held[stretch.places.first], np.maximum(1.0, np.abs(now.used) + AT_ENDS), 1.0)
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
        return float((self.stretch.weight / np.sqrt(self.now.z)).sum())

    def _look(self) -> None:
        self.now: State = self.stretch.at(self.x)

    def _rooms(self) -> tuple[Floats, Floats, Floats]:
        """How far rows are from both their limits, and deviations from the radius."""
        return self.limit - self.now.used, self.limit + self.now.used, -self.now.excess(self.radius)

    def step(self) -> bool:
        """Go one step; False where there is none."""
        from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

        try:
            factor = cholesky_banded(self._matrix().T, overwrite_ab=True, lower=True, check_finite=False)
        except LinAlgError:
            return False
        rooms, gap = self._rooms(), self.gap
        mu = gap / self.count

        def toward(mu: float, second: list[Floats | float]) -> tuple[Floats, list[tuple[Floats, Floats]], float, float]:
            right = self._right(mu, rooms, second)
            right[self.fixed] = 0.0
            move = cho_solve_banded((factor, True), right, check_finite=False).reshape(-1, SLOT)
            changes = [
                side.step(mu, room, moved, each)
                for side, room, moved, each in zip(self.sides, rooms, self._moved(move), second)
            ]
            primal = min(reach(side.slack, change[0]) for side, change in zip(self.sides, changes))
            primal = min(primal, reach(0.5 * self.now.z, self.stretch.pace_moved(move)))
            return move, changes, primal, min(reach(s.multiplier, c[1]) for s, c in zip(self.sides, changes))

        _, changes, primal, dual = toward(0.0, [0.0, 0.0, 0.0])
        left = sum(
            float(((side.slack + primal * change[0]) * (side.multiplier + dual * change[1])).sum())
            for side, change in zip(self.sides, changes)
        )
        centring = max((left / gap) ** 2, 1e-3)
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
        """(unknowns, 36) the band of the Newton matrix, from the diagonal on; what is fixed has a unit of its own."""
        stretch, balls = self.stretch, self.stretch.tube.balls
        above, below, ball = self.sides
        weight = above.multiplier / above.slack + below.multiplier / below.slack
        moment = np.zeros_like(balls.metric)
        for k, g in enumerate(GROUPS):
            force = self.now.force[:, g]
            moment[:, g, g] = ball.multiplier[:, k, None, None] * balls.metric[:, g, g]
            moment[:, g, g] += (ball.multiplier / ball.slack)[:, k, None, None] * force[:, :, None] * force[:, None, :]
        band = np.zeros((len(self.fixed), WIDTH))
        band[:, 0] = HELD
        bend = 0.75 * stretch.weight * self.now.z**-2.5
        kernel.matrix(stretch.places, self.now.felt, weight, bend, balls, moment, band)
        fix(band, self.fixed)
        return band

    def _right(self, mu: float, rooms: tuple[Floats, Floats, Floats], second: list[Floats | float]) -> Floats:
        """(unknowns,) the right side of the Newton system."""
        stretch = self.stretch
        above, below, ball = (side.share(mu, room, each) for side, room, each in zip(self.sides, rooms, second))
        push = np.concatenate([ball[:, k, None] * self.now.force[:, g] for k, g in enumerate(GROUPS)], axis=1)
        pull = -0.5 * stretch.weight * self.now.z**-1.5
        out = np.zeros_like(self.x)
        kernel.gradient(stretch.places, self.now.felt, above - below, pull, stretch.tube.balls, push, out)
        return -out.ravel()

    def _moved(self, move: Floats) -> tuple[Floats, Floats, Floats]:
        """By how much the rooms of rows and balls grow with a move (slots, 6), to the first order."""
        rows, off = self.stretch.rows_moved(self.now, move), self.stretch.tube.moved(move)
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


def fix(band: Floats, fixed: Bools) -> None:
    """Take the unknowns that are fixed out of a band (unknowns, 36): a unit is left of each."""
    at = np.flatnonzero(fixed)
    for k in range(WIDTH):
        band[at, k] = 0.0
        band[at[at >= k] - k, k] = 0.0
    band[at, 0] = 1.0
