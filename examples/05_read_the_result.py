"""What a trajectory knows: motion at any time, peaks, what binds, and where in the program."""

from __future__ import annotations

import numpy as np

import toolpace as tp
from toolpace import demo


def main() -> tp.Trajectory:
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(demo.spiral_program(300, machine), machine)
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine)

    middle = trajectory.at(trajectory.duration / 2.0)
    print("joints [m, rad]", dict(zip(trajectory.joints, middle.q.round(5))))
    print("velocities     ", dict(zip(trajectory.joints, middle.qd.round(5))))

    usage = trajectory.usage()
    print("jerk over its limit, at the peak:", {joint: round(r, 4) for joint, r in usage.jerk.items()})
    print("share of the time in which each limit binds:", trajectory.limited_by())

    points = trajectory.sample(1e-3)
    speed = np.linalg.norm(np.diff(points.tip, axis=0), axis=1) / 1e-3
    slowest = 100 + int(np.argmin(speed[100:-100]))
    print(f"slowest at {points.t[slowest]:.3f} s, block {points.block[slowest]}: {speed[slowest] * 60e3:.0f} mm/min")
    return trajectory


if __name__ == "__main__":
    main()
