"""WORKPIECE: the blank of the simulation, which is the stock."""

from __future__ import annotations

from typing import Any

from toolpace.common.errors import UsageError
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.sinumerik.syntax.values import Value
from toolpace.programs.stock_figures import Solid, StockFigures, WorkpieceFigures

KIND, MASK, FIRST = 3, 4, 5
"""Places of the kind of blank, of the mask, and of the first figure among the arguments."""
LOWER_ABSOLUTE, CORNER_ABSOLUTE = 64, 16 + 32
"""Bits of the mask: ZI counts from the zero (else from ZA); the second corner counts from it (else from the first)."""
NOT_READ = "WORKPIECE of this form is passed over: tell the stock on the set-up sheet ([stock])"


def take_blank(values: list[Value | None], control: Control, unit: float) -> None:
    """Note the stock that WORKPIECE tells, in the work offset in force; other forms are passed over, and said.

    WORKPIECE(,,,"BOX",mask,ZA,ZI,ZB,X0,Y0,X1,Y1) and WORKPIECE(,,,"CYLINDER",mask,ZA,ZI,ZB,diameter), as SINUMERIK
    Operate writes them: ZA is the upper end, ZI the lower one; ZB, from where on the blank may be cut, is not needed.
    unit: of the figures [m].
    """
    findings = control.findings
    if len(values) <= KIND or values[KIND] is None:
        findings.ignored("WORKPIECE")
        return
    figures = [0.0 if value is None else value for value in values[MASK:]]
    try:
        shape = _shape(str(values[KIND]), [float(value) for value in figures], unit)  # type: ignore[arg-type]
        if shape is not None:
            source = f"{control.source.name}:{control.line}: WORKPIECE"
            solid = Solid(**shape, frame=control.frame_of_stock(), source=source)
            findings.workpiece = WorkpieceFigures(StockFigures(solid))
            return
    except (UsageError, TypeError, ValueError, OverflowError):
        pass
    findings.ignored("WORKPIECE")
    findings.assumed(NOT_READ)


def _shape(kind: str, figures: list[float], unit: float) -> dict[str, Any] | None:
    """The body of a mask and the figures behind it; None for a form that is not read."""
    mask, lengths = int(figures[0]) if figures else 0, [value * unit for value in figures[1:]]
    if len(lengths) < 4 or mask & ~(LOWER_ABSOLUTE | CORNER_ABSOLUTE | 128):
        return None
    upper, lower = lengths[0], lengths[1] + (0.0 if mask & LOWER_ABSOLUTE else lengths[0])
    lower, upper = sorted((lower, upper))
    if kind.upper() == "CYLINDER" and len(lengths) == 4:
        return {"cylinder": ((0.0, 0.0, lower), (0.0, 0.0, upper), lengths[3])}
    if kind.upper() != "BOX" or len(lengths) != 7:
        return None
    x0, y0, x1, y1 = lengths[3:]
    if not mask & CORNER_ABSOLUTE:
        x1, y1 = x0 + x1, y0 + y1
    elif mask & CORNER_ABSOLUTE != CORNER_ABSOLUTE:
        # which of both bits speaks of X no source tells
        return None
    (x0, x1), (y0, y1) = sorted((x0, x1)), sorted((y0, y1))
    return {"box": ((x0, y0, lower), (x1, y1, upper))}
