"""Machines of LinuxCNC's kinematics that are not built in."""

from __future__ import annotations

from toolpace.machine.machine import Machine

XYZBC_TRT = """
name = "xyzbc-trt"
[units]
length = "mm"
angle = "deg"
[chain]
workpiece = ["B", "C"]
tool = ["X", "Y", "Z"]
spindle_nose = [0, 0, 0]
tool_length = 0
"""


def _joint(name: str, kind: str, direction: list[int], more: str) -> str:
    limits = "velocity = 60\nacceleration = 400\njerk = 4000"
    return f'[joints.{name}]\nkind = "{kind}"\ndirection = {direction}\n{limits}\n{more}\n'


def xyzbc_trt() -> Machine:
    """A table C, at x = 7, y = -4, on a tilting table B whose axis is 20 mm aside of it and 15 mm up."""
    joints = [
        _joint("X", "linear", [1, 0, 0], "travel = [-500, 500]"),
        _joint("Y", "linear", [0, 1, 0], "travel = [-500, 500]"),
        _joint("Z", "linear", [0, 0, 1], "travel = [-500, 500]"),
        _joint("B", "rotary", [0, 1, 0], "travel = [-120, 120]\npoint = [27, 0, 15]"),
        _joint("C", "rotary", [0, 0, 1], "travel = [-3600, 3600]\npoint = [7, -4, 0]"),
    ]
    # its machine coordinates are positions of the joints
    setup = "[setup]\nmachine_zero = { X = 0, Y = 0, Z = 0 }\n"
    return Machine.from_toml(XYZBC_TRT + "".join(joints) + setup, "xyzbc-trt.toml")
