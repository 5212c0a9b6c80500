"""Chains of the kinematics modules that have two turning axes and tell where these are.

After "Five-axis kinematics" and "Switchable kinematics" of LinuxCNC's documents, and kins(9). Words are the tip in the
part; in the frame of the bed the spindle nose is at the position of X, Y, Z.
"""

from __future__ import annotations

from collections.abc import Callable

from toolpace.machine.from_control.linuxcnc.loaded import Module
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.unplaced_axes import ALONG

DEFAULT_PIVOT = {"5axiskins": 250.0, "maxkins": 0.666}
"""The modules' own defaults of pivot-length [machine units]."""


def _combined(*figures: Figure) -> tuple[Origin, ...]:
    return tuple(origin for figure in figures for origin in figure.origins)


def _sense(module: Module, letter: str, sense: float, note: str) -> Figure:
    """The direction of a turning axis: along its letter or against it."""
    return Figure(tuple(sense * part + 0.0 for part in ALONG[letter]), (Origin(f"{module.name}: {note}"),))


def _constant_chain(module: Module, record: MachineRecord, workpiece: str, tool: str) -> None:
    """The order of the joints, which the module determines, with the nose in the origin."""
    name = Origin(f"{module.name} (the nose is at X, Y, Z)")
    record.chain["workpiece"] = Figure(tuple(workpiece), (module.origin,))
    record.chain["tool"] = Figure(("X", "Y", "Z", *tool), (module.origin,))
    record.chain["spindle_nose"] = Figure((0.0, 0.0, 0.0), (name,))
    record.chain["tool_length"] = Figure(0.0, (Origin("tools have their lengths in the set-up sheet"),))


def _tool_pin(module: Module, record: MachineRecord, name: str) -> Figure:
    """The length of tool that the module counts with beside that of the tool in force; zero where HAL connects it."""
    value = module.value(name)
    if value is not None and value.adds_tool:
        return Figure(value.number, value.origins)
    record.remarks.append(
        f"{module.name}.{name} is not connected to motion.tooloffset.z: the control does not hold the tip of a tool "
        "with a length."
    )
    return module.pin(name, 0.0)


def tilting_table(module: Module, record: MachineRecord) -> None:
    """xyzac-trt-kins and xyzbc-trt-kins: C on a tilting table A or B, whose axes need not meet."""
    tilt = "A" if module.name == "xyzac-trt-kins" else "B"
    aside = "y-offset" if tilt == "A" else "x-offset"
    _constant_chain(module, record, f"{tilt}C", "")
    x, y, z = (module.pin(f"{axis}-rot-point", 0.0) for axis in "xyz")
    offset, up = module.pin(aside, 0.0), module.pin("z-offset", 0.0)
    tool = _tool_pin(module, record, "tool-offset")
    dx, dy = (0.0, offset.number) if tilt == "A" else (offset.number, 0.0)
    height = z.number + up.number + tool.number
    record.joints["C"]["point"] = Figure((x.number, y.number, 0.0), _combined(x, y))
    record.joints[tilt]["point"] = Figure(
        (x.number + dx, y.number + dy, height), _combined(x, y, z, offset, up) + (tool.origins if tool.number else ())
    )
    conventional = module.pin("conventional-directions", 0.0)
    sense = -1.0 if conventional.number else 1.0
    note = "conventional-directions is on" if conventional.number else "the part turns by the right-hand rule"
    for letter in (tilt, "C"):
        record.joints[letter]["direction"] = _sense(module, letter, sense, note)


def two_turntables(module: Module, record: MachineRecord) -> None:
    """xyzab_tdr_kins: a table A on a table B; the part turns against the right-hand rule."""
    _constant_chain(module, record, "BA", "")
    x, y, z = (module.pin(f"{axis}-rot-point", 0.0) for axis in "xyz")
    up = module.pin("z-offset", 0.0)
    tool = _tool_pin(module, record, "tool-offset-z")
    height = z.number + tool.number
    record.joints["B"]["point"] = Figure((x.number, y.number, height), _combined(x, y, z))
    record.joints["A"]["point"] = Figure((x.number, y.number, height + up.number), _combined(x, y, z, up))
    for letter in "AB":
        note = "the tool turns by the right-hand rule, as the part sees it"
        record.joints[letter]["direction"] = _sense(module, letter, -1.0, note)


def fork_head(module: Module, record: MachineRecord) -> None:
    """5axiskins: a head whose C turns B; both axes meet above the nose. B has the other sign than ISO 841."""
    _constant_chain(module, record, "", "CB")
    pivot = _pivot(module, record)
    for letter, sense in (("C", 1.0), ("B", -1.0)):
        record.joints[letter]["point"] = Figure((0.0, 0.0, pivot.number), pivot.origins)
        record.joints[letter]["direction"] = _sense(module, letter, sense, f"sense of {letter}")


def tilting_head(module: Module, record: MachineRecord) -> None:
    """maxkins: a tilting head B above a turntable C whose axis is X = Y = 0.

    The chain is that of its inverse, by which it moves. Its forward kinematics leave the tilt out of C's turn, and are
    another machine's where both are turned.
    """
    _constant_chain(module, record, "C", "B")
    pivot = _pivot(module, record)
    conventional = module.pin("conventional-directions", 0.0)
    record.joints["B"]["point"] = Figure((0.0, 0.0, pivot.number), pivot.origins)
    record.joints["C"]["point"] = Figure((0.0, 0.0, 0.0), (Origin("maxkins: C turns about X = Y = 0"),))
    note = "conventional-directions is on" if conventional.number else "against the right-hand rule"
    record.joints["B"]["direction"] = _sense(module, "B", 1.0 if conventional.number else -1.0, note)
    record.joints["C"]["direction"] = _sense(module, "C", -1.0, "the tool turns by the right-hand rule")
    record.remarks.append(
        "maxkins moves by its inverse kinematics, which are this machine; its forward kinematics, from which it takes "
        "its position after homing, are others where B and C are both turned."
    )


def _pivot(module: Module, record: MachineRecord) -> Figure:
    """From the nose up to the tilting axis."""
    value = module.value("pivot-length")
    if value is None or not value.adds_tool:
        record.remarks.append(
            f"{module.name}.pivot-length does not have the tool's length in it (motion.tooloffset.z): the control does "
            "not hold the tip of a tool with a length."
        )
    return module.pin("pivot-length", DEFAULT_PIVOT[module.name])


CHAINS: dict[str, tuple[str, Callable[[Module, MachineRecord], None]]] = {
    "xyzac-trt-kins": ("AC", tilting_table),
    "xyzbc-trt-kins": ("BC", tilting_table),
    "xyzab_tdr_kins": ("AB", two_turntables),
    "5axiskins": ("BC", fork_head),
    "maxkins": ("BC", tilting_head),
}
"""By module: its turning axes, and what fills in [chain], and direction and point of these."""
