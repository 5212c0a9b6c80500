"""The figures as PNG, with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolpace.files import whole_file
from toolpace.study.figures import Figure, Panel

FAR = 3.0
"""Limits further out than this multiple of the data are named, not drawn."""


def write(figures: Sequence[Figure], folder: Path) -> list[str]:
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
                space = any(curve.z is not None for curve in panel.curves)
                axes = canvas.add_subplot(
                    rows, len(row), i * len(row) + j + 1, **({"projection": "3d"} if space else {})
                )
                draw(axes, panel, space)
        named: dict[str, Any] = {}
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


def draw(axes: Any, panel: Panel, space: bool) -> None:
    """One panel on its axes."""
    for curve in panel.curves:
        style: dict[str, Any] = {"color": curve.colour, "label": curve.name or None}
        if curve.style == "marks":
            style |= {"linestyle": "none", "marker": "o", "markersize": 4}
        else:
            style |= {"linewidth": 1.3, "linestyle": "--" if curve.style == "dash" else "-"}
        data = (curve.x, curve.y, curve.z) if space else (curve.x, curve.y)
        axes.plot(*data, **style)
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    if space:
        axes.set_zlabel(panel.z_label)
        axes.tick_params(labelsize=8)
        axes.locator_params(nbins=5)
        axes.set_aspect("equal")
        axes.view_init(elev=18, azim=-62)
    else:
        axes.grid(True, color="#e4e8ee", linewidth=0.7)
        axes.spines[["top", "right"]].set_visible(False)
        if panel.equal:
            axes.set_aspect("equal", adjustable="datalim")
    title = panel.title if not panel.note else f"{panel.title}: {panel.note}"
    axes.set_title(title, fontsize=10)
    limits(axes, panel)


def limits(axes: Any, panel: Panel) -> None:
    """The limit as dashed lines, where it is near enough to the curves."""
    if panel.limit is None:
        return
    low = min(np.nanmin(curve.y) for curve in panel.curves)
    high = max(np.nanmax(curve.y) for curve in panel.curves)
    for sign, reach in ((1.0, high), (-1.0, -low)):
        if reach * FAR >= panel.limit:
            axes.axhline(sign * panel.limit, color="#c92a3f", linewidth=1.0, linestyle="--")
