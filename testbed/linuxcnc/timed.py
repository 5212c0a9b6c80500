"""Programs whose time on LinuxCNC is compared with ours: six that the model was tuned on."""

from __future__ import annotations

import math
import random

HEAD = "G21 G90 G17 G94 G40 G49"
START = "G0 X0 Y0 Z0 A0 C0"


def program(*lines: str, head: str = "G64") -> str:
    """A program in mm that starts in the zero of the machine, with a word of the path mode."""
    return "\n".join([HEAD, head, START, *lines, "M2", ""])


def blade(passes: int = 6, points: int = 60) -> str:
    """Five-axis passes over a twisted blade, the tip held, each block with its time (G93); rapids between."""
    lines = ["M428", "G93"]
    for k in range(passes):
        lean = 0.2 * k
        place = ""
        for i in range(points + 1):
            u = i / points
            angle = math.radians(70.0 * u + 6.0 * k)
            x, y = 18.0 * math.cos(angle) - 18.0, 18.0 * math.sin(angle)
            z = 4.0 * math.sin(2.5 * u) - lean
            a, c = -30.0 - 12.0 * math.sin(3.0 * u + lean), 60.0 * u + 8.0 * k
            place = f"X{x:.3f} Y{y:.3f} Z{z:.3f} A{a:.3f} C{c:.3f}"
            lines.append(f"G0 {place}" if i == 0 else f"G1 {place} F{120 + 20 * (i % 3)}")
        lines.append("G94\nG0 Z12\nG93")
    return program(*lines, "G94", "M429", head="G64 P0.02")


def pocket(steps: int = 4) -> str:
    """A pocket with rounded corners in rings, tangent lines and arcs, a helix down; G64 with a tolerance."""
    lines = ["G1 X30 Y20 F1500"]
    for level in range(2):
        lines.append(f"G3 X30 Y20 Z{-1.5 * (level + 1)} I-3 J0 F600")
        for k in range(steps):
            w, h, r = 4.0 + 5.0 * k, 2.0 + 4.0 * k, 1.0 + 0.8 * k
            lines += [
                f"G1 X{30 + w:.3f} Y{20 - h + r:.3f} F1200",
                f"G1 Y{20 + h - r:.3f}",
                f"G3 X{30 + w - r:.3f} Y{20 + h:.3f} I{-r:.3f} J0",
                f"G1 X{30 - w + r:.3f}",
                f"G3 X{30 - w:.3f} Y{20 + h - r:.3f} I0 J{-r:.3f}",
                f"G1 Y{20 - h + r:.3f}",
                f"G3 X{30 - w + r:.3f} Y{20 - h:.3f} I{r:.3f} J0",
                f"G1 X{30 + w - r:.3f}",
                f"G3 X{30 + w:.3f} Y{20 - h + r:.3f} I0 J{r:.3f}",
            ]
        lines.append("G1 X30 Y20 F1500")
    return program(*lines, head="G64 P0.05")


def corners(count: int = 120) -> str:
    """Straight blocks of all lengths that turn by all angles, G64 without a tolerance."""
    dice = random.Random(5)
    x = y = z = 0.0
    angle = 0.0
    lines = []
    for k in range(count):
        angle += math.radians(dice.uniform(-170.0, 170.0))
        length = 10.0 ** dice.uniform(-1.0, 1.2)
        x, y = x + length * math.cos(angle), y + length * math.sin(angle)
        z += dice.uniform(-0.5, 0.5)
        lines.append(f"G1 X{x:.4f} Y{y:.4f} Z{z:.4f}" + (f" F{dice.choice([300, 900, 2500])}" if k % 10 == 0 else ""))
    return program(*lines)


def modes() -> str:
    """Exact path, exact stop, both blendings, feeds by the minute and by time, rapids, over one figure."""
    figure = ["X12 Y0", "X12 Y9", "X8 Y12.5", "X7.9 Y12.6", "X0 Y12", "X0 Y0"]
    lines = []
    for mode in ("G61", "G61.1", "G64", "G64 P0.05", "G64 P0.2 Q0.1"):
        lines += [mode, "G94", *(f"G1 {place} F800" for place in figure)]
        lines += ["G93", *(f"G1 {place} F{30 + 40 * k}" for k, place in enumerate(figure)), "G94"]
        lines += [f"G0 {place}" for place in figure]
    return program(*lines)


def switching() -> str:
    """Spindle, coolant, tools, dwells, work offsets and rapids between short cuts."""
    lines = []
    for k in range(6):
        x = 5.0 * k
        lines += [
            f"T{k % 3 + 1} M6", f"M3 S{1000 + 100 * k}", f"G0 X{x} Y{2 * k}", "G0 Z2", "M8", f"G1 Z-1 F{200 + 100 * k}",
            f"G1 X{x + 4} F900", "G4 P0.25", f"G1 Y{2 * k + 5}", "M9", f"G2 X{x + 7} Y{2 * k + 8} I3 J0", "G4 P0.1",
            "G0 Z10", "M5",
        ]  # fmt: skip
    return program(*lines, head="G64 P0.01")


def noise(count: int = 900) -> str:
    """A long curve of short straight blocks with noise in it, joined within a tolerance (Q)."""
    dice = random.Random(11)
    lines = ["G1 X0 Y0 F2400"]
    for i in range(1, count + 1):
        u = i / count
        x, y = 60.0 * u + dice.gauss(0.0, 0.002), 12.0 * math.sin(9.0 * u) + dice.gauss(0.0, 0.002)
        z = 2.0 * math.cos(7.0 * u) - 2.0
        lines.append(f"X{x:.4f} Y{y:.4f} Z{z:.4f}")
    return program(*lines, head="G64 P0.02 Q0.008")


TUNED = {"blade": blade, "pocket": pocket, "corners": corners, "modes": modes, "switching": switching, "noise": noise}
"""The model was tuned on these."""
