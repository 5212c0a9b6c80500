"""Limits of one's own along a path: rows linear in z = (ds/dt)^2 and its derivatives, from those of the joints.

Whatever moves with the joints has limits of the same two forms as the joints themselves. With p(q) a quantity that
depends on their positions (the place of a carried part, the length of a cable), and primes its derivatives along the
path,

    d2p/dt2 = p'' z + p' z' / 2                          a row of acceleration
    d3p/dt3 = (p''' z + 1.5 p'' z' + p' z'' / 2) sqrt(z)    a row of jerk

so `Rows.acceleration_of` and `Rows.jerk_of` need p alone. Rows of other physics, as the torques of a chain without
gravity are, give their coefficients. What a drive has to give falls with its speed: `lines` are limits that do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import one_line
from toolpace.common.workers import Lock

ORDERS = {"acceleration": 2, "jerk": 3}
"""The kinds of rows, and how many coefficients each has: of z' and z; of z'', z' and z."""
STEP = 3e-3
"""How far the joints go for a difference of a quantity [m or rad]. What a difference leaves out grows with its fourth
power, rounding with its inverse third."""
NEWTON_STEPS = 30
"""For the speed at which a row meets a line: from far beyond it each step halves what is left at least."""


@dataclass(frozen=True, repr=False)
class Rows:
    """`count` rows of one limit along a path: |row| <= limit at any time, for each of them.

    Of acceleration: c1 z' + c0 z, with z = (ds/dt)^2. Of jerk: (c2 z'' + c1 z' + c0 z) sqrt(z). Raises UsageError for
    a limit that is no positive number, and where the function gives something else than it should. Equal are rows of
    equal figures and of the same functions.
    """

    name: str
    """Stands in what limits a motion: "slosh"."""
    unit: str
    """Of the limit: "m/s^2"."""
    limit: float
    """Largest value of each row, above and below."""
    function: Callable[[Floats], npt.ArrayLike]
    """From the joints q (4, n, joints), positions and three derivatives along the path, to the coefficients
    (n, count, 2) of z' and z, or (n, count, 3) of z'', z' and z, in that order; without the axis of a count of one too.
    It is called with any number of places, by one thread at a time."""
    kind: str = "acceleration"
    """"acceleration" or "jerk"."""
    count: int = 1
    quantity: Callable[[Floats], npt.ArrayLike] | None = None
    """What it is the acceleration or jerk of, (n, count) of positions (n, joints), where that is so: the judge
    differences it over time."""
    lines: Callable[[Floats], tuple[npt.ArrayLike, npt.ArrayLike]] | None = None
    """Limits that depend on the speed, and on which side of zero a row is. From the joints as `function` has them to
    straight lines over ds/dt, (n, count, pieces, 2) of them for values above and as many for values below zero: the
    height of each at rest, and by how much it falls for each unit of ds/dt. The least of the lines is the limit, in its
    unit. With an axis more, (n, count, pieces, choices, 2), the largest of its choices stands for each piece: so
    curves that are not concave are told. Then `limit` is the largest value that counts in a plot or a message. Rows of
    jerk have the same lines on either side."""
    pieces: int = 1
    """How many lines each row has on a side, where limits depend on the speed."""
    jumps_at_turns_of: tuple[int, ...] = ()
    """Joints where whose velocity along the path changes its sign the limits jump, as dry friction does."""
    _lock: Lock = field(default_factory=Lock, init=False, compare=False)

    def __post_init__(self) -> None:
        if self.kind not in ORDERS:
            raise UsageError(f"rows {self.name}: kind is {self.kind!r}; give 'acceleration' or 'jerk'")
        if not self.name or not self.name.isprintable():
            raise UsageError(f"rows: the name is {self.name!r}; give one that can be printed")
        number(self.limit, f"rows {self.name}: limit", least=0.0, above=True)
        if not isinstance(self.count, int) or self.count < 1:
            raise UsageError(f"rows {self.name}: count is {self.count!r}; give a whole number of rows, 1 or more")
        if not isinstance(self.pieces, int) or self.pieces < 1:
            raise UsageError(f"rows {self.name}: pieces is {self.pieces!r}; give a whole number of lines, 1 or more")

    @classmethod
    def acceleration_of(
        cls, name: str, unit: str, limit: float, quantity: Callable[[Floats], npt.ArrayLike], count: int = 1
    ) -> Rows:
        """A limit on the acceleration of a quantity: (n, count) of positions (n, joints) of the joints.

        Its derivatives are differences of it over 3e-3 m or rad of the joints: it must be smooth over that.
        """

        def coefficients(q: Floats) -> Floats:
            first, second, _ = derivatives_along(quantity, q, count, name)
            return np.stack([first / 2.0, second], axis=2)

        return cls(name, unit, limit, coefficients, "acceleration", count, quantity)

    @classmethod
    def jerk_of(
        cls, name: str, unit: str, limit: float, quantity: Callable[[Floats], npt.ArrayLike], count: int = 1
    ) -> Rows:
        """A limit on the jerk of a quantity, as `acceleration_of` has one on its acceleration."""

        def coefficients(q: Floats) -> Floats:
            first, second, third = derivatives_along(quantity, q, count, name)
            return np.stack([first / 2.0, 1.5 * second, third], axis=2)

        return cls(name, unit, limit, coefficients, "jerk", count, quantity)

    def __repr__(self) -> str:
        return one_line(self, f"{self.name} {self.limit:g} {self.unit}", f"{self.count} of {self.kind}")

    @property
    def order(self) -> int:
        """1 of acceleration, 2 of jerk: the place of its kind among speed, acceleration and jerk."""
        return ORDERS[self.kind] - 1

    @property
    def width(self) -> int:
        """How many rows a place has in an optimisation problem: one a line, above and below zero."""
        return self.count if self.lines is None else 2 * self.count * self.pieces

    def shares(self, q: Floats) -> Floats:
        """(n, count, 3) coefficients of z, z', z'' over the limit, from the joints q (4, n, joints)."""
        with self._lock:
            found = self._figures(self.function(q), "the function gives")
        width = ORDERS[self.kind]
        if found.shape == (q.shape[1], width) and self.count == 1:
            found = found[:, None]
        if found.shape != (q.shape[1], self.count, width):
            raise UsageError(
                f"rows {self.name}: the function gives shape {found.shape} for {q.shape[1]} places; it must be "
                f"({q.shape[1]}, {self.count}, {width})"
            )
        self._check_finite(found, "the function gives")
        out = np.zeros((q.shape[1], self.count, 3))
        out[:, :, :width] = found[:, :, ::-1] / self.limit
        return out

    def line_shares(self, q: Floats) -> Floats:
        """(2, n, count, pieces, choices, 2) height and fall of the lines above and below zero over the limit."""
        assert self.lines is not None
        with self._lock:
            sides = [self._figures(side, "lines with") for side in self.lines(q)]
        sides = [side[:, :, :, None] if side.ndim == 4 else side for side in sides]
        wanted = (q.shape[1], self.count, self.pieces)
        for side in sides:
            if side.ndim != 5 or side.shape[:3] != wanted or side.shape[4] != 2 or side.shape != sides[0].shape:
                n, count, pieces = wanted
                raise UsageError(
                    f"rows {self.name}: lines of shape {side.shape} for {n} places; they must be ({n}, {count}, "
                    f"{pieces}, 2), or ({n}, {count}, {pieces}, choices, 2)"
                )
            self._check_finite(side, "lines with")
            at_rest = side[:, :, :, :, 0].max(axis=3).min(axis=(1, 2))
            if not (at_rest > 0.0).all():
                at = int(at_rest.argmin())
                raise UsageError(
                    f"rows {self.name}: lines of {at_rest[at]:.6g} {self.unit} at rest with the joints at "
                    f"{np.round(q[0, at], 6).tolist()}: no motion begins there; give lines above zero at rest"
                )
        return np.stack(sides) / self.limit

    def _figures(self, found: npt.ArrayLike, what: str) -> Floats:
        """What a function of one's own gives, as numbers. Raises UsageError where it gives none."""
        try:
            array = np.asarray(found)
            if array.dtype.kind in "biuf":
                return array.astype(np.float64, copy=False)
        except ValueError:  # rows of several lengths
            pass
        raise UsageError(f"rows {self.name}: {what} {type(found).__name__} of no real numbers; give an array of them")

    def _check_finite(self, found: Floats, what: str) -> None:
        if not np.isfinite(found).all():
            raise UsageError(f"rows {self.name}: {what} {found[~np.isfinite(found)][0]}; give finite numbers")

    def limits_at(self, q: Floats, speed: Floats) -> Floats:
        """(2, n, count) the limits above and below zero at ds/dt (n,), over `limit`."""
        if self.lines is None:
            return np.ones((2, q.shape[1], self.count))
        height, fall = np.moveaxis(self.line_shares(q), 5, 0)
        least: Floats = (height - fall * speed[:, None, None, None]).max(axis=4).min(axis=3)
        return least

    def values(self, q: Floats, state: Floats) -> Floats:
        """(n, count) the rows over `limit` at the joints q (4, n, joints) and states (4, n) of s."""
        v, a, j = state[1][:, None], state[2][:, None], state[3][:, None]
        c0, c1, c2 = np.moveaxis(self.shares(q), 2, 0)
        values: Floats = c0 * v * v + 2.0 * c1 * a if self.order == 1 else c0 * v**3 + 2.0 * (c1 * v * a + c2 * j)
        return values

    def ratio(self, q: Floats, state: Floats) -> Floats:
        """(n,) largest |row| over its limit at the joints q (4, n, joints) and states (4, n) of s.

        Infinite where a limit that depends on the speed is zero or less.
        """
        largest: Floats = self.line_ratios(q, state).min(axis=2).max(axis=1)
        return largest

    def line_ratios(self, q: Floats, state: Floats) -> Floats:
        """(n, k, choices) the same over each line: of the least of the choices the largest counts. Smooth along a path,
        where the limit bends, too."""
        value = self.values(q, state)
        if self.lines is None:
            return np.abs(value)[:, :, None]
        height, fall = np.moveaxis(self.line_shares(q), 5, 0)
        above, below = height - fall * state[1][:, None, None, None]
        value = value[:, :, None, None]
        limit = np.where(value >= 0.0, above, below)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios: Floats = np.where(limit > 0.0, np.abs(value) / limit, np.where(value == 0.0, 0.0, np.inf))
        return ratios.reshape(len(value), -1, ratios.shape[3])

    def steady(self, q: Floats) -> tuple[Floats, Floats]:
        """(n,) the most z at steady speed, and (n,) the most d3s/dt3 at rest; inf where the rows hold nothing."""
        shares = self.shares(q)
        if self.lines is not None:
            third = np.full(q.shape[1], np.inf)
            if self.order == 2:
                with np.errstate(divide="ignore"):
                    at_rest = self.limits_at(q, np.zeros(q.shape[1])).min(axis=0)
                    third = (0.5 * at_rest / np.abs(shares[:, :, 2])).min(axis=1)
            return self.most_z(q, np.ones(q.shape[1]), shares[:, :, 0]), third
        c0, _, c2 = np.abs(shares).max(axis=1).T
        with np.errstate(divide="ignore"):
            return (1.0 / c0) ** (1.0 if self.order == 1 else 2.0 / 3.0), 0.5 / c2

    def most_z(self, q: Floats, speed: Floats, value: Floats) -> Floats:
        """(n,) by what z may be multiplied at most where its states all scale with it, and the rows are `value`
        (n, count) over `limit` at ds/dt = speed (n,).

        With x the root of that factor, value x^2, or x^3 of jerk, meets height - fall x.
        """
        power = self.order + 1.0
        side = np.where(value >= 0.0, 0, 1)
        lines = np.take_along_axis(self.line_shares(q), side[None, :, :, None, None, None], axis=0)[0]
        height, fall = lines[..., 0], lines[..., 1] * speed[:, None, None, None]
        size = np.abs(value)[:, :, None, None] + np.zeros_like(height)
        with np.errstate(all="ignore"):
            # where a line rises, as with friction that helps to brake, the root is further out
            x = (height / size) ** (1.0 / power) + (np.maximum(-fall, 0.0) / size) ** (1.0 / (power - 1.0))
            x = np.where(np.isfinite(x), x, height / np.where(fall > 0.0, fall, 0.0))
            for _ in range(NEWTON_STEPS):  # convex in x: from beyond the root each step stays beyond it
                step = (size * x**power + fall * x - height) / (power * size * x ** (power - 1.0) + fall)
                x = np.where(np.isfinite(step), np.maximum(x - step, 0.0), x)
        factor: Floats = x.max(axis=3).min(axis=(1, 2)) ** 2
        return factor


def derivatives_along(quantity: Callable[[Floats], npt.ArrayLike], q: Floats, count: int, name: str) -> Floats:
    """(3, n, count) first to third derivative along the path of a quantity of positions, by differences.

    Central ones of seven places on the Taylor polynomial of the joints q (4, n, joints): of sixth order, and of the
    fourth for the third derivative (Fornberg 1988).
    """
    n, factorial = q.shape[1], np.array([1.0, 2.0, 6.0])
    with np.errstate(divide="ignore"):
        reach = (STEP / 3.0 * factorial[:, None, None] / np.abs(q[1:])) ** (1.0 / np.arange(1.0, 4.0))[:, None, None]
    h = reach.min(axis=(0, 2))
    h[~np.isfinite(h)] = 1.0
    x = h * np.arange(-3.0, 4.0)[:, None]
    places = q[0] + x[:, :, None] * (q[1] + x[:, :, None] * (q[2] / 2.0 + x[:, :, None] * q[3] / 6.0))
    found = np.asarray(quantity(np.ascontiguousarray(places.reshape(7 * n, -1))), dtype=float)
    if found.shape not in ((7 * n, count), (7 * n,)) or found.size != 7 * n * count:
        raise UsageError(
            f"rows {name}: the quantity has shape {found.shape} for {7 * n} positions; it must be ({7 * n}, {count})"
        )
    f = found.reshape(7, n, count)
    (odd3, odd2, odd1), (even3, even2, even1) = f[:2:-1][:3] - f[:3], f[:2:-1][:3] + f[:3]
    h = h[:, None]
    return np.stack([
        (45.0 * odd1 - 9.0 * odd2 + odd3) / (60.0 * h),
        (270.0 * even1 - 27.0 * even2 + 2.0 * even3 - 490.0 * f[3]) / (180.0 * h**2),
        (-13.0 * odd1 + 8.0 * odd2 - odd3) / (8.0 * h**3),
    ])  # fmt: skip
