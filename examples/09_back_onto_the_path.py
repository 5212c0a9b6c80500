"""
Back onto the path
==================

Amid the motion the tool is measured off its path. The way back starts in motion, with the velocities and accelerations
that the joints have at that instant, and keeps to every limit.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

machine = tp.Machine.load("paper-ab")
trajectory = tp.plan(tp.Path.paper_arc(), machine)

# %%
# At 3.1 s the tip was measured here.

time, measured = 3.1, np.array([0.059, 0.0568, 0.0589])
commanded = trajectory.tip([time])[0][0]
print(f"off by {1e3 * np.linalg.norm(measured - commanded):.3f} mm")
again = tp.replan(trajectory, time, tip=measured)
print(f"left to run: {trajectory.duration - time:.4f} s as planned, {again.duration:.4f} s by way of the detour")
print(f"worst use of a limit {again.usage().worst:.5f}")
for part in again.skipped:
    print(f"left out of the path: {1e3 * part.length:.3f} mm, up to {1e3 * part.off:.3f} mm off the way of the tip")

# %%
# Distance from the arc, and the acceleration of joint B, over time.

points, planned = again.sample(1e-3), trajectory.sample(1e-3)
radius = np.hypot(np.hypot(points.tip[:, 0], points.tip[:, 1]), points.tip[:, 2])
across = (points.tip[:, 0] - points.tip[:, 1]) / np.sqrt(2.0)
off = np.hypot(radius - 0.1, across)
figure, (distance, joint_b) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
distance.plot(time + points.t, 1e3 * off)
distance.set(xlabel="time [s]", ylabel="distance from the path [mm]", xlim=(time - 0.1, time + 1.0))
joint = machine.joints.index("B")
joint_b.plot(planned.t, planned.qdd[:, joint], color="grey", label="as planned")
joint_b.plot(time + points.t, points.qdd[:, joint], label="from the deflection on")
joint_b.set(xlabel="time [s]", ylabel="acceleration of B [rad/s²]", xlim=(time - 0.1, time + 1.0))
joint_b.legend()
for panel in (distance, joint_b):
    panel.axvline(time, color="black", linestyle=":", linewidth=0.8)
    panel.grid(alpha=0.3)
plt.show()

# %%
# The same measurement may mean something else: the joints are where they were commanded, and the tool bends by 0.1 mm.
# Then the set-points go on without a jump, to a motion that is off the path by the opposite of it.

bending = np.array([0.06e-3, -0.07e-3, 0.04e-3])
straight = tp.replan(trajectory, time, deflection=bending, cause="bending")
bent = straight.sample(1e-3)
tips = bent.tip + bending
radius, across = np.linalg.norm(tips, axis=1), (tips[:, 0] - tips[:, 1]) / np.sqrt(2.0)
error = np.hypot(radius - 0.1, across)
print(f"bent tip off the path: {1e6 * error[0]:.0f} um at first, {1e6 * error[200:].max():.3f} um after 0.2 s")
figure, panel = plt.subplots(figsize=(8, 4), layout="constrained")
panel.plot(1e3 * bent.t, 1e6 * error)
panel.set(xlabel="time since the measurement [ms]", ylabel="bent tip off the path [µm]", xlim=(0, 200))
panel.grid(alpha=0.3)
plt.show()
