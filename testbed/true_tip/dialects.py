"""Programs of every dialect, of a generator that knows what they mean, planned: is the real tip where they say?

The programs have tilted planes, cycles, frames, offsets, machine coordinates and up to three tools.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np

import toolpace as tp
from testbed.one_program.generate import MACHINES, generate
from testbed.one_program.run import WRITERS, read
from testbed.one_program.writer import CannotWriteError
from testbed.true_tip.held import farthest

MORE = (
    *MACHINES, "xyzbc-nutating-large", "xyzbc-millturn", "linuxcnc-xyzac-trt", "linuxcnc-xyzbc-bridgemill",
    "xyzab-table",
)  # fmt: skip
DIALECTS = tuple(name for name in WRITERS if name != "cldata")
CHORD = 0.007
"""Most turn of a piece of a curved way [rad]: a chord of it is 0.3 um off a radius of 50 mm."""


def sections(moves):
    """Tool length [mm] and way (n, 3) of its tip [m] of each stretch with tools of one length."""
    # nothing leads to the first place
    begin = moves[0].pose(np.array([1.0, 1.0]))[0]
    for length, group in groupby(moves, key=lambda move: move.length_of_tool):
        ways = [] if length != moves[0].length_of_tool else [begin]
        for move in group:
            if move is moves[0]:
                continue
            turned = np.radians(np.abs(move.rotary[1] - move.rotary[0]).sum()) if move.turns else 0.0
            turned += abs(move.circle.sweep) if move.circle is not None else 0.0
            ways.append(move.pose(np.linspace(0.0, 1.0, 2 + int(turned / CHORD)))[0])
        if ways and ways != [begin]:
            yield length, np.concatenate(ways) * 1e-3


def off(dialect, seed, dt=5e-4, effort="low"):
    """Largest distance of the real tip from the program, both ways [m]; nan where the dialect has no words for it."""
    program = generate(seed, MORE)
    writer = WRITERS[dialect](program)
    try:
        text = writer.write()
    except CannotWriteError:
        return float("nan")
    toolpath = read(writer, text)
    machine = tp.Machine.load(program.machine)
    trajectory = tp.plan_program(toolpath, machine, 10e-6, np.radians(0.05), effort=effort).trajectory
    points = trajectory.sample(dt)
    model = writer.machine
    told = [machine.joints.index(letter) for letter in "XYZ"]
    rotary = np.degrees(points.q[:, [machine.joints.index(letter) for letter in model.letters]])
    lengths = points.tool_length if len(points.tool_length) else np.full(len(points), machine.tool_length)
    found = list(sections(writer.world.moves))
    edges = [0, *(1 + np.flatnonzero(np.diff(lengths))), len(points)]
    if len(edges) != len(found) + 1:
        raise AssertionError(f"{len(edges) - 1} tools in the plan, {len(found)} in the program")
    worst = 0.0
    for (length, way), first, last in zip(found, edges, edges[1:]):
        if abs(lengths[first] * 1e3 - length) > 1e-9:
            raise AssertionError(f"a tool of {lengths[first] * 1e3} mm in the plan, {length} in the program")
        part = slice(first, last)
        real = model.tip(points.q[part][:, told] * 1e3, rotary[part], length) * 1e-3
        worst = max(worst, farthest(real, way), farthest(way, real))
    return worst
