"""Checks of the tool, from forward kinematics and the set-up sheet: travel, tip, axis, length; rounding near a pole."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import parse_length
from toolpace.judge.seen_motion import SeenMotion, each_block, ways
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

AGREEMENT = 1e-8
"""How far the columns of tip and axis may be from forward kinematics [m or rad]."""
TRAVEL_ROUNDING = 1e-9
"""How far out of travel a joint may be by rounding [m or rad]."""
STEP = 1e-6
"""Angle by which a joint is turned to see what the tool axis and the tip do [rad]."""
LEAST = 1e-6
"""Least turn of the tool axis over that of the joint that counts: nearer to the pole the joint is free."""
SAME = 1e-9
"""Lengths that differ by less are one [m]: sheets are written in millimetres and inches."""
METRES = {"m": 1.0, "mm": 1e-3, "in": 0.0254}


def forward_kinematics(points: SetPoints, machine: Machine) -> tuple[Floats, Floats]:
    """Tips (n, 3) [m] and tool axes (n, 3) of the set-points' joint positions."""
    tip, axis = np.empty((len(points), 3)), np.empty((len(points), 3))

    def of_block(begin: int, end: int) -> None:
        rows = slice(begin, end)
        tip[rows], axis[rows] = machine.forward(points.q[rows], points.tool_length[rows] if lengths else None)

    lengths = len(points.tool_length)
    each_block(of_block, len(points))
    return tip, axis


def tool_checks(seen: SeenMotion, machine: Machine) -> list[Check]:
    """Travel of each joint; the tip and axis columns against the forward kinematics of positions."""
    assert seen.tool is not None
    checks, highest, lowest, off = [], seen.tool.highest, seen.tool.lowest, seen.tool.off
    for j, joint in enumerate(seen.joints):
        low, high = float(machine.travel[j, 0]), float(machine.travel[j, 1])
        unit = "rad" if machine.is_rotary[j] else "m"
        for bound, worst, at_least in ((high, int(highest.row[j]), False), (low, int(lowest.row[j]), True)):
            if np.isfinite(bound):
                value = -float(lowest.value[j]) if at_least else float(highest.value[j])
                over = bound - value if at_least else value - bound
                time, block = seen.place(worst)
                ok = over <= TRAVEL_ROUNDING
                name = "lowest position" if at_least else "highest position"
                checks.append(Check(name, value, bound, unit, ok, time, block, joint, at_least=at_least))
    for name, unit, value, worst in zip(("tip column", "axis column"), ("m", "rad"), off.value, off.row):
        time, block = seen.place(worst)
        ok, note = bool(value <= AGREEMENT), "against forward kinematics"
        checks.append(Check(name, float(value), AGREEMENT, unit, ok, time, block, note=note))
    return checks


def pole_rounding(q: Floats, machine: Machine) -> Floats:
    """(n, m) how far positions (n, m) may be off [m or rad] because a pole is near, beyond their own rounding.

    A joint that turns the tool axis by a share s of its own turn is known from an axis of 1e-16 to 1e-16 / s only, and
    the linear joints follow it, as the tip stays where it is.
    """
    out = np.zeros_like(q)
    for j in machine.rotary:
        turn = STEP * (np.arange(q.shape[1]) == j)
        (tip0, axis0), (tip1, axis1) = machine.forward(q - turn), machine.forward(q + turn)
        share = np.linalg.norm(axis1 - axis0, axis=1) / (2.0 * STEP)
        lever = np.linalg.norm(tip1 - tip0, axis=1) / (2.0 * STEP)
        off = np.finfo(float).eps * (1.0 / np.clip(share, LEAST, 1.0) - 1.0)
        out[:, j] += off
        out[:, machine.linear] += (lever * off)[:, None]
    return out


def tool_table(sheet: str) -> dict[str, float]:
    """Number or name of each tool on a set-up sheet (its text), and its length [m]; nan: as the machine's own."""
    try:
        tables = tomllib.loads(sheet)
    except tomllib.TOMLDecodeError:
        cure = "is not the text of a set-up sheet; give what the file holds"
        raise UsageError(f"verify: sheet {sheet[:40]!r} {cure}") from None
    unit = METRES[tables.get("units", {}).get("length", "mm")]
    written = {_plain(name): tool.get("length", math.nan) for name, tool in tables.get("tools", {}).items()}
    return {name: parse_length(each) if isinstance(each, str) else each * unit for name, each in written.items()}


def _plain(name: str) -> str:
    """A tool's number without leading zeros, or its name."""
    return name.lstrip("0") or "0" if name.strip().isdigit() else " ".join(name.split())


def way_lengths(points: SetPoints, tip: Floats, axis: Floats) -> Floats:
    """(n - 1,) how far the tip goes in each step [m]; see `ways`."""
    lengths = np.empty(len(points) - 1)

    def of_block(begin: int, end: int) -> None:
        lengths[begin:end] = np.sqrt((ways(points.tool_length, tip, axis, begin, end) ** 2).sum(axis=1))

    each_block(of_block, len(lengths))
    return lengths


def tool_lengths(machine: Machine, toolpath: ToolPath) -> Floats:
    """(n,) of the tool on the way to each point of a program [m]."""
    return np.where(np.isnan(toolpath.tool_length), machine.tool_length, toolpath.tool_length)


def length_checks(seen: SeenMotion, machine: Machine, toolpath: ToolPath, table: Mapping[str, float]) -> list[Check]:
    """The lengths that set-points name against the program's, and the program's against the sheet."""
    assert seen.tool is not None
    off, row, checks = 0.0, 0, []
    named = len(seen.tool.length_off.value) > 0
    if named:
        off, row = float(seen.tool.length_off.value[0]), int(seen.tool.length_off.row[0])
    else:
        off = float(np.abs(machine.tool_length - tool_lengths(machine, toolpath)[1:]).min())
    if named or off > SAME:
        note = "against those of the program's tools"
        checks.append(Check("tool length of set-points", off, SAME, "m", off <= SAME, *seen.place(row), note=note))
    return [*checks, *sheet_check(machine, toolpath, table)]


def sheet_check(machine: Machine, toolpath: ToolPath, table: Mapping[str, float]) -> list[Check]:
    """Whether each way of the program is that of a tool as long as the sheet says, or as the program's own words do."""
    if all(map(math.isnan, table.values())):
        return []
    own, wanted, worst, at = machine.tool_length, tool_lengths(machine, toolpath), 0.0, 1
    for k, operation in enumerate(toolpath.operations):
        rows = 1 + np.flatnonzero(toolpath.operation[1:] == k)
        if not len(rows):
            continue
        name = _plain(operation.tool)
        alone = next(iter(table.values())) if len(table) == 1 and not name else own
        listed = table.get(name, alone)
        right = np.array([own if math.isnan(listed) else listed, *operation.told_lengths])
        off = np.abs(wanted[rows, None] - right).min(axis=1)
        if off.max() > worst:
            worst, at = float(off.max()), int(rows[np.argmax(off)])
    note = f"of tool {toolpath.operations[toolpath.operation[at]].tool or 'without a name'}, against the set-up sheet"
    return [Check("tool length", worst, SAME, "m", worst <= SAME, block=int(toolpath.block[at]), note=note)]
