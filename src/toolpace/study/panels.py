"""Figures as plain data: panels of curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats

JOINT_COLOURS = {"X": "#2563c9", "Y": "#0f8a6a", "Z": "#7a4fd0", "A": "#d9622b", "B": "#c2255c"}
WAY_COLOURS = {"literal": "#0f8a6a", "genetic": "#d9622b", "optimal": "#2563c9"}
"""By planner, and of the way back to the letter."""
WAY_NAMES = {"literal": "to the letter", "genetic": "genetic (the paper's planner)", "optimal": "optimal"}
"""The same, in legends."""
GIVEN, MARK, INK = "#9aa5b4", "#c2255c", "#17202e"
"""Colours of what is given, of marks, and of text."""
LIMIT = "#c92a3f"
FAR = 3.0
"""Limits further out than this multiple of the data are named, not drawn."""


@dataclass(frozen=True)
class Curve:
    """One line, or marks, of a panel; z for a panel in space."""

    name: str
    x: Floats
    y: Floats
    colour: str
    z: Floats | None = None
    style: str = "line"
    """line, or marks"""


@dataclass(frozen=True)
class Panel:
    """One pair or triple of axes."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    z_label: str = ""
    limit: float | None = None
    """Drawn as a line above (and below, if the curves go there); if it lies far outside it is only named."""
    note: str = ""
    equal: bool = False
    """Whether both axes have the same scale."""
    shown: tuple[float, float] | None = None
    """The part of x that is shown at first; None for all."""

    @property
    def in_space(self) -> bool:
        """Whether its curves have three coordinates."""
        return any(curve.z is not None for curve in self.curves)

    def limits_drawn(self) -> list[float]:
        """Where the limit is near enough to the curves to be drawn, above and below."""
        if self.limit is None:
            return []
        low = min(np.nanmin(curve.y) for curve in self.curves)
        high = max(np.nanmax(curve.y) for curve in self.curves)
        return [sign * self.limit for sign, reach in ((1.0, high), (-1.0, -low)) if FAR * reach >= self.limit]


@dataclass(frozen=True)
class Figure:
    """One figure of the paper, redrawn."""

    number: int
    title: str
    rows: tuple[tuple[Panel, ...], ...]
    caption: str = field(default="")


def in_space(name: str, points: Floats, colour: str, style: str = "line") -> Curve:
    """A curve of points (n, 3) [m], in mm."""
    x, y, z = 1e3 * np.atleast_2d(points).T
    return Curve(name, x, y, colour, z, style)


def joined(parts: Sequence[Floats]) -> Floats:
    """One after the other with a gap between."""
    out: Floats = np.concatenate([x for part in parts for x in ([np.nan], part)][1:])
    return out
