"""
Three planners on one path
==========================

The fastest motion; that of the genetic algorithm of Wu, Li, Liu and Perez (ACC 2009); and the fastest one if jerk were
free, to see what jerk limits cost.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

machine = tp.Machine.load("paper-ab")
path = tp.Path.paper_arc(feed=0.06)
plans = {
    "optimal": tp.plan(path, machine),
    "genetic, 10 generations": tp.plan(path, machine, planner=tp.Genetic(generations=10)),
    "second order": tp.plan(path, machine, planner=tp.SecondOrder()),
}
for name, trajectory in plans.items():
    jerk = max(trajectory.usage().jerk.values())
    print(f"{name:25} {trajectory.duration:.4f} s, jerk up to {jerk:.4f} of its limit")

# %%
# Accelerations of the planner without jerk limits jump: its jerk is infinite, and no machine can follow.

figure, (speeds, accelerations) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
joint = machine.joints.index("A")
for name, trajectory in plans.items():
    points = trajectory.sample(1e-3)
    speeds.plot(points.t, 1e3 * np.linalg.norm(np.gradient(points.tip, 1e-3, axis=0), axis=1), label=name)
    accelerations.plot(points.t, points.qdd[:, joint])
speeds.set(xlabel="time [s]", ylabel="speed of the tip [mm/s]")
speeds.legend()
accelerations.set(xlabel="time [s]", ylabel="acceleration of A [rad/s²]")
for panel in (speeds, accelerations):
    panel.grid(alpha=0.3)
plt.show()
