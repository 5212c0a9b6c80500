"""A program with a slot, a stop and a dwell, and the file of a tool that bends in it."""

from __future__ import annotations

PROGRAM = """\
G21 G90 G17
T1 M6
S18000 M3
G0 X0 Y0 Z20 A0 C0
G1 Z0 F1500
X40
Y30
G4 P0.1
X10 Y15
G0 Z20
G0 X0 Y0
M30
"""

TOOL_FILE = """\
[tool]
diameter = "4mm"
teeth = 2
helix = "30deg"
stick_out = "40mm"
[bending]
youngs_modulus = "580GPa"
[cutting]
spindle_speed = "18000rpm"
Ktc = "800MPa"
Krc = "300 N/mm2"
Kte = "15N/mm"
Kre = "12N/mm"
[engagement]
milling = "down"
axial_depth = "8mm"
radial_depth = "0.15mm"
"""
TOOL_OF_STOCK = TOOL_FILE[: TOOL_FILE.index("[engagement]")] + '[engagement]\nmilling = "stock"\n'
"""The same tool, whose engagement is that in a stock."""
