"""The results of the comparison as a picture."""

from __future__ import annotations

import statistics
from pathlib import Path

from benchmarks.tables import GUARDED, Results

COLOURS = {
    "toolpace": "#1f77b4",
    "toolpace, guarded": "#17becf",
    "toppra": "#7f7f7f",
    "IPOPT": "#9467bd",
    "copp, one pass": "#d62728",
    "copp, its loop": "#ff7f0e",
    "linear program": "#8c564b",
    "ruckig": "#e377c2",
}
HIGHEST = 1.6
"""Durations beyond this multiple of ours are left out of the picture; the tables have them."""


def draw(results: Results, path: Path) -> None:
    """Time a point and duration over the number of cells: medians as lines, from least to worst as bands."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (speed, duration) = plt.subplots(1, 2, figsize=(12, 4.8))
    for planner in results.planners:
        colour = COLOURS.get(planner, "black")
        by_n: dict[str, list[tuple[int, list[float]]]] = {"speed": [], "duration": []}
        for n in results.meshes:
            cases = [c for c in results.cases if (c, n, planner) in results.by]
            times = [v for c in cases if (v := results.get(c, n, planner, "us_a_point")) is not None]
            shares = [v for c in cases if (v := results.ratio(c, n, (planner, "duration_s"), (GUARDED, "duration_s")))]
            by_n["speed"] += [(n, times)] if times else []
            by_n["duration"] += [(n, shares)] if shares else []
        for axes, found in ((speed, by_n["speed"]), (duration, by_n["duration"])):
            if not found:
                continue
            n_ = [n for n, _ in found]
            axes.plot(n_, [statistics.median(v) for _, v in found], "o-", color=colour, label=planner)
            axes.fill_between(n_, [min(v) for _, v in found], [max(v) for _, v in found], color=colour, alpha=0.12)
    speed.set(xscale="log", yscale="log", xlabel="mesh cells", ylabel="microseconds a point, one thread")
    duration.set(xscale="log", xlabel="mesh cells", ylabel="duration / that of toolpace, guarded", ylim=(0.9, HIGHEST))
    for axes in (speed, duration):
        axes.grid(True, alpha=0.3)
        axes.set_xticks(results.meshes, [str(n) for n in results.meshes])
        axes.minorticks_off()
    handles, labels = speed.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False, fontsize=9)
    figure.suptitle("Medians over all paths; bands from the least to the worst", fontsize=11)
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    figure.savefig(path, dpi=110)
    plt.close(figure)
