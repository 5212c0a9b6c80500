"""Sampling: a trajectory at equal times, block by block, rounded to grids of powers of two where it goes to disk.

A set-point's last digits are noise of the arithmetic, and noise cannot be compressed. Grids are told by that of the
jerk, u, and the time step, h = 2^k <= dt:

    jerk u    acceleration u h    velocity u h^2    position u h^3 / 4

A third difference of positions is then off by at most 8 (u h^3 / 8) / dt^3 <= u, where u is `SHARE` of the joint's jerk
limit; and no position is off by more than 2^-43 m or rad, 1.2e-13: far below any tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Protocol

import numpy as np

from toolpace.common.arrays import Floats, Ints, number
from toolpace.common.workers import Workers
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import ROWS, Block, SetPoints, SetPointSource, refuse_too_many
from toolpace.motion.usage import Motion

if TYPE_CHECKING:
    from toolpace.path.axis_path import AxisPath

SHARE = 1e-5
"""Of a jerk limit by which rounding may show: a tenth of what the judge grants."""
COARSEST = 2.0**-42
"""Grid of positions that is never exceeded [m or rad]."""


class MotionOverTime(Protocol):
    """What is sampled, as a Trajectory is."""

    @property
    def axis_path(self) -> AxisPath: ...
    @property
    def limits(self) -> Limits: ...
    @property
    def duration(self) -> float: ...
    @property
    def joints(self) -> tuple[str, ...]: ...
    def put_motion(self, t: Floats, motion: Motion, block: Ints) -> Ints: ...


class Sampling:
    """Set-points of a trajectory every `dt` [s], worked out as they are taken; the last is at or just after the end.

    A `SetPointSource`: of a long motion no more is in memory than the block that somebody works on. `on_grid` rounds
    them. Raises UsageError for a time step that is none.
    """

    def __init__(self, trajectory: MotionOverTime, dt: float, *, on_grid: bool) -> None:
        self.dt = number(dt, "set-points: time step dt", least=0.0, above=True, unit="s")
        self.trajectory, self.joints = trajectory, trajectory.joints
        self.machine, lengths = trajectory.axis_path.machine, trajectory.axis_path.tool_lengths
        self.has_tool = self.machine is not None
        self._tools = np.zeros(0) if np.isnan(lengths).all() else lengths
        self._grid = grids(trajectory.limits, self.dt) if on_grid else None
        self._count = int(np.ceil(trajectory.duration / self.dt * (1.0 - 1e-12))) + 1

    def __len__(self) -> int:
        return self._count

    def times(self, rows: Ints) -> Floats:
        """(k,) times of some rows (k,) [s]."""
        found: Floats = self.dt * rows.astype(np.float64)
        return found

    def rows(self, begin: int, end: int) -> SetPoints:
        """The set-points from row `begin` to before row `end`."""
        return self.at(np.arange(begin, end))

    def at(self, rows: Ints) -> SetPoints:
        """The set-points of some rows (k,), in their order."""
        out = self._room(len(rows))
        self._fill(out, slice(None), self.times(rows))
        return SetPoints(**out, joints=self.joints)

    def all(self) -> SetPoints:
        """All of them at once. Raises UsageError where they would not fit into memory."""
        refuse_too_many(self.trajectory.duration, self.dt, len(self.joints))
        out = self._room(len(self))

        def fill(begin: int) -> None:
            end = min(begin + ROWS, len(self))
            self._fill(out, slice(begin, end), self.times(np.arange(begin, end)))

        Workers().each(fill, range(0, len(self), ROWS))
        return SetPoints(**out, joints=self.joints)

    def _room(self, count: int) -> dict[str, np.ndarray]:
        m, tools = len(self.joints), count * self.has_tool
        shapes = {"t": (count,), "q": (count, m), "qd": (count, m), "qdd": (count, m), "qddd": (count, m)}
        shapes |= {"tip": (tools, 3), "axis": (tools, 3), "tool_length": (count * (len(self._tools) > 0),)}
        return {name: np.empty(shape) for name, shape in shapes.items()} | {"block": np.empty(count, dtype=np.int64)}

    def _fill(self, out: dict[str, np.ndarray], part: slice, t: Floats) -> None:
        """Put the set-points at times t (k,) into a part of the columns."""
        columns = {name: values[part] for name, values in out.items()}
        columns["t"][:] = t
        motion = Motion(*(columns[name] for name in ("q", "qd", "qdd", "qddd")))
        run = self.trajectory.put_motion(t, motion, columns["block"])
        if self._grid is not None:
            for grid, values in zip(self._grid, (motion.q, motion.qd, motion.qdd, motion.qddd)):
                round_to(grid, values)
        lengths = self._tools[run] if len(self._tools) else None
        if lengths is not None:
            columns["tool_length"][:] = lengths
        if self.machine is not None:
            columns["tip"][:], columns["axis"][:] = self.machine.forward(motion.q, lengths)


def each_block(
    source: SetPointSource, takers: Sequence[Callable[[Block], None]], beside: Sequence[Callable[[], object]] = ()
) -> None:
    """Give each block of a source to all takers, on all cores; work that is done `beside` it comes first.

    An error, and Ctrl-C, are raised when the blocks under way are done.
    """

    def give(begin: int) -> None:
        block = Block.of(source, begin, min(begin + ROWS, len(source)))
        for take in takers:
            take(block)

    pieces: list[Callable[[], object]] = [*beside, *(partial(give, k) for k in range(0, len(source), ROWS))]
    Workers().each(lambda work: work(), pieces)


def grids(limits: Limits, dt: float) -> Floats:
    """(4, m) grids of positions, velocities, accelerations and jerks of each joint, powers of two.

    Where nothing limits the jerk, the acceleration's limit over a step is taken, and so on.
    """
    h = _power_of_two(dt)
    position = []
    for velocity, acceleration, jerk in zip(limits.velocity, limits.acceleration, limits.jerk):
        by_limits = SHARE * min(float(jerk) * h**3, float(acceleration) * h**2, float(velocity) * h) / 4.0
        position.append(_power_of_two(min(by_limits, COARSEST)))
    q = np.array(position)
    found: Floats = np.stack([q, 4.0 * q / h, 4.0 * q / h**2, 4.0 * q / h**3])
    return found


def round_to(grid: Floats, values: Floats) -> None:
    """Round values (n, m) to grids (m,) of powers of two, in place. What is coarser than its grid stays as it is."""
    values /= grid
    np.rint(values, out=values)
    values *= grid
    values += 0.0  # zero has no sign


def _power_of_two(value: float) -> float:
    """The largest power of two that is at most a value above zero."""
    return math.ldexp(0.5, math.frexp(value)[1])
