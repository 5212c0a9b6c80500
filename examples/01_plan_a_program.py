"""
From a program to a verified motion
===================================

Read, fit, plan, judge, write. The picture shows each axis against its limits: at any time one of them binds, or the
feed does.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import toolpace as tp
from toolpace.cli import demo_programs

# %%
# The program is one pass round a blade, 300 blocks of half a millimetre. Any program of yours will do.

folder = Path(tempfile.mkdtemp())
program = folder / "blade.ngc"
program.write_text(demo_programs.spiral_program(300))

# %%
# The curve may stray 10 micrometres from the program, and the tool axis 0.0008 radians: that makes it smooth. Without
# ``feed`` the feeds of the program hold.

machine = tp.Machine.load("xyzac-trunnion")
toolpath = tp.read(program, machine, feed="none")  # as fast as the machine can
path = tp.Path.fit(toolpath, tip_tolerance=10e-6, axis_tolerance=8e-4, machine=machine)
trajectory = tp.plan(path, machine)

# %%
# The judge knows nothing of the planner. It raises an error where a limit or a tolerance is broken.

tp.verify(trajectory, machine, toolpath, tip_tolerance=10e-6, axis_tolerance=8e-4).raise_if_failed()
trajectory.save(folder / "setpoints.npz")
tp.report(trajectory, folder / "report.html", toolpath)

print(f"{len(toolpath)} points in {trajectory.duration:.3f} s")
print(f"at most {trajectory.gap:.4%} from the fastest on its mesh")
for what, share in trajectory.limited_by().items():
    print(f"limited by {what:15} {share:6.1%} of the time")

# %%
# Velocity, acceleration and jerk of the five axes, with their limits as dashed lines.

points = trajectory.sample(1e-3)
rows = {
    "velocity": (points.qd, machine.limits.velocity, "/s"),
    "acceleration": (points.qdd, machine.limits.acceleration, "/s²"),
    "jerk": (points.qddd, machine.limits.jerk, "/s³"),
}
figure, panels = plt.subplots(3, 5, figsize=(13, 6.5), sharex=True, layout="constrained")
for row, (kind, (values, limits, per)) in zip(panels, rows.items()):
    for joint, panel in enumerate(row):
        unit = "rad" if machine.is_rotary[joint] else "m"
        panel.plot(points.t, values[:, joint], linewidth=1, color=f"C{joint}")
        for limit in (limits[joint], -limits[joint]):
            panel.axhline(limit, color="black", linestyle="--", linewidth=0.8)
        panel.set_title(f"{kind} of {machine.joints[joint]} [{unit}{per}]", fontsize=9)
        panel.tick_params(labelsize=8)
for panel in panels[-1]:
    panel.set_xlabel("time [s]", fontsize=9)
plt.show()
