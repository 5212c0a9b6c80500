"""Set-points: joint positions at equal time steps, with derivatives and the tool in the workpiece frame."""

from __future__ import annotations

import math
import os
import zipfile
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np

from toolpace.common.arrays import Floats, Ints, integers, numbers
from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import free_memory, reason, whole_file
from toolpace.common.units import format_time
from toolpace.common.value_objects import ByValue, named, one_line

OPTIONAL = "tool_length"
"""The one column that a file may lack."""
ROWS = 1 << 15
"""Rows of a block: what is worked on at once stays in the cache of a core."""
REACH = 4
"""Rows before and behind a block that come with it, for differences."""
COPIES, STREAMED_COPIES = 3, 2
"""How often as much memory as set-points take is needed at once, to sample, judge and draw them: where all of them are
held, and where each block is let go (2.3 and 1.4 were measured of 40 minutes)."""


def refuse_too_many(
    duration: float, dt: float, joints: int, what: str = "the motion takes", copies: int = COPIES
) -> None:
    """Raise UsageError where so many `copies` of set-points every `dt` [s] of a `duration` [s] would not fit into
    memory."""
    row = 8 * (1 + 4 * joints + 6 + 1)
    wanted, free = duration / dt * row * copies, free_memory()
    if wanted <= free:
        return
    least = duration * row * copies / free
    # written with two digits, and never below what just fits
    digit = 10.0 ** (math.floor(math.log10(least)) - 1)
    least = digit * math.ceil(least / digit)
    raise UsageError(
        f"set-points: {what} {format_time(duration)}, that is {duration / dt:.3g} set-points every {dt:g} s, and "
        f"{wanted / 1e9:.3g} GB of memory, of which {free / 1e9:.3g} GB are free; take a time step of {least:.2g} s or "
        "more, or split the program"
    )


class SetPointSource(Protocol):
    """Set-points that can be taken block by block: those in memory, and those of a trajectory (motion/sampling.py)."""

    @property
    def t(self) -> Floats:
        """(n,) times [s]."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the columns of positions."""

    @property
    def has_tool(self) -> bool:
        """Whether tip and axis are known."""

    def __len__(self) -> int: ...

    def rows(self, begin: int, end: int) -> SetPoints:
        """The set-points from row `begin` to before row `end`."""

    def at(self, rows: Ints) -> SetPoints:
        """The set-points of some rows (k,), in their order."""


@dataclass(frozen=True)
class Block:
    """The set-points of a motion from one row to before another, with up to `REACH` beside them."""

    near: SetPoints
    """Rows from `first` on."""
    first: int
    begin: int
    end: int
    of_all: int
    """How many rows the whole motion has."""
    _columns: dict[str, Floats] = field(default_factory=dict)

    @classmethod
    def of(cls, source: SetPointSource, begin: int, end: int) -> Block:
        """That of a source."""
        first = max(begin - REACH, 0)
        return cls(source.rows(first, min(end + REACH, len(source))), first, begin, end, len(source))

    @cached_property
    def points(self) -> SetPoints:
        """Only those from `begin` to `end`."""
        return self.near.rows(self.begin - self.first, self.end - self.first)

    def columns(self, name: str, begin: int, end: int) -> Floats:
        """(m, k) columns of some rows of the motion, turned once for all parts of the block."""
        if name not in self._columns:
            self._columns[name] = np.ascontiguousarray(getattr(self.near, name).T)
        return self._columns[name][:, begin - self.first : end - self.first]

    def times(self, begin: int, end: int) -> Floats:
        """(k,) times of some rows of the motion [s]."""
        return self.near.t[begin - self.first : end - self.first]


def in_memory(source: SetPointSource) -> SetPoints:
    """All set-points of a source at once."""
    return source if isinstance(source, SetPoints) else source.rows(0, len(source))


@dataclass(frozen=True, eq=False, repr=False)
class SetPoints(ByValue):
    """Set-points of a motion, one row a time step; lengths in m, angles in rad, times in s.

    Without a machine there is no tool: `tip` and `axis` then have no rows. Raises UsageError for arrays of other
    shapes, and for what are no numbers.
    """

    t: Floats
    """(n,) times [s], equally spaced."""
    q: Floats
    """(n, joints) joint positions."""
    qd: Floats
    """(n, joints) joint velocities."""
    qdd: Floats
    """(n, joints) joint accelerations."""
    qddd: Floats
    """(n, joints) joint jerks."""
    tip: Floats
    """(n, 3) tool tip in the workpiece frame [m], or (0, 3)."""
    axis: Floats
    """(n, 3) unit vectors from the tip to the spindle, or (0, 3)."""
    block: Ints
    """(n,) line number of the block being run."""
    joints: tuple[str, ...]
    """Names of the columns of `q`."""
    tool_length: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) of the tool in the spindle, whose tip that is [m]; (0,) where every tool is as long as the machine's own."""

    def __post_init__(self) -> None:
        n, m = len(numbers(self.t, "set-points: t", ("n",), finite=False, unit="s")), len(self.joints)
        tools = n if numbers(self.tip, "set-points: tip", ("n", 3), finite=False, unit="m").size else 0
        lengths = tools if numbers(self.tool_length, "set-points: tool_length", ("n",), finite=False).size else 0
        shapes = {"t": (n,), "q": (n, m), "qd": (n, m), "qdd": (n, m), "qddd": (n, m)}
        of_tools = {"tip": (tools, 3), "axis": (tools, 3), "tool_length": (lengths,)}
        block = integers(self.block, "set-points: block", (n,))
        block.flags.writeable = False
        object.__setattr__(self, "block", block)
        for name, shape in (shapes | of_tools).items():
            # what is not finite is for the judge to tell, with its time and joint
            value = numbers(getattr(self, name), f"set-points: {name}", shape, finite=False)
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        step = f" every {(self.t[1] - self.t[0]) * 1e3:.6g} ms" if len(self) > 1 else ""
        tool = "with the tool" if self.has_tool else "without a tool"
        return one_line(self, f"{len(self)}{step}", named(self.joints), tool)

    def rows(self, begin: int, end: int) -> SetPoints:
        """The set-points from row `begin` to before row `end`."""
        return self._picked(slice(begin, end))

    def at(self, rows: Ints) -> SetPoints:
        """The set-points of some rows (k,), in their order."""
        return self._picked(rows)

    def _picked(self, rows: slice | Ints) -> SetPoints:
        columns = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "joints"}
        picked = {name: values[rows] if len(values) else values for name, values in columns.items()}
        return SetPoints(**picked, joints=self.joints)

    @property
    def has_tool(self) -> bool:
        """Whether tip and axis are known."""
        return len(self.tip) > 0

    @property
    def tip_steps(self) -> Floats:
        """(n - 1,) way of the tip in each time step [m], of the tool in the spindle at its begin."""
        step = self.tip[1:] - self.tip[:-1]
        if len(self.tool_length):
            step += np.diff(self.tool_length)[:, None] * self.axis[1:]
        way: Floats = np.sqrt(np.einsum("ij,ij->i", step, step))
        return way

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the npz file (not compressed: a million set-points in about a second), whole or not at
        all. `tool_length` is in it where it is known."""
        arrays = {f.name: np.asarray(getattr(self, f.name)) for f in fields(self)}
        if not len(self.tool_length):
            del arrays[OPTIONAL]
        with whole_file(path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **arrays)  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SetPoints:
        """Read what `save` wrote. Raises UsageError, naming the file, where it is missing, cut short or
        another thing."""
        source = Path(path)
        cure = "plan again, into a new folder"
        try:
            with source.open("rb") as file:
                archive = np.load(file, allow_pickle=False)
                if not isinstance(archive, np.lib.npyio.NpzFile):
                    raise UsageError(f"{source}: holds one array, not set-points; give the setpoints.npz of a plan")
                names = [f.name for f in fields(cls)]
                if more := sorted(set(archive.files) - set(names)):
                    raise UsageError(f"{source}: holds {', '.join(more)} besides set-points; {cure}")
                if missing := [name for name in names if name not in (*archive.files, OPTIONAL)]:
                    raise UsageError(f"{source}: not a set-points file: lacks {', '.join(missing)}; {cure}")
                arrays = {name: archive[name] for name in archive.files}
        except ToolpaceError:
            raise
        except FileNotFoundError:
            raise UsageError(f"{source}: no such file; `toolpace plan` writes it") from None
        except OSError as error:
            raise UsageError(f"{source}: cannot read: {reason(error)}") from None
        except (ValueError, EOFError, KeyError, zipfile.BadZipFile, zipfile.LargeZipFile):
            raise UsageError(f"{source}: damaged or not a set-points file; {cure}") from None
        joints = tuple(str(name) for name in np.atleast_1d(arrays.pop("joints")))
        try:
            given = np.asarray(arrays.pop("block"))
            if given.dtype.kind not in "iu":
                raise UsageError(f"block holds {given.dtype}, not line numbers")
            block = given.astype(np.int64)
            if any(np.iscomplexobj(value) for value in arrays.values()):
                raise TypeError
            floats = {name: np.asarray(value, dtype=np.float64) for name, value in arrays.items()}
            return cls(**floats, block=block, joints=joints)
        except (ValueError, TypeError):
            raise UsageError(f"{source}: holds no numbers where set-points should be; {cure}") from None
        except UsageError as error:
            raise UsageError(f"{source}: {error}; {cure}") from None
