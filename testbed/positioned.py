"""A 3+2 program: operations on tilted planes, clearing loops, and retracts between them."""

from __future__ import annotations

import math

CUTTING, LINK, PLUNGE = 1500.0, 15_000.0, 500.0
"""Feeds [mm/min]."""


def positioned(operations: int = 25, blocks: int = 116) -> str:
    """A program for Fanuc's words on a machine whose table turns: `blocks` lines of clearing an operation.

    Each operation turns the table, goes down, clears rounded loops with fast links between them, and retracts to the
    machine's end of Z, as posts of CAM systems write it.
    """
    lines = ["%", "O1000", "G21 G90 G94 G17 G40 G49 G80", "G54"]
    for number in range(operations):
        tool = 1 + number % 4
        tilt, turn = 15.0 * (number % 4), 40.0 * number % 360.0
        lines += [f"T{tool} M6", f"S{6000 + 500 * tool} M3", "G53 G0 Z0.", "G69"]
        lines += [f"G68.2 X0. Y0. Z0. I{turn:.3f} J{tilt:.3f} K{-turn:.3f}", "G53.1"]
        lines += ["G0 X-22. Y-15.", f"G43 Z30. H{tool}", f"G1 Z{-0.5 * (number % 3):.3f} F{PLUNGE:.0f}"]
        lines += clearing(blocks)
        lines += ["G0 Z30.", "G69", "G53 G0 Z0.", "G49"]
    return "\n".join([*lines, "M30", "%"]) + "\n"


def clearing(blocks: int) -> list[str]:
    """Loops of a cut, a small arc, and a way back above the feed along short lines, a little further each time."""
    lines: list[str] = []
    y = -15.0
    while len(lines) < blocks:
        x = 18.0 + 3.0 * math.sin(0.7 * y)
        lines += [f"G1 X{x:.3f} Y{y:.3f} F{CUTTING:.0f}", f"G3 X{x:.3f} Y{y + 1.0:.3f} I0. J0.5"]
        for k in range(1, 7):
            share = k / 6.0
            lines.append(f"G1 X{x - 2 * x * share:.3f} Y{y + 1.0 + math.sin(math.pi * share) - 0.5 * share:.3f}")
        lines[-6] += f" F{LINK:.0f}"
        y += 0.5 if y < 12.0 else -27.0
    return lines[:blocks]
