"""What a plan looks like, as result.png beside this file: `python docs/pictures/result.py` draws it anew."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection

import toolpace as tp
from toolpace.cli import demo_programs

BLADE = (5.0, 10.2)
"""The stretch of time that is shown: one blade [s]."""


def plan() -> tp.Trajectory:
    """The demo's impeller, with 200 blocks a blade."""
    machine = tp.Machine.load(demo_programs.MACHINE)
    toolpath = tp.read_text(demo_programs.impeller_program(machine, 200), machine)
    return tp.plan(tp.Path.fit(toolpath, machine=machine), machine)


def draw(trajectory: tp.Trajectory, target: Path) -> None:
    """The path in space, coloured by the speed of the tip; and joints over their limits for one blade."""
    mpl.use("agg")
    mpl.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    points = trajectory.sample(1e-3)
    tip, speed = 1e3 * points.tip, 60.0 * np.linalg.norm(np.gradient(points.tip, 1e-3, axis=0), axis=1)
    figure = plt.figure(figsize=(11, 4.6), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.15))

    space = left.add_subplot(projection="3d")
    cutting = speed[1:] < 1.02 * 60.0 * demo_programs.FEED
    pieces = np.stack([tip[:-1], tip[1:]], axis=1)
    space.add_collection3d(Line3DCollection(pieces[~cutting], color="silver", linewidths=0.7))
    coloured = Line3DCollection(pieces[cutting], cmap="plasma", linewidths=1.8)
    coloured.set_array(speed[1:][cutting])
    space.add_collection3d(coloured)
    space.set(xlim=(-40, 40), ylim=(-40, 40), zlim=(0, 76))
    space.set_box_aspect((80, 80, 76), zoom=1.2)
    space.view_init(34, -60)
    space.set_axis_off()
    left.colorbar(coloured, ax=space, label="speed of the tip [m/min]", shrink=0.6, location="left")

    shown = (points.t >= BLADE[0]) & (points.t <= BLADE[1])
    limits = trajectory.limits
    kinds = {
        "velocity": points.qd / limits.velocity,
        "acceleration": points.qdd / limits.acceleration,
        "jerk": points.qddd / limits.jerk,
    }
    panels = right.subplots(3, 1, sharex=True)
    for panel, (kind, shares) in zip(panels, kinds.items()):
        panel.plot(points.t[shown], 100.0 * shares[shown], linewidth=1)
        for limit in (100.0, -100.0):
            panel.axhline(limit, color="black", linestyle="--", linewidth=0.8)
        panel.set(ylabel=f"{kind} [%]", ylim=(-115, 115))
    panels[-1].set_xlabel("time [s]")
    right.suptitle("one blade: each axis in percent of its limit", fontsize=10)
    right.legend(panels[0].get_lines()[:5], trajectory.joints, loc="outside lower center", ncols=5, frameon=False)
    figure.savefig(target, dpi=100)


if __name__ == "__main__":
    draw(plan(), Path(__file__).with_suffix(".png"))
