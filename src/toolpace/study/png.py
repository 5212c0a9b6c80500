"""The figures as PNG, with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from toolpace.files import whole_file
from toolpace.study.figures import FAR, Figure, Panel

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d import Axes3D


def write_pictures(figures: Sequence[Figure], folder: Path) -> list[str]:
    """Write figure_N.png for each figure and return their names; nothing without matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure as Canvas
    except ImportError:
        return []
    names = []
    for figure in figures:
        rows, columns = len(figure.rows), max(map(len, figure.rows))
        size = (5.2 * columns, 4.8) if rows == 1 else (6.6 * max(columns, 1.35), 2.7 * rows + 0.6)
        canvas = Canvas(figsize=size, dpi=130, layout="constrained")
        FigureCanvasAgg(canvas)
        for i, row in enumerate(figure.rows):
            for j, panel in enumerate(row):
                place = (rows, len(row), i * len(row) + j + 1)
                if panel.in_space:
                    draw_in_space(canvas.add_subplot(*place, projection="3d"), panel)
                else:
                    draw_in_plane(canvas.add_subplot(*place), panel)
        named: dict[str, Artist] = {}
        for axes in canvas.axes:
            named |= dict(zip(*reversed(axes.get_legend_handles_labels())))
        canvas.legend(
            named.values(),
            named.keys(),
            loc="outside lower center",
            ncols=min(len(named), 6),
            frameon=False,
            fontsize=9,
        )
        canvas.suptitle(f"Figure {figure.number}. {figure.title}", fontsize=12, fontweight="bold")
        name = f"figure_{figure.number}.png"
        with whole_file(folder / name) as temporary:
            canvas.savefig(temporary, format="png")
        names.append(name)
    return names


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
    draw_limit(axes, panel)


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
            linestyle="none" if marks else "--" if curve.style == "dash" else "-",
            linewidth=1.3,
        )
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    axes.set_title(panel.title if not panel.note else f"{panel.title}: {panel.note}", fontsize=10)


def draw_limit(axes: Axes, panel: Panel) -> None:
    """The limit as dashed lines, where it is near enough to the curves."""
    if panel.limit is None:
        return
    low = min(np.nanmin(curve.y) for curve in panel.curves)
    high = max(np.nanmax(curve.y) for curve in panel.curves)
    for sign, reach in ((1.0, high), (-1.0, -low)):
        if reach * FAR >= panel.limit:
            axes.axhline(sign * panel.limit, color="#c92a3f", linewidth=1.0, linestyle="--")
