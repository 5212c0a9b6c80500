"""
Torques of an arm
=================

An arm of three joints, told by its masses, swings a load up and down again. Its motors hold it with most of what they
have; what is left moves it. So it goes up more slowly than down, and no acceleration limit could say that.
"""

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp


def rod(reach: float, length: float, mass: float) -> tp.Link:
    """A rod along x that turns about -y at its end, `reach` from the bed [m, kg]."""
    across = mass * length**2 / 12.0
    return tp.Link(
        "rotary", (0, -1, 0), (reach, 0, 0), mass, (reach + length / 2.0, 0, 0), (across / 50.0, across, across),
        viscous_friction=1.0, dry_friction=2.0,
    )  # fmt: skip


arm = tp.Dynamics((rod(0.0, 0.45, 8.0), rod(0.45, 0.40, 4.0), rod(0.85, 0.15, 3.0)))
motors = np.array([75.0, 28.0, 6.0])


def swing(s: np.ndarray, order: int) -> np.ndarray:
    """Up by a quarter turn and down again, each joint by its share."""
    size, phase = np.array([1.1, -0.7, 0.5]), np.pi * np.asarray(s)[:, None]
    turned = size * np.pi**order * np.sin(phase + order * np.pi / 2.0)
    return turned + np.array([0.0, 0.4, -0.2]) if order == 0 else turned


path = tp.AxisPath.from_callable(swing, joints=("shoulder", "elbow", "wrist"))
limits = tp.Limits(3.0, 40.0, 1500.0, path.joints)
plan = tp.plan(path, limits, rows=tp.torque_rows(arm, motors, path.joints))

t = np.linspace(0.0, plan.duration, 2000)
motion = plan.at(t)
shares = np.abs(arm(motion.q, motion.qd, motion.qdd)) / motors
print(f"{plan.duration:.3f} s, at most {plan.gap:.2%} slower than the best on this path and mesh")
print("held by", ", ".join(f"{name} {share:.0%}" for name, share in plan.limited_by().items() if share > 0.05))
print(tp.verify(plan, plan.limits).ok)

figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
for name, share, speed in zip(path.joints, shares.T, motion.qd.T):
    above.plot(t, 100.0 * share, label=name)
    below.plot(t, speed)
above.set(ylabel="torque [% of the motor's]")
above.legend()
below.set(xlabel="time [s]", ylabel="velocity [rad/s]")
plt.show()
