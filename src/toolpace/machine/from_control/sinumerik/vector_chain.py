"""The vector chain of swivel heads and tables, and the joints of a machine that it tells.

With positions m of X, Y, Z, a tool t (from its tip to the nose) and turns R1, R2 about the directions V1, V2 the tip is

    two axes in the head (T):       p = m - I1 - R1 (I2 + R2 (I3 + t))
    two axes in the table (P):      p = R2' (R1' (m - t - I2) - I3) - I4
    one in each, the first in
    the head (M):                   p = R2' (m - I1 - R1 (I2 + t) - I3) - I4

from the zero point of the table. R turns by the right-hand rule what the axis carries, tool or workpiece. Sources:
Function Manual Tools, W1, "Toolholder with orientation capability" (kinematic types T, P, M; description of a rotation,
page 2-92 of 08/2005; a table whose axis points along +Y is turned by +45 degrees about it, page 2-98); Commissioning
Manual Operate IM9, 12/2017, "Swiveling" (pages 571 and 572: where each vector begins and ends, their closing sums, and
which datum of a transformation is which vector). A turn is counted from the position that $TC_CARR24, 25 or MD24510
name: at that one the vectors are measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.sinumerik.channel_axes import ChannelAxis
from toolpace.machine.from_control.unplaced_axes import ALONG, hold_at_rest
from toolpace.machine.geometry import parallel, turned

CLOSED = 0.002
"""Sum of a closed chain [mm]: measured figures are rounded to a micrometre."""
SHARE = 1e-9
"""Below it a component is rounding."""
DIGITS = 12
"""Decimal places that are written."""
KINDS = {"T": "both axes in the head", "P": "both axes in the table", "M": "one axis in the head, one in the table"}
TOOL = {"T": ("I1", "I2", "I3"), "P": (), "M": ("I1", "I2")}
"""Vectors on the tool's side by kind, from the slide to the nose."""
TABLE = {"T": (), "P": ("I2", "I3", "I4"), "M": ("I3", "I4")}
"""Vectors on the table's side, from machine zero to the zero point of the table."""
ON_TABLE = {"T": (False, False), "P": (True, True), "M": (False, True)}
"""Whether each axis carries the workpiece, by kind."""
CLOSING = {"T": (("I1", ("I2", "I3")),), "P": (("I4", ("I2", "I3")),), "M": (("I1", ("I2",)), ("I4", ("I3",)))}
"""The vectors that close a chain, and those that each of them takes back."""


@dataclass(frozen=True)
class SwivelAxis:
    """A turning axis of a chain."""

    name: str
    """Of the joint."""
    direction: Figure
    """(3,) about which a positive turn is right-handed for what it carries."""
    start: Figure
    """Its position at which the vectors are measured [deg]."""
    axis: ChannelAxis


class OpenEnd(NamedTuple):
    """A closing vector that does not take back what others lead."""

    name: str
    figure: Figure
    others: list[Figure]
    vector: Floats
    """(3,)"""
    wanted: Floats
    """(3,) what would close the chain."""

    @property
    def of_others(self) -> str:
        """Where the others are from."""
        return " and ".join(each.origin for each in self.others)


@dataclass(frozen=True)
class VectorChain:
    """One swivel head, table, or both."""

    kind: Figure
    """"T", "P" or "M"."""
    axes: tuple[SwivelAxis | None, SwivelAxis | None]
    """The first and the second; None where the machine has no such axis."""
    vectors: dict[str, Figure]
    """I1 to I4; those that are not there are 0."""
    tool: Figure
    """(3,) from the tip to the nose at the start."""

    def vector(self, name: str) -> Floats:
        """(3,) a vector in the units of the files."""
        figure = self.vectors.get(name)
        return np.zeros(3) if figure is None else _array(figure)

    def open_ends(self, unit: float) -> list[OpenEnd]:
        """Closing vectors that do not close.

        unit: millimetres in a unit of length.
        """
        found = []
        for name, others in CLOSING[str(self.kind.value)]:
            last, wanted = self.vector(name), -sum((self.vector(other) for other in others), np.zeros(3)) + 0.0
            if np.abs(last - wanted).max() * unit > CLOSED:
                own = self.vectors.get(name, Figure((0.0, 0.0, 0.0), self.kind.origins))
                led = [self.vectors[each] for each in others if each in self.vectors]
                found.append(OpenEnd(name, own, led, last, wanted))
        return found

    def place(self, record: MachineRecord) -> None:
        """Fill in [chain], direction and point of the turning joints; an axis that is missing is held at rest."""
        kind = str(self.kind.value)
        head, table = {"T": (self.axes, ()), "P": ((), self.axes), "M": (self.axes[:1], self.axes[1:])}[kind]
        on_tool, on_table = ([axis.name for axis in side if axis is not None] for side in (head, table))
        if len(on_tool + on_table) < 2:
            held, about_tool = self._held()
            hold_at_rest(record, held)
            # nearer to the tool than one that turns about it, else nearest the part
            if not about_tool:
                on_table = [*on_table, held]
            elif on_table:
                on_table = [held, *on_table]
            else:
                on_tool = [*on_tool, held]
        record.chain["workpiece"] = Figure(tuple(on_table), self.kind.origins)
        record.chain["tool"] = Figure(("X", "Y", "Z", *on_tool), self.kind.origins)
        nose, (tool,) = self._side(record, head, TOOL[kind], -1.0, [_unit(self.tool)])
        zero, frame = self._side(record, table, TABLE[kind], 1.0, list(np.eye(3)))
        starts = [self._starts(side) for side in (head, table)]
        straight = (Origin("the nose is at X, Y, Z"),)
        record.chain["spindle_nose"] = Figure(_rounded(nose), self._origins(TOOL[kind]) + starts[0] or straight)
        record.chain["tool_length"] = Figure(0.0, (Origin("tools have their lengths in the set-up sheet"),))
        for key, value, usual, origins in (
            ("tool_axis", tool, (0.0, 0.0, 1.0), self.tool.origins + starts[0]),
            ("workpiece_origin", zero, (0.0, 0.0, 0.0), self._origins(TABLE[kind]) + starts[1]),
            ("workpiece_x", frame[0], (1.0, 0.0, 0.0), starts[1]),
            ("workpiece_z", frame[2], (0.0, 0.0, 1.0), starts[1]),
        ):
            if np.abs(value - usual).max() > SHARE:
                record.chain[key] = Figure(_rounded(value), origins)

    def _held(self) -> tuple[str, bool]:
        """The letter of an axis beside the only one, across it, and whether that one turns about the tool."""
        only = next(axis for axis in self.axes if axis is not None)
        about_tool = parallel(_unit(only.direction), _unit(self.tool))
        letters = (letter for letter in ("AB" if about_tool else "CAB") if letter != only.name)
        return next(each for each in letters if not parallel(np.array(ALONG[each]), _unit(only.direction))), about_tool

    def _side(
        self,
        record: MachineRecord,
        axes: Sequence[SwivelAxis | None],
        names: Sequence[str],
        sign: float,
        carried: list[Floats],
    ) -> tuple[Floats, list[Floats]]:
        """Write the axes of a side, and return its end and the carried directions, all with every joint at zero.

        names: vectors from the beginning of the side to its first axis, and so on to its end; sign: -1 where they
        lead back.
        """
        ends = list(np.cumsum([sign * self.vector(name) for name in names] or [np.zeros(3)], axis=0))
        directions = [np.zeros(3) if axis is None else _unit(axis.direction) for axis in axes]
        for k in reversed(range(len(axes))):
            axis = axes[k]
            if axis is None:
                continue
            about, back = directions[k], -math.radians(axis.start.number)
            ends[k + 1 :] = [ends[k] + turned(about, back, end - ends[k]) for end in ends[k + 1 :]]
            directions[k + 1 :] = [turned(about, back, each) for each in directions[k + 1 :]]
            carried = [turned(about, back, each) for each in carried]
        for k, axis in enumerate(axes):
            if axis is not None:
                before = self._starts(axes[:k])
                joint = record.joints[axis.name]
                turned_back = Figure(_rounded(directions[k]), axis.direction.origins + before)
                joint["direction"] = turned_back if before else axis.direction
                joint["point"] = Figure(_rounded(ends[k]), self._origins(names[: k + 1]) + before or self.kind.origins)
        return ends[-1], carried

    def _origins(self, names: Sequence[str]) -> tuple[Origin, ...]:
        """Of those vectors that are not 0."""
        return tuple(origin for name in names if self.vector(name).any() for origin in self.vectors[name].origins)

    def _starts(self, axes: Sequence[SwivelAxis | None]) -> tuple[Origin, ...]:
        """Of the positions that are not 0."""
        return tuple(origin for axis in axes if axis is not None and axis.start.number for origin in axis.start.origins)

    def against_iso(self) -> list[str]:
        """Axes that turn the tool, as the part sees it, against the right-hand rule about X, Y or Z (ISO 841)."""
        found = []
        for axis, table in zip(self.axes, ON_TABLE[str(self.kind.value)]):
            if axis is not None and axis.name in ALONG:
                along = float(_unit(axis.direction) @ ALONG[axis.name])
                if (along > SHARE) if table else (along < -SHARE):
                    found.append(axis.name)
        return found


def is_direction(figure: Figure) -> bool:
    """Whether a vector is long enough to be a direction."""
    return math.hypot(*figure.vector) > SHARE


def _array(figure: Figure) -> Floats:
    return np.array(figure.vector)


def _unit(figure: Figure) -> Floats:
    vector = _array(figure)
    return vector / np.linalg.norm(vector)


def _rounded(vector: Floats) -> tuple[float, ...]:
    """Without the rounding of sums and turns."""
    return tuple(float(value) for value in np.round(vector, DIGITS) + 0.0)
