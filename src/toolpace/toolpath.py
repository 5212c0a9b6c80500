"""What a program says: points, tool axes, feeds, stops. Dense, dumb, faithful."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.description import counted, one_line
from toolpace.equality import ByValue


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


@dataclass(frozen=True, eq=False, repr=False)
class ToolPath(ByValue):
    """The points of a program in the workpiece frame; entry i speaks of point i and of the way from i - 1 to i.

    Between two points the tip moves straight; the tool axis turns along the great circle, or, where `rotary` is
    given, the rotary joints move in proportion (the reader inserts points until both agree closely).
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

    def __post_init__(self) -> None:
        for name in ("tip_tolerance", "axis_tolerance"):
            if len(getattr(self, name)) != len(self.tip):
                object.__setattr__(self, name, np.full(len(self.tip), np.nan))
        if len(self.normal) != len(self.tip):
            object.__setattr__(self, "normal", np.full((len(self.tip), 3), np.nan))
        if len(self.rapid) != len(self.tip):
            object.__setattr__(self, "rapid", np.isinf(self.feed) & (self.least_time <= 0.0))
        if len(self.operation) != len(self.tip):
            object.__setattr__(self, "operation", np.zeros(len(self.tip), dtype=np.int64))
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        return len(self.tip)

    @property
    def least_duration(self) -> float:
        """What no motion along it can be shorter than by much [s]: its feeds, least times and dwells."""
        way = np.linalg.norm(np.diff(self.tip, axis=0), axis=1)
        return float(np.maximum(way / self.feed[1:], self.least_time[1:]).sum() + self.dwell.sum())

    def __repr__(self) -> str:
        given = f"rotary joints {' '.join(self.rotary_joints)}" if self.rotary is not None else "tool axes"
        # the end of a long name tells more than the folders it begins with
        source = self.source if len(self.source) <= 40 else f"...{self.source[-37:]}"
        count = counted(len(self), "point")
        return one_line(self, f"{source}: {count}" if source else count, counted(self.blocks, "block"), given)
