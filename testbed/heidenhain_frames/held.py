"""A program read, and each of its blocks held against where the control goes."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

import toolpace as tp
from testbed.heidenhain_frames.program import Writer
from testbed.heidenhain_frames.world import World, WrongError
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.setup_file import setup_of_text

EXPECTED = (
    "within the travel", "out of travel", "scaled unevenly", "PLANE over a ", "PLANE AXIAL is not read",
    "NX NY NZ with an oversize", "rotary axis of the table is shifted", "mirror of a rotary axis",
    "mirrored rotary axis", "AXIS SPAT over a mirror", "leaves",
)  # fmt: skip
"""Parts of the messages with which these programs may be refused."""


@dataclass
class Held:
    """What came of one program."""

    refused: str = ""
    wrong: str = ""
    tip: float = 0.0
    """The worst distance of a block's end from where the control goes [m]."""
    axis: float = 0.0
    way: float = 0.0
    """The worst distance of a point on the way of the tip from the straight line, where the tip goes straight [m]."""
    blocks: int = 0
    said: Counter = field(default_factory=Counter)


def held(seed) -> Held:
    """Read the program of a seed, and hold it against the truth."""
    written = Writer(seed).write()
    machine, setup = tp.Machine.load(written.machine), setup_of_text(written.sheet)
    try:
        path = tp.read_text(written.text, machine, setup=setup, controller="heidenhain", name="frames.h")
    except ToolpaceError as error:
        return Held(refused=str(error))
    world = World(written.chain, written.zero, written.presets, written.tools)
    found = Held(said=Counter(written.said))
    names = [name.upper() for name in path.rotary_joints]
    row = 0
    for line, method, arguments in written.steps:
        rows = np.flatnonzero(path.block == line)
        seen_at = rows[-1] if len(rows) else row
        seen = dict(zip(names, path.rotary[seen_at]))
        standing, before, part = world.q.copy(), world.forward(world.q)[0], world.on_part()
        try:
            getattr(world, method)(seen, *arguments)
        except WrongError as error:
            found.wrong = f"line {line}: {error}"
            return found
        row = int(seen_at)
        if method not in MOVES:
            continue
        found.blocks += 1
        tip, axis = world.forward(world.q)
        # a block without points leaves the machine where it is
        reached, upright = (path.tip[row], path.axis[row]) if len(rows) else (before, world.forward(standing)[1])
        if row == 0 and len(rows):
            # the path starts with the tip of the tool with which the first motion begins
            reached = reached + (path.tool_length[0] - world.length) * upright
        off = float(np.linalg.norm(reached - tip))
        if off > 1e-6 and not found.wrong:
            found.wrong = f"line {line}: {off * 1e3:.6f} mm off, {written.text.splitlines()[line - 1]}"
        found.tip = max(found.tip, off)
        found.axis = max(found.axis, float(np.linalg.norm(upright - axis)))
        if part and method in STRAIGHT and world.on_part() and len(rows) > 1:
            found.way = max(found.way, float(beside(path.tip[rows], before, tip)))
    return found


MOVES = ("line", "spatial_line", "vector_line", "machine_line", "retract", "position", "tilt", "tilt_axial", "untilt")
STRAIGHT = ("spatial_line", "vector_line")


def beside(points, first, last):
    """The largest distance of points (n, 3) from the straight line between two."""
    way = last - first
    share = np.clip((points - first) @ way / max(float(way @ way), 1e-30), 0.0, 1.0)
    return np.linalg.norm(points - first - share[:, None] * way, axis=1).max()
