"""Figures as panels of curves, and as drawings (SVG)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.study.svg import SOFT, Drawing

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
WIDTH = 1160
HIGH, ROW, GAP = 380, 150, 42
"""Height of a single row of panels, of one of several, and between two of these [pixels]."""
LABEL = 22
"""The same for the label of x, where each row has one."""
LEFT, RIGHT, ABOVE, BELOW = 66, 14, 66, 44
"""Room beside a panel, above the first row, with legend and titles, and below the last [pixels]."""
AROUND, OVER = math.radians(-62.0), math.radians(18.0)
"""From where what lies in space is seen: around z from x, and above."""
TICKS = 4
"""About so many marks along an axis."""
GRID = "#e4e8ee"
SEEN = 0.6
"""Way along a curve by which its points are apart [pixels]."""
Range = tuple[float, float]


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


def figure_svg(figure: Figure) -> str:
    """A figure as a drawing."""
    rows = len(figure.rows)
    gap = GAP + LABEL * bool(figure.rows[0][0].x_label)
    high = HIGH if rows == 1 else ROW
    drawing = Drawing(WIDTH, ABOVE + rows * high + (rows - 1) * gap + BELOW, f"Figure {figure.number}")
    _legend(drawing, figure)
    for i, row in enumerate(figure.rows):
        wide = WIDTH / len(row)
        for j, panel in enumerate(row):
            corner = (j * wide + LEFT, ABOVE + i * (high + gap))
            place = Place(drawing, f"figure-{figure.number}-{i}-{j}", *corner, wide - LEFT - RIGHT, high)
            (_draw_in_space if panel.in_space else _draw_in_plane)(place, panel)
    return drawing.svg()


@dataclass(frozen=True)
class Place:
    """Where a panel is drawn [pixels]."""

    drawing: Drawing
    name: str
    left: float
    top: float
    wide: float
    high: float

    def title(self, panel: Panel) -> None:
        """Above the panel, with its note."""
        text = ": ".join(word for word in (panel.title, panel.note) if word)
        self.drawing.words((self.left, self.top - 8), text, INK, size=12, bold=True)

    def curves(self, curves: Sequence[Curve], at: Callable[[Curve], Floats]) -> None:
        """Lines and marks within the panel; `at` gives the places (n, 2) of a curve."""
        parts = self.drawing.parts
        box = f'x="{self.left:.1f}" y="{self.top:.1f}" width="{self.wide:.1f}" height="{self.high:.1f}"'
        parts.append(f'<clipPath id="{self.name}"><rect {box}/></clipPath><g clip-path="url(#{self.name})">')
        for curve in curves:
            points = at(curve)
            if curve.style == "marks":
                for point in points[np.isfinite(points).all(axis=1)]:
                    self.drawing.circle(point, 3.0, curve.colour, curve.colour)
            else:
                for piece in _pieces(points):
                    self.drawing.line(piece, curve.colour, 1.4)
        parts.append("</g>")


def _pieces(points: Floats) -> Iterator[Floats]:
    """The stretches of points (n, 2) between those that are none, without points that nobody sees apart."""
    there = np.isfinite(points).all(axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(int)))
    for begin, end in ends.reshape(-1, 2):
        if end - begin > 1:
            piece = points[begin:end]
            gone = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(piece, axis=0), axis=1))))
            seen = np.diff(np.floor(gone / SEEN), prepend=-1.0) > 0.0
            seen[-1] = True
            yield piece[seen]


def _legend(drawing: Drawing, figure: Figure) -> None:
    """Every name once, in its colour."""
    curves: dict[str, Curve] = {}
    for curve in (curve for row in figure.rows for panel in row for curve in panel.curves if curve.name):
        curves.setdefault(curve.name, curve)
    x = float(LEFT)
    for name, curve in curves.items():
        drawing.line([(x, 18.0), (x + 18.0, 18.0)], curve.colour, 3.0)
        drawing.words((x + 24.0, 22.0), name, SOFT, size=12)
        x += 48.0 + 6.6 * len(name)


def _draw_in_plane(place: Place, panel: Panel) -> None:
    """Curves with marks along both axes, and the limit."""
    drawing, limits = place.drawing, panel.limits_drawn()
    x_range = panel.shown or _range([curve.x for curve in panel.curves])
    y_range = _padded(_range([*(curve.y for curve in panel.curves), np.array(limits)]))
    if panel.equal:
        x_range, y_range = _equally(_padded(x_range), y_range, place.wide / place.high)

    def at(x: Floats, y: Floats) -> Floats:
        across = place.left + (np.asarray(x) - x_range[0]) / (x_range[1] - x_range[0]) * place.wide
        down = place.top + (y_range[1] - np.asarray(y)) / (y_range[1] - y_range[0]) * place.high
        return np.column_stack(np.broadcast_arrays(across, down))

    ends_x, ends_y = np.array(x_range), np.array(y_range)
    for mark in round_marks(*y_range):
        drawing.line(at(ends_x, np.array([mark])), GRID, 1.0)
        drawing.words(at(ends_x[:1], np.array([mark]))[0], f"{mark:.6g}", SOFT, off=(-7, 4), anchor="end", size=11)
    for mark in round_marks(*x_range):
        drawing.line(at(np.array([mark]), ends_y), GRID, 1.0)
        drawing.words(at(np.array([mark]), ends_y[:1])[0], f"{mark:.6g}", SOFT, off=(0, 15), anchor="middle", size=11)
    for value in limits:
        drawing.line(at(ends_x, np.array([value])), LIMIT, 1.0, dash=True)
    place.curves(panel.curves, lambda curve: at(curve.x, curve.y))
    place.title(panel)
    foot = (place.left + 0.5 * place.wide, place.top + place.high)
    drawing.words(foot, panel.x_label, SOFT, off=(0, 32), anchor="middle", size=12)
    x, y = place.left - 52.0, place.top + 0.5 * place.high
    drawing.parts.append(f'<g transform="rotate(-90 {x:.1f} {y:.1f})">')
    drawing.words((x, y), panel.y_label, SOFT, anchor="middle", size=12)
    drawing.parts.append("</g>")


def _draw_in_space(place: Place, panel: Panel) -> None:
    """Curves as seen from aside, in the box around them, whose three edges in front are the axes."""
    drawing = place.drawing
    ranges = [_range([points[:, k].round(6) for points in map(_points, panel.curves)]) for k in range(3)]
    corners = np.array([[x, y, z] for x in ranges[0] for y in ranges[1] for z in ranges[2]])
    seen = corners @ _view()
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = min((place.wide - 130.0) / (high[0] - low[0]), (place.high - 50.0) / (high[1] - low[1]))
    centre = np.array([place.left + 0.5 * place.wide, place.top + 0.5 * place.high])

    def at(points: Floats) -> Floats:
        found: Floats = centre + scale * (points @ _view() - 0.5 * (low + high)) * [1.0, -1.0]
        return found

    for i in range(8):
        for bit in (1, 2, 4):
            if not i & bit:
                drawing.line(at(corners[[i, i | bit]]), GRID, 1.0)
    (x0, x1), (y0, y1), (z0, z1) = ranges
    front = {
        panel.x_label: ((x0, y0, z0), (x1, y0, z0)), panel.y_label: ((x1, y0, z0), (x1, y1, z0)),
        panel.z_label: ((x0, y0, z0), (x0, y0, z1)),
    }  # fmt: skip
    for k, (label, ends) in enumerate(front.items()):
        edge = at(np.array(ends))
        drawing.line(edge, SOFT, 1.0)
        off, anchor = ((-8.0, 4.0), "end") if k == 2 else ((4.0, 16.0), "start")
        text = f"{label.split(' [')[0]} {ranges[k][0]:.1f} to {ranges[k][1]:.1f}"
        drawing.words(edge.mean(axis=0), text, SOFT, off=off, anchor=anchor, size=11)
    place.curves(panel.curves, lambda curve: at(_points(curve)))
    place.title(panel)


def _points(curve: Curve) -> Floats:
    """(n, 3) of a curve in space."""
    assert curve.z is not None
    return np.column_stack((curve.x, curve.y, curve.z))


def _view() -> Floats:
    """(3, 2) what x, y and z are across and upwards, as seen from aside."""
    c, s = math.cos(AROUND), math.sin(AROUND)
    return np.array([[-s, -math.sin(OVER) * c], [c, -math.sin(OVER) * s], [0.0, math.cos(OVER)]])


def _range(values: Sequence[Floats]) -> Range:
    """The least and the largest of all, a little apart where they are one."""
    every = np.concatenate([np.ravel(each) for each in values])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    room = 0.0 if high > low else 0.5 * abs(high) or 0.5
    return low - room, high + room


def _padded(found: Range) -> Range:
    room = 0.06 * (found[1] - found[0])
    return found[0] - room, found[1] + room


def _equally(x: Range, y: Range, shape: float) -> tuple[Range, Range]:
    """Ranges about the same middles with one scale, in a panel `shape` times as wide as high."""
    high = max(y[1] - y[0], (x[1] - x[0]) / shape)
    middles = 0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])
    wide = 0.5 * high * shape
    return (middles[0] - wide, middles[0] + wide), (middles[1] - 0.5 * high, middles[1] + 0.5 * high)


def round_marks(low: float, high: float) -> list[float]:
    """Round values, evenly apart, between two."""
    rough = (high - low) / TICKS
    size = 10.0 ** math.floor(math.log10(rough))
    step = next(size * k for k in (1.0, 2.0, 5.0, 10.0) if size * k >= rough * (1.0 - 1e-9))
    return [step * k + 0.0 for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
