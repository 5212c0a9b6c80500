"""
What a trajectory knows
=======================

Motion at any time, peaks, what binds, and where in the program.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection

import toolpace as tp
from toolpace import demo

machine = tp.Machine.load("xyzac-trunnion")
toolpath = tp.read_text(demo.spiral_program(300, machine), machine, feed="none")
trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine)

# %%
# The motion at any time, not only at set-points.

middle = trajectory.at([trajectory.duration / 2.0])
print("joints [m, rad]", dict(zip(trajectory.joints, middle.q[0].round(5).tolist())))
print("velocities     ", dict(zip(trajectory.joints, middle.qd[0].round(5).tolist())))

# %%
# Peaks over limits in continuous time, and what holds the motion back for how long.

usage, limited_by = trajectory.usage(), trajectory.limited_by()
print("jerk over its limit, at the peak:", {joint: round(r, 4) for joint, r in usage.jerk.items()})
print("share of the time in which each limit binds:", {name: round(share, 3) for name, share in limited_by.items()})

figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
for kind, shift in (("velocity", -0.27), ("acceleration", 0.0), ("jerk", 0.27)):
    peaks = getattr(usage, kind)
    left.bar(np.arange(len(peaks)) + shift, peaks.values(), width=0.25, label=kind)
left.set_xticks(np.arange(len(trajectory.joints)), trajectory.joints)
left.axhline(1.0, color="black", linestyle="--", linewidth=0.8)
left.set(ylabel="peak / limit", title="how much of each limit is used", ylim=(0.0, 1.25))
left.legend(ncols=3, loc="upper center")
shares = dict(reversed(limited_by.items()))
right.barh(list(shares), [100.0 * share for share in shares.values()], color="C4")
right.set(xlabel="share of the time [%]", title="what holds the motion back")
plt.show()

# %%
# Set-points know their place in the program. Where is the tool slowest, but for its start and its end?

points = trajectory.sample(1e-3)
speed = np.linalg.norm(np.diff(points.tip, axis=0), axis=1) / 1e-3
slowest = 100 + int(np.argmin(speed[100:-100]))
print(f"slowest at {points.t[slowest]:.3f} s, block {points.block[slowest]}: {speed[slowest] * 60e3:.0f} mm/min")

tip = 1e3 * points.tip
figure = plt.figure(figsize=(9, 6.5), layout="constrained")
space = figure.add_subplot(projection="3d")
pieces = Line3DCollection(np.stack([tip[:-1], tip[1:]], axis=1), cmap="viridis", linewidths=3)
pieces.set_array(speed * 60e3)
space.add_collection3d(pieces)
every = slice(0, None, 60)
space.quiver(*tip[every].T, *points.axis[every].T, length=6.0, color="grey", linewidth=0.7, arrow_length_ratio=0.0)
space.plot(*tip[slowest], "o", color="red", label="slowest")
space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
space.set_aspect("equal")
space.legend()
figure.colorbar(pieces, label="speed of the tip [mm/min]", shrink=0.7)
plt.show()
