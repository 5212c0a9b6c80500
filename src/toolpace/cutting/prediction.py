"""The predicted bending along a program during a motion, smoothed at the ends of cuts.

of a motion along the path:
  when each place is passed                  the law of each run; the joints there
  speed of the tip on the way to each        across the tool axis: what makes chips
  force of the cut, along feed and normal    cutting_forces
  deflection, in the workpiece frame         compliance, turned with the machine
  averaged along the way                     blending

The speed is that of the tip along the program, where the bent tip is to be. Moves along the tool axis (plunge, retract)
make no chip across, and take no force here: where they end, the force grows in proportion to the sine of the angle
between motion and tool axis, from PLUNGE on, until it is whole at ACROSS.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.cutting.compliance import tool_to_workpiece
from toolpace.cutting.forces import CuttingForces
from toolpace.cutting.inserted_points import Places
from toolpace.machine.cutting_tool import Cut, CuttingTool
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.path import Path
from toolpace.path.run import PathRun
from toolpace.programs.toolpath import ToolPath

PLUNGE, ACROSS = math.sin(math.radians(5.0)), math.sin(math.radians(15.0))
"""Share of a motion across the tool axis up to which it is one along it, and from which it is one across."""
BOXES = 3


def predicted_bending(
    places: Places, kept: Ints, cut: Ints, tool: CuttingTool, machine: Machine, path: Path, trajectory: Trajectory
) -> Floats:
    """Deflection (n, 3) [m] of the tip in the workpiece frame at n places, blended.

    cut: (n,) which of the tool's cuts acts on the way to each place, -1 for none. path: fitted to the places
    `kept` (k,), whose parameter the trajectory follows.
    """
    duration, rotary = passages(places, kept, path, trajectory, machine)
    step = places.toolpath.way[1:]
    at = np.flatnonzero((cut[1:] >= 0) & (duration > 0.0))
    bent = np.zeros((len(step), 3))
    bent[at] = bending_of_ways(step[at] / duration[at, None], rotary[at], cut[1:][at], tool, machine)
    return blended(places.way, bent, tool.blend)


def bending_of_ways(velocity: Floats, rotary: Floats, cut: Ints, tool: CuttingTool, machine: Machine) -> Floats:
    """Deflection (k, 3) [m] where the tip goes at velocities (k, 3) [m/s], with rotary joints at (k, 2) [rad]."""
    turn = tool_to_workpiece(machine, rotary)
    axis = turn[:, :, 2]
    across = velocity - np.einsum("nc,nc->n", velocity, axis)[:, None] * axis
    speed = np.linalg.norm(across, axis=1)
    whole = np.linalg.norm(velocity, axis=1)
    share = np.clip((speed / np.where(whole > 0.0, whole, 1.0) - PLUNGE) / (ACROSS - PLUNGE), 0.0, 1.0)
    feed = across / np.where(share > 0.0, speed, 1.0)[:, None]
    normal = np.cross(axis, feed)
    force = np.zeros((len(velocity), 3))
    for k, forces in enumerate(map(CuttingForces, cuts_of(tool))):
        of_cut = np.flatnonzero((cut == k) & (share > 0.0))
        force[of_cut] = forces.feed_forward(forces.feed_per_tooth(speed[of_cut]), tool.force)
    force *= share[:, None]
    in_workpiece = force[:, :1] * feed + force[:, 1:2] * normal + force[:, 2:] * axis
    found: Floats = np.einsum("nab,bc,ndc,nd->na", turn, tool.compliance, turn, in_workpiece, optimize=True)
    return found


def passages(places: Places, kept: Ints, path: Path, trajectory: Trajectory, machine: Machine) -> tuple[Floats, Floats]:
    """Of the way to each place but the first: how long the motion is on it (n - 1,) [s], 0 where it has no way, and
    where its rotary joints are in its middle (n - 1, 2) [rad]."""
    duration, rotary = np.zeros(len(places.way) - 1), np.zeros((len(places.way) - 1, 2))
    for run, joints, law in zip(path.runs, trajectory.axis_path.runs, trajectory.laws):
        at, s = parameters(places, kept, run)
        passed = law.times_at(s)
        passed[0], passed[-1] = 0.0, law.duration
        duration[at[:-1]] = np.diff(passed)
        rotary[at[:-1]] = joints.evaluate(0.5 * (s[:-1] + s[1:]))[0][:, machine.rotary]
    return duration, rotary


def parameters(places: Places, kept: Ints, run: PathRun) -> tuple[Ints, Floats]:
    """The places (k,) that a run goes along, both ends too, and its parameters there."""
    # a kept place that no block leads to stands where the one before it does
    point = np.arange(run.entry[0] - 1, run.entry[-1] + 1)
    s = run.block_start[np.searchsorted(run.entry, point, side="right")]
    at = np.arange(kept[point[0]], kept[point[-1]] + 1)
    cell = np.clip(np.searchsorted(kept[point], at, side="right") - 1, 0, len(point) - 2)
    here, there = kept[point[cell]], kept[point[cell + 1]]
    whole = places.way[there] - places.way[here]
    share = np.where(at == there, 1.0, (places.way[at] - places.way[here]) / np.where(whole > 0.0, whole, 1.0))
    return at, s[cell] + share * (s[cell + 1] - s[cell])


def blended(way: Floats, value: Floats, length: float) -> Floats:
    """Averages (n, d) at ascending places (n,) [m] of a value (n - 1, d) that is constant between them.

    Beyond both ends it is nothing. Places must lie closer than a small share of the length [m] wherever the value is
    not nothing within half of that length: between them the averages are taken as straight.
    """
    width = length / BOXES
    places, back = np.unique(way, return_inverse=True)
    pad = width * np.linspace(-0.5 * (BOXES + 1), 0.0, 128, endpoint=False)
    grid = np.concatenate([places[0] + pad, places, places[-1] - pad[::-1]])
    # where places stand twice the way between them has no length, and its value no weight
    moves = way[1:] > way[:-1]
    steps = np.zeros((len(grid) - 1, value.shape[1]))
    steps[np.searchsorted(grid, way[:-1])[moves]] = value[moves]
    left, right = steps, steps
    for _ in range(BOXES):
        found = _moving_average(grid, left, right, width)
        left, right = found[:-1], found[1:]
    result: Floats = found[len(pad) :][: len(places)][back]
    return result


def _moving_average(grid: Floats, left: Floats, right: Floats, width: float) -> Floats:
    """Means (n, d) over a width about places (n,); between them it goes straight from `left` to `right` (n - 1, d)."""
    dx = np.diff(grid)[:, None]
    whole = np.concatenate([np.zeros((1, left.shape[1])), np.cumsum(0.5 * (left + right) * dx, axis=0)])

    def integral(x: Floats) -> Floats:
        """(n, d) up to x."""
        x = np.clip(x, grid[0], grid[-1])
        k = np.clip(np.searchsorted(grid, x, side="right") - 1, 0, len(dx) - 1)
        h = (x - grid[k])[:, None]
        up_to: Floats = whole[k] + h * (left[k] + 0.5 * h / dx[k] * (right[k] - left[k]))
        return up_to

    found: Floats = (integral(grid + 0.5 * width) - integral(grid - 0.5 * width)) / width
    return found


def cuts_of(tool: CuttingTool) -> list[Cut]:
    """The cuts of a tool: first that of all operations that are not named, then those of these that are."""
    return [tool.cut, *(cut for cut in tool.operations.values() if cut is not None)]


def cut_of_way(tool: CuttingTool, toolpath: ToolPath) -> Ints:
    """(n,) which of `cuts_of` acts on the way to each point; -1 for none: rapids, ways without a feed, other tools.

    Raises UsageError where the program does not have the operations or tools that the file names, or nothing cuts.
    """
    names = [operation.name for operation in toolpath.operations]
    tools = [operation.tool for operation in toolpath.operations]
    program = toolpath.source or "the program"
    for what, wanted, there in (("operation", tool.operations, names), ("tool", tool.only, tools)):
        for name in wanted:
            if name not in there:
                named = [each for each in there if each]
                hint = did_you_mean(name, named) if named else f"it names no {what}s: leave that out"
                raise UsageError(f"{tool.source}: {program} has no {what} '{name}'; {hint}")
    order = [name for name, cut in tool.operations.items() if cut is not None]
    of_operation = np.array(
        [
            -1 if tool.only and called not in tool.only
            else 0 if name not in tool.operations
            else 1 + order.index(name) if name in order
            else -1
            for name, called in zip(names, tools)
        ]
    )  # fmt: skip
    found = np.where(at_feed(toolpath), of_operation[toolpath.operation], -1)
    if not (found >= 0).any():
        raise UsageError(
            f"{tool.source}: nothing of {program} cuts with this tool, so nothing bends: its ways are rapids, "
            "have no feed, or are of other tools"
        )
    return np.asarray(found, dtype=np.int64)


def at_feed(toolpath: ToolPath) -> Bools:
    """(n,) whether the way to each point is cut: neither a rapid, nor without feed and time, nor without length."""
    ruled = np.isfinite(toolpath.feed) | (toolpath.least_time > 0.0)
    return np.asarray(ruled & ~toolpath.rapid & (toolpath.way_length > 0.0))
