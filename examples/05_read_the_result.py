"""
What a trajectory knows
=======================

Motion at any time, peaks, what binds, and where in the program.
"""

# sphinx_gallery_thumbnail_number = 2

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection

import toolpace as tp
from toolpace.cli import demo_programs

# %%
# An impeller of seven blades, by a tool that goes down one side of a blade and up the other.

machine = tp.Machine.load("xyzac-trunnion")
toolpath = tp.read_text(demo_programs.impeller_program(machine, 60), machine)
path = tp.Path.fit(toolpath, machine=machine)
trajectory = tp.plan(path, machine)

# %%
# The motion at any time, not only at set-points.

middle = trajectory.at(trajectory.duration / 2.0)
print("joints [m, rad]", dict(zip(trajectory.joints, middle.q.round(5).tolist())))
print("velocities     ", dict(zip(trajectory.joints, middle.qd.round(5).tolist())))

# %%
# Peaks over limits in continuous time, and what holds the motion back for how long.

usage, limited_by = trajectory.usage(), trajectory.limited_by()
for name, share in limited_by.items():
    print(f"{name:15} {share:6.2%}")

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
# Set-points know their place in the program. Where is the tool slowest while it cuts, but for the ends of a blade?

points = trajectory.sample(1e-3)
tip, speed = 1e3 * points.tip, 60.0 * np.linalg.norm(np.gradient(points.tip, 1e-3, axis=0), axis=1)
cuts = tip[:, 2] < 34.0
slowest = np.flatnonzero(cuts)[np.argmin(speed[cuts])]
print(f"slowest at {points.t[slowest]:.3f} s, block {points.block[slowest]}: {speed[slowest]:.3f} m/min")

# %%
# The path in space: rapids in grey, the rest coloured by the speed of the tip.

figure = plt.figure(figsize=(9, 6.5), layout="constrained")
space = figure.add_subplot(projection="3d")
rapid = speed[1:] > 1.02 * demo_programs.FEED * 60.0
pieces = np.stack([tip[:-1], tip[1:]], axis=1)
space.add_collection3d(Line3DCollection(pieces[rapid], color="grey", linewidths=0.6))
coloured = Line3DCollection(pieces[~rapid], cmap="plasma", linewidths=2.2)
coloured.set_array(speed[1:][~rapid])
space.add_collection3d(coloured)
space.set(xlim=(-42, 42), ylim=(-42, 42), zlim=(0, 76), xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
space.set_aspect("equal")
space.view_init(34, -60)
figure.colorbar(coloured, label="speed of the tip [m/min]", shrink=0.6)
plt.show()
