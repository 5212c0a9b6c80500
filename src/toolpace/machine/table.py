"""A machine as a table in millimetres and degrees."""

from __future__ import annotations

import math

from toolpace.machine.file import MachineFile


def rows(file: MachineFile, kind: str) -> list[dict[str, str]]:
    """One row a joint of a machine of some class: machine, class, joint, kind, carries, travel, limits."""
    table = []
    for name, joint in file.joints.items():
        unit, scale = ("deg", 180.0 / math.pi) if joint.kind == "rotary" else ("mm", 1e3)
        low, high = joint.travel or (-math.inf, math.inf)
        table.append(
            {
                "machine": file.name,
                "class": kind,
                "joint": name,
                "kind": joint.kind,
                "carries": "workpiece" if name in file.chain.workpiece else "tool",
                "travel": "endless" if joint.wrap else f"{low * scale:g} .. {high * scale:g} {unit}",
                "velocity": f"{joint.velocity * scale:g} {unit}/s",
                "acceleration": f"{joint.acceleration * scale:g} {unit}/s^2",
                "jerk": f"{joint.jerk * scale:g} {unit}/s^3",
            }
        )
    return table


def title(file: MachineFile, kind: str) -> str:
    """Name, class and the chain from the workpiece over the bed to the tool."""
    chain = file.chain
    inward = " < ".join(["workpiece", *reversed(chain.workpiece), "bed"])
    outward = " > ".join(["", *chain.tool, "tool"])
    tool = f"tool length {chain.tool_length * 1e3:g} mm"
    return f"{file.name}: {kind}, {inward}{outward}, {tool}"
