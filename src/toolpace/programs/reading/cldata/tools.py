"""The shape of a tool from cutter-location data: TLDATA of NX, and CUTTER of APT."""

from __future__ import annotations

import math
from typing import Any

from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE
from toolpace.programs.reading.cldata.words import NUMBER, Statement, figure
from toolpace.programs.reading.findings import Findings
from toolpace.programs.tool_figures import ToolFigures

NOT_READ = "the shape of the tool in {} (first line {}) is not read: write it on the set-up sheet ([tools])"
SAME = 1e-3
"""By how much figures of a corner may differ, in parts of the diameter: they are printed with four decimals."""


def tool_shape(statement: Statement, unit: float, source: str, findings: Findings) -> ToolFigures | None:
    """What TLDATA or CUTTER tells of the tool; None, with an assumption noted, where it is of another form.

    unit: of its lengths [m].
    """
    words, major = statement.minors, statement.major
    kind = "CUTTER" if major == "CUTTER" else ",".join(word for word in words if not NUMBER.fullmatch(word))
    values = [figure(word) for word in words if NUMBER.fullmatch(word)]
    try:
        figures = _figures(kind, values, unit)
        if figures is not None:
            return ToolFigures(**figures, source=f"{source}:{statement.line}: {major}")
    except UsageError:
        pass
    findings.assumed(NOT_READ.format(f"{major}/{kind}"[:40], statement.line))
    return None


def _figures(kind: str, values: list[float], unit: float) -> dict[str, Any] | None:
    """Figures of a tool in SI; None for a form that is not read.

    TLDATA/MILL: diameter, lower radius, length, taper angle, tip angle (of the end, from the plane across the axis),
    and with seven numbers the centre of the lower radius. TLDATA/DRILL,MILL: diameter, radius, length, point angle,
    flute length. CUTTER: diameter, corner radius; or all seven of APT (ANSI X3.37): diameter, corner radius, its
    centre from the axis and above the tip, angle of the end, angle of the side, height.
    """
    centre = side = end = length = 0.0
    flutes = None
    if kind == "MILL" and len(values) in (5, 7):
        diameter, corner, length, side, end = values[:5]
        centre = values[5] if len(values) == 7 else 0.5 * diameter - corner
    elif kind == "DRILL,MILL" and len(values) == 5:
        diameter, corner, length, point, flutes = values
        if corner:
            return None
        drill = {"kind": "drill", "diameter": diameter * unit, "point_angle": point * DEGREE}
        return drill | {"stick_out": length * unit or None, "flute_length": flutes * unit or None}
    elif kind == "CUTTER" and len(values) in (1, 2):
        diameter, corner = (*values, 0.0)[:2]
        centre = 0.5 * diameter - corner
    elif kind == "CUTTER" and len(values) == 7:
        diameter, corner, centre, above, end, side, length = values
        if abs(above - corner) > SAME * diameter:
            return None
    else:
        return None
    if abs(centre - (0.5 * diameter - corner)) > SAME * diameter or (end and (corner or side)):
        return None
    found: dict[str, Any] = {"diameter": diameter * unit, "stick_out": length * unit or None}
    if end:
        return found | {"kind": "chamfer", "point_angle": math.pi - 2.0 * end * DEGREE}
    ball = abs(corner - 0.5 * diameter) <= SAME * diameter
    if side:
        return found | {"kind": "ball" if ball else "taper", "taper": side * DEGREE} | (
            {} if ball else {"corner_radius": corner * unit}
        )
    if ball:
        return found | {"kind": "ball"}
    return found | {"kind": "bull" if corner else "flat", "corner_radius": corner * unit}
