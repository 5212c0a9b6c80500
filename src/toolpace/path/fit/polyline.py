"""Polylines of tip and rotary joints (or tool axis) between stops, from a tool path.

The parameter counts tip and turn in their tolerances, ds = sqrt(|dtip / tip_tolerance|^2 + |dturn / axis_tolerance|^2):
a pure rotation has length, rounding noise of either kind weighs alike, and a sphere around a point is the tube.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import PathError, ReachError
from toolpace.machine.machine import Machine
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, columns_at

LEAST_CELL = 1e-7
"""Shorter cells count as repeated points [tolerances]."""
POLE_LEVER = 0.03
"""Sine of the angle to a pole below which a turn about it counts as if there [1]."""
MOST_ITERATIONS = 8
"""Times that points are put in, at most."""
STILL = 0.01
"""Turns of the tool axis below it are not divided [tolerances]."""
SOUND_TURN = 0.3
"""Most turn of a rotary joint between two points at which its solution is chosen [rad]: these are half a turn apart."""
ACROSS, ALONG = np.sqrt(3.0) / 2.0, np.sqrt(3.0) / 4.0
"""Half axes b and a [radii of the ball]."""
FADE = 2.0
"""Length from an end of a run over which the ellipsoid grows to its size [tolerances]."""
LEAST_SIZE = 0.01
"""Size below which its metric is that of this one: at the end itself it would have none."""


@dataclass(frozen=True)
class PlaceTolerances:
    """The tolerances of a tool path, place by place: all else of a fit counts in the narrowest."""

    tip: float
    """The narrowest of the tip [m]."""
    axis: float
    """The narrowest of the tool axis [rad]."""
    room: Floats
    """(n, 2) those of tip and axis on the way to each point, in these."""
    outward: Floats | None = None
    """(n, 3) unit vectors at each point to the side on which the tip must be; None: both."""

    @classmethod
    def of(cls, toolpath: ToolPath, tip: float | Tolerances, axis: float | Tolerances) -> PlaceTolerances:
        """Those of the points of a tool path. Raises UsageError."""
        tips, axes = Tolerances.of(tip, "tip_tolerance"), Tolerances.of(axis, "axis_tolerance")
        along = np.stack([tips.tip_beside_chords(toolpath), axes.axis_along(toolpath)], axis=1)
        least = along.min(axis=0)
        return cls(float(least[0]), float(least[1]), along / least, tips.outward_along(toolpath))

    def counting_in(self, other: PlaceTolerances) -> PlaceTolerances:
        """The same tolerances, in the narrowest of others."""
        room = self.room * [self.tip / other.tip, self.axis / other.axis]
        return PlaceTolerances(other.tip, other.axis, room, self.outward)


@dataclass(frozen=True)
class Polyline:
    """What one run shall follow; all in tolerances."""

    s: Floats
    """(k + 1,) chord length from 0."""
    tip: Floats
    """(k + 1, 3)"""
    turn: Floats
    """(k + 1, 2) rotary joints or (k + 1, 3) tool axis."""
    axis: Floats
    """(k + 1, 3) unit tool axis."""
    entry: Ints
    """(k,) entry of the ToolPath that each cell leads to."""
    room: Floats
    """(k, 2) tolerance of tip and tool axis in each cell; 1 where they are the narrowest of the program."""
    tool_length: float
    """Of the tool in the spindle [m]; nan: as long as the machine's own."""
    dwell: float
    """Time to wait at the end [s]."""
    wait: float = 0.0
    """Time to wait at the start [s]; the first run only."""
    half: HalfBall | None = None
    """On which side the tip must be; None: both."""

    def room_at(self, s: Floats) -> Floats:
        """(n, 2) tolerance of tip and tool axis at parameters (n,); where two meet, the narrower."""
        if np.all(self.room == 1.0):
            return np.ones((len(s), 2))
        last = len(self.room) - 1
        before = np.clip(np.searchsorted(self.s, s, side="left") - 1, 0, last)
        after = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, last)
        room: Floats = np.minimum(self.room[before], self.room[after])
        return room


def polylines(toolpath: ToolPath, tolerances: PlaceTolerances, machine: Machine | None) -> list[Polyline]:
    """The runs of a ToolPath. Repeated points and runs of no length vanish; their dwells go to the run before."""
    tip_tolerance, axis_tolerance = tolerances.tip, tolerances.axis
    if tolerances.outward is not None:
        toolpath = replace(toolpath, normal=tolerances.outward)
    dense, entry = refined(toolpath, axis_tolerance, machine)
    tip, begin = dense.tip / tip_tolerance, dense.way_start / tip_tolerance
    turn = (dense.axis if dense.rotary is None or machine is None else dense.rotary) / axis_tolerance
    length = np.sqrt(np.sum((tip - begin)[1:] ** 2, axis=1) + turn_length(turn, axis_tolerance, machine) ** 2)
    stops = np.flatnonzero(dense.stop)
    stops = np.unique(np.concatenate([[0], stops, [len(dense) - 1]]))
    runs: list[Polyline] = []
    wait = float(dense.dwell[0])
    for start, end in pairwise(stops):
        steps = length[start:end]
        kept = np.flatnonzero(steps > LEAST_CELL)
        dwell = float(dense.dwell[end])
        if len(kept) == 0:
            if runs:
                runs[-1] = replace(runs[-1], dwell=runs[-1].dwell + dwell)
            else:
                wait += dwell
            continue
        nodes = start + np.concatenate([[0], kept + 1])
        nodes[-1] = end
        s = np.concatenate([[0.0], np.cumsum(steps[kept])])
        # the tool may have been changed at the stop, and its tip be elsewhere than that of the one before
        followed = tip[nodes]
        followed[0] = begin[start + 1]
        runs.append(
            Polyline(
                s=s,
                half=None if tolerances.outward is None else HalfBall(s, dense.normal[nodes]),
                tip=followed,
                turn=turn[nodes],
                axis=dense.axis[nodes],
                entry=entry[start + 1 + kept],
                room=tolerances.room[entry[start + 1 + kept]],
                tool_length=float(dense.tool_length[end]),
                dwell=dwell,
                wait=0.0 if runs else wait,
            )
        )
    if not runs:
        raise PathError(f"{toolpath.source or 'tool path'}: nothing moves")
    return runs


def turn_length(turn: Floats, axis_tolerance: float, machine: Machine | None) -> Floats:
    """Length of the turn of each cell (n - 1,) in tolerances, as the tool axis feels it.

    Near a pole rounding makes one rotary joint jitter by degrees. It counts by what it does to the axis, but at
    least by POLE_LEVER, so that a turn at the pole has length too.
    """
    step = np.diff(turn, axis=0)
    if machine is None:
        return np.asarray(np.linalg.norm(step, axis=1))
    columns = axis_columns(0.5 * (turn[1:] + turn[:-1]) * axis_tolerance, machine)
    moved = np.einsum("nca,na->nc", columns, step)
    return np.asarray(np.sqrt(np.sum(moved**2, axis=1) + POLE_LEVER**2 * np.sum(step**2, axis=1)))


def axis_columns(rotary: Floats, machine: Machine) -> Floats:
    """Derivative (n, 3, 2) of the tool axis along both rotary joints (n, 2) [rad]."""
    columns = []
    for joint in range(2):
        jet = np.zeros((4, len(rotary), 2))
        jet[0] = rotary
        jet[1, :, joint] = 1.0
        columns.append(machine.axis_jets(jet)[1])
    return np.stack(columns, axis=2)


def refined(toolpath: ToolPath, axis_tolerance: float, machine: Machine | None) -> tuple[ToolPath, Ints]:
    """The tool path with points put in where straight lines of the turn would leave the great circle of the axis.

    With a machine the result has rotary joints. Returns it with the entry of the given path of each point.
    """
    entry = np.arange(len(toolpath))
    if machine is not None and toolpath.rotary is not None:
        return with_rotary(toolpath, machine, machine.choose_rotary(toolpath)), entry
    if toolpath.rotary is not None:
        toolpath = replace(toolpath, rotary=None, rotary_joints=())  # joints of no machine
    chord = np.linalg.norm(np.diff(toolpath.axis, axis=0), axis=1)
    if np.any(chord > 1.999):
        i = int(np.argmax(chord)) + 1
        raise PathError(
            f"{toolpath.source or 'tool path'}:{toolpath.block[i]}: the tool axis turns by half a turn in one block,"
            " in no certain plane; put a point between"
        )
    angle = 2.0 * np.arcsin(0.5 * chord)
    # the chord of a great circle dips by angle^2 / 8
    toolpath, entry = inserted(toolpath, entry, np.ceil(angle / np.sqrt(0.4 * axis_tolerance)).astype(np.int64))
    if machine is None:
        return toolpath, entry
    rotary = decided(machine, toolpath, axis_tolerance)
    for _ in range(MOST_ITERATIONS):
        between = toolpath.axis[1:] + toolpath.axis[:-1]
        between /= np.linalg.norm(between, axis=1)[:, None]
        error = np.linalg.norm(machine.axis_at(0.5 * (rotary[1:] + rotary[:-1])) - between, axis=1)
        moves = np.linalg.norm(np.diff(toolpath.axis, axis=0), axis=1) > STILL * axis_tolerance
        count = np.where(moves, np.clip(np.ceil(np.sqrt(error / (0.05 * axis_tolerance))), 1, 8), 1).astype(np.int64)
        if np.all(count == 1):
            break
        toolpath, entry = inserted(toolpath, entry, count)
        rotary = carried_on(machine, toolpath, np.concatenate([[0], np.cumsum(count)]), rotary)
    return with_rotary(toolpath, machine, rotary), entry


def with_rotary(toolpath: ToolPath, machine: Machine, rotary: Floats) -> ToolPath:
    """The tool path with rotary joints (n, 2), in the order of the machine."""
    return replace(toolpath, rotary=rotary, rotary_joints=tuple(machine.geometry.rotary_joints))


def decided(machine: Machine, toolpath: ToolPath, axis_tolerance: float) -> Floats:
    """Rotary joints (n, 2) along a tool path: chosen with points put in where a joint could turn far between two."""
    dense, at = toolpath, np.arange(len(toolpath))
    for _ in range(MOST_ITERATIONS):
        moves = np.linalg.norm(np.diff(dense.axis, axis=0), axis=1) > STILL * axis_tolerance
        count = np.where(moves & (machine.turn_between(dense.axis) > SOUND_TURN), 4, 1)
        if np.all(count == 1):
            break
        dense, _ = inserted(dense, np.arange(len(dense)), count)
        at = np.concatenate([[0], np.cumsum(count)])[at]
    if dense is toolpath:
        return machine.choose_rotary(toolpath)
    try:
        rotary = machine.choose_rotary(dense)[at]
    except ReachError:
        # the points of the program itself make the better message
        return machine.choose_rotary(toolpath)
    return carried_on(machine, toolpath, np.arange(len(toolpath)), rotary)


def carried_on(machine: Machine, toolpath: ToolPath, chosen: Ints, rotary: Floats) -> Floats:
    """Rotary joints (n, 2) along a tool path on the branch that was chosen at its points `chosen` (k,).

    Where that branch does not hold between these points, or makes the joints turn by far more than it seemed when it
    was chosen, the choice is made anew with all of them.
    """
    try:
        between = machine.rotary_between(toolpath, chosen, rotary)
    except ReachError:
        return machine.choose_rotary(toolpath)
    more = np.abs(np.diff(between, axis=0)).sum() - np.abs(np.diff(rotary, axis=0)).sum()
    return between if more < SOUND_TURN else machine.choose_rotary(toolpath)


def inserted(toolpath: ToolPath, entry: Ints, count: Ints) -> tuple[ToolPath, Ints]:
    """The tool path with each cell cut into count (n - 1,) equal parts."""
    count = np.maximum(count, 1)
    if np.all(count == 1):
        return toolpath, entry
    n = len(toolpath)
    cell = np.repeat(np.arange(n - 1), count)
    part = np.arange(len(cell)) - np.repeat(np.cumsum(count) - count, count) + 1
    u = (part / count[cell])[:, None]
    last = part == count[cell]
    origin = np.concatenate([[0], cell + 1])
    tip = toolpath.way_start[cell + 1] * (1.0 - u) + toolpath.tip[cell + 1] * u
    axis = great_circle(toolpath.axis[cell], toolpath.axis[cell + 1], u)
    tip[last], axis[last] = toolpath.tip[1:], toolpath.axis[1:]
    ends = np.concatenate([[True], last])
    normal = toolpath.normal[cell] * (1.0 - u) + toolpath.normal[cell + 1] * u
    normal[last] = toolpath.normal[1:]
    dense = replace(
        toolpath,
        normal=np.concatenate([toolpath.normal[:1], unit(normal)]),
        tip=np.concatenate([toolpath.tip[:1], tip]),
        axis=np.concatenate([toolpath.axis[:1], axis]),
        least_time=toolpath.least_time[origin],
        **columns_at(toolpath, origin, ends),
    )
    return dense, entry[origin]


def great_circle(a: Floats, b: Floats, u: Floats) -> Floats:
    """The unit vectors (n, 3) a share u (n, 1) of the way from a to b."""
    angle = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(b - a, axis=1)))[:, None]
    straight = angle < 1e-6
    safe = np.where(straight, 1.0, angle)
    left = np.where(straight, 1.0 - u, np.sin((1.0 - u) * safe) / np.sin(safe))
    right = np.where(straight, u, np.sin(u * safe) / np.sin(safe))
    out = left * a + right * b
    return np.asarray(out / np.linalg.norm(out, axis=1)[:, None])


@dataclass(frozen=True)
class HalfBall:
    """Ellipsoids inside one half of the tolerance tube, for tolerances on one side; all in tolerances.

    Of the ball of radius 1 about the program's tip the half with n . d >= 0 may be used. In it lies the ellipsoid

        |d across n|^2 / b^2 + (n . d - a)^2 / a^2 <= 1        b = sqrt(3) / 2,  a = sqrt(3) / 4

    of most volume (65 percent of the half ball). So the tube is still one ball at each sample, only about another place
    and in another metric, and no solver has to know of sides. Where a run starts and ends the curve is at the program's
    point itself: towards these places the ellipsoid shrinks.
    """

    s: Floats
    """(k + 1,) parameters of the vertices."""
    out: Floats
    """(k + 1, 3) unit vectors there, away from the part."""

    def outward(self, at: Floats) -> Floats:
        """(n, 3) unit vectors at parameters (n,)."""
        return unit(np.stack([np.interp(at, self.s, each) for each in self.out.T], axis=1))

    def size(self, at: Floats) -> Floats:
        """(n,) of the ellipsoid there, at most 1."""
        return np.asarray(np.clip(np.minimum(at - self.s[0], self.s[-1] - at) / FADE, 0.0, 1.0))

    def centre(self, at: Floats) -> Floats:
        """(n, 3) of the ellipsoid, from the program's tip on."""
        return np.asarray(ALONG * self.size(at)[:, None] * self.outward(at))

    def metric(self, at: Floats) -> Floats:
        """(n, 3, 3) what a way from the centre is, squared: 1 on the ellipsoid."""
        out, size = self.outward(at), np.maximum(self.size(at), LEAST_SIZE)
        along = out[:, :, None] * out[:, None, :]
        shape = (np.eye(3) - along) / ACROSS**2 + along / ALONG**2
        return np.asarray(shape / size[:, None, None] ** 2)

    def distance(self, off: Floats, at: Floats) -> Floats:
        """(n,) of places `off` (n, 3) the program's tip from the centre, in the metric."""
        way = off - self.centre(at)
        return np.asarray(np.sqrt(np.einsum("na,nab,nb->n", way, self.metric(at), way)))


def unit(vectors: Floats) -> Floats:
    """(n, 3) the vectors at length 1; what has none stays as it is."""
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
