"""The predicted bending along a program during a motion, at its points and at those put in where it may change.

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
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.cutting.compliance import tool_to_workpiece
from toolpace.cutting.forces.fixed_engagement import CuttingForces
from toolpace.machine.cutting_tool import Cut, CuttingTool, EngagedDeflection
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.fit.polyline import great_circle
from toolpace.path.path import Path
from toolpace.path.run import PathRun
from toolpace.programs.toolpath import ToolPath, columns_at, no_normals

PARTS = 48
"""Points over the length of a blend: straight lines between them miss the blend by 0.2 percent of the bending."""
NEAR = 0.25
"""Share of their distance within which a point of the program stands for one that would be put in."""
CHUNK = 64
"""Of so many places one is kept in any case; a power of two."""
PLUNGE, ACROSS = math.sin(math.radians(5.0)), math.sin(math.radians(15.0))
"""Share of a motion across the tool axis up to which it is one along it, and from which it is one across."""
BOXES = 3
"""Moving averages, one of the other: each adds a continuous derivative, and the path needs two for its acceleration."""


@dataclass(frozen=True)
class Stations:
    """The points of a program and those between, at which bending is told."""

    toolpath: ToolPath
    """As it is programmed, of n points."""
    origin: Ints
    """(n,) point of the program that each is or leads to."""
    way: Floats
    """(n,) way of the tip up to each [m]."""

    def needed(self, shift: Floats, straight: float) -> Ints:
        """The places (k,) that a path shifted by (n, 3) [m] takes, to be within `straight` [m] between them."""
        return needed(self.way, shift, np.append(np.diff(self.origin) > 0, True), straight)

    def shifted(self, shift: Floats, kept: Ints) -> ToolPath:
        """The tool path of the places `kept` (k,), with its tips moved by `shift` (n, 3) [m]."""
        path = self.toolpath
        return replace(
            path,
            tip=path.tip[kept] + shift[kept],
            axis=path.axis[kept],
            feed=path.feed[kept],
            least_time=np.diff(np.cumsum(path.least_time)[kept], prepend=0.0),
            block=path.block[kept],
            stop=path.stop[kept],
            dwell=path.dwell[kept],
            rotary=None if path.rotary is None else path.rotary[kept],
            rapid=path.rapid[kept],
            operation=path.operation[kept],
            tip_tolerance=path.tip_tolerance[kept],
            axis_tolerance=path.axis_tolerance[kept],
            tool_length=path.tool_length[kept],
            bow=path.bow[kept],
            spindle=path.spindle[kept],
        )


def stations_of(toolpath: ToolPath, machine: Machine, cut: Ints, blend: float) -> Stations:
    """The places of a program whose ways are cut where `cut` (n,) is not negative. Raises ReachError.

    Points are put in wherever bending can be, blended over a length [m]: that far about all that is cut.
    """
    steps = toolpath.way_length[1:]
    way = np.concatenate([[0.0], np.cumsum(steps)])
    between = _between(way, cut, blend)
    cell = np.searchsorted(way, between, side="right") - 1
    share = (between - way[cell]) / steps[cell]
    # each way: first the points put in, then its own
    order = np.argsort(np.concatenate([cell + share, np.arange(1.0, len(way))]), kind="stable")
    leads = np.concatenate([cell + 1, np.arange(1, len(way))])[order]
    part = np.concatenate([share, np.ones(len(way) - 1)])[order]
    origin = np.concatenate([[0], leads])
    dense = with_points(toolpath, machine, origin, np.concatenate([[1.0], part]))
    return Stations(dense, origin, np.cumsum(dense.way_length))


def _between(way: Floats, cut: Ints, blend: float) -> Floats:
    """Where along the way points are put in, ascending [m]."""
    step = blend / PARTS
    ways = np.flatnonzero(cut[1:] >= 0)
    low, high = way[ways] - blend, way[ways + 1] + blend
    # ends of ways ascend, so that stretches that touch are found by neighbours
    head = np.flatnonzero(np.concatenate([[True], low[1:] > high[:-1]]))
    low, high = low[head], np.append(high[head[1:] - 1], high[-1])
    first = np.ceil(np.maximum(low, 0.0) / step).astype(np.int64)
    count = np.floor(np.minimum(high, way[-1]) / step).astype(np.int64) + 1 - first
    count = np.maximum(count, 0)
    lattice = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first, count)) * step
    after = np.clip(np.searchsorted(way, lattice), 1, len(way) - 1)
    free = np.minimum(np.abs(lattice - way[after - 1]), np.abs(way[after] - lattice)) > NEAR * step
    found: Floats = lattice[free]
    return found


def with_points(toolpath: ToolPath, machine: Machine, origin: Ints, share: Floats) -> ToolPath:
    """A tool path of points a share (k,) of the way to its points `origin` (k,)."""
    own = share == 1.0
    before, u = np.maximum(origin - 1, 0), share[:, None]
    tip = toolpath.tip[origin] - (1.0 - u) * toolpath.way[origin]
    tip[own] = toolpath.tip[origin[own]]
    rotary, axis = None, toolpath.axis[origin].copy()
    if toolpath.rotary is not None:
        chosen = machine.choose_rotary(toolpath)
        rotary = chosen[before] + u * (chosen[origin] - chosen[before])
        axis[~own] = machine.axis_at(rotary[~own])
    else:
        a, b = toolpath.axis[before[~own]], toolpath.axis[origin[~own]]
        axis[~own] = great_circle(a, b, u[~own])
    begins = np.concatenate([[True], own[:-1]])
    part = share - np.where(begins, 0.0, np.concatenate([[0.0], share[:-1]]))
    return replace(
        toolpath,
        tip=tip,
        axis=axis,
        least_time=toolpath.least_time[origin] * part,
        normal=no_normals(),
        rotary=rotary,
        rotary_joints=() if rotary is None else tuple(machine.geometry.rotary_joints),
        **columns_at(toolpath, origin, own),
    )


def needed(way: Floats, value: Floats, fixed: Bools, straight: float) -> Ints:
    """The places (k,) of n along a way [m] between which a value (n, d) is within `straight` of a straight line.

    All that are `fixed` are among them, both ends too. Between two of these, or in a CHUNK, every place is kept, or
    every second, fourth, ...: as few as do.
    """
    at = np.arange(len(way))
    corner = fixed | (at % CHUNK == 0) | (at == at[-1])
    corners = np.flatnonzero(corner)
    chunk = np.minimum(np.searchsorted(corners, at, side="right") - 1, len(corners) - 2)
    first, last = corners[chunk], corners[chunk + 1]
    stride = np.ones(len(corners) - 1, dtype=np.int64)
    for wider in 2 ** np.arange(1, CHUNK.bit_length()):
        before = first + (at - first) // wider * wider
        after = np.minimum(before + wider, last)
        whole = way[after] - way[before]
        share = (way - way[before]) / np.where(whole > 0.0, whole, 1.0)
        off = value - value[before] - share[:, None] * (value[after] - value[before])
        worst = np.maximum.reduceat(np.sqrt((off**2).sum(axis=1)), corners[:-1])
        stride[(worst <= straight) & (stride == wider // 2)] = wider
    return np.flatnonzero(corner | ((at - first) % stride[chunk] == 0))


def predicted_bending(
    stations: Stations, kept: Ints, cut: Ints, tool: CuttingTool, machine: Machine, path: Path, trajectory: Trajectory
) -> Floats:
    """Deflection (n, 3) [m] of the tip in the workpiece frame at n places, blended.

    cut: (n,) which of the tool's cuts acts on the way to each place, -1 for none. path: fitted to the places
    `kept` (k,), whose parameter the trajectory follows.
    """
    duration, rotary = passages(stations, kept, path, trajectory, machine)
    step = stations.toolpath.way[1:]
    at = np.flatnonzero((cut[1:] >= 0) & (duration > 0.0))
    bent = np.zeros((len(step), 3))
    velocity = step[at] / duration[at, None]
    if tool.engaged is None:
        bent[at] = bending_of_ways(velocity, rotary[at], cut[1:][at], tool, machine)
    else:
        middle = 0.5 * (stations.way[1:] + stations.way[:-1])[at]
        bent[at] = engaged_bending_of_ways(velocity, rotary[at], middle, tool.engaged, machine)
    return blended(stations.way, bent, tool.blend)


def bending_of_ways(velocity: Floats, rotary: Floats, cut: Ints, tool: CuttingTool, machine: Machine) -> Floats:
    """Deflection (k, 3) [m] where the tip goes at velocities (k, 3) [m/s], with rotary joints at (k, 2) [rad]."""
    turn = tool_to_workpiece(machine, rotary)
    feed, normal, axis, share, speed = _feed_frames(velocity, turn[:, :, 2])
    force = np.zeros((len(velocity), 3))
    for k, forces in enumerate(map(CuttingForces, cuts_of(tool))):
        of_cut = np.flatnonzero((cut == k) & (share > 0.0))
        force[of_cut] = forces.feed_forward(forces.feed_per_tooth(speed[of_cut]), tool.force)
    force *= share[:, None]
    in_workpiece = force[:, :1] * feed + force[:, 1:2] * normal + force[:, 2:] * axis
    found: Floats = np.einsum("nab,bc,ndc,nd->na", turn, tool.compliance, turn, in_workpiece, optimize=True)
    return found


def engaged_bending_of_ways(
    velocity: Floats, rotary: Floats, way: Floats, engaged: EngagedDeflection, machine: Machine
) -> Floats:
    """Deflection (k, 3) [m] by the engagement along a program, `way` (k,) [m] along it; for all else see
    `bending_of_ways`."""
    feed, normal, axis, share, _ = _feed_frames(velocity, tool_to_workpiece(machine, rotary)[:, :, 2])
    slope, constant = (
        np.stack([np.interp(way, engaged.way, column) for column in each.T], axis=1)
        for each in (engaged.slope, engaged.constant)
    )
    bent = share[:, None] * (slope * np.linalg.norm(velocity, axis=1)[:, None] + constant)
    found: Floats = bent[:, :1] * feed + bent[:, 1:2] * normal + bent[:, 2:] * axis
    return found


def _feed_frames(velocity: Floats, axis: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Feed across the axis, normal and axis (k, 3); share of the motion that counts as across (k,), and its speed
    across (k,) [m/s]."""
    across = velocity - np.einsum("nc,nc->n", velocity, axis)[:, None] * axis
    speed = np.linalg.norm(across, axis=1)
    whole = np.linalg.norm(velocity, axis=1)
    share = np.clip((speed / np.where(whole > 0.0, whole, 1.0) - PLUNGE) / (ACROSS - PLUNGE), 0.0, 1.0)
    feed = across / np.where(share > 0.0, speed, 1.0)[:, None]
    return feed, np.cross(axis, feed), axis, share, speed


def passages(
    stations: Stations, kept: Ints, path: Path, trajectory: Trajectory, machine: Machine
) -> tuple[Floats, Floats]:
    """Of the way to each place but the first: how long the motion is on it (n - 1,) [s], 0 where it has no way, and
    where its rotary joints are in its middle (n - 1, 2) [rad]."""
    duration, rotary = np.zeros(len(stations.way) - 1), np.zeros((len(stations.way) - 1, 2))
    for run, joints, law in zip(path.runs, trajectory.axis_path.runs, trajectory.laws):
        at, s = parameters(stations, kept, run)
        passed = law.times_at(s)
        passed[0], passed[-1] = 0.0, law.duration
        duration[at[:-1]] = np.diff(passed)
        rotary[at[:-1]] = joints.evaluate(0.5 * (s[:-1] + s[1:]))[0][:, machine.rotary]
    return duration, rotary


def parameters(stations: Stations, kept: Ints, run: PathRun) -> tuple[Ints, Floats]:
    """The places (k,) that a run goes along, both ends too, and its parameters there."""
    # a kept place that no block leads to stands where the one before it does
    point = np.arange(run.entry[0] - 1, run.entry[-1] + 1)
    s = run.block_start[np.searchsorted(run.entry, point, side="right")]
    at = np.arange(kept[point[0]], kept[point[-1]] + 1)
    cell = np.clip(np.searchsorted(kept[point], at, side="right") - 1, 0, len(point) - 2)
    here, there = kept[point[cell]], kept[point[cell + 1]]
    whole = stations.way[there] - stations.way[here]
    share = np.where(at == there, 1.0, (stations.way[at] - stations.way[here]) / np.where(whole > 0.0, whole, 1.0))
    return at, s[cell] + share * (s[cell + 1] - s[cell])


def blended(way: Floats, value: Floats, length: float) -> Floats:
    """Averages (n, d) at ascending places (n,) [m] of a value (n - 1, d) that is constant between them.

    Beyond both ends it is nothing. Places must lie closer than a small share of the length [m] wherever the value is
    not nothing within half of that length: between them the averages are taken as straight.
    """
    width = length / BOXES
    stations, back = np.unique(way, return_inverse=True)
    pad = width * np.linspace(-0.5 * (BOXES + 1), 0.0, 128, endpoint=False)
    grid = np.concatenate([stations[0] + pad, stations, stations[-1] - pad[::-1]])
    # where places stand twice the way between them has no length, and its value no weight
    moves = way[1:] > way[:-1]
    steps = np.zeros((len(grid) - 1, value.shape[1]))
    steps[np.searchsorted(grid, way[:-1])[moves]] = value[moves]
    left, right = steps, steps
    for _ in range(BOXES):
        found = _moving_average(grid, left, right, width)
        left, right = found[:-1], found[1:]
    result: Floats = found[len(pad) :][: len(stations)][back]
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
