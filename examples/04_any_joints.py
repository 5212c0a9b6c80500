"""
Any joints along any curve
==========================

The door for robots: the path is a function of (s, order) that gives the joints and their first three derivatives by s.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

AMPLITUDE = np.array([0.8, 0.5, 1.1, 0.6, 0.9, 1.3, 0.4])
FREQUENCY = np.array([1.0, 2.0, 1.5, 3.0, 2.5, 1.0, 2.0]) * np.pi
PHASE = np.linspace(0.0, 2.0, 7)


def joints(s: np.ndarray, order: int) -> np.ndarray:
    """The order-th derivative of seven joints (n, 7) at s (n,): each derivative turns a sine by a quarter."""
    return AMPLITUDE * FREQUENCY**order * np.sin(np.outer(s, FREQUENCY) + PHASE + order * np.pi / 2.0)


path = tp.AxisPath.from_callable(joints, s0=0.0, s1=1.0)
limits = tp.Limits(velocity=2.0, acceleration=10.0, jerk=200.0, joints=path.joints)
trajectory = tp.plan(path, limits)
print(f"{trajectory.duration:.4f} s on {trajectory.mesh_points} mesh points")

# %%
# The same on a fixed mesh, as one would for a comparison.

fixed = tp.plan(path, limits, mesh=200)
print(f"{fixed.duration:.4f} s on {fixed.mesh_points}")

# %%
# Seven joints, three limits each, as dashed lines: nearly all the time one joint or another is at one of them.

points = trajectory.sample(1e-3)
figure, panels = plt.subplots(3, 1, figsize=(10, 7.5), sharex=True, layout="constrained")
kinds = (("velocity [rad/s]", points.qd, 2.0), ("acceleration [rad/s²]", points.qdd, 10.0))
for panel, (name, values, limit) in zip(panels, (*kinds, ("jerk [rad/s³]", points.qddd, 200.0))):
    panel.plot(points.t, values, linewidth=1.2)
    for side in (limit, -limit):
        panel.axhline(side, color="black", linestyle="--", linewidth=0.8)
    panel.set_ylabel(name)
    panel.grid(alpha=0.3)
panels[-1].set_xlabel("time [s]")
figure.legend(panels[0].get_lines()[:7], trajectory.joints, loc="outside upper center", ncols=7)
plt.show()
