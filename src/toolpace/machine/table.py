"""A machine in words and figures for people: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine


def rows(machine: Machine) -> list[dict[str, str]]:
    """One row a joint: machine, class, joint, kind, carries, travel, velocity, acceleration, jerk."""
    table = []
    limits = machine.limits
    for i, (name, joint) in enumerate(machine.file.joints.items()):
        unit, scale = ("deg", 180.0 / math.pi) if joint.kind == "rotary" else ("mm", 1e3)
        low, high = machine.travel[i] * scale
        table.append(
            {
                "machine": machine.name,
                "class": machine.kind,
                "joint": name,
                "kind": joint.kind,
                "carries": "workpiece" if name in machine.file.chain.workpiece else "tool",
                "travel": "endless" if joint.wrap else f"{low:g} .. {high:g} {unit}",
                "velocity": f"{limits.velocity[i] * scale:g} {unit}/s",
                "acceleration": f"{limits.acceleration[i] * scale:g} {unit}/s^2",
                "jerk": f"{limits.jerk[i] * scale:g} {unit}/s^3",
            }
        )
    return table


def title(machine: Machine) -> str:
    """Name, class and the chain from the workpiece over the bed to the tool."""
    chain = machine.file.chain
    inward = " < ".join(["workpiece", *reversed(chain.workpiece), "bed"])
    outward = " > ".join(["", *chain.tool, "tool"])
    tool = f"tool length {machine.tool_length * 1e3:g} mm"
    return f"{machine.name}: {machine.kind}, {inward}{outward}, {tool}"
