"""Tool paths: the points, tool axes, feeds and stops of a program."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints, integers, marks, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import (
    FARTHEST_PART,
    FASTEST_FEED,
    LONGEST_TOOL,
    METRES,
    METRES_PER_SECOND,
    ask_about_unit,
    refuse_other_unit,
)
from toolpace.common.value_objects import ByValue, counted, one_line
from toolpace.programs.speed_profile import SpeedProfile
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

UNIT = 1e-6
"""By how much the length of a tool axis may differ from 1."""


def no_rapids() -> Bools:
    """None."""
    return np.zeros(0, dtype=np.bool_)


def no_operations() -> Ints:
    """None."""
    return np.zeros(0, dtype=np.int64)


def untold() -> Floats:
    """None."""
    return np.zeros(0)


def no_normals() -> Floats:
    """None."""
    return np.zeros((0, 3))


def no_numbers() -> Ints:
    """None."""
    return np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Operation:
    """A part of a program: what it is called there, and the tool that works in it."""

    name: str = ""
    tool: str = ""
    """Number or name of the tool as the program writes it; empty where it names none."""
    told_lengths: tuple[float, ...] = ()
    """Lengths of it by the program's own words, where they are not the table's [m]: H of another number, DL, G43.1."""
    figures: ToolFigures | None = None
    """Its shape, as far as the program tells it (TLDATA, TOOL DEF, a rule of the controller's file); else None."""


@dataclass(frozen=True, eq=False, repr=False)
class ToolPath(ByValue):
    """The points of a program in the workpiece frame; entry i speaks of point i and of the way from i - 1 to i.

    Between two points the tip moves straight; the tool axis turns along the great circle, or, where `rotary` is
    given, the rotary joints move in proportion (the reader inserts points until both agree closely). Raises UsageError
    for arrays of other shapes and for figures that no path has.
    """

    tip: Floats
    """(n, 3) tool tip [m]."""
    axis: Floats
    """(n, 3) unit vectors from the tip to the spindle."""
    feed: Floats
    """(n,) most speed of the tip on the way to the point [m/s]; inf for rapids and where only `least_time` rules."""
    least_time: Floats
    """(n,) least time of the way to the point [s]: inverse-time feeds and rotations in place; 0 elsewhere."""
    block: Ints
    """(n,) line number, from 1, of the block that ends at the point or passes it."""
    stop: Bools
    """(n,) whether the motion comes to rest at the point; true for the first and the last."""
    dwell: Floats
    """(n,) time to wait at the point [s]; 0 where there is no dwell."""
    rotary: Floats | None = None
    """(n, 2) rotary joint positions that the program asks for [rad], unwound; None for cutter-location data."""
    rotary_joints: tuple[str, ...] = ()
    """Names of the joints of `rotary`, in the order of its columns."""
    source: str = ""
    """Name of the program, for messages."""
    blocks: int = 0
    """Number of blocks that were read, moving or not."""
    skipped: dict[str, int] = field(default_factory=dict)
    """Statements without meaning for motion that were passed over, and how often."""
    rapid: Bools = field(default_factory=no_rapids)
    """(n,) whether the way to the point is a rapid; where it is not given, all that has neither feed nor time."""
    operation: Ints = field(default_factory=no_operations)
    """(n,) which of `operations` the way to the point belongs to; the first where it is not given."""
    operations: tuple[Operation, ...] = (Operation(),)
    """The operations of the program, in its order."""
    controller: str = ""
    """Name of the controller that the program was read for; empty for tables and points."""
    assumed: tuple[str, ...] = ()
    """What the program leaves open and the reader took for granted, a sentence each."""

    tip_tolerance: Floats = field(default_factory=untold)
    """(n,) how far the tip may stray on the way to the point, by the program's own words [m] (CYCLE832, CTOL, cycle 32,
    G64 P, G187 E); nan where it tells none. What is obeyed is given to the fit: see `Tolerances`."""
    axis_tolerance: Floats = field(default_factory=untold)
    """(n,) the same of the tool axis [rad]."""
    normal: Floats = field(default_factory=no_normals)
    """(n, 3) unit vectors out of the part where the tool touches it at the point, by the program's own words (NX NY NZ
    of Klartext's LN); nan where it tells none. See `Tolerances.side`."""
    numbered: Ints = field(default_factory=no_numbers)
    """(k, 2) number (N) and line of each numbered block of a program for a control."""
    tool_length: Floats = field(default_factory=untold)
    """(n,) length of the tool in the spindle on the way to the point, whose tip `tip` is [m]; nan everywhere where all
    are as long as the machine's own. It changes at stops only: the joints stay, and the other tip is elsewhere."""
    bow: Floats = field(default_factory=untold)
    """(n,) most distance of the program's own way to the point from the straight one [m]: arcs, splines, and the ways
    of the tip that words of joints tell are read as points close together. 0 where it is straight."""

    spindle: Floats = field(default_factory=untold)
    """(n,) turns of the spindle per second on the way to the point [1/s]: above zero clockwise seen from the spindle
    (M3), below it counterclockwise (M4), 0 where it stands; nan where the program does not tell it."""
    workpiece: WorkpieceFigures = field(default_factory=WorkpieceFigures)
    """What the program tells of the workpiece (BLK FORM, WORKPIECE)."""
    speed_profile: SpeedProfile | None = None
    """Most speed of the tip from place to place, beside the feeds: what the cut allows. None: the feeds alone hold."""

    def __post_init__(self) -> None:
        taken = self._figures() | self._marks()
        if self.rotary is not None:
            if len(self.rotary_joints) != 2:
                raise UsageError(
                    f"tool path: rotary_joints is {self.rotary_joints!r}; give the names of both columns of rotary"
                )
            taken["rotary"] = numbers(self.rotary, "tool path: rotary", (len(self.tip), 2), unit="rad")
        for name, value in taken.items():
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    def _figures(self) -> dict[str, Floats]:
        """What is told in real numbers, as it is kept. Raises UsageError, as all below."""
        tip = numbers(self.tip, "tool path: tip", ("n", 3), unit="m")
        n = len(tip)
        axis = numbers(self.axis, "tool path: axis", (n, 3))
        length = np.linalg.norm(axis, axis=1)
        if (off := np.abs(length - 1.0) > UNIT).any():
            at = int(np.argmax(off))
            raise UsageError(f"tool path: axis {at} has the length {length[at]:.9g}; divide it by its length")
        feed = numbers(self.feed, "tool path: feed", (n,), finite=False, unit="m/s")
        if not (feed > 0.0).all():
            at = int(np.argmin(feed > 0.0))
            raise UsageError(f"tool path: feed {at} is {feed[at]:g} m/s; give feeds above zero, inf for rapids")
        if n:
            ask_about_unit(float(np.abs(tip).max()), FARTHEST_PART, "tool path: a coordinate of tip", METRES)
            fastest = float(feed[np.isfinite(feed)].max(initial=0.0))
            ask_about_unit(fastest, FASTEST_FEED, "tool path: feed", METRES_PER_SECOND)
        taken = {"tip": tip, "axis": axis, "feed": feed}
        for name in ("least_time", "dwell"):
            taken[name] = numbers(getattr(self, name), f"tool path: {name}", (n,), unit="s")
            if (taken[name] < 0.0).any():
                at = int(np.argmin(taken[name]))
                raise UsageError(f"tool path: {name} {at} is {taken[name][at]:g} s; give times of 0 or more")
        for name, width in (
            ("tip_tolerance", ()), ("axis_tolerance", ()), ("tool_length", ()), ("spindle", ()), ("normal", (3,)),
        ):  # fmt: skip
            value = numbers(getattr(self, name), f"tool path: {name}", ("n", *width), finite=False)
            # a column that tells nothing may have any length: of a path that points were taken out of
            holds_values = value.size > 0 and not np.isnan(value).all()
            taken[name] = (
                numbers(value, f"tool path: {name}", (n, *width), (0, *width), finite=False)
                if holds_values
                else np.full((n, *width), np.nan)
            )
        bow = numbers(self.bow, "tool path: bow", ("n",), unit="m")
        taken["bow"] = numbers(bow, "tool path: bow", (n,), (0,), unit="m") if bow.any() else np.zeros(n)
        with np.errstate(over="ignore"):
            length = np.linalg.norm(taken["normal"], axis=1)
        if (off := (length <= 0.0) | np.isinf(length)).any():
            at = int(np.argmax(off))
            raise UsageError(
                f"tool path: normal {at} has the length {length[at]:g}; give unit vectors, or nan where none is told"
            )
        return taken

    def _marks(self) -> dict[str, Ints | Bools]:
        """What is told in whole numbers and in marks, as it is kept."""
        n = len(self.tip)
        rapid = marks(self.rapid, "tool path: rapid", ("n",))
        operation = integers(self.operation, "tool path: operation", ("n",))
        rapid = marks(rapid, "tool path: rapid", (n,), (0,)) if rapid.any() else rapid
        operation = integers(operation, "tool path: operation", (n,), (0,)) if operation.any() else operation
        if len(operation) and not (operation.min() >= 0 and operation.max() < len(self.operations)):
            raise UsageError(
                f"tool path: operation goes from {operation.min()} to {operation.max()}; there are "
                f"{len(self.operations)} operations, counted from 0"
            )
        return {
            "block": integers(self.block, "tool path: block", (n,)),
            "stop": marks(self.stop, "tool path: stop", (n,)),
            "rapid": rapid if len(rapid) == n else np.isinf(self.feed) & (np.asarray(self.least_time) <= 0.0),
            "operation": operation if len(operation) == n else np.zeros(n, dtype=np.int64),
            "numbered": integers(self.numbered, "tool path: numbered", ("k", 2)),
        }

    def __len__(self) -> int:
        return len(self.tip)

    @property
    def way_start(self) -> Floats:
        """(n, 3) where the way to each point begins [m]: at the point before, with the tip of the tool in the spindle.

        Nothing leads to the first point: its way begins at itself.
        """
        start = np.concatenate([self.tip[:1], self.tip[:-1]])
        longer = np.diff(self.tool_length)
        change = np.flatnonzero(np.abs(longer) > 0.0)
        start[change + 1] -= longer[change, None] * self.axis[change]
        return start

    @property
    def way(self) -> Floats:
        """(n, 3) the straight way of the tip to each point [m]; zero to the first."""
        return self.tip - self.way_start

    @property
    def way_length(self) -> Floats:
        """(n,) its length [m]."""
        length: Floats = np.linalg.norm(self.way, axis=1)
        return length

    def part(self, first: int, last: int) -> ToolPath:
        """The points from `first` to `last` as a path of their own, which begins and ends at rest."""
        n, kept = len(self), slice(first, last + 1)
        values = {column.name: getattr(self, column.name) for column in fields(self) if column.name != "numbered"}
        columns: dict[str, Any] = {
            name: value[kept] for name, value in values.items() if isinstance(value, np.ndarray) and len(value) == n
        }
        stop = columns["stop"].copy()
        stop[[0, -1]] = True
        profile = self.speed_profile
        if profile is not None:
            ends = np.array([first, last], dtype=np.float64)
            columns["speed_profile"] = profile.along(ends, ends - first)
        return replace(self, **(columns | {"stop": stop}))

    def with_tool(self, length: float) -> ToolPath:
        """The same poses of the machine, as the tip of a tool of this length passes them [m]; `tool_length` is nan.

        Ways of other tools are not straight for it where the tool turns: this is for what asks for joints at points.
        """
        refuse_other_unit(length, LONGEST_TOOL, "tool path: tool length", METRES)
        other = np.where(np.isnan(self.tool_length), 0.0, self.tool_length - length)
        if not other.any():
            return self
        return replace(self, tip=self.tip + other[:, None] * self.axis, tool_length=untold())

    def spindle_of(self, operation: Ints, block: Ints) -> Floats:
        """(k,) turns of the spindle per second [1/s] in blocks (k,) of operations (k,), signed as `spindle`; nan where
        the program does not tell it. Where one block is executed at several speeds, the last one that it moved at."""
        operation = integers(operation, "tool path: spindle_of: operation", ("k",))
        block = integers(block, "tool path: spindle_of: block", (len(operation),))
        lines = int(max(self.block.max(initial=0), block.max(initial=0))) + 1
        own = self.operation * lines + self.block
        order = np.argsort(own, kind="stable")
        wanted = operation * lines + block
        place = np.searchsorted(own[order], wanted, side="right") - 1
        at = order[np.maximum(place, 0)]
        alike = (place >= 0) & (self.operation[at] == operation) & (self.block[at] == block)
        found: Floats = np.where(alike, self.spindle[at], np.nan)
        return found

    @property
    def most_speed(self) -> Floats:
        """(n,) most speed of the tip on the way to each point [m/s], by its feed or its least time; inf where neither
        says."""
        timed = (self.least_time > 0.0) & (self.way_length > 0.0)
        by_time = self.way_length / np.where(timed, self.least_time, 1.0)
        found: Floats = np.where(timed, np.minimum(self.feed, by_time), self.feed)
        return found

    def fed_by(self, profile: SpeedProfile) -> ToolPath:
        """The same with a profile of speed; each way at feed that it limits has its most speed there for a feed, and no
        time of its own."""
        most = profile.most_of_ways(len(self))
        limited = (self.way_length > 0.0) & ~self.rapid & np.isfinite(most)
        feed, least_time = np.where(limited, most, self.feed), np.where(limited, 0.0, self.least_time)
        return replace(self, feed=feed, least_time=least_time, speed_profile=profile)

    @property
    def least_duration(self) -> float:
        """What no motion along it can be shorter than by much [s]: its feeds, least times and dwells."""
        way = self.way_length[1:]
        return float(np.maximum(way / self.feed[1:], self.least_time[1:]).sum() + self.dwell.sum())

    def __repr__(self) -> str:
        direction = f"rotary joints {' '.join(self.rotary_joints)}" if self.rotary is not None else "tool axes"
        # the end of a long name tells more than the folders it begins with
        source = self.source if len(self.source) <= 40 else f"...{self.source[-37:]}"
        count = counted(len(self), "point")
        return one_line(self, f"{source}: {count}" if source else count, counted(self.blocks, "block"), direction)


def check_toolpath(toolpath: object, asks: str) -> None:
    """Raise UsageError where something else is given in place of a tool path; `asks` is who asks for it."""
    if isinstance(toolpath, ToolPath):
        return
    raise UsageError(f"{asks}: {type(toolpath).__name__} in place of a tool path; give what tp.read returns")


def columns_at(toolpath: ToolPath, origin: Ints, own: Bools) -> dict[str, Any]:
    """The columns, beside poses and times, of a path with points put into its moves.

    Each point is put before or at the point `origin` (k,) of the path, and is that point itself where `own` (k,).
    """
    return {
        "feed": toolpath.feed[origin],
        "block": toolpath.block[origin],
        "stop": toolpath.stop[origin] & own,
        "dwell": np.where(own, toolpath.dwell[origin], 0.0),
        "rapid": toolpath.rapid[origin],
        "operation": toolpath.operation[origin],
        "tip_tolerance": toolpath.tip_tolerance[origin],
        "axis_tolerance": toolpath.axis_tolerance[origin],
        "tool_length": toolpath.tool_length[origin],
        "bow": toolpath.bow[origin],
        "spindle": toolpath.spindle[origin],
    }
