"""Replans from random states and deflections: is a way back always found, within all limits, joined, and quick?

    python -m testbed.replans [count] [seed]

Feeds from 10 to 20 000 mm/min, sizes from 1 micrometre to 10 mm, any direction, any instant (the ends and the ramps
more often), both causes and all planners, on the paper's arc, a line, corners, a spline, and splines of five axes.
Judged from positions alone: third, second and first differences over the instant of leaving, the way back and the
rejoining (a divided difference never passes the derivative, and one over a jump of velocity or acceleration passes the
jerk limit by far), the tip by kinematics of its own (testbed/true_tip/chain.py). Prints the table of the documentation.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np

import toolpace as tp
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.chain import Chain
from toolpace.common.errors import InfeasibleError

FEEDS = (10.0, 60.0, 180.0, 600.0, 1800.0, 6000.0, 20000.0)
"""[mm/min]"""
SIZES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
"""Ends of the classes of sizes in the table [m]."""
KINDS = ("arc", "line", "corners", "spline", "five 1", "five 2")
PLANNERS = ("optimal", "direct", "genetic")
CAUSES = ("displaced", "bending")
PASSED = 1.0002
"""Use of a limit by differences that counts as passed: what is promised, and rounding."""
OFF_PATH = 1e-7
"""Distance of the tip from the path after the rejoining that counts as off it: the sag of the chords it is held to
[m]."""
STARTS = 800
SLOW = 1.0
"""Time of computing that is told [s]."""


@dataclass
class Case:
    """A deflection, and what came of it."""

    kind: str
    feed: float
    cause: str
    planner: str
    size: float
    time: float
    refused: str = ""
    seconds: float = 0.0
    lost: float = 0.0
    used: float = 0.0
    fed: float = 0.0
    off: float = 0.0

    @property
    def faults(self) -> list[str]:
        """What is wrong with it, in words."""
        wrong = [self.refused] if self.refused else []
        wrong += [f"limits {self.used:.6f}"] if self.used > PASSED else []
        wrong += [f"feed {self.fed:.6f}"] if self.fed > PASSED else []
        return wrong + ([f"off the path by {self.off:.3g} m"] if self.off > OFF_PATH else [])

    def told(self) -> str:
        """In one line."""
        return (
            f"{self.kind}, F{self.feed:g}, {self.cause}, {self.planner}, {self.size:.3g} m at {self.time:.6g} s:"
            f" {'; '.join(self.faults)}, {self.seconds:.2f} s"
        )


def machine_of(kind: str) -> tp.Machine:
    """The machine of a kind of path."""
    return tp.Machine.load("paper-ab" if kind == "arc" else "xyzbc-head")


@cache
def chain_of(kind: str) -> Chain:
    """Kinematics of its own."""
    return Chain((BUILTIN / f"{machine_of(kind).name}.toml").read_text())


@cache
def planned(kind: str, feed: float) -> tp.Trajectory:
    """The plan of a kind of path at a feed [mm/min]."""
    speed = feed / 60e3
    machine = machine_of(kind)
    if kind == "arc":
        path = tp.Path.paper_arc()
        run = path.runs[0]
        path = replace(path, runs=(replace(run, feed=np.full_like(run.feed, speed)),))
    elif kind == "corners":
        places = ["X10 Y10", "X30 Y10", "X30 Y30 Z5", "X10 Y35 Z5", "X12 Y10"]
        text = "G21 G90 G61 G54\n" + "".join(f"G1 {place} F{feed:g}\n" for place in places) + "M30\n"
        path = tp.Path.fit(tp.read_text(text, machine), machine=machine)
    elif kind == "line":
        path = spline(np.linspace([0.1, 0.1, 0.1], [0.16, 0.1, 0.1], 4), 0.0, speed)
    else:
        random = np.random.default_rng(int(kind[-1]) if kind[-1].isdigit() else 3)
        points = np.cumsum(random.uniform(-0.5, 1.0, (8, 3)) * 0.02, axis=0) + np.array([0.05, 0.05, 0.1])
        path = spline(points, 0.0 if kind == "spline" else random.uniform(-0.4, 0.4, (8, 2)), speed)
    return tp.plan(path, machine, bound=False)


def spline(points: np.ndarray, leans: np.ndarray | float, speed: float) -> tp.Path:
    """A cubic B-spline of points (n, 3) [m], with the tool axis leaning."""
    n = len(points)
    knots = np.r_[np.zeros(3), np.linspace(0.0, 1.0, n - 2), np.ones(3)]
    axes = np.ones((n, 3))
    axes[:, :2] = np.reshape(leans, (-1, 2)) + 0.3 if np.ndim(leans) == 2 else 0.0
    return tp.Path.from_bspline(knots, points, points + 0.1 * axes, 3, speed)


def drawn(random: np.random.Generator) -> tuple[Case, np.ndarray]:
    """A case, and the direction of its deflection."""
    kind, feed = str(random.choice(KINDS)), float(random.choice(FEEDS))
    duration = planned(kind, feed).duration
    share = float(random.choice([random.uniform(), random.choice([0.0, 1.0, 1e-4, 1e-3, 1e-2, 0.99, 0.999, 0.9999])]))
    way = random.normal(size=3)
    case = Case(
        kind, feed, str(random.choice(CAUSES)), str(random.choice(PLANNERS)),
        float(10.0 ** random.uniform(-6.0, -2.0)), share * duration,
    )  # fmt: skip
    return case, way / np.linalg.norm(way)


def tried(case: Case, way: np.ndarray) -> Case:
    """The case with what came of it."""
    old, machine, chain = planned(case.kind, case.feed), machine_of(case.kind), chain_of(case.kind)
    q = old.at([case.time]).q
    tip = chain.forward(q, chain.own_length)[0][0] + case.size * way
    began = time.process_time()
    try:
        new = tp.replan(
            old, case.time, tip, machine, cause=case.cause, planner=case.planner, most=2.0 * SIZES[-1]
        )
    except InfeasibleError as error:
        case.seconds = time.process_time() - began
        case.refused = f"refused: {error}"
        return case
    case.seconds = time.process_time() - began
    case.lost = new.duration - (old.duration - case.time)
    judge(case, old, new, case.size * way, chain)
    return case


def judge(case: Case, old: tp.Trajectory, new: tp.Trajectory, found: np.ndarray, chain: Chain) -> None:
    """What a replan uses, from positions alone, to the case; `found` (3,) is the deflection [m]."""
    detour = getattr(new.axis_path.runs[0], "detour", None)
    whole = new.duration if detour is None else detour.duration
    above = 0.0 if detour is None else new.axis_path.runs[0].above[1]
    offset = new.at([0.0]).q[0] - old.at([case.time]).q[0]
    limits = (new.limits.velocity, new.limits.acceleration, new.limits.jerk)
    bending = found if case.cause == "bending" else np.zeros(3)
    for step in (2e-4, 1e-3, 5e-3):
        starts = np.unique(np.r_[np.linspace(-3.0, 3.0, 25) * step, np.linspace(-3 * step, 1.2 * whole, STARTS)])
        starts = np.concatenate([starts, whole + np.linspace(-4.0, 2.0, 25) * step])
        q = np.stack([joints(old, new, case.time, offset, starts + k * step) for k in range(4)])
        noise = 16.0 * np.finfo(float).eps * (1.0 + np.abs(q).max(axis=(0, 1)))
        for order, limit in enumerate(limits, start=1):
            change = np.diff(q, order, axis=0)[0]
            used = np.maximum(np.abs(change) - 2.0**order * noise, 0.0) / step**order / limit
            case.used = max(case.used, float(used.max()))
        after = starts[starts >= above]
        ends = [
            chain.forward(joints(old, new, case.time, offset, after + k * step), chain.own_length)[0] for k in range(2)
        ]
        speed = (np.linalg.norm(ends[1] - ends[0], axis=1) - 1e-15) / step
        case.fed = max(case.fed, float(speed.max() / (case.feed / 60e3)))
    later = np.linspace(whole, new.duration, 30)
    tips = chain.forward(new.at(later).q, chain.own_length)[0] + bending
    clock = np.linspace(0.0, old.duration, 6000)
    case.off = from_chords(tips, chain.forward(old.at(clock).q, chain.own_length)[0])


def joints(old: tp.Trajectory, new: tp.Trajectory, time: float, offset: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n, m) at times (n,) since the leaving: before it those of the old motion, moved to where they were found."""
    before = old.at(time + np.minimum(t, 0.0)).q + offset
    return np.where((t < 0.0)[:, None], before, new.at(np.maximum(t, 0.0)).q)


def from_chords(points: np.ndarray, way: np.ndarray) -> float:
    """The largest distance of points (n, 3) from the chords between places (k, 3)."""
    worst = 0.0
    a, along = way[:-1], np.diff(way, axis=0)
    square = np.maximum(np.einsum("kd,kd->k", along, along), 1e-300)
    for point in points:
        share = np.clip(np.einsum("kd,kd->k", point - a, along) / square, 0.0, 1.0)
        worst = max(worst, float(np.linalg.norm(a + share[:, None] * along - point, axis=1).min()))
    return worst


def sweep(count: int, seed: int) -> list[Case]:
    """Random cases, each tried."""
    random = np.random.default_rng(seed)
    return [tried(*drawn(random)) for _ in range(count)]


def table(cases: list[Case]) -> str:
    """Median and worst of the time lost and of the time computed, by feed and size."""
    lines = ["| feed, mm/min | " + " | ".join(f"to {1e3 * size:g} mm" for size in SIZES[1:]) + " |"]
    lines.append("|---" * len(SIZES) + "|")
    for feed in FEEDS:
        row = [f"{feed:g}"]
        for low, high in pairwise(SIZES):
            here = [case for case in cases if case.feed == feed and low <= case.size < high and not case.refused]
            both = ([case.lost for case in here], [case.seconds for case in here])
            row.append(
                "; ".join(f"{np.median(each):.3f}, {max(each):.3f}" for each in both) if here else "none"
            )
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines)


def told(cases: list[Case]) -> str:
    """What is wrong, the worst figures, and the table."""
    seconds = [case.seconds for case in cases]
    lines = [case.told() for case in cases if case.faults or case.seconds > SLOW]
    lines.append(
        f"{len(cases)} cases, refused {sum(bool(case.refused) for case in cases)}; limits at most"
        f" {max(case.used for case in cases):.6f}, feed {max(case.fed for case in cases):.6f}, off the path"
        f" {1e6 * max(case.off for case in cases):.3g} um; computed in {np.median(seconds):.3f} s in the median,"
        f" {np.quantile(seconds, 0.99):.3f} s of 99 percent, {max(seconds):.3f} s at worst"
    )
    return "\n".join([*lines, table(cases)])


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]]
    print(told(sweep(*{0: (200, 1), 1: (*given, 1)}.get(len(given), given[:2]))))
