"""Figures as panels of curves, and as interactive drawings by plotly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats

if TYPE_CHECKING:
    import plotly.graph_objects as go

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
DIGITS = np.float32
"""Of what is drawn: seven digits, in half the place."""
HIGH, ROW, GAP = 460, 150, 62
"""Height of a single row of panels, of one of several, and between two of these [pixels]."""
LABEL = 22
"""The same for the label of x, where each row has one."""
ABOVE, BELOW = 90, 50
"""Margins of a drawing, with legend and titles above [pixels]."""


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


def as_html(figure: Figure) -> str:
    """A figure as a piece of a page that holds plotly.js."""
    import plotly.io

    html: str = plotly.io.to_html(
        drawn(figure), full_html=False, include_plotlyjs=False, div_id=f"figure-{figure.number}",
        config={"displaylogo": False, "responsive": True},
    )  # fmt: skip
    return html


def drawn(figure: Figure) -> go.Figure:
    """The plotly figure; all distances of its layout are shares of the height inside its margins."""
    from plotly.subplots import make_subplots

    rows, columns = len(figure.rows), max(map(len, figure.rows))
    specs = [[{"type": "scene" if panel.in_space else "xy"} for panel in row] for row in figure.rows]
    titles = [f"{p.title}<br><sup>{p.note}</sup>" if p.note else p.title for row in figure.rows for p in row]
    gap = GAP + LABEL * bool(figure.rows[0][0].x_label)
    inside = HIGH - ABOVE - BELOW if rows == 1 else rows * ROW + (rows - 1) * gap
    out = make_subplots(
        rows=rows, cols=columns, specs=specs, subplot_titles=titles, horizontal_spacing=0.08,
        vertical_spacing=gap / inside,
    )  # fmt: skip
    shown: set[str] = set()
    for i, row in enumerate(figure.rows, 1):
        for j, panel in enumerate(row, 1):
            add_panel(out, panel, i, j, shown)
    out.update_layout(
        height=inside + ABOVE + BELOW, template="plotly_white",
        margin={"l": 60, "r": 20, "t": ABOVE, "b": BELOW},
        legend={"orientation": "h", "y": 1.0 + 0.5 * ABOVE / inside, "yanchor": "bottom", "x": 0}, hovermode="closest",
        font={"size": 12},
    )  # fmt: skip
    return out


def add_panel(out: go.Figure, panel: Panel, i: int, j: int, shown: set[str]) -> None:
    """One panel of a plotly figure; every name stands once in the legend."""
    import plotly.graph_objects as go

    for curve in panel.curves:
        marks = curve.style == "marks"
        common = {
            "name": curve.name, "legendgroup": curve.name, "mode": "markers" if marks else "lines",
            "showlegend": bool(curve.name) and curve.name not in shown,
        }  # fmt: skip
        shown.add(curve.name)
        line = {"color": curve.colour, "width": 2 if curve.z is None else 4}
        marker = {"color": curve.colour, "size": 7 if curve.z is None else 3}
        style = {"marker": marker} if marks else {"line": line}
        x, y = curve.x.astype(DIGITS), curve.y.astype(DIGITS)
        if curve.z is not None:
            out.add_trace(go.Scatter3d(x=x, y=y, z=curve.z.astype(DIGITS), **common, **style), i, j)
        else:
            out.add_trace(go.Scatter(x=x, y=y, **common, **style), i, j)
    if panel.in_space:
        out.update_scenes(
            {
                "xaxis_title": panel.x_label, "yaxis_title": panel.y_label, "zaxis_title": panel.z_label,
                "aspectmode": "data",
                "camera": {"eye": {"x": 1.0, "y": -2.2, "z": 0.8}, "center": {"x": 0, "y": 0, "z": -0.15}},
            }, row=i, col=j,
        )  # fmt: skip
        return
    out.update_xaxes(title_text=panel.x_label, range=panel.shown, row=i, col=j)
    out.update_yaxes(title_text=panel.y_label, row=i, col=j)
    if panel.equal:
        name = next(t for t in reversed(out.data) if t.type == "scatter").xaxis or "x"
        out.update_yaxes(scaleanchor=name, scaleratio=1, row=i, col=j)
    for value in panel.limits_drawn():
        out.add_hline(value, line={"color": LIMIT, "width": 1, "dash": "dash"}, row=i, col=j)
