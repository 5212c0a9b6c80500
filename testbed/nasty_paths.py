"""Joint paths made to break a planner, by family and seed: each family is one function of a random generator.

A case says what must come out: a motion, a refusal, or either. From rest to rest along a path on which joints with
positive limits move there always is a motion, so a refusal is a failure there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from testbed.jets import Jets, along, beside, harmonics, path_of, standing, straight
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.callable_run import CallableRun
from toolpace.path.path import Path
from toolpace.path.run import unit_jets
from toolpace.planning.planned_run import EndState

ANSWER, REFUSAL, EITHER = "answer", "refusal", "either"
COARSE = (8, 9, 10, 13, 20, 50)
MESHES = (20, 50, 50, 100, 100, 200, None)


@dataclass
class Nasty:
    """A path, its limits, options of `plan`, and what must come out."""

    path: AxisPath
    limits: Limits
    options: dict[str, Any] = field(default_factory=dict)
    expected: str = ANSWER
    names: str = ""
    """What a refusal must name."""
    places: tuple[float, ...] = ()
    """Parameters about which a judge should look closely."""
    family: str = ""
    seed: int = 0


def some_harmonics(random) -> Jets:
    """A smooth path of one to six joints."""
    return harmonics(random, int(random.integers(1, 7)))


def some_line(random, joints=3) -> Jets:
    """A straight line in any direction."""
    return straight(random.normal(size=joints))


def joints_of(jets) -> int:
    """The number of joints of a path."""
    return jets(np.zeros(1)).shape[2]


def limits_for(random, joints, tight=None) -> Limits:
    """Limits like those of a machine for a path of about a metre, every other time with a fifth of the jerk."""
    tight = random.random() < 0.5 if tight is None else tight
    jerk = random.uniform(10.0, 40.0, joints) * (0.2 if tight else 1.0)
    return Limits(random.uniform(0.5, 2.0, joints), random.uniform(1.5, 6.0, joints), jerk)


def mesh(random, meshes=MESHES):
    """A mesh of the list; None leaves it to the planner."""
    return {"mesh": meshes[int(random.integers(len(meshes)))]}


def logarithmic(random, low, high, size=None):
    """10 to a power between low and high."""
    return 10.0 ** random.uniform(low, high, size)


def smooth(random) -> Nasty:
    """Smooth paths of one to nine joints."""
    joints = int(random.choice([1, 1, 2, 3, 5, 6, 9]))
    return Nasty(path_of(harmonics(random, joints)), limits_for(random, joints), mesh(random))


def coarse(random) -> Nasty:
    """Meshes of eight cells and a few more."""
    joints = int(random.integers(1, 7))
    jets = harmonics(random, joints, int(random.integers(1, 5)))
    return Nasty(path_of(jets), limits_for(random, joints), mesh(random, COARSE))


def pole(random) -> Nasty:
    """The tool axis of an A/C trunnion passes its pole at 1e-8 to 1e-2; there C makes half a turn."""
    machine = Machine.load(str(random.choice(["xyzac-trunnion", "xyzbc-trunnion", "xyzbc-head"])))
    past, angle = logarithmic(random, -8, -2), random.uniform(0, 2 * np.pi)
    reach, sway = random.uniform(0.05, 0.5), random.normal(size=3) * 0.02
    middle = random.uniform(0.3, 0.7)
    still = random.random() < 0.3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def f(s, order):
        lean = np.zeros((4, len(s), 3))
        lean[0, :, :2] = np.stack([reach * (s - middle), np.full(len(s), past)], axis=1) @ turn.T
        lean[1, :, :2] = turn @ [reach, 0.0]
        lean[0, :, 2] = 1.0
        tip = np.sin(s[:, None] * [3.0, 2.0, 4.0] + 0.5 * np.pi * order) * np.array([3.0, 2.0, 4.0]) ** order
        return 0.0 * tip if still else tip * sway, unit_jets(lean)[order]

    feed = np.inf if random.random() < 0.5 else logarithmic(random, -3, -1)
    path = AxisPath.follow(Path.from_callable(f, feed=feed), machine)
    return Nasty(path, machine.limits, mesh(random, (100, 300, None)), places=(middle,))


def standing_tip(random) -> Nasty:
    """The tip stands still while the axis turns, under a feed of the tip."""
    machine = Machine.load("xyzac-trunnion")
    tilt, sway, turn = random.uniform(0.2, 0.8), random.uniform(0.0, 0.15), random.uniform(0.1, 3.0)
    size = 0.0 if random.random() < 0.5 else logarithmic(random, -9, -4)

    def f(s, order):
        a = np.stack([tilt + sway * np.sin(3 * s), sway * 3 * np.cos(3 * s), -9 * sway * np.sin(3 * s),
                      -27 * sway * np.cos(3 * s)])  # fmt: skip
        unit = np.zeros((4, len(s), 3))
        # of (sin a cos b, sin a sin b, cos a): products of complex exponentials
        for sign in (1.0, -1.0):
            rate = np.stack([a[0] + sign * turn * s, a[1] + sign * turn, a[2], a[3]])
            wave = exponential(rate)
            unit[:, :, 0] += wave.imag / 2.0
            unit[:, :, 1] += -sign * wave.real / 2.0
        unit[:, :, 2] = exponential(a).real
        tip = size * np.sin(s[:, None] * [3.0, 2.0, 4.0] + 0.5 * np.pi * order) * np.array([3.0, 2.0, 4.0]) ** order
        return tip, unit[order]

    path = AxisPath.follow(Path.from_callable(f, feed=logarithmic(random, -3, -1)), machine)
    return Nasty(path, machine.limits, mesh(random, (50, 100, 300, None)))


def exponential(a):
    """exp(i a) and three derivatives (4, n), given those of a."""
    w = np.exp(1j * a[0])
    d1 = 1j * a[1]
    d2 = 1j * a[2] + d1**2
    d3 = 1j * a[3] + 3.0 * d1 * 1j * a[2] + d1**3
    return w * np.stack([np.ones_like(d1), d1, d2, d3])


def cusp(random) -> Nasty:
    """A reversal of one joint rounded to a nanometre up to a millimetre."""
    e, middle = logarithmic(random, -9, -3), random.uniform(0.2, 0.8)

    def corner(s):
        x = s - middle
        r = np.sqrt(x * x + e * e)
        return np.stack([r, x / r, e * e / r**3, -3.0 * e * e * x / r**5])[:, :, None]

    joints = int(random.integers(1, 4))
    jets = beside(corner, harmonics(random, joints) if random.random() < 0.5 else some_line(random, joints))
    options = mesh(random, (50, 100, 300, None))
    return Nasty(path_of(jets), limits_for(random, joints + 1), options, places=(middle,))


def limits_apart(random) -> Nasty:
    """Limits up to six orders of magnitude apart between joints, and between kinds."""
    joints = int(random.integers(2, 7))
    given = limits_for(random, joints)
    spread = logarithmic(random, -3, 3, (3, joints)) if random.random() < 0.5 else logarithmic(random, -3, 3, joints)
    return Nasty(path_of(harmonics(random, joints)), given.scaled(*np.broadcast_to(spread, (3, joints))), mesh(random))


def infinite_limits(random) -> Nasty:
    """Some kinds of some joints, or of all joints, without a limit."""
    joints = int(random.integers(1, 6))
    given = limits_for(random, joints)
    off = random.random((3, joints)) < 0.4
    if random.random() < 0.5:
        off[:] = (random.random(3) < 0.5)[:, None]
    off[:, 0] &= not off[:, 0].all()
    values = [np.where(o, np.inf, v) for o, v in zip(off, (given.velocity, given.acceleration, given.jerk))]
    return Nasty(path_of(harmonics(random, joints)), Limits(*values), mesh(random))


def lengths(random) -> Nasty:
    """Joints that move by a nanometre up to a hundred kilometres within limits of metres."""
    jets = some_harmonics(random) if random.random() < 0.7 else some_line(random)
    joints = joints_of(jets)
    size = logarithmic(random, -9, 5)
    return Nasty(path_of(lambda s: size * jets(s)), limits_for(random, joints), mesh(random))


def parameters(random) -> Nasty:
    """The parameter scaled by 1e-6 to 1e6, counted from far away from zero."""
    jets = some_harmonics(random)
    joints = joints_of(jets)
    k = logarithmic(random, -6, 6)
    s0 = 0.0 if random.random() < 0.4 else k * random.choice([-1.0, 1.0]) * logarithmic(random, 0, 6)

    def scaled(s):
        return np.stack([(s - s0) / k, np.full(len(s), 1.0 / k), np.zeros(len(s)), np.zeros(len(s))])

    return Nasty(path_of(along(jets, scaled), s0, s0 + k), limits_for(random, joints), mesh(random))


def slow_spots(random) -> Nasty:
    """A parameter like s^3 about one to three places: q' nearly vanishes there, and ds/dt must be large."""
    jets = some_harmonics(random) if random.random() < 0.7 else some_line(random)
    joints = joints_of(jets)
    places = random.uniform(0.0, 1.0, int(random.integers(1, 4)))
    flat, width = logarithmic(random, -6, -1), random.uniform(0.05, 0.3)

    def one(s):
        # x' = 1 + flat - 1 / (1 + (s - p)^2 / w^2), whose integral is an arc tangent
        x, x1, x2, x3 = s * (1.0 + flat), np.full(len(s), 1.0 + flat), np.zeros(len(s)), np.zeros(len(s))
        for p in places:
            u = (s - p) / width
            r = 1.0 / (1.0 + u * u)
            x = x - width * np.arctan(u) / len(places)
            x1 = x1 - r / len(places)
            x2 = x2 + 2.0 * u * r * r / width / len(places)
            x3 = x3 + (2.0 * r * r - 8.0 * u * u * r**3) / width**2 / len(places)
        return np.stack([x, x1, x2, x3])

    path = path_of(along(jets, one))
    return Nasty(path, limits_for(random, joints), mesh(random, (50, 100, 300, None)), places=tuple(places))


class Hinted(CallableRun):
    """A run with hints of its own."""

    def __init__(self, run, hints):
        super().__init__(run.f, run.s0, run.s1, run.speed_cap, run.breaks)
        self.hints = hints


def crowded(random) -> Nasty:
    """Breaks and hints that are given twice, or lie 1e-15 to 1e-6 of the run apart, or next to its ends."""
    jets = some_harmonics(random)
    joints = joints_of(jets)
    places = random.uniform(0.0, 1.0, int(random.integers(1, 5)))
    near = [places, places, places + logarithmic(random, -15, -6, len(places)), np.nextafter(places, 1.0)]
    near.append(logarithmic(random, -15, -3, 2))
    near.append(1.0 - logarithmic(random, -15, -3, 2))
    breaks = np.concatenate([part for part in near if random.random() < 0.6] or [places])
    path = path_of(jets, breaks=breaks)
    options = mesh(random, (50, 100, 300, None))
    if random.random() < 0.4:
        hints = np.sort(np.concatenate([[0.0, 1.0], np.clip(np.concatenate(near), 0.0, 1.0)]))
        path = AxisPath((Hinted(path.runs[0], hints),), path.joints)
        options = mesh(random, (50, None))
    return Nasty(path, limits_for(random, joints), options, places=tuple(places))


def kinks(random) -> Nasty:
    """Jumps of the third derivative: cubic splines through random points, knots up to a thousand times closer."""
    from scipy.interpolate import CubicSpline

    joints, n = int(random.integers(1, 6)), int(random.integers(3, 14))
    s = np.concatenate([[0.0], np.cumsum(logarithmic(random, -3 if random.random() < 0.3 else -1, 0, n))])
    s /= s[-1]
    way = np.cumsum(random.normal(size=(n + 1, joints)) * np.append(1.0, np.diff(s))[:, None], axis=0)
    spline = CubicSpline(s, way)
    path = path_of(lambda x: np.stack([spline(x, order) for order in range(4)]), breaks=s[1:-1])
    return Nasty(path, limits_for(random, joints), mesh(random, (100, 300, None)))


def caps_that_jump(random) -> Nasty:
    """A feed cap that jumps up and down by up to a thousand times, one to thirty times."""
    jets = some_harmonics(random)
    joints = joints_of(jets)
    breaks = np.sort(random.uniform(0.0, 1.0, int(random.integers(1, 31))))
    caps = logarithmic(random, -3, 0, len(breaks) + 1)
    caps[random.random(len(caps)) < 0.2] = np.inf
    path = path_of(jets, breaks=breaks, speed_cap=lambda s: caps[np.searchsorted(breaks, s, side="right")])
    return Nasty(path, limits_for(random, joints), mesh(random, (100, 300, None)), places=tuple(breaks))


def standing_joints(random) -> Nasty:
    """Joints that never move, or stand on a part of the path; at times all of them stand there."""
    jets, moving = some_harmonics(random), int(random.integers(1, 4))
    still = int(random.integers(0, 3))
    low, high = np.sort(random.uniform(0.1, 0.9, 2))
    inner = harmonics(random, moving)

    def stop(s):
        # stands still at x = low from s = low to high, leaves with a vanishing third derivative
        u = np.where(s < low, s - low, np.where(s > high, s - high, 0.0))
        k = 1.0 / max(low, 1.0 - high) ** 4
        return np.stack([low + k * u**5, 5 * k * u**4, 20 * k * u**3, 60 * k * u**2])

    parts = [along(inner, stop)]
    if random.random() < 0.6:
        parts.append(jets)
    constant = random.normal(size=still)
    if still:
        parts.append(standing(constant))
    whole = beside(*parts)
    path = path_of(whole, breaks=[low, high])
    limits = limits_for(random, joints_of(whole))
    return Nasty(path, limits, mesh(random, (50, 100, 300, None)), places=(low, high))


def nothing_moves(random) -> Nasty:
    """A constant path, with or without a feed cap: no joint asks for time."""
    joints = int(random.integers(1, 4))
    place = random.normal(size=joints)
    cap = np.inf if random.random() < 0.5 else logarithmic(random, -3, 3)
    path = path_of(standing(place), speed_cap=cap)
    return Nasty(path, limits_for(random, joints), mesh(random, (50, 100, None)), EITHER)


def nothing_limits(random) -> Nasty:
    """No limit at all on what moves, with or without a feed cap."""
    jets = some_harmonics(random)
    joints = joints_of(jets)
    cap = np.inf if random.random() < 0.5 else logarithmic(random, -3, 3)
    limits = Limits(*(np.full(joints, np.inf),) * 3)
    return Nasty(path_of(jets, speed_cap=cap), limits, mesh(random, (50, 100, None)), EITHER)


def stopping(random) -> Nasty:
    """From motion to rest, or the other way, on a straight line a little longer or shorter than that takes."""
    v, a, j = logarithmic(random, -1, 1), logarithmic(random, -1, 1), logarithmic(random, -1, 2)
    speed = v * random.uniform(0.2, 1.0)
    needed = speed * (speed / a + a / j if speed * j >= a * a else 2.0 * np.sqrt(speed / j)) / 2.0
    longer = float(random.choice([-0.1, -0.01, 0.01, 0.02, 0.1, 1.0]))
    length = needed * (1.0 + longer)
    end = str(random.choice(["start", "end"]))
    options = {**mesh(random, (100, 300, None)), end: EndState(speed, 0.0)}
    # so little room is lost on a mesh that is fixed
    expected = REFUSAL if longer < 0.0 else ANSWER if longer >= 0.1 or options["mesh"] is None else EITHER
    return Nasty(path_of(straight([1.0]), 0.0, length), Limits([v], [a], [j]), options, expected, "s =")


def at_the_limit(random) -> Nasty:
    """A start or an end at exactly a limit, just below it, or beyond it: beyond, the limit must be named."""
    share = float(random.choice([0.9, 0.999, 1.0, 1.0 + 1e-5, 1.001, 1.1, 10.0]))
    kind = str(random.choice(["velocity", "feed", "acceleration"]))
    cap = 0.7 if kind == "feed" else np.inf
    end = str(random.choice(["start", "end"]))
    sign = 1.0 if end == "start" else -1.0
    state = EndState(share * (0.7 if kind == "feed" else 1.0), 0.0)
    if kind == "acceleration":
        # speeding up from a start at little speed, slowing down towards such an end: slack remains
        state = EndState(0.3, sign * 3.0 * share)
    options = {**mesh(random, (100, 300, None)), end: state}
    names = {"velocity": "the velocity limit of q1", "feed": "the feed cap",
             "acceleration": "the acceleration limit of q1"}[kind]  # fmt: skip
    expected = ANSWER if share <= 1.0 + 1e-5 else REFUSAL
    path = path_of(straight([1.0]), 0.0, 3.0, speed_cap=cap)
    return Nasty(path, Limits([1.0], [3.0], [20.0]), options, expected, names)


def in_motion(random) -> Nasty:
    """A piece of a path from and to states that the motion along the whole path passes, slowed down or not."""
    from toolpace.planning.planner import plan

    jets = some_harmonics(random)
    joints = joints_of(jets)
    limits = limits_for(random, joints)
    whole = plan(path_of(jets), limits, mesh=200, bound=False)
    low, high = np.sort(random.uniform(0.02, 0.98, 2))
    slow = float(random.choice([0.5, 0.9, 0.99, 1.0]))
    (s0, v0, a0), (s1, v1, a1) = (whole.state(share * whole.duration) for share in (low, high))
    ends = {"start": EndState(slow * v0, slow**2 * a0), "end": EndState(slow * v1, slow**2 * a1)}
    which = random.integers(3)
    if which == 1:
        s0 = 0.0
        del ends["start"]
    if which == 2:
        s1 = 1.0
        del ends["end"]
    options = {**mesh(random, (100, 300, None)), **ends}
    # what a single cell of a fixed mesh passes cannot be taken away by slowing down the whole
    expected = ANSWER if slow <= 0.9 and options["mesh"] is None else EITHER
    return Nasty(path_of(jets, s0, s1), limits, options, expected, "s =")


FAMILIES: dict[str, Callable[[Any], Nasty]] = {
    family.__name__: family
    for family in (
        smooth, coarse, pole, standing_tip, cusp, limits_apart, infinite_limits, lengths, parameters, slow_spots,
        crowded, kinks, caps_that_jump, standing_joints, nothing_moves, nothing_limits, stopping, at_the_limit,
        in_motion,
    )
}  # fmt: skip


def case(family: str, seed: int) -> Nasty:
    """The case of a family and a seed."""
    made = FAMILIES[family](np.random.default_rng([seed, *family.encode()]))
    made.family, made.seed = family, seed
    return made
