"""What a program is made of, before any dialect: lengths in mm, angles in degrees, feeds in mm/min, times in s.

Places are in the coordinates of the frames around them.
"""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.arrays import Floats


@dataclass(frozen=True)
class Line:
    """Straight to a place (3,)."""

    to: Floats
    speed: float
    """0: rapid."""


@dataclass(frozen=True)
class By:
    """Straight by a way (3,)."""

    way: Floats
    speed: float


@dataclass(frozen=True)
class Arc:
    """About a centre in a plane (0: XY, 1: ZX, 2: YZ), to a place (3,) that may lie higher; an end over the start is
    a full circle, and `turns` more whole ones follow."""

    plane: int
    centre: Floats
    """(3,); its coordinate along the normal says nothing."""
    to: Floats
    left: bool
    """Counter-clockwise, seen against the normal."""
    turns: int
    speed: float


@dataclass(frozen=True)
class Turn:
    """Straight to a place (3,) while the rotary joints go to `rotary` (2,)."""

    to: Floats
    rotary: Floats
    seconds: float
    """0: rapid."""
    vector: bool = False
    """Whether a dialect that can shall say it by the tool axis."""


@dataclass(frozen=True)
class Dwell:
    """Wait."""

    seconds: float


@dataclass(frozen=True)
class Stop:
    """M0."""


@dataclass(frozen=True)
class Tool:
    """Another tool."""

    number: str


@dataclass(frozen=True)
class Offset:
    """Another work offset."""

    name: str


@dataclass(frozen=True)
class Home:
    """At rapid to machine coordinates of some slides: slot to value."""

    to: dict[int, float]


@dataclass(frozen=True)
class Holes:
    """A drilling cycle at places (2,); `row` is the step of places in a row, `ring` centre, radius, first angle."""

    kind: str
    """drill, dwell, peck, break, tap, bore, bore and dwell."""
    top: float
    bottom: float
    to_top: bool
    """Whether it ends at the top, or at the height it began from."""
    places: tuple[tuple[float, float], ...]
    speed: float
    seconds: float = 0.0
    peck: float = 0.0
    clearance: float = 0.0
    row: tuple[float, float] | None = None
    ring: tuple[float, float, float, float] | None = None


@dataclass(frozen=True)
class Frame:
    """What is in it, in a frame: a shift (3,), a turn about an axis [slot, deg], scales or mirrors (3,)."""

    kind: str
    """shift, turn, mirror, scale."""
    value: Floats
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Tip:
    """What is in it, with X, Y, Z as the tip on the part."""

    body: tuple[Node, ...]


@dataclass(frozen=True)
class Plane:
    """What is in it, in a plane on the part whose normal is the tool axis at `rotary` (2,).

    At its beginning the rotary joints go there at rapid, and the slides stand, or the tip does (`follow`)."""

    at: Floats
    """(3,)."""
    spin: float
    """Of X about the normal [deg]."""
    rotary: Floats
    follow: bool
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Repeat:
    """So many times."""

    times: int
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Call:
    """A subprogram, by name."""

    name: int
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Row:
    """A loop over a counting variable: lines to start + k step, k from 0 to times - 1."""

    start: Floats
    step: Floats
    times: int
    speed: float


Node = Line | By | Arc | Turn | Dwell | Stop | Tool | Offset | Home | Holes | Frame | Tip | Plane | Repeat | Call | Row


@dataclass(frozen=True)
class Program:
    """A whole program, and the job it belongs to."""

    seed: int
    machine: str
    offsets: dict[str, Floats]
    tools: dict[str, float]
    machine_zero: Floats | None
    first: tuple[str, str]
    """Tool and work offset that it begins with."""
    begin: Floats
    """(3,) its first place."""
    clearance: float
    """Of pecks: a parameter of the controller [mm]."""
    body: tuple[Node, ...]
