"""Random deflections on the study, the flank, the fan and the demo: is every replan within all limits, and quick?

    python -m benchmarks.deflections [count] [seed] [repeats]

Deflections of the tip by 0.01 to 5 mm in any direction and of the tool axis by up to 2 degrees ("displaced"), and bent
tools by 0.01 to 1 mm ("bending"), at random instants. Judged from positions alone: differences of `at()` within the
limits (testbed/from_positions.py), the tip against the feed of the nearest point of the path; the time to the rejoining
against the shortest that ruckig finds, without feed and travel, from the same state to any state of the motion.
`repeats` replans in a row, a millisecond apart, each from the one before. Writes benchmarks/results/deflections.json.
"""

from __future__ import annotations

import datetime
import json
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import ruckig

import toolpace as tp
from benchmarks.machine import RESULTS, processor
from testbed import from_positions, published
from toolpace import deflection
from toolpace.cli.demo_programs import impeller_program
from toolpace.common.errors import InfeasibleError
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.motion_state import Stretch
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.laws import ChainLaw, LawPiece
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_through
from toolpace.path.path import Path
from toolpace.planning.planner import plan

CAUSES = ("displaced", "bending")
PLACES = 60
"""States of the motion that ruckig is asked for the way to."""
STARTS = 1500
"""Third differences of positions that are looked at."""


def demo() -> tuple[Path, Machine]:
    """The program of the demo, fitted."""
    machine = Machine.load("xyzac-trunnion")
    return tp.Path.fit(tp.read_text(impeller_program(machine), machine), machine=machine), machine


CASES: dict[str, Callable[[], tuple[Path, Machine]]] = {
    "study": lambda: (quintic_through(Path.paper_arc(), Machine.load("paper-ab")), Machine.load("paper-ab")),
    "flank": published.flank,
    "fan": published.fan,
    "demo": demo,
}


def cases() -> dict[str, tuple[Path, Machine]]:
    """Those that papers print."""
    return {name: made() for name, made in CASES.items() if name != "demo"}


@dataclass
class Row:
    """What came of the deflections of one path and cause."""

    path: str
    cause: str
    figures: dict[str, list[float]] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def add(self, **figures: float) -> None:
        for name, value in figures.items():
            self.figures.setdefault(name, []).append(value)

    def told(self) -> dict[str, object]:
        told: dict[str, object] = {"path": self.path, "cause": self.cause, "replans": len(self.figures["replan_ms"])}
        for name, values in self.figures.items():
            told[name] = {"median": float(np.nanmedian(values)), "worst": float(np.nanmax(values))}
        return told | {"refused": self.refused, "faults": self.faults}


def draw(old: Trajectory, cause: str, random: np.random.Generator) -> tuple[float, np.ndarray, np.ndarray | None]:
    """An instant, where the tip is measured, and the tool axis."""
    t = float(random.uniform(0.0, old.duration))
    tip, axis = (value[0] for value in old.tip([t]))
    way = random.normal(size=3)
    most = 5e-3 if cause == "displaced" else 1e-3
    tip = tip + 10.0 ** random.uniform(-5.0, np.log10(most)) * way / np.linalg.norm(way)
    turn = np.cross(axis, random.normal(size=3))
    angle = np.radians(random.uniform(0.0, 2.0))
    turned = np.cos(angle) * axis + np.sin(angle) * turn / np.linalg.norm(turn)
    return t, tip, turned if cause == "displaced" else None


def stretch_of(new: Trajectory, seconds: float) -> Trajectory:
    """The first seconds of a motion, within its first run."""
    run, law = new.axis_path.runs[0], new.laws[0]
    end = min(seconds, law.duration)
    s = float(law.at(np.array([end]))[0, 0])
    path = AxisPath((Stretch(run, s),), new.joints, new.axis_path.machine)
    return Trajectory(path, new.limits, (ChainLaw([LawPiece(law, 0.0, end)]),))


def shortest(old: Trajectory, new: Trajectory, limits: Limits) -> float:
    """Time of the shortest way from the start to a state of the motion that is rejoined, without feed and travel."""
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    detour = run.detour
    m = len(limits)
    clock = detour.left + detour.duration * np.linspace(-0.3, 1.7, PLACES)
    clock = np.unique(np.clip(np.append(clock, detour.commanded.law.duration), 0.0, detour.commanded.law.duration))
    states = detour.commanded.motion(clock)
    otg, given, answer = ruckig.Ruckig(m), ruckig.InputParameter(m), ruckig.Trajectory(m)
    # a start may use what a plan may
    for name, limit in (("velocity", limits.velocity), ("acceleration", limits.acceleration), ("jerk", limits.jerk)):
        setattr(given, f"max_{name}", np.minimum(1.0001 * limit, 1e6).tolist())
    given.current_position, given.current_velocity, given.current_acceleration = detour.motion(np.zeros(1))[
        :3, 0
    ].tolist()
    least = np.inf
    for k in range(len(clock)):
        given.target_position, given.target_velocity, given.target_acceleration = states[:3, k].tolist()
        if otg.calculate(given, answer) in (ruckig.Result.Working, ruckig.Result.Finished):
            least = min(least, answer.duration)
    return least


def tip_over_feed(old: Trajectory, new: Trajectory, after: float) -> float:
    """Largest speed of the tip over the feed of the nearest point of the path, on the detour after a time."""
    run, base = new.axis_path.runs[0], old.axis_path.runs
    assert isinstance(run, DetourRun)
    followed = run.rest_of
    plain = followed.base if hasattr(followed, "base") else followed
    assert any(plain is each for each in base)
    t = np.linspace(after, run.detour.duration, 400)[:-1]
    ends = [new.tip(t + d) for d in (0.0, 1e-6)]
    speed = np.linalg.norm(ends[1][0] - ends[0][0], axis=1) / 1e-6
    places = run.detour.commanded.place(
        run.detour.left + (run.detour.rejoin - run.detour.left) * np.linspace(-0.5, 1.5, 2000)
    )
    way = plain.run.evaluate(places).tip[0]
    tips = ends[0][0] - (followed.compensation.offset if hasattr(followed, "compensation") else 0.0)
    nearest = np.argmin(np.linalg.norm(tips[:, None] - way[None], axis=2), axis=1)
    return float((speed / plain.run.feed[plain.run.block_index(places[nearest])]).max(initial=0.0))


def judge(old: Trajectory, new: Trajectory, time_: float, given: np.ndarray, cause: str, row: Row) -> None:
    """Figures and faults of one replan."""
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    machine, detour = new.axis_path.machine, run.detour
    assert machine is not None
    share, until = run.above
    used = from_positions.used_by_positions(stretch_of(new, 1.2 * detour.duration))[1:].max()
    row.add(
        used_by_positions=used, feed_after_the_start=tip_over_feed(old, new, min(until, detour.duration)),
        start_above_feed=share, above_until_ms=1e3 * until, rejoin_ms=1e3 * detour.duration, lost_ms=1e3 * detour.lost,
        over_shortest=detour.duration / shortest(old, new, old.limits),
    )  # fmt: skip
    before, after = old.at(time_), new.at(0.0)
    found = []
    if used > 1.0001:
        found.append(f"positions use {used:.6f}")
    tip = machine.forward(after.q[None])[0][0]
    starts = np.linalg.norm(tip - given) if cause == "displaced" else np.abs(after.q - before.q).max()
    if starts > 1e-9:
        found.append(f"starts {starts:.3g} off")
    t = np.linspace(detour.duration, new.laws[0].duration, 30)
    there = machine.forward(new.at(t).q)[0]
    wanted = old.axis_path.runs[moment(old, time_)].evaluate(new.parameter(t))[0]
    aimed = machine.forward(wanted)[0] - (given - machine.forward(before.q[None])[0][0]) * (cause == "bending")
    error = float(np.linalg.norm(there - aimed, axis=1).max())
    row.add(error_after_um=1e6 * error)
    if error > 1e-8:
        found.append(f"{1e6 * error:.3g} um off after the rejoining")
    if found:
        row.faults.append(f"t = {time_!r}: {'; '.join(found)}")


def moment(old: Trajectory, t: float) -> int:
    """The run at a time."""
    return int(np.clip(np.searchsorted(old.starts, t, side="right") - 1, 0, len(old.laws) - 1))


def in_a_row(old: Trajectory, repeats: int, random: np.random.Generator) -> dict[str, object]:
    """Replans a millisecond apart, each from the one before, with deflections of 2 micrometres."""
    step, spent, current = 1e-3, [], old
    for k in range(repeats):
        if current.duration < 2.0 * step:
            break
        given = current.tip([step])[0][0] + 2e-6 * random.normal(size=3)
        began = time.process_time()
        current = deflection.replan(current, step, given)
        spent.append(1e3 * (time.process_time() - began))
        if k % 1000 == 0:
            print(k, f"{np.median(spent[-1000:]):.3g} ms", flush=True)
    tenth = max(len(spent) // 10, 1)
    return {
        "replans": len(spent), "median_ms": float(np.median(spent)), "worst_ms": max(spent),
        "median_of_the_first_tenth_ms": float(np.median(spent[:tenth])),
        "median_of_the_last_tenth_ms": float(np.median(spent[-tenth:])),
        "lost_us_each": 1e6 * (current.duration - (old.duration - len(spent) * step)) / len(spent),
    }  # fmt: skip


def main(count: int = 1000, seed: int = 2026, repeats: int = 10000) -> None:
    """Run, print and write the results."""
    from_positions.STARTS = STARTS
    random = np.random.default_rng(seed)
    rows, of_all, row_of = [], Row("all", "both"), {}
    for name, made in CASES.items():
        old = plan(*made(), bound=False)
        for cause in CAUSES:
            row = row_of[name, cause] = Row(name, cause)
            for _ in range(count // (len(CASES) * len(CAUSES))):
                t, given, axis = draw(old, cause, random)
                began = time.process_time()
                try:
                    new = deflection.replan(old, t, given, axis=axis, cause=cause)
                except InfeasibleError as error:
                    row.refused.append(str(error))
                    continue
                row.add(replan_ms=1e3 * (time.process_time() - began))
                judge(old, new, t, given, cause, row)
            for figure, values in row.figures.items():
                of_all.figures.setdefault(figure, []).extend(values)
            of_all.refused += row.refused
            of_all.faults += row.faults
            rows.append(row.told())
            print(rows[-1], flush=True)
    rows.append(of_all.told())
    result = {
        "toolpace": tp.__version__, "python": platform.python_version(), "ruckig": ruckig.__version__,
        "machine": f"{platform.machine()}, {processor()}", "seed": seed,
        "date": datetime.date.today().isoformat(), "rows": rows,
    }  # fmt: skip
    out = RESULTS / "deflections.json"
    out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    if repeats:
        result["in_a_row"] = in_a_row(old, repeats, random)
        out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(out)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
