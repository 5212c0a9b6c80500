"""Any number of joints along any smooth curve: the door for robots. The path is a function of (s, order)."""

from __future__ import annotations

import numpy as np

import toolpace as tp

AMPLITUDE = np.array([0.8, 0.5, 1.1, 0.6, 0.9, 1.3, 0.4])
FREQUENCY = np.array([1.0, 2.0, 1.5, 3.0, 2.5, 1.0, 2.0]) * np.pi
PHASE = np.linspace(0.0, 2.0, 7)


def joints(s: np.ndarray, order: int) -> np.ndarray:
    """The order-th derivative of seven joints (n, 7) at s (n,): each derivative turns a sine by a quarter."""
    return AMPLITUDE * FREQUENCY**order * np.sin(np.outer(s, FREQUENCY) + PHASE + order * np.pi / 2.0)


def main() -> tp.Trajectory:
    path = tp.AxisPath.from_callable(joints, s0=0.0, s1=1.0)
    limits = tp.Limits(velocity=2.0, acceleration=10.0, jerk=200.0, joints=path.joints)
    trajectory = tp.plan(path, limits)
    print(f"{trajectory.duration:.4f} s on {trajectory.mesh_points} mesh points")

    # The same on a fixed mesh, as one would for a comparison.
    fixed = tp.plan(path, limits, mesh=200)
    print(f"{fixed.duration:.4f} s on {fixed.mesh_points}")
    return trajectory


if __name__ == "__main__":
    main()
