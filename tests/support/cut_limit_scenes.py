"""Programs whose cut changes on the way, with their sheets: a pocket, a slot that widens, a wall with steps, a ball on
a surface."""

from __future__ import annotations

import math

HEAD = "G21 G90 G54 G17\nT1 M6\nS{turns} M3\n"
TOOL = """[tools.1]
kind = "{kind}"
diameter = {diameter}
flute_length = {flutes}
teeth = 3
helix = 30
stick_out = 40
material = "carbide"
spindle_speed = {turns}
"""


def sheet(box, kind="flat", diameter=10.0, turns=6000, uncertainty=0.0, flutes=20):
    """A set-up sheet of a box [mm] and one tool."""
    return f"[stock]\nbox = {box}\nuncertainty = {uncertainty}\n" + TOOL.format(
        kind=kind, diameter=diameter, turns=turns, flutes=flutes
    )


def pocket(size=30.0, step=2.5, depth=3.0, feed=600):
    """A square pocket from inside, in squares with corners of 90 degrees, plunged into a hole that is there: the first
    square is entered from the side of a slot."""
    lines, half = ["G0 X0 Y0 Z5", f"G1 Z-{depth} F200"], step
    while half <= 0.5 * size - 5.0 + 1e-9:
        lines.append(f"G1 X{half:g} F{feed}" if half == step else f"G1 X{half:g}")
        lines += [f"G1 Y{half:g}", f"G1 X{-half:g}", f"G1 Y{-half:g}", f"G1 X{half:g}", "G1 Y0"]
        half += step
    low = -0.5 * size - 10.0
    return HEAD.format(turns=6000) + "\n".join(lines) + "\nG0 Z20\nM30\n", sheet([[low, low, -15], [-low, -low, 0]])


def widening_slot(feed=600):
    """Down the middle of a wedge: a slot that is cut once, then its sides, ever wider."""
    lines = ["G0 X-12 Y0 Z-3", f"G1 X70 F{feed}", "G0 Z20", "G0 X-12 Y0", "G0 Z-3", f"G1 X0 F{feed}", "G1 X60 Y8"]
    return HEAD.format(turns=6000) + "\n".join([*lines, "G0 Z20", "M30"]) + "\n", sheet([[0, -25, -15], [60, 25, 0]])


def stepped_wall(feed=600):
    """Along a wall whose stock stands out in steps: the steps are cut by the passes before."""
    lines = []
    for k, end in enumerate((45.0, 30.0, 15.0)):
        lines += ["G0 X-8 Y%g Z-4" % (-9.0 + 2.0 * k), f"G1 X{end:g} F{feed}", "G0 Z20"]
    lines += ["G0 X-8 Y-2.5", "G0 Z-4", f"G1 X70 F{feed}", "G0 Z20"]
    return HEAD.format(turns=6000) + "\n".join([*lines, "M30"]) + "\n", sheet([[0, -7, -15], [60, 25, 0]])


def tilted_ball(feed=900):
    """Rows of a ball over a wave, tilted by 15 degrees about X."""
    lines = ["G43.4 H1", "G0 X-8 Y0 Z8 A15 C0"]
    for row in range(2):
        xs = [-6.0 + 0.5 * k for k in range(97)]
        xs = xs[::-1] if row % 2 else xs
        for k, x in enumerate(xs):
            z = -1.5 + 0.7 * math.sin(0.2 * x)
            lines.append(f"G1 X{x:.4f} Y{row * 2.0:g} Z{z:.4f} A15 C0" + (f" F{feed}" if not k and not row else ""))
    lines += ["G0 Z20", "G49"]
    text = HEAD.format(turns=8000) + "\n".join(lines) + "\nM30\n"
    return text, sheet([[0, -10, -15], [36, 15, 0]], "ball", 8.0, 8000, flutes=6)


def turning_ball(feed=900):
    """A row of a ball that leans over by 40 degrees on its way."""
    lines = ["G43.4 H1", "G0 X-6 Y0 Z8 A0 C0"]
    for k in range(81):
        start = f" F{feed}" if not k else ""
        lines.append(f"G1 X{-6.0 + 0.5 * k:g} Y0 Z-1.5 A{0.5 * k:g} C0{start}")
    text = HEAD.format(turns=8000) + "\n".join([*lines, "G0 Z20", "G49"]) + "\nM30\n"
    return text, sheet([[0, -10, -15], [28, 15, 0]], "ball", 8.0, 8000, flutes=6)


SCENES = {"pocket": pocket, "slot": widening_slot, "wall": stepped_wall, "ball": tilted_ball, "turning": turning_ball}
