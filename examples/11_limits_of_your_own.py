"""
Limits of your own
==================

An arm of two links carries an open cup. Beside the limits of its joints hold the torques of its drives, and the
acceleration that the cup bears. Both are rows along the path, linear in z = (ds/dt)^2 and its derivatives.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

UPPER, LOWER = 0.5, 0.4  # lengths of the links [m]
INERTIA, COUPLING, ELBOW = 0.9, 0.25, 0.2  # m1 c1^2 + I1 + m2 (l1^2 + c2^2) + I2, m2 l1 c2, m2 c2^2 + I2 [kg m^2]
TORQUES = {"torque of the shoulder": 6.0, "torque of the elbow": 2.5}  # [N m]
BORNE = 4.0  # acceleration of the cup, in each direction [m/s^2]


def cup(q: np.ndarray) -> np.ndarray:
    """Where the cup is (n, 2) [m] with the joints at q (n, 2) [rad]."""
    reach = q[:, 0] + q[:, 1]
    x = UPPER * np.cos(q[:, 0]) + LOWER * np.cos(reach)
    return np.stack([x, UPPER * np.sin(q[:, 0]) + LOWER * np.sin(reach)], axis=1)


def torques(q: np.ndarray) -> np.ndarray:
    """Coefficients of z' and z in both torques (n, 2, 2), M q'' + c(q, q'), from the joints q (4, n, 2)."""
    cos, sin = COUPLING * np.cos(q[0, :, 1]), COUPLING * np.sin(q[0, :, 1])
    inertia = np.array([[INERTIA + 2.0 * cos, ELBOW + cos], [ELBOW + cos, ELBOW + 0.0 * cos]])
    u, v = q[1].T
    turning = np.stack([-sin * (2.0 * u * v + v * v), sin * u * u], axis=1)
    of_slope, of_bend = (np.einsum("ijn,nj->ni", inertia, q[order]) for order in (1, 2))
    return np.stack([of_slope / 2.0, of_bend + turning], axis=2)


drives = [
    tp.Rows(name, "N m", limit, lambda q, k=k: torques(q)[:, k]) for k, (name, limit) in enumerate(TORQUES.items())
]
slosh = tp.Rows.acceleration_of("slosh", "m/s^2", BORNE, cup, count=2)

waypoints = np.array([[-0.6, 1.4], [0.1, 0.9], [0.9, 1.3], [1.4, 0.6]])
path = tp.AxisPath.from_waypoints(waypoints, joints=["shoulder", "elbow"])
limits = tp.Limits(velocity=3.0, acceleration=25.0, jerk=400.0, joints=path.joints)
plans = {
    "joints alone": tp.plan(path, limits),
    "with torques": tp.plan(path, limits, rows=drives),
    "with torques and a cup": tp.plan(path, limits, rows=[*drives, slosh]),
}
for name, each in plans.items():
    most = max(each.limited_by().items(), key=lambda item: item[1])
    print(f"{name}: {each.duration:.3f} s, most of the time at the limit {most[0]}")

# %%
# What more of each limit would gain, and whether the judge, who knows nothing of the planner, finds the rows held.

full = plans["with torques and a cup"]
for name, seconds in list(full.prices().items())[:4]:
    print(f"1 % more {name}: {seconds / full.duration:.3%} of the time")
print(tp.verify(full, full.limits).ok)

# %%
# The torque of the shoulder and the acceleration of the cup, as the joints' motion over time shows them: with the time
# as parameter z is 1, and a row is its last coefficient.

figure, panels = plt.subplots(2, 1, figsize=(10, 6), sharex=True, layout="constrained")
for name, each in plans.items():
    t = np.linspace(0.0, each.duration, 2001)
    motion = each.at(t)
    moment = np.stack([motion.q, motion.qd, motion.qdd, motion.qddd])
    panels[0].plot(t, torques(moment)[:, 0, 1], label=name)
    panels[1].plot(t[1:-1], np.diff(cup(motion.q), 2, axis=0)[:, 0] / t[1] ** 2)
for panel, limit, title in zip(panels, (6.0, BORNE), ("torque of the shoulder [N m]", "cup along x [m/s²]")):
    for side in (limit, -limit):
        panel.axhline(side, color="black", linestyle="--", linewidth=0.8)
    panel.set_ylabel(title)
    panel.grid(alpha=0.3)
panels[-1].set_xlabel("time [s]")
figure.legend(loc="outside upper center", ncols=3)
plt.show()
