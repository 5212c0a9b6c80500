"""
Through waypoints
=================

The smoothest curve through given positions of the joints, without a stop, beside a cubic spline through the same.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

import toolpace as tp

# %%
# Six positions of six joints, and limits that hold for each.

waypoints = np.random.default_rng(1).uniform(-1.5, 1.5, (6, 6))
limits = tp.Limits(velocity=np.full(6, 2.0), acceleration=8.0, jerk=80.0)
paths = {
    "smoothest": tp.AxisPath.from_waypoints(waypoints),
    "cubic spline": tp.AxisPath.from_spline(CubicSpline(np.linspace(0.0, 1.0, 6), waypoints)),
}
plans = {name: tp.plan(path, limits) for name, path in paths.items()}
for name, trajectory in plans.items():
    print(f"{name:13} {trajectory.duration:.3f} s, at most {trajectory.gap:.3%} from the fastest on its mesh")

# %%
# Positions and jerk of three of the joints.

figure, panels = plt.subplots(2, 2, figsize=(12, 6.5), sharex=True, layout="constrained")
for (upper, lower), (name, trajectory) in zip(panels.T, plans.items()):
    points = trajectory.sample(1e-3)
    upper.plot(points.t, points.q[:, :3])
    upper.set(title=f"{name}, {trajectory.duration:.2f} s", ylabel="position [rad]")
    lower.plot(points.t, points.qddd[:, :3], linewidth=1)
    for side in (80.0, -80.0):
        lower.axhline(side, color="black", linestyle="--", linewidth=0.8)
    lower.set(xlabel="time [s]", ylabel="jerk [rad/s³]")
    for panel in (upper, lower):
        panel.grid(alpha=0.3)
figure.legend(panels[0, 0].get_lines(), ("joint 1", "joint 2", "joint 3"), loc="outside upper center", ncols=3)
plt.show()
