"""Checks of the tool, from forward kinematics and the set-up sheet: travel, tip, axis, length; rounding near a pole."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
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


def tool_checks(points: SetPoints, machine: Machine, tip: Floats, axis: Floats) -> list[Check]:
    """Travel of each joint; the tip and axis columns against `tip` and `axis`, the forward kinematics of
    `q`."""
    checks = []
    for j, joint in enumerate(points.joints):
        low, high = float(machine.travel[j, 0]), float(machine.travel[j, 1])
        unit = "rad" if machine.is_rotary[j] else "m"
        q = points.q[:, j]
        for bound, worst, at_least in ((high, int(np.argmax(q)), False), (low, int(np.argmin(q)), True)):
            if np.isfinite(bound):
                value = float(q[worst])
                over = bound - value if at_least else value - bound
                time, block = float(points.t[worst]), int(points.block[worst])
                ok = over <= TRAVEL_ROUNDING
                name = "lowest position" if at_least else "highest position"
                checks.append(Check(name, value, bound, unit, ok, time, block, joint, at_least=at_least))
    if points.has_tool:
        for name, told, true, limit, unit in (
            ("tip column", points.tip, tip, AGREEMENT, "m"),
            ("axis column", points.axis, axis, AGREEMENT, "rad"),
        ):
            off = np.sqrt(((told - true) ** 2).sum(axis=1))
            worst = int(np.argmax(off))
            time, block = float(points.t[worst]), int(points.block[worst])
            ok = bool(off[worst] <= limit)
            note = "against forward kinematics"
            checks.append(Check(name, float(off[worst]), limit, unit, ok, time, block, note=note))
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
    """Number or name of each tool on a set-up sheet (its text), and its length [m]."""
    try:
        tables = tomllib.loads(sheet)
    except tomllib.TOMLDecodeError:
        cure = "is not the text of a set-up sheet; give what the file holds"
        raise UsageError(f"verify: sheet {sheet[:40]!r} {cure}") from None
    unit = METRES[tables.get("units", {}).get("length", "mm")]
    return {_plain(name): float(tool["length"]) * unit for name, tool in tables.get("tools", {}).items()}


def _plain(name: str) -> str:
    """A tool's number without leading zeros, or its name."""
    return name.lstrip("0") or "0" if name.strip().isdigit() else " ".join(name.split())


def ways(points: SetPoints, tip: Floats, axis: Floats) -> Floats:
    """(n - 1, 3) how the tip at (n, 3) goes in each step, with the tool in the spindle at its begin: where another one
    takes its place the tip is elsewhere, and did not go there."""
    step = np.diff(tip, axis=0)
    if len(points.tool_length):
        step += np.diff(points.tool_length)[:, None] * axis[1:]
    return step


def length_checks(points: SetPoints, machine: Machine, toolpath: ToolPath, table: Mapping[str, float]) -> list[Check]:
    """The lengths that set-points name against the program's, and the program's against the sheet."""
    own = machine.tool_length
    wanted = np.where(np.isnan(toolpath.tool_length), own, toolpath.tool_length)
    named = points.tool_length if len(points.tool_length) else np.array([own])
    lengths = np.unique(wanted[1:])
    off = np.abs(named[:, None] - lengths).min(axis=1)
    worst = int(np.argmax(off))
    checks = []
    if len(points.tool_length) or (off > SAME).any():
        ok, note = bool(off[worst] <= SAME), "against those of the program's tools"
        place = float(points.t[worst]), int(points.block[worst])
        checks.append(Check("tool length of set-points", float(off[worst]), SAME, "m", ok, *place, note=note))
    return [*checks, *_sheet_check(own, toolpath, wanted, table)]


def _sheet_check(own: float, toolpath: ToolPath, wanted: Floats, table: Mapping[str, float]) -> list[Check]:
    """Whether each way of the program is that of a tool as long as the sheet says, or as the program's own words do."""
    if not table:
        return []
    worst, at = 0.0, 1
    for k, operation in enumerate(toolpath.operations):
        rows = 1 + np.flatnonzero(toolpath.operation[1:] == k)
        if not len(rows):
            continue
        name = _plain(operation.tool)
        alone = next(iter(table.values())) if len(table) == 1 and not name else own
        right = np.array([table.get(name, alone), *operation.told_lengths])
        off = np.abs(wanted[rows, None] - right).min(axis=1)
        if off.max() > worst:
            worst, at = float(off.max()), int(rows[np.argmax(off)])
    note = f"of tool {toolpath.operations[toolpath.operation[at]].tool or 'without a name'}, against the set-up sheet"
    return [Check("tool length", worst, SAME, "m", worst <= SAME, block=int(toolpath.block[at]), note=note)]
