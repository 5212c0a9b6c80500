"""Random deflections on the study, the flank and the fan: does every replan come back to the path within all limits?

    python -m benchmarks.deflections [count] [seed]

Deflections of the tip by 0.01 to 5 mm in any direction and of the tool axis by up to 2 degrees, at random instants.
Prints a table and writes benchmarks/results/deflections.json.
"""

from __future__ import annotations

import json
import platform
import sys
import time
from dataclasses import dataclass

import numpy as np

import toolpace
from benchmarks.machine import RESULTS, processor
from testbed import published
from toolpace import deflect
from toolpace.axispath.quintic import quintic_through
from toolpace.deflect.detour import DetourRun
from toolpace.deflect.feed import tip_velocity
from toolpace.errors import InfeasibleError
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.planning.planner import plan
from toolpace.trajectory import Trajectory

PLANNERS = ("optimal", "genetic")


def cases() -> dict[str, tuple[Path, Machine]]:
    """The paths, each with its machine."""
    machine = Machine.load("paper-ab")
    return {
        "study": (quintic_through(Path.paper_arc(), machine), machine),
        "flank": published.flank(),
        "fan": published.fan(),
    }


@dataclass(frozen=True)
class Draw:
    """One deflection."""

    time: float
    tip: np.ndarray
    axis: np.ndarray


def draw(trajectory: Trajectory, random: np.random.Generator) -> Draw:
    """A deflection by 0.01 to 5 mm (evenly in the logarithm) and up to 2 degrees at a random instant."""
    t = float(random.uniform(0.0, trajectory.duration))
    tip, axis = (value[0] for value in trajectory.tip([t]))
    way = random.normal(size=3)
    tip = tip + 10.0 ** random.uniform(-5.0, np.log10(5e-3)) * way / np.linalg.norm(way)
    turn = np.cross(axis, random.normal(size=3))
    angle = np.radians(random.uniform(0.0, 2.0))
    return Draw(t, tip, np.cos(angle) * axis + np.sin(angle) * turn / np.linalg.norm(turn))


def faults(old: Trajectory, new: Trajectory, given: Draw) -> list[str]:
    """What is wrong with a replan; nothing if it starts as deflected, rejoins the path and keeps to the limits."""
    found = []
    usage = new.usage().worst
    if usage > 1.0001:
        found.append(f"usage {usage:.6f}")
    before, after = old.at([given.time]), new.at([0.0])
    machine = new.axis_path.machine
    assert machine is not None
    tip, axis = machine.forward(after.q)
    if np.linalg.norm(tip[0] - given.tip) > 1e-9 or np.linalg.norm(axis[0] - given.axis) > 1e-9:
        found.append("does not start at the deflection")
    for kind, limit in (("qd", old.limits.velocity), ("qdd", old.limits.acceleration)):
        scale = np.where(np.isfinite(limit), limit, 1.0)
        if (np.abs(getattr(before, kind) - getattr(after, kind)) > 1e-6 * scale).any():
            found.append(f"{kind} jumps")
    end = old.at([old.duration]).q[0]
    if np.abs(new.at([new.duration]).q[0] - end).max() > 1e-9:
        found.append("does not end where the path ends")
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    if not run.ends_here:
        s = np.linspace(run.join, run.s1, 50)
        if np.abs(run.evaluate(s)[0] - old.axis_path.runs[0].evaluate(s)[0]).max() > 1e-12:
            found.append("leaves the path again")
    return found


def overspeed(run: DetourRun, new: Trajectory) -> float:
    """Most by which the tip passes the feed on the way back, relative to the feed."""
    if not np.isfinite(run.excess.feed):
        return 0.0
    motion = new.at(np.linspace(0.0, run.detour.duration, 500))
    assert run.machine is not None
    speed = np.linalg.norm(tip_velocity(run.machine, motion.q, motion.qd), axis=1)
    return max(float(speed.max()) / run.excess.feed - 1.0, 0.0)


def main(count: int = 1000, seed: int = 2009) -> None:
    """Run, print and write the results."""
    random = np.random.default_rng(seed)
    rows = []
    for name, (path, machine) in cases().items():
        share = count // 3 + (1 if name == "study" and count % 3 else 0)
        for planner in PLANNERS:
            old = plan(path, machine, planner=planner)
            usages, rejoin, losses, seconds, excess, refused, faulty = [], [], [], [], [], [], []
            carried = stopped = 0
            for _ in range(share):
                given = draw(old, random)
                began = time.perf_counter()
                try:
                    new = deflect.replan(old, given.time, given.tip, axis=given.axis, planner=planner)
                except InfeasibleError as error:
                    refused.append(str(error))
                    continue
                seconds.append(time.perf_counter() - began)
                run = new.axis_path.runs[0]
                assert isinstance(run, DetourRun)
                found = faults(old, new, given)
                if found:
                    faulty.append(f"t = {given.time!r}: {'; '.join(found)}")
                usages.append(new.usage().worst)
                rejoin.append(run.detour.duration)
                losses.append(new.duration - (old.duration - given.time))
                excess.append(overspeed(run, new))
                carried += run.detour.carry > 0.0
                stopped += run.ends_here
            rows.append(
                {
                    "path": name, "planner": planner, "deflections": share, "refused": len(refused),
                    "faulty": len(faulty), "worst_usage": max(usages),
                    "median_rejoin_s": float(np.median(rejoin)), "worst_rejoin_s": max(rejoin),
                    "median_loss_s": float(np.median(losses)), "worst_loss_s": max(losses),
                    "median_replan_s": float(np.median(seconds)), "worst_replan_s": max(seconds),
                    "worst_feed_excess": max(excess), "carried_on_first": carried,
                    "rejoined_at_the_stop": stopped, "reasons": refused[:5], "faults": faulty[:5],
                }
            )  # fmt: skip
            print(rows[-1], flush=True)
    result = {
        "toolpace": toolpace.__version__, "python": platform.python_version(),
        "machine": f"{platform.machine()}, {processor()}", "seed": seed, "rows": rows,
    }  # fmt: skip
    out = RESULTS / "deflections.json"
    out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(out)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
