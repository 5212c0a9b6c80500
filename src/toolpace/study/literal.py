"""The rejoin of the paper to the letter: steps (1) to (4) of section II.D.

Step (2): deflection and projection are the ends of an interval, "with the same velocity, acceleration, and jerk", each
of x_w, y_w, z_w, A and B a quintic, Eq. (7a). Step (3): its period T_dp by the genetic algorithm. Step (4): so for the
interval from the projection to the next reference point.

A quintic has six coefficients. Both positions, velocity and acceleration take them all; then the jerks at both ends
differ by 12 times the acceleration over the period. Jerks are the same too where that acceleration is zero, and only
there. So there are two readings. Either asks the joints for a jump: the same velocity of the tip, at another place, is
another velocity of the joints wherever a rotary axis turns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.kernels.planners import genetic
from toolpace.kernels.planners.quintic_interval import Interval, comfortable, interval_of
from toolpace.machine.limits import KINDS
from toolpace.machine.machine import Machine
from toolpace.motion.laws import QuinticLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_path
from toolpace.path.path import Path
from toolpace.planning.genetic import Genetic, Intervals, Preset, breeding_of, with_bred_periods

SAMPLES = 257
"""Times of the first interval at which the limits are looked at."""
DOUBLINGS = 12
"""Of the period at which the tip would go straight at the feed, until one keeps to the limits."""
ROOM = 1.0 - 1e-4
"""Usage allowed at the samples: what lies between two of them is less than the rest."""


@dataclass(frozen=True)
class LiteralWay:
    """The way back as printed."""

    trajectory: Trajectory
    """From the deflection to the next reference point, over which it passes in motion."""
    rates: Floats
    """(3, 2, 5) velocity, acceleration and jerk of x_w, y_w, z_w and both rotary joints, at both ends of the first."""
    jump: Floats
    """(2, m) velocity and acceleration that each joint would have to take on at once."""

    @property
    def periods(self) -> Floats:
        """(2,) T_dp and the time from the projection to the next reference point [s]."""
        law = self.trajectory.laws[0]
        assert isinstance(law, QuinticLaw)
        return law.periods


def literal_way(
    followed: Trajectory, path: Path, machine: Machine, deflection: Floats, place: float, following: float,
    *, same_jerk: bool, options: Genetic,
) -> LiteralWay:  # fmt: skip
    """The way back from a deflection (3,) [m] to the projection at s = `place` and the reference point at `following`.

    `followed` is the trajectory that was followed on the `path`, in rotary joints; its velocities and accelerations are
    those of the projection. With `same_jerk` the accelerations at deflection and projection are zero, that jerks be the
    same. Raises InfeasibleError where the genetic algorithm finds no period.
    """
    law, limits = followed.laws[0], followed.limits
    start, end = (law.at(np.array([law.passing_time(s)]))[:, 0] for s in (place, following))
    jets = coordinates(path, np.array([place, following]))
    begin, goal = in_time(jets[:, 0], start), jets[:3, 1]
    if same_jerk:
        begin[2] = 0.0
    feed = float(path.runs[0].feed[0])
    v = float(start[1])

    def by_s(where: Floats) -> Floats:
        """Value and two derivatives (3, 5) by s = v t of the state of the projection, at another place."""
        return np.stack([where, begin[1] / v, begin[2] / v**2])

    found = begin[0].copy()
    found[:3] = deflection
    ends = np.stack([by_s(found), by_s(begin[0])], axis=1)

    def usage(period: float) -> float:
        """Largest value over limit on the first interval, with s = v t."""
        run = interval_path([0.0, v * period], ends, feed)
        q = AxisPath.follow(run, machine).runs[0].evaluate(s := np.linspace(0.0, v * period, SAMPLES))
        of_joints = max(np.max(np.abs(q[k]) * v**k / getattr(limits, kind)) for k, kind in enumerate(KINDS, 1))
        return max(float(of_joints), float(np.linalg.norm(run.runs[0].evaluate(s).tip[1], axis=1).max()) * v / feed)

    least = float(np.linalg.norm(found[:3] - begin[0, :3])) / feed
    first = bred_period(usage, least, options)
    rest = interval_path([0.0, following - place], np.stack([ends[:, 1], goal], axis=1), feed)
    second = rest_period(rest, followed, (v, 0.0, float(end[1]), float(end[2])), options)

    s = np.array([0.0, v * first, v * first + following - place])
    both = interval_path(s, np.stack([ends[:, 0], ends[:, 1], goal], axis=1), feed)
    speeds, accelerations = np.array([v, v, end[1]]), np.array([0.0, 0.0, end[2]])
    motion = QuinticLaw(s, speeds, accelerations, np.array([first, second]))
    trajectory = Trajectory(AxisPath.follow(both, machine), limits, (motion,), planner="genetic, to the letter")
    return LiteralWay(trajectory, end_rates(both, s[:2], v), joint_jump(followed, trajectory, law.passing_time(place)))


def coordinates(path: Path, s: Floats) -> Floats:
    """(4, n, 5) x_w, y_w, z_w and rotary joints of a path's first run, with three derivatives by s."""
    jet = path.runs[0].evaluate(s)
    assert jet.rotary is not None
    return np.concatenate([jet.tip, jet.rotary], axis=2)


def in_time(jets: Floats, state: Floats) -> Floats:
    """(3, 5) value, velocity and acceleration of jets (4, 5) by s under s and its time derivatives (4,)."""
    return np.stack([jets[0], jets[1] * state[1], jets[2] * state[1] ** 2 + jets[1] * state[2]])


def interval_path(s: Floats | list[float], jets: Floats, feed: float) -> Path:
    """Quintic intervals through points at s (n,) with jets (3, n, 5)."""
    return quintic_path(s, jets[:, :, :3], jets[:, :, 3:], feed)


def end_rates(path: Path, s: Floats, v: float) -> Floats:
    """(3, 2, 5) velocity, acceleration and jerk at both ends of an interval that is run through at s = v t."""
    # the third derivative jumps at the end, and there it is that of the left side which is meant
    jets = coordinates(path, np.array([s[0], np.nextafter(s[1], s[0])]))
    return np.stack([jets[k] * v**k for k in (1, 2, 3)])


def joint_jump(followed: Trajectory, way: Trajectory, time: float) -> Floats:
    """(2, m) what velocity and acceleration of the joints differ by where the way back begins."""
    before, after = followed.at(np.array([time])), way.at(np.zeros(1))
    return np.stack([after.qd[0] - before.qd[0], after.qdd[0] - before.qdd[0]])


def bred_period(usage: Callable[[float], float], least: float, options: Genetic) -> float:
    """The shortest period that the genetic algorithm finds to keep to the limits, the gene being the period.

    In the first population is the first of `least`, twice that, and so on that does; the others are not shorter than
    half of it.
    """
    first = next((t for t in least * 2.0 ** np.arange(DOUBLINGS) if usage(t) <= ROOM), None)
    if first is None:
        raise InfeasibleError(f"study: no period up to {least * 2.0**DOUBLINGS:.3g} s keeps to the limits")
    low, high, bits = 0.5 * first, first, options.bits
    genes = genetic.first_population(options.population, 1, bits, options.seed)
    genes[0, 0] = genetic.encode(first, bits, low, high)
    best = float(first)
    for generation in range(options.generations + 1):
        periods = np.array([genetic.decode(gene, bits, low, high) for gene in genes[:, 0]])
        used = np.array([usage(period) for period in periods])
        passed = used <= ROOM
        best = min(best, float(periods[passed].min(initial=np.inf)))
        if generation < options.generations:
            genes = genetic.breed(genes, np.where(passed, periods, 1e3 * high * (1.0 + used)), breeding_of(options))
    return best


def rest_period(path: Path, followed: Trajectory, ends: tuple[float, float, float, float], options: Genetic) -> float:
    """The shortest period found of the interval to the next reference point, by the planner's own algorithm.

    `ends`: speed and acceleration of s at both.
    """
    machine = followed.axis_path.machine
    assert machine is not None
    run = AxisPath.follow(path, machine).runs[0]
    parts = Intervals(run, followed.limits, np.array([run.s0, run.s1]), (False, False))
    whole = Interval(parts.x, parts.share, parts.pace)
    begin, _, _ = comfortable(interval_of(whole, 0), np.array(ends), options.reserve)
    speeds = Preset(np.array(ends[0::2]), np.array(ends[1::2]), np.array([begin]))
    return float(with_bred_periods(parts, speeds, options).periods[0])
