"""A program with tools of several lengths, followed while its tools bend; where its real tip is, by own kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import toolpace as tp
from testbed.true_tip.cases import Case, Maker
from toolpace.deflection.following import Follower, Measurement, Status
from toolpace.programs.reading.setup_file import setup_of_text

SETTLED = 0.3
"""Time after the begin of a cut from which on the tip is to be where the program has it [s]."""
LAG, PERIOD = 2, 4e-3
"""Set-points by which the machine is behind, and the time from one to the next [s]."""


@dataclass
class Followed:
    """The worst over the cuts of a run."""

    tip: float
    """Distance of the real tip, bent and corrected, from where the plan has it [m]."""
    said: Status
    """All that was said in a cut."""
    feed: float
    """Largest speed of the real tip, not bent, over F."""
    limits: float
    """Largest share of a limit of a joint, by differences of set-points."""


def planned(seed: int, machine: str, mode: str, lengths: list[float], points: int = 20):
    """A case, its motion with a reserve of a tenth, and the machine with the part where it is clamped."""
    case, _, path, reserved, on = fitted(seed, machine, mode, lengths, points)
    return case, tp.plan(path, reserved, bound=False), on


def fitted(seed: int, machine: str, mode: str, lengths: list[float], points: int = 20):
    """A case, its tool path and path, and the machine with a tenth in reserve and without."""
    case = None
    while case is None:
        case = Maker(seed, machine, mode, lengths, points).make()
        seed += 1000
    setup, on = setup_of_text(case.sheet), tp.Machine.load(machine)
    on = on.mounted(**setup.part) if setup.part else on
    reserved = on.reserved(0.1)
    toolpath = tp.read_text(case.text, reserved, setup=setup, controller=case.controller, name="case" + case.suffix)
    path = tp.Path.fit(toolpath, tip_tolerance=20e-6, axis_tolerance=1e-3, machine=reserved)
    return case, toolpath, path, reserved, on


def real_length(case: Case, block):
    """(n,) length of the tool that is in the spindle at blocks (n,): one comes with the line "T..." before its cut."""
    length, changes = np.full(len(block), case.cuts[0].length), [
        line for line, text in enumerate(case.text.splitlines(), 1)
        if text.startswith(("T", "TOOL CALL", "LOADTL/")) and not text.startswith("TRA")
    ]  # fmt: skip
    for line, cut in zip(changes, case.cuts, strict=True):
        length[block >= line] = cut.length
    return length


def block_at(trajectory, t):
    """(n,) line of the block at times (n,) [s]."""
    run, s = trajectory.run_at(t), trajectory.parameter(t)
    return np.array([trajectory.axis_path.runs[k].block_at(np.array([at]))[0] for k, at in zip(run, s)])


def followed(case: Case, trajectory, machine, bending, feed=1.0, **figures) -> Followed:
    """Follow a plan to its end while the tip is bent by `bending` (3,) [m], on drives that are late."""
    follower = Follower(trajectory, machine, period=PERIOD, delay=LAG * PERIOD, gain=0.2, **figures)
    times = np.arange(0.0, trajectory.duration + PERIOD, PERIOD)
    blocks = block_at(trajectory, times)
    start = trajectory.at(0.0).q
    given, path, said, at = [start] * (LAG + 1), [start] * (LAG + 1), [0] * (LAG + 1), [0.0] * (LAG + 1)
    for k in range(int((1.5 * follower.duration / feed + 1.0) / PERIOD)):
        # the machine is where the set-point of LAG ago has it
        length = real_length(case, block_of(times, blocks, at[k : k + 1]))[0]
        tip, axis = (each[0] for each in case.chain.forward(given[k][None], length))
        point = follower.step(Measurement(k * PERIOD, tip=tip + bending, axis=axis), feed=feed)
        given.append(point.q)
        path.append(point.q - point.correction[0])
        said.append(int(point.status))
        at.append(point.path_time)
        if point.status & Status.ENDED:
            break
    return judged(case, machine, np.array(given), np.array(path), np.array(said), block_of(times, blocks, at), bending)


def block_of(times, blocks, at):
    """(n,) block at each time of the path (n,) [s]."""
    return blocks[np.searchsorted(times, at).clip(0, len(times) - 1)]


def judged(case, machine, given, path, said, block, bending) -> Followed:
    """The worst over all cuts, from the set-points and own kinematics."""
    tip = speed = 0.0
    status, limits = 0, 0.0
    for order, kind in enumerate(("velocity", "acceleration", "jerk"), 1):
        used = np.abs(np.diff(given, order, axis=0)).max(axis=0) / PERIOD**order / getattr(machine.limits, kind)
        limits = max(limits, float(used.max()))
    for cut in case.cuts:
        rows = np.flatnonzero((block >= cut.lines[0]) & (block <= cut.lines[1]))
        assert len(rows) > SETTLED / PERIOD + 25
        wanted = case.chain.forward(path[rows], cut.length)[0]
        real = case.chain.forward(given[rows], cut.length)[0]
        speed = max(speed, float(np.linalg.norm(np.diff(real, axis=0), axis=1).max()) / PERIOD / case.feed)
        settled = slice(int(SETTLED / PERIOD), None)
        tip = max(tip, float(np.linalg.norm(real + bending - wanted, axis=1)[settled].max()))
        status |= int(np.bitwise_or.reduce(said[rows][settled]))
    return Followed(tip, Status(status), speed, limits)
