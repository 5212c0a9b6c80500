"""A path at the nodes and probes of mesh cells, from the fewest evaluations that determine it."""

from __future__ import annotations

import threading

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.kernels.motion import between_nodes
from toolpace.kernels.optimal import first_guess
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun

UNLIKE = 1e-6
"""Share of a limit up to which the path may differ from what its derivatives at the nodes tell of it."""
BENT = 1e-4
"""How far a smooth cap on ds/dt may be from a polynomial of the third degree in a cell, relative to itself; one of the
fourth is taken, and beyond this it is asked at each probe."""
QUARTERS = np.array([0.25, 0.75])
OFF = 1e-6
"""How far any other cap, which is asked at each probe, may be from that polynomial in a cell that is taken for simple,
relative to itself."""
FASTER = 4.0
"""How much of the z at steady speed, or of that of the law at hand, a motion may have."""


class PathAtProbes:
    """What is known of a path between the nodes of one mesh.

    It is asked at the nodes and in the middle of the cells. Where the middle, and what the positions gain, are as the
    derivatives at the nodes say, these tell the path at all probes. Elsewhere the same is tried with both halves of a
    cell, and where that does not do either, the path is asked at each probe.
    """

    def __init__(self, run: AxisRun, limits: Limits, nodes: Floats, cache: CachedPath | None = None) -> None:
        """Take the nodes (n,), and what is known of the path already."""
        self.run, self.limits, self.nodes, self.cache = run, limits, nodes, cache or run
        self.unlike = np.zeros(len(nodes) - 1, dtype=np.bool_)
        """(n - 1,) cells in which the path, or its cap, does more than what is known at few places says, as far as
        seen."""
        self.hiding = np.zeros(len(nodes) - 1, dtype=np.bool_)
        """(n - 1,) those in which the path does."""
        self._highest = np.full(len(nodes) - 1, np.inf)
        """(n - 1,) z up to which that counts."""
        breaks = run.breaks[(run.breaks > nodes[0]) & (run.breaks < nodes[-1]) & ~np.isin(run.breaks, nodes)]
        self._torn = np.zeros(len(nodes) - 1, dtype=np.bool_)
        self._torn[np.searchsorted(nodes, breaks) - 1] = True

    def take_over(self, before: PathAtProbes, parts: Ints) -> None:
        """Take what was seen on a mesh whose cells have been cut into so many parts (cells,) for this one."""
        whole = parts == 1
        self.unlike, self.hiding = (np.repeat(marks & whole, parts) for marks in (before.unlike, before.hiding))
        self._highest = np.repeat(before._highest, parts)

    def is_outgrown(self, law: SplineLaw) -> bool:
        """Whether a law is so fast somewhere that what was seen of the path does not count."""
        z = law.z_at_nodes()
        return bool((np.maximum(z[:-1], z[1:]) > self._highest).any())

    def interpolated(self, which: Ints, inside: Floats, law: SplineLaw | None = None) -> tuple[Floats, Floats]:
        """q', q'', q''' (n, 3, m, k) and caps (n, k) at the shares `inside` of the cells `which`, ascending.

        For motions whose z is nowhere more than FASTER times that at steady speed, or that of `law`: next to rest that
        is far less, and what positions gain in so short a cell is rounding.
        """
        begin, end = self.nodes[which], self.nodes[which + 1]
        length = end - begin
        low, middle, high = self._ends_and_middles(which, begin + length / 2.0)
        z = self._highest_z(low, middle, high)
        if law is not None:
            of_law = law.z_at_nodes()
            self._highest[which] = FASTER * np.maximum(of_law[which], of_law[which + 1])
            z = np.minimum(z, self._highest[which])
        unlike = ~self._alike(begin, length, low[0], middle[0], high[0], z)
        torn = self._torn[which]
        out = path_between(low[0], high[0], length, inside)
        halved = np.flatnonzero(unlike & ~torn)
        alike, of_halves = self._halves(begin, length, halved, low[0], middle[0], high[0], z, inside)
        out[halved[alike]], unlike[halved[alike]] = of_halves[alike], False
        self.hiding[which] = unlike | torn
        caps, vague = self._caps(begin, end, low[1], middle[1], high[1], inside)
        self.unlike[which] = evaluated = unlike | torn | vague
        if evaluated.any():
            out[evaluated], caps[evaluated] = self.evaluated(which[evaluated], inside)
        return out, caps

    def evaluated(self, which: Ints, inside: Floats) -> tuple[Floats, Floats]:
        """q', q'', q''' (n, 3, m, k) and caps (n, k) at the shares `inside` (k,) of some cells, asked at each."""
        s = probes(self.nodes[which], self.nodes[which + 1], inside)
        q, cap = self.run.with_cap(np.clip(s, self.run.s0, self.run.s1))
        by_cell = q[1:].reshape(3, len(which), len(inside), -1).transpose(1, 0, 3, 2)
        return np.ascontiguousarray(by_cell), cap.reshape(len(which), -1)

    def _ends_and_middles(self, which: Ints, middles: Floats) -> list[tuple[Floats, Floats]]:
        """Path (4, n, m) and cap (n,) where the cells `which` (n,), ascending, begin, at some `middles` (k,), and where
        they end.

        The path is from inside a cell at a break.
        """
        at = np.union1d(which, which + 1)
        nodes, count = self.nodes[at], len(at)
        first, last = np.searchsorted(at, which), np.searchsorted(at, which + 1)
        broken = np.flatnonzero(np.isin(nodes, self.run.breaks))
        s = np.concatenate([nodes, middles, np.nextafter(nodes[broken], -np.inf)])
        q, cap = self.cache.with_cap(np.clip(s, self.run.s0, self.run.s1))
        high, cap_high = q[:, :count].copy(), cap[:count].copy()
        high[:, broken], cap_high[broken] = q[:, count + len(middles) :], cap[count + len(middles) :]
        between = slice(count, count + len(middles))
        parts = (q[:, first], cap[first]), (q[:, between], cap[between]), (high[:, last], cap_high[last])
        return [(np.ascontiguousarray(path), of_path) for path, of_path in parts]

    def _highest_z(self, *places: tuple[Floats, Floats]) -> Floats:
        """(n,) the highest z that a motion may have in cells, from path (4, n, m) and cap (n,) at places of them."""
        z = np.zeros(len(places[0][1]))
        for q, cap in places:
            limits = self.limits.velocity, self.limits.acceleration, self.limits.jerk
            fastest, steady, _ = first_guess.pointwise(q, *limits, cap)
            z = np.maximum(z, np.minimum(fastest, FASTER * steady))
        z[z == np.inf] = 0.0
        return z

    def _alike(self, s: Floats, length: Floats, low: Floats, middle: Floats, high: Floats, z: Floats) -> Bools:
        """(n,) whether the derivatives at both ends (4, n, m) tell the path in the middle, and what positions gain."""
        limits = self.limits
        of_joints = limits.velocity, limits.acceleration, limits.jerk
        alike: Bools = between_nodes.deviation_from_quintic(s, low, high, middle, length, z, *of_joints) <= UNLIKE
        return alike

    def _halves(
        self, begin: Floats, length: Floats, cells: Ints,
        low: Floats, middle: Floats, high: Floats, z: Floats, inside: Floats,
    ) -> tuple[Bools, Floats]:  # fmt: skip
        """Whether both halves of some cells (n,) tell the path in them, and the path (n, 3, m, k) that they tell."""
        if not len(cells):
            return np.zeros(0, dtype=np.bool_), np.empty((0, 3, low.shape[2], len(inside)))
        low, middle, high = (np.ascontiguousarray(part[:, cells]) for part in (low, middle, high))
        begin, half, z = begin[cells], length[cells] / 2.0, z[cells]
        quarters, _ = self.cache.with_cap((begin[:, None] + 2.0 * half[:, None] * QUARTERS).ravel())
        first, last = np.ascontiguousarray(quarters[:, ::2]), np.ascontiguousarray(quarters[:, 1::2])
        alike = self._alike(begin, half, low, first, middle, z)
        alike &= self._alike(begin + half, half, middle, last, high, z)
        before = inside <= 0.5
        parts = (low, middle, 2.0 * inside[before]), (middle, high, 2.0 * inside[~before] - 1.0)
        interpolated = [path_between(one, other, half, share) for one, other, share in parts]
        return alike, np.concatenate(interpolated, axis=3)

    def _caps(
        self, begin: Floats, end: Floats, low: Floats, middle: Floats, high: Floats, inside: Floats
    ) -> tuple[Floats, Bools]:
        """Caps (n, k) from those at the ends and in the middle (n,) of cells and a few more, and where these do not
        tell them."""

        def at(shares: Floats) -> Floats:
            places = probes(begin, end, shares)
            return self.run.speed_cap(np.clip(places, self.run.s0, self.run.s1)).reshape(-1, len(shares)).T

        quarters = at(QUARTERS)
        five = np.stack([low, quarters[0], middle, quarters[1], high])
        if self.run.smooth_cap and not (five < np.inf).any():
            return np.full((len(low), len(inside)), np.inf), np.zeros(len(low), dtype=np.bool_)
        caps, bend = caps_between(five, inside)
        if self.run.smooth_cap:
            return caps, ~(bend <= BENT)
        evaluated = at(inside).T
        with np.errstate(invalid="ignore"):
            same = (np.abs(caps - evaluated) <= OFF * evaluated) | (caps == evaluated)
        return evaluated, ~same.all(axis=1)


def path_between(low: Floats, high: Floats, length: Floats, inside: Floats) -> Floats:
    """q', q'', q''' (n, 3, m, k) at the shares `inside` (k,) of cells, from the path (4, n, m) at both their ends."""
    out = np.empty((len(length), 3, low.shape[2], len(inside)))
    between_nodes.path_between(low, high, length, inside, out)
    return out


def probes(low: Floats, high: Floats, inside: Floats) -> Floats:
    """(n k,) places at the shares `inside` (k,) of cells between low and high (n,), their ends taken from inside."""
    s = low[:, None] + (high - low)[:, None] * inside
    s[:, inside == 1.0] = np.nextafter(high, -np.inf)[:, None]
    return np.asarray(s.ravel())


def caps_between(caps: Floats, inside: Floats) -> tuple[Floats, Floats]:
    """(n, k) caps on ds/dt at the shares `inside` (k,) of cells, from those at five even places of each (5, n).

    A feed over the speed of the tip: the square of its inverse is taken for a polynomial of the fourth degree. Returns
    with them how far, relative to itself, it is (n,) from one of the third.
    """
    square = np.square(1.0 / caps)
    order = np.vander(np.linspace(0.0, 1.0, 5), 5)
    interpolated = square.T @ np.linalg.solve(order.T, np.vander(inside, 5).T)
    bend = np.abs(np.array([1.0, -4.0, 6.0, -4.0, 1.0]) @ square)
    least = square.min(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1.0 / np.sqrt(np.maximum(interpolated, 0.5 * least[:, None])), np.where(least > 0.0, bend / least, bend)


class CachedPath:
    """Path and cap of a run, asked once at each place and remembered: for runs that are solved in one piece."""

    def __init__(self, run: AxisRun) -> None:
        self._run, self._lock = run, threading.Lock()
        self._place = np.empty(0)
        """(n,) where it is known, ascending."""
        self._path, self._cap = np.empty((4, 0, 0)), np.empty(0)
        """(4, n, joints) and (n,) there."""
        self.rest_caps: dict[tuple[float, float], float] = {}
        """Most z at the inner ends of cells at rest, by that node and the way to rest."""

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        """Path (4, n, joints) and cap (n,) on ds/dt at s (n,), as AxisRun.with_cap tells them."""
        with self._lock:
            is_cached = np.append(self._place, np.nan)[np.searchsorted(self._place, s)] == s
        if not is_cached.all():
            fresh = np.unique(s[~is_cached])
            self._learn(fresh, *self._run.with_cap(fresh))
        with self._lock:
            at = np.searchsorted(self._place, s)
            return self._path.take(at, axis=1), self._cap.take(at)

    def _learn(self, fresh: Floats, path: Floats, cap: Floats) -> None:
        """Remember the path (4, n, joints) and the cap (n,) at places (n,), ascending; two threads may learn one."""
        with self._lock:
            if not len(self._place):
                self._place, self._path, self._cap = fresh, np.ascontiguousarray(path), np.asarray(cap)
                return
            before = np.searchsorted(self._place, fresh)
            new = np.append(self._place, np.nan)[before] != fresh
            order = np.argsort(np.concatenate([self._place, fresh[new]]), kind="stable")
            self._place = np.concatenate([self._place, fresh[new]])[order]
            self._path = np.concatenate([self._path, path[:, new]], axis=1).take(order, axis=1)
            self._cap = np.concatenate([self._cap, np.asarray(cap)[new]])[order]
