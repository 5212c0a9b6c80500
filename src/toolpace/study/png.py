"""Figures as PNG by matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.common.files import whole_file
from toolpace.study.drawings import LIMIT, Figure, Panel

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from mpl_toolkits.mplot3d import Axes3D

SQUARE, WIDE, HIGH = 4.0, 5.6, 1.6
"""Side of a panel that stands alone in its row, width and height of the others [inches]."""
BESIDE, ABOVE, BELOW, GAP, LABEL = 0.85, 0.75, 0.95, 0.5, 0.2
"""Room left of, above and below the panels, between two rows, and for the label of x [inches]."""


def write_pictures(figures: Sequence[Figure], folder: Path) -> list[str]:
    """Write figure_N.png for each figure and return their names; nothing without matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure as Canvas
    except ImportError:
        return []
    names = []
    for figure in figures:
        canvas = laid_out(figure, Canvas)
        FigureCanvasAgg(canvas)
        named: dict[str, Artist] = {}
        for axes in canvas.axes:
            named |= dict(zip(*reversed(axes.get_legend_handles_labels())))
        canvas.legend(
            named.values(),
            named.keys(),
            loc="lower center",
            ncols=min(len(named), 7),
            frameon=False,
            fontsize=9,
        )
        canvas.suptitle(f"Figure {figure.number}. {figure.title}", fontsize=12, fontweight="bold")
        name = f"figure_{figure.number}.png"
        with whole_file(folder / name) as temporary:
            canvas.savefig(temporary, format="png")
        names.append(name)
    return names


def laid_out(figure: Figure, kind: type[Canvas]) -> Canvas:
    """The panels of a figure on a canvas; distances are set, since to find them takes as long as to draw."""
    rows, columns = len(figure.rows), max(map(len, figure.rows))
    gap = GAP + LABEL * bool(figure.rows[0][0].x_label)
    wide, high = (SQUARE, SQUARE) if rows == 1 else (max(WIDE, 9.0 / columns), HIGH)
    size = (columns * (wide + BESIDE), rows * (high + gap) - gap + ABOVE + BELOW)
    canvas = kind(figsize=size, dpi=110)
    canvas.subplots_adjust(
        left=BESIDE / size[0], right=1.0 - 0.2 / size[0], bottom=BELOW / size[1], top=1.0 - ABOVE / size[1],
        wspace=BESIDE / wide, hspace=gap / high,
    )  # fmt: skip
    for i, row in enumerate(figure.rows):
        for j, panel in enumerate(row):
            place = (rows, len(row), i * len(row) + j + 1)
            if panel.in_space:
                draw_in_space(canvas.add_subplot(*place, projection="3d"), panel)
            else:
                draw_in_plane(canvas.add_subplot(*place), panel)
    return canvas


def draw_in_space(axes: Axes3D, panel: Panel) -> None:
    """One panel of curves in space."""
    draw_curves(axes, panel)
    axes.set_zlabel(panel.z_label)
    axes.tick_params(labelsize=8)
    axes.locator_params(nbins=5)
    axes.set_aspect("equal")
    axes.view_init(elev=18, azim=-62)


def draw_in_plane(axes: Axes, panel: Panel) -> None:
    """One panel of curves in a plane, with the limit."""
    draw_curves(axes, panel)
    axes.grid(True, color="#e4e8ee", linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
    for value in panel.limits_drawn():
        axes.axhline(value, color=LIMIT, linewidth=1.0, linestyle="--")
    if panel.shown is not None:
        axes.set_xlim(*panel.shown)


def draw_curves(axes: Axes, panel: Panel) -> None:
    """All curves of a panel, its labels and its title."""
    for curve in panel.curves:
        marks = curve.style == "marks"
        axes.plot(
            *((curve.x, curve.y) if curve.z is None else (curve.x, curve.y, curve.z)),
            color=curve.colour,
            label=curve.name or None,
            marker="o" if marks else None,
            markersize=4,
            linestyle="none" if marks else "-",
            linewidth=1.3,
        )
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    axes.set_title(panel.title if not panel.note else f"{panel.title}: {panel.note}", fontsize=10)
