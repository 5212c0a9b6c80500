"""A machine file: two joint chains, from the bed to the workpiece and from the bed to the tool, and the limits."""

from __future__ import annotations

import numpy as np

import toolpace as tp

MILL = """
name = "my-mill"
[units]
length = "mm"
angle = "deg"
[chain]                             # points and directions: in the frame of the bed, every joint at zero
workpiece = ["Y", "C"]              # from the bed to the workpiece: a table that slides and turns
workpiece_origin = [0, 0, 100]
tool = ["X", "Z", "B"]              # from the bed to the tool: a head that tilts
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


def text() -> str:
    linear, rotary = (400, 4000, 40000), (120, 600, 6000)
    joints = [
        ("X", "linear", [1, 0, 0], [0, 0, 0], "travel = [-400, 400]", linear),
        ("Y", "linear", [0, 1, 0], [0, 0, 0], "travel = [-300, 300]", linear),
        ("Z", "linear", [0, 0, 1], [0, 0, 0], "travel = [-200, 350]", linear),
        ("B", "rotary", [0, 1, 0], [0, 0, 450], "travel = [-95, 95]", rotary),
        ("C", "rotary", [0, 0, -1], [0, 0, 0], "wrap = true", rotary),
    ]
    names = ("name", "kind", "direction", "point", "range", "limits")
    return MILL + "".join(JOINT.format(**dict(zip(names, joint))) for joint in joints)


def main() -> tp.Machine:
    machine = tp.Machine.from_toml(text(), "my-mill.toml")  # or Machine.load("my-mill.toml")
    print(machine)

    # Forward kinematics, and back: both ways to reach a tool axis, then the linear joints.
    q = np.array([[0.02, -0.03, 0.05, np.radians(30.0), np.radians(70.0)]])
    tip, axis = machine.forward(q)
    ways, _pole = machine.rotary_solutions(axis)
    for way in ways[0]:
        print("rotary", np.degrees(way).round(3), "joints", machine.joints_at(tip, way[None])[0].round(4))
    return machine


if __name__ == "__main__":
    main()
