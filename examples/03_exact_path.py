"""
A curve given exactly
=====================

Paths need not come from programs. Here an arc with its tool axis is given as such, and timed against what the feed
alone would take.
"""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

# %%
# The quarter circle of Wu, Li, Liu and Perez (ACC 2009), radius 0.1 m, on the machine of that paper.

machine = tp.Machine.load("paper-ab")
feed = 0.03  # [m/s]
path = tp.Path.paper_arc(feed)
trajectory = tp.plan(path, machine)
by_feed = 0.1 * math.pi / 2.0 / feed
print(f"feed alone {by_feed:.4f} s, with every limit {trajectory.duration:.4f} s")
print(f"worst use of a limit {trajectory.usage().worst:.5f}")

# %%
# The same arc at higher feeds: from some feed on the axes decide, and a higher feed buys nothing.

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
feeds = np.array([0.03, 0.045, 0.06, 0.075, 0.09])
durations = []
for asked in feeds:
    faster = tp.plan(tp.Path.paper_arc(asked), machine)
    durations.append(faster.duration)
    points = faster.sample(1e-3)
    speed = np.linalg.norm(np.gradient(points.tip, 1e-3, axis=0), axis=1)
    (line,) = left.plot(points.t, 1e3 * speed, label=f"feed {asked * 1e3:.0f} mm/s")
    left.axhline(1e3 * asked, color=line.get_color(), linestyle="--", linewidth=0.8)
left.set(xlabel="time [s]", ylabel="speed of the tip [mm/s]", title="speed, and the feed as a dashed line")
left.legend()
right.plot(1e3 * feeds, durations, "o-", label="every limit")
right.plot(1e3 * feeds, 0.1 * math.pi / 2.0 / feeds, "o--", color="grey", label="feed alone")
right.set(xlabel="feed [mm/s]", ylabel="duration [s]", title="what a higher feed buys")
right.legend()
for panel in (left, right):
    panel.grid(alpha=0.3)
plt.show()
