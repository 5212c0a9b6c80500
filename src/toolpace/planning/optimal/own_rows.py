"""Rows of one's own as those of the optimisation problem, and limits that depend on the speed made linear in z.

Of a row of acceleration, with x = sqrt(z) and W = |height| + limit:

    r . u <= height - fall x    becomes    (r . u + fall x - height + W) / W <= 1       above, and -r . u below likewise
    fall x <= fall (x0 / 2 + z / (2 x0))                                                 its tangent at the present x0

so that a row within the tangent is within the line. That rows hold on both sides is of no matter: the other side is
one that values next to the limit below zero keep. Of a row of jerk,

    r . u x <= height - fall x    becomes    r . u / height + fall / height <= 1 / x              and -r . u likewise

which is linear but for 1 / x, as all rows of jerk are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.machine.limits import Limits

LEAST_SHARE, LEAST_RISE = 1e-4, 1e-6
"""Least share of a line's height by which it has fallen, or has risen, where its tangent is laid: next to rest z may
grow by a large factor still. Below there the tangent of a line that rises lies outside by up to half of the share."""


class LineRows(NamedTuple):
    """The rows of a problem whose limits depend on the speed, k of them a point, before they are made linear."""

    column: Ints
    """(k,) their places among the rows of a point."""
    is_jerk: Bools
    """(k,)"""
    rows: Floats
    """(points, k, 3) r, over the largest limit."""
    height: Floats
    """(points, k, choices) of the lines at rest, over the largest limit."""
    fall: Floats
    """(points, k, choices) of the lines, by ds/dt."""
    ahead: Floats
    """(points,) how far beyond a point acceleration is held."""

    def at(self, which: slice | Bools) -> LineRows:
        """Those of some points."""
        rows, height, fall, ahead = (part[which] for part in self[2:])
        return self._replace(rows=rows, height=height, fall=fall, ahead=ahead)

    def times(self, by: Floats) -> LineRows:
        """With rows of acceleration and of jerk times factors (points, 2)."""
        return self._replace(rows=self.rows * by[:, self.is_jerk.astype(np.int64), None])

    def without_acceleration(self, points: Bools) -> LineRows:
        """With nothing to hold of acceleration at some points."""
        rows, fall = self.rows.copy(), self.fall.copy()
        there = np.ix_(points, ~self.is_jerk)
        rows[there], fall[there] = 0.0, 0.0
        return self._replace(rows=rows, fall=fall)

    def ahead_of(self, basis: Floats) -> Floats:
        """(points, 4) z where acceleration is held, from the basis (points, 3, 4) of the points."""
        h = self.ahead[:, None]
        ahead: Floats = basis[:, 0] + h * (basis[:, 1] + h / 2.0 * basis[:, 2])
        return ahead

    def speeds(self, basis: Floats, near: Floats) -> Floats:
        """(points, k) ds/dt where each row is held, from basis and coefficients (points, 4) of the points."""
        z = [(weights * near).sum(axis=1) for weights in (self.ahead_of(basis), basis[:, 0])]
        speeds: Floats = np.sqrt(np.maximum(np.stack(z, axis=1), 0.0))[:, self.is_jerk.astype(np.int64)]
        return speeds

    def chosen(self, x: Floats) -> tuple[Floats, Floats]:
        """(points, k) height and fall of the largest choices at ds/dt x (points, k)."""
        largest = (self.height - self.fall * x[:, :, None]).argmax(axis=2)[:, :, None]
        height, fall = (np.take_along_axis(part, largest, axis=2)[:, :, 0] for part in (self.height, self.fall))
        return height, fall

    def over_range(self, most: Floats) -> tuple[Floats, Floats]:
        """(points, k) height and fall of lines that no choice is above between rest and ds/dt of `most` (points,)."""
        if self.height.shape[2] == 1:
            return self.height[:, :, 0], self.fall[:, :, 0]
        height = self.height.max(axis=2)
        at_most = (self.height - self.fall * most[:, None, None]).max(axis=2)
        return height, (height - at_most) / most[:, None]

    def linear(self, x: Floats) -> tuple[Floats, Floats]:
        """(points, k, 3) rows and (points, k) constants, made linear at ds/dt x (points, k)."""
        height, fall = self.chosen(x)
        rows, shift, root = self.scaled(height, fall)
        share = np.where(fall > 0.0, LEAST_SHARE, LEAST_RISE)
        floor = share * np.abs(height) / np.maximum(np.abs(fall), 1e-300)
        there = np.maximum(x, np.where(self.is_jerk, 0.0, floor))
        there = np.where(root != 0.0, there, 1.0)
        slope, h = root / (2.0 * there), self.ahead[:, None]
        rows = rows + np.stack([slope, slope * h, slope * h * h / 2.0], axis=2)
        return rows, shift + root * there / 2.0

    def scaled(self, height: Floats, fall: Floats) -> tuple[Floats, Floats, Floats]:
        """Rows (points, k, 3), constants and coefficients of sqrt(z) (points, k) for lines (points, k): of
        acceleration below 1, of jerk below 1 / sqrt(z)."""
        scale = np.where(self.is_jerk, height, np.abs(height) + 1.0)
        shift = np.where(self.is_jerk, fall, scale - height) / scale
        return self.rows / scale[:, :, None], shift, np.where(self.is_jerk, 0.0, fall / scale)

    def limits(self, x: Floats) -> Floats:
        """(points, k) the limits of these rows at ds/dt x (points, k), as they count in the scaled rows: 1 where a row
        has no constant."""
        height, fall = self.chosen(x)
        limit: Floats = (height - fall * x) / np.where(self.is_jerk, height, np.abs(height) + 1.0)
        return limit

    def exceeded_by(self, basis: Floats, near: Floats) -> float:
        """By how much a row is above its limit at most, as a share of the largest limit: from basis and coefficients
        (points, 4) of the points. Where a limit rises with the speed (`fall` below zero) its tangent lies outside."""
        x = self.speeds(basis, near)
        height, fall = self.chosen(x)
        value = np.einsum("pkd,pdj,pj->pk", self.rows, basis, near) * np.where(self.is_jerk, x, 1.0)
        return float((value - height + fall * x).max(initial=0.0))


def with_own_rows(
    rows: Floats, limits: Limits, q: Floats, q_ahead: Floats, ahead: Floats
) -> tuple[Floats, LineRows | None]:
    """(n, 2 h, 3) the rows of the joints (n, 2 m, 3) with rows of one's own behind those of either kind; rows of zeros
    where there are fewer of one kind, and where limits depend on the speed: those come beside them.

    From the path (4, n, m) at the places, and `ahead` of them, where acceleration is held: z goes on by its slope.
    """
    m, half = len(limits), limits.half
    out = np.zeros((len(rows), 2 * half, 3))
    out[:, :m], out[:, half : half + m] = rows[:, :m], rows[:, m:]
    at = {1: m, 2: half + m}
    parts: list[tuple[Ints, int, Floats, Floats]] = []
    for own in limits.rows:
        there = q_ahead if own.order == 1 else q
        shares = own.shares(there)
        if own.order == 1:
            h = ahead[:, None]
            c0, c1 = shares[:, :, 0], shares[:, :, 1]
            shares = np.stack([c0, c1 + h * c0, h * (c1 + h * c0 / 2.0)], axis=2)
        columns = np.arange(at[own.order], at[own.order] + own.width)
        at[own.order] += own.width
        if own.lines is None:
            out[:, columns] = shares
        else:
            sides = own.line_shares(there)
            lines = np.concatenate(list(sides), axis=1).reshape(len(rows), own.width, *sides.shape[4:])
            signed = np.concatenate([shares, -shares], axis=1)
            parts.append((columns, own.order, np.repeat(signed, own.pieces, axis=1), lines))
    return out, line_rows(parts, ahead) if parts else None


def line_rows(parts: list[tuple[Ints, int, Floats, Floats]], ahead: Floats) -> LineRows:
    """Those of several rows of one's own: columns (k,), order, rows (n, k, 3) and lines (n, k, choices, 2) of each."""
    choices = max(lines.shape[2] for *_, lines in parts)
    # what has fewer choices repeats its first
    filled = [
        np.concatenate([lines, np.repeat(lines[:, :, :1], choices - lines.shape[2], axis=2)], axis=2)
        for *_, lines in parts
    ]
    height, fall = np.moveaxis(np.concatenate(filled, axis=1), 3, 0)
    return LineRows(
        np.concatenate([columns for columns, *_ in parts]),
        np.concatenate([np.full(len(columns), order == 2) for columns, order, *_ in parts]),
        np.concatenate([rows for _, _, rows, _ in parts], axis=1), height, fall, ahead,
    )  # fmt: skip
