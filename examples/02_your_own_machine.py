"""
A machine of your own
=====================

A machine file says which joints carry the workpiece and which the tool, from the bed outwards, and how far and how fast
each moves. Nothing else has to be set up: kinematics follow from it, both ways.
"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp

# %%
# Points and directions are in the frame of the bed, with every joint at zero. This machine has a table that slides and
# turns, and a head that tilts.

MILL = """
name = "my-mill"
[units]
length = "mm"
angle = "deg"
[chain]
workpiece = ["Y", "C"]              # from the bed to the workpiece
workpiece_origin = [0, 0, 100]
tool = ["X", "Z", "B"]              # from the bed to the tool
spindle_nose = [0, 0, 300]
tool_length = 120
"""
JOINT = """
[joints.{name}]
kind = "{kind}"
direction = {direction}
point = {point}
{range}
velocity = {limits[0]}
acceleration = {limits[1]}
jerk = {limits[2]}
"""
linear, rotary = (400, 4000, 40000), (120, 600, 6000)
JOINTS = [
    ("X", "linear", [1, 0, 0], [0, 0, 0], "travel = [-400, 400]", linear),
    ("Y", "linear", [0, 1, 0], [0, 0, 0], "travel = [-300, 300]", linear),
    ("Z", "linear", [0, 0, 1], [0, 0, 0], "travel = [-200, 350]", linear),
    ("B", "rotary", [0, 1, 0], [0, 0, 450], "travel = [-95, 95]", rotary),
    ("C", "rotary", [0, 0, -1], [0, 0, 0], "wrap = true", rotary),
]
names = ("name", "kind", "direction", "point", "range", "limits")
text = MILL + "".join(JOINT.format(**dict(zip(names, joint))) for joint in JOINTS)

machine = tp.Machine.from_toml(text, "my-mill.toml")  # or Machine.load("my-mill.toml")
print(machine)

# %%
# Forward kinematics, and back: two ways to reach a tool axis, then the linear joints of each.

q = np.array([[0.02, -0.03, 0.05, np.radians(30.0), np.radians(70.0)]])
tip, axis = machine.forward(q)
ways, _pole = machine.rotary_solutions(axis)
for way in ways[0]:
    print("rotary", np.degrees(way).round(3), "joints", machine.joints_at(tip, way[None])[0].round(4))

# %%
# A tool axis that swings from one side through upright to the other, passing the pole at a degree: one way tilts B
# through zero, the other one turns the table by half a turn. The planner chooses over the whole path.

swing = np.radians(np.linspace(-60.0, 60.0, 601))
beside = np.radians(1.0)
axes = np.stack([np.sin(swing), np.sin(beside) * np.cos(swing), np.cos(beside) * np.cos(swing)], axis=1)
ways, _pole = machine.rotary_solutions(axes)
figure, panels = plt.subplots(1, 2, figsize=(11, 4), sharex=True, layout="constrained")
for panel, column in zip(panels, range(2)):
    joint = machine.joints[machine.rotary[column]]
    for way in range(2):
        angle = np.degrees(ways[:, way, column])
        angle[1:][np.abs(np.diff(angle)) > 180.0] = np.nan  # where it is counted from the other side
        panel.plot(np.degrees(swing), angle, label=f"solution {way + 1}")
    panel.set(title=f"joint {joint}", xlabel="tilt of the tool axis [deg]", ylabel=f"{joint} [deg]")
    panel.grid(alpha=0.3)
    panel.legend()
plt.show()
