"""The computation of the study: the paper's arc, plans with and without deflection, projections, backward motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from toolpace import deflection
from toolpace.common.arrays import Floats
from toolpace.deflection.detour import DetourRun
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_through
from toolpace.path.path import Path
from toolpace.planning.genetic import Genetic, Intervals, preset, reference_points, with_bred_periods
from toolpace.planning.planned_run import AT_REST
from toolpace.planning.planner import plan
from toolpace.study.literal import LiteralWay, literal_way

FEED = 0.03
"""F of Eq. (11) [m/s]."""
RADIUS = 0.1
"""Of the arc [m]."""
INTERVALS = 31
"""Of the path, as in the paper."""
DEFLECTION = (0.059, 0.0568, 0.0589)
"""Where the tip is found [m]."""
PRINTED_PROJECTION = (0.058, 0.058, 0.0571)
"""[m]"""
DEFLECTED_INTERVAL = 20
"""These as section III has them."""
GENERATIONS = (1, 10, 100)
"""The paper's, and ten and a hundred times as many, to see what they find."""
OPTIONS = Genetic()
"""The genetic algorithm's: population, seed and the rest as `Genetic` documents them."""
SEEDS = tuple(range(OPTIONS.seed, OPTIONS.seed + 10))
"""The first is that of every figure; what the others find shows how much is luck."""
CLOSED_FORM = 5.3112
"""Optimum rest to rest: L / F + 2 sqrt(F / J), J = 21.2 m/s^3 the tip's jerk where B's limit binds [s]."""
SAMPLES = 4001
"""Times that are looked at: of a way back of half a second one every eighth of a millisecond, in which the tip moves by
0.004 mm; near a place of return by its square."""


@dataclass(frozen=True)
class Study:
    """All results; `with_deflection` starts at the instant of the deflection."""

    machine: Machine
    path: Path
    genetic: dict[int, Trajectory]
    """Without deflection, by number of generations."""
    optimal: Trajectory
    interval: deflection.Projection
    """Projection on the 20th interval: the paper's."""
    whole: deflection.Projection
    """Projection on the whole path."""
    instant: dict[str, float]
    """When each planner's tool passes the beginning of the 20th interval, where it is found deflected [s]."""
    with_deflection: dict[str, Trajectory]
    """genetic: by way of the projection, as in the paper; optimal: the fastest way back."""
    by_seed: dict[int, Floats]
    """(10,) durations without deflection of all seeds, by number of generations [s]."""
    literal: dict[str, LiteralWay]
    """The paper's way back to the letter: "acceleration" with the reference's acceleration at both ends of the first
    interval, "jerk" with the same jerk at both, which takes an acceleration of zero."""

    @property
    def points(self) -> Floats:
        """(32,) parameters of the reference points, s [m]."""
        return self.path.runs[0].breaks

    @property
    def feed_bound(self) -> float:
        """Length over feed [s]: no motion is faster."""
        return 0.5 * np.pi * RADIUS / FEED

    def pairs(self) -> dict[str, tuple[Trajectory, Trajectory]]:
        """By planner the trajectories without and with deflection."""
        without = {"genetic": self.genetic[GENERATIONS[0]], "optimal": self.optimal}
        return {name: (without[name], self.with_deflection[name]) for name in without}

    @property
    def next_point(self) -> float:
        """When the genetic plan without deflection passes the reference point behind the deflected interval [s]."""
        law = self.genetic[GENERATIONS[0]].laws[0]
        return law.passing_time(float(self.points[DEFLECTED_INTERVAL]))

    def remaining(self) -> dict[str, float]:
        """Time from the deflection to the end, by way back [s]."""
        rest = self.genetic[GENERATIONS[0]].duration - self.next_point
        literal = {f"literal_{name}": way.trajectory.duration + rest for name, way in self.literal.items()}
        return literal | {name: after.duration for name, after in self.with_deflection.items()}

    def ways(self) -> dict[str, tuple[Trajectory, float]]:
        """The trajectory from the deflection, and how long it takes back onto the path [s], by way back."""
        letter = {f"literal_{name}": (way.trajectory, float(way.periods[0])) for name, way in self.literal.items()}
        ours = {
            name: (after, after.laws[0].passing_time(detour_run(after).join))
            for name, after in self.with_deflection.items()
        }
        return letter | ours

    def backwards(self) -> dict[str, Backwards]:
        """What is gone backwards, by way back."""
        return {name: gone_back(way, duration, RADIUS) for name, (way, duration) in self.ways().items()}

    def facts(self) -> dict[str, object]:
        """The figures of study.json."""
        peak = {
            name: {"without_deflection": usage_facts(a), "with_deflection": usage_facts(b)}
            for name, (a, b) in self.pairs().items()
        }
        return {
            "projection_interval20_m": list(map(float, self.interval.tip)),
            "projection_path_m": list(map(float, self.whole.tip)),
            "distance_interval20_m": self.interval.distance,
            "distance_path_m": self.whole.distance,
            "duration_genetic_s": {str(n): t.duration for n, t in self.genetic.items()},
            "genetic": {"population": OPTIONS.population, "seed": OPTIONS.seed, "seeds": list(SEEDS)},
            "duration_by_seed_s": {str(n): list(map(float, found)) for n, found in self.by_seed.items()},
            "duration_optimal_s": self.optimal.duration,
            "duration_closed_form_s": CLOSED_FORM,
            "lower_bound_feed_s": self.feed_bound,
            "lower_bound_s": self.optimal.lower_bound or None,
            "peak_usage": peak,
            "periods_s": {
                **{f"genetic_{n}": list(map(float, periods(self, t))) for n, t in self.genetic.items()},
                "optimal": list(map(float, periods(self, self.optimal))),
            },
            "deflection": {
                name: {
                    "instant_s": self.instant[name],
                    "remaining_s": b.duration,
                    "remaining_without_s": a.duration - self.instant[name],
                    "detour_s": self.ways()[name][1],
                }
                for name, (a, b) in self.pairs().items()
            },
            "to_the_letter": {
                name: {
                    "periods_s": list(map(float, way.periods)),
                    "peak_usage": usage_facts(way.trajectory),
                    "jump_of_velocity": list(map(float, way.jump[0])),
                    "jump_of_acceleration": list(map(float, way.jump[1])),
                }
                for name, way in self.literal.items()
            },
            "remaining_s": self.remaining(),
            "gone_back": {
                name: {"tip_m": back.tip, "joints": list(map(float, back.joints))}
                for name, back in self.backwards().items()
            },
        }


def detour_run(trajectory: Trajectory) -> DetourRun:
    """The way back with which a trajectory after a deflection begins."""
    run = trajectory.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    return run


def usage_facts(trajectory: Trajectory) -> dict[str, object]:
    """Peak value over limit, the worst first."""
    peak = trajectory.usage()
    return {
        "worst": peak.worst, "feed": peak.feed, "velocity": peak.velocity,
        "acceleration": peak.acceleration, "jerk": peak.jerk,
    }  # fmt: skip


def periods(study: Study, trajectory: Trajectory) -> Floats:
    """(31,) time in each interval, T_i [s]."""
    passed = [trajectory.laws[0].passing_time(float(s)) for s in study.points]
    return np.diff(passed)


def durations_by_seed(axis_path: AxisPath, machine: Machine, options: Genetic) -> Floats:
    """(10,) durations that the genetic planner finds with each of the seeds [s]; the preset speeds know no seed."""
    run = axis_path.runs[0]
    parts = Intervals(run, machine.limits, reference_points(run, options.intervals), (True, True))
    speeds = preset(parts, AT_REST, AT_REST, options.reserve)
    return np.array([with_bred_periods(parts, speeds, replace(options, seed=seed)).periods.sum() for seed in SEEDS])


def simulate(progress: Callable[[float], None]) -> Study:
    """Compute the study; a few seconds."""
    machine = Machine.load("paper-ab")
    path = quintic_through(Path.paper_arc(FEED), machine, INTERVALS)
    axis_path = AxisPath.follow(path, machine)
    progress(0.05)
    genetic, by_seed = {}, {}
    for k, count in enumerate(GENERATIONS):
        options = replace(OPTIONS, generations=count)
        genetic[count] = plan(axis_path, machine, planner=options)
        by_seed[count] = durations_by_seed(axis_path, machine, options)
        progress(0.1 + 0.15 * (k + 1))
    optimal = plan(axis_path, machine)
    progress(0.8)
    points = path.runs[0].breaks
    where = (float(points[DEFLECTED_INTERVAL - 1]), float(points[DEFLECTED_INTERVAL]))
    interval = deflection.project(path, DEFLECTION, interval=where)
    whole = deflection.project(path, DEFLECTION)
    first = genetic[GENERATIONS[0]]
    instant = {
        "genetic": first.laws[0].passing_time(where[0]),
        "optimal": optimal.laws[0].passing_time(where[0]),
    }
    back = {
        "genetic": deflection.replan(
            first, instant["genetic"], DEFLECTION, machine, planner=OPTIONS, rejoin="projection", interval=where
        ),
        "optimal": deflection.replan(optimal, instant["optimal"], DEFLECTION, machine),
    }
    literal = {
        name: literal_way(
            first, path, machine, np.array(DEFLECTION), interval.s, where[1], same_jerk=name == "jerk", options=OPTIONS
        )
        for name in ("acceleration", "jerk")
    }
    progress(1.0)
    return Study(machine, path, genetic, optimal, interval, whole, instant, back, by_seed, literal)


@dataclass(frozen=True)
class Backwards:
    """What is gone backwards between the deflection and the rejoining."""

    tip: float
    """Of the nearest point of the arc [m]."""
    joints: Floats
    """(m,) of each joint [m or rad]."""


def along_arc(tip: Floats, radius: float) -> Floats:
    """(n,) length of the paper's arc up to its nearest point to each tip (n, 3), in closed form [m]."""
    length: Floats = radius * np.arctan2((tip[:, 0] + tip[:, 1]) / np.sqrt(2.0), tip[:, 2])
    return length


def most_gone_back(values: Floats) -> Floats:
    """(m,) most by which values (n, m) fall behind what they had reached."""
    behind: Floats = (np.maximum.accumulate(values, axis=0) - values).max(axis=0)
    return behind


def gone_back(way: Trajectory, duration: float, radius: float) -> Backwards:
    """That of the first `duration` [s] of a trajectory; a joint's direction is the one it starts with."""
    t = np.linspace(0.0, duration, SAMPLES)
    motion = way.at(t)
    forward = np.sign(motion.qd[0])
    tip = along_arc(way.tip(t)[0], radius)
    return Backwards(float(most_gone_back(tip[:, None])[0]), most_gone_back(motion.q * forward))
