"""Random plans of many families, each by its seed: a third by default, a third on fixed meshes, a third in motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from testbed import nasty_paths
from testbed.jets import along, beside, harmonics, path_of, standing
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan

WAYS = ("default", "mesh", "motion")
Random = np.random.Generator
Made = tuple[AxisPath, int, float]
"""A path, its joints, and the size of what they do."""


@dataclass
class RandomPlan:
    """A path, its limits, and options of `plan`."""

    seed: int
    family: str
    way: str
    path: AxisPath
    limits: Limits
    options: dict[str, Any] = field(default_factory=dict)


def logarithmic(random: Random, low: float, high: float, size: Any = None) -> Any:
    """10 to a power between low and high."""
    return 10.0 ** random.uniform(low, high, size)


def ten_harmonics(random: Random) -> Made:
    """Ten harmonics a joint."""
    joints = int(random.integers(1, 10))
    return path_of(harmonics(random, joints, 10)), joints, 1.0


def random_knots(random: Random) -> Made:
    """Splines of degree three, four and five through random points, knots up to a thousand times closer in places."""
    from scipy.interpolate import make_interp_spline

    joints, count = int(random.integers(1, 7)), int(random.integers(8, 60))
    s = np.concatenate([[0.0], np.cumsum(logarithmic(random, -random.uniform(0.0, 3.0), 0.0, count))])
    s /= s[-1]
    way = np.cumsum(random.normal(size=(count + 1, joints)) * np.gradient(s)[:, None] ** 0.7, axis=0)
    return AxisPath.from_spline(make_interp_spline(s, way, k=int(random.choice([4, 5])))), joints, 1.0


def waypoints(random: Random) -> Made:
    """The smoothest curve through random places."""
    joints = int(random.integers(1, 7))
    return (
        AxisPath.from_waypoints(np.cumsum(random.normal(size=(int(random.integers(3, 40)), joints)), axis=0)),
        joints,
        5.0,
    )


def blends(random: Random) -> Made:
    """Lines joined by arcs of a quintic, their ends given as breaks, off by a few roundings."""
    from scipy.interpolate import BPoly, PPoly

    joints, count = int(random.integers(1, 6)), int(random.integers(2, 25))
    points = np.cumsum(random.normal(size=(count + 1, joints)), axis=0)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    s /= s[-1]
    way = np.diff(points, axis=0) / np.diff(s)[:, None]
    half = np.minimum(0.45 * np.minimum(np.diff(s)[:-1], np.diff(s)[1:]), logarithmic(random, -6, -1))
    x, values = [0.0], [(points[0], way[0])]
    for k, e in enumerate(half):
        x += [s[k + 1] - e, s[k + 1] + e]
        values += [(points[k + 1] - e * way[k], way[k]), (points[k + 1] + e * way[k + 1], way[k + 1])]
    x, values = [*x, 1.0], [*values, (points[-1], way[-1])]
    table = np.array([[p, v, 0.0 * v] for p, v in values])
    parts = [PPoly.from_bernstein_basis(BPoly.from_derivatives(x, table[:, :, j])) for j in range(joints)]
    told = np.array(x[1:-1]) + np.spacing(0.5) * random.integers(-3, 4, len(x) - 2)
    return (
        path_of(
            lambda u: np.stack(
                [np.stack([p(u, k) if k == 0 else p.derivative(k)(u) for p in parts], axis=1) for k in range(4)]
            ),
            breaks=told,
        ),
        joints,
        3.0,
    )


def reversals(random: Random) -> Made:
    """One joint, or a few in step, that go out and back."""
    joints, rate, phase = int(random.integers(1, 3)), random.uniform(3.0, 12.0), random.uniform(0.0, 6.3)
    size = random.normal(size=joints)
    return (
        path_of(
            lambda s: np.stack([np.outer(rate**k * np.sin(rate * s + phase + k * np.pi / 2), size) for k in range(4)])
        ),
        joints,
        1.0,
    )


def standing_at_one_place(random: Random) -> Made:
    """All joints stand at one s: s^2, s^3 and their kin."""
    joints, place, power = int(random.integers(1, 5)), random.uniform(0.2, 0.8), int(random.choice([2, 3]))

    def x(s: Any) -> Any:
        u = s - place
        return np.stack([u**2, 2 * u, 2 + 0 * u, 0 * u] if power == 2 else [u**3, 3 * u**2, 6 * u, 6 + 0 * u])

    return path_of(along(harmonics(random, joints), x)), joints, 0.3


def narrow_bends(random: Random) -> Made:
    """A smooth path with one to three S-bends 1e-7 to 1e-2 of it wide, of any height."""
    joints, count = int(random.integers(1, 6)), int(random.integers(1, 4))
    base, place = harmonics(random, joints, 3), random.uniform(0.05, 0.95, count)
    width = logarithmic(random, -7, -2, count)
    height = random.normal(size=(count, joints)) * (width * logarithmic(random, -3, 0.5, count))[:, None]

    def jets(s: Any) -> Any:
        out = base(s)
        for p, w, h in zip(place, width, height):
            y = np.tanh((s - p) / w)
            g = 1.0 - y * y
            out = out + np.stack([y, g / w, -2 * y * g / w**2, (6 * y * y - 2) * g / w**3])[:, :, None] * h
        return out

    return path_of(jets), joints, 1.0


def scaled_joints(random: Random) -> Made:
    """Joints of sizes 1e-6 to 1e6, limits alike: see `limits_of`."""
    joints = int(random.integers(2, 8))
    return path_of(harmonics(random, joints, 5)), joints, 1.0


def nearly_straight(random: Random) -> Made:
    """A line, and next to nothing beside it."""
    joints = int(random.integers(1, 7))
    line, bend = random.normal(size=joints), logarithmic(random, -9, -2)
    base = harmonics(random, joints)
    return (
        path_of(
            lambda s: (
                bend * base(s)
                + np.stack([np.outer(s, line), np.tile(line, (len(s), 1)), *np.zeros((2, len(s), joints))])
            )
        ),
        joints,
        1.0,
    )


def short_or_long(random: Random) -> Made:
    """1e-6 to 1e4 of what the limits are made for."""
    joints, size = int(random.integers(1, 6)), logarithmic(random, -6, 4)
    base = harmonics(random, joints)
    return path_of(lambda s: size * base(s)), joints, 1.0


def joints_at_rest(random: Random) -> Made:
    """Some joints never move."""
    joints, still = int(random.integers(1, 6)), int(random.integers(1, 4))
    return path_of(beside(harmonics(random, joints, 5), standing(random.normal(size=still)))), joints + still, 1.0


def caps(random: Random) -> Made:
    """A cap on ds/dt that jumps."""
    joints, places = int(random.integers(1, 7)), np.sort(random.uniform(0.0, 1.0, int(random.integers(1, 20))))
    cap = logarithmic(random, -2, 0.5, len(places) + 1)
    path = path_of(
        harmonics(random, joints), breaks=places, speed_cap=lambda s: cap[np.searchsorted(places, s, side="right")]
    )
    return path, joints, 1.0


OWN: tuple[Callable[[Random], Made], ...] = (
    ten_harmonics, random_knots, waypoints, blends, reversals, standing_at_one_place, narrow_bends, scaled_joints,
    nearly_straight, short_or_long, joints_at_rest, caps,
)  # fmt: skip
NASTY = ("pole", "standing_tip", "cusp", "slow_spots", "crowded", "kinks", "parameters", "standing_joints")
FAMILIES = (*(family.__name__ for family in OWN), *NASTY)


def limits_of(random: Random, joints: int, size: float, spread: float) -> Limits:
    """Limits like those of a machine, apart from joint to joint by up to the power `spread` of ten."""
    apart = logarithmic(random, -spread, spread, joints)
    ramp = random.uniform(0.2, 1.0)
    return Limits(*(size * apart * random.uniform(0.5, 2.0, joints) * base for base in (1.0, 4.0, 40.0 * ramp)))


def random_plan(seed: int) -> RandomPlan:
    """The plan of a seed. Raises InfeasibleError where the whole path, from which states are taken, has no motion."""
    random = np.random.default_rng([seed, 20_261])
    way, family = WAYS[seed % 3], FAMILIES[(seed // 3) % len(FAMILIES)]
    if family in NASTY:
        case = nasty_paths.case(family, seed)
        path, limits = case.path, case.limits
    else:
        path, joints, size = OWN[FAMILIES.index(family)](random)
        limits = limits_of(random, joints, size, 3.0 if family == "scaled_joints" else 0.5)
    mesh = {"mesh": int(logarithmic(random, np.log10(20), np.log10(2000)))}
    options: dict[str, Any] = mesh if way == "mesh" else {}
    if way == "motion":
        path, options = in_motion(random, path, limits)
        options |= mesh if random.random() < 0.3 else {}
    return RandomPlan(seed, family, way, path, limits, options)


def in_motion(random: Random, path: AxisPath, limits: Limits) -> tuple[AxisPath, dict[str, Any]]:
    """A piece of a path between states that a motion along it passes at nine tenths of its speed."""
    run = path.runs[0]
    whole = plan(path, limits, mesh=200, bound=False)
    share = np.sort(random.uniform(0.02, 0.98, 2))
    slow, which = 0.9, int(random.integers(3))
    states = [whole.state(float(part * whole.duration)) for part in share]
    ends = {
        name: EndState(slow * v, slow**2 * a)
        for k, (name, (_, v, a)) in enumerate(zip(("start", "end"), states))
        if which in (k, 2) and v > 0.0
    }
    s0, s1 = (states[0][0] if "start" in ends else run.s0), (states[1][0] if "end" in ends else run.s1)
    piece = AxisPath.from_callable(
        lambda s, order: run.evaluate(s)[order], s0, s1, speed_cap=run.speed_cap, breaks=run.breaks, hints=run.hints
    )
    return piece, ends
