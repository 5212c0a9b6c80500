"""Programs whose time on LinuxCNC is compared with ours: those written after the model was done."""

from __future__ import annotations

import math
import random

from testbed.linuxcnc.timed import program


def surface(passes: int = 8, points: int = 250) -> str:
    """Three-axis finishing to and fro, short blocks, straight links; a tolerance for both, roundings and chains."""
    dice = random.Random(3)
    lines = ["F3000"]
    for k in range(passes):
        order = range(points + 1) if k % 2 == 0 else range(points, -1, -1)
        for i in order:
            x, y = 80.0 * i / points, 1.5 * k
            z = 3.0 * math.sin(0.11 * x + 0.2 * k) * math.cos(0.05 * x) + dice.gauss(0.0, 0.001)
            lines.append(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f}")
    return program(*lines, head="G64 P0.01")


def ruled(rows: int = 5, points: int = 70) -> str:
    """Five-axis flank cuts by feed a minute with the tip held, no tolerance, words only where they change."""
    lines = ["M428", "G1 F900"]
    for k in range(rows):
        for i in range(points + 1):
            u = i / points
            words = [f"X{40 * u - 20:.3f}", f"Y{6.0 * math.sin(3 * u + k):.3f}"]
            words += [f"A{-20 - 8 * math.cos(4 * u):.3f}"] if i % 4 else []
            words += [f"C{25 * math.sin(2 * u + 0.3 * k):.3f}"] if i % 3 else []
            lines.append(" ".join(words))
        lines += ["G0 Z20", f"G0 X-20 Y{6.0 * math.sin(k + 1):.3f}", f"G1 Z{-k} F400", "F900"]
    return program(*lines, "M429")


def holes() -> str:
    """Drilling, pecking and boring cycles over a grid, back to both levels."""
    lines = ["M3 S3000", "G0 Z20"]
    for cycle in ("G98 G81 Z-8 R2 F300", "G99 G83 Z-12 R2 Q4 F250", "G98 G82 Z-3 R1 P0.2 F200", "G99 G85 Z-6 R2 F500"):
        lines.append(f"{cycle} X5 Y5")
        lines += [f"X{5 + 17 * (k % 3)} Y{5 + 12 * (k // 3)}" for k in range(1, 9)]
        lines.append("G80")
    return program(*lines, head="G64 P0.02")


def bores() -> str:
    """Helices of several turns and arcs in all three planes, exact path and blended."""
    lines = ["F1500"]
    for mode in ("G61", "G64 P0.05"):
        lines += [
            mode, "G0 X0 Y0 Z5", "G1 X6 F1500", "G3 X6 Y0 Z-4 I-6 J0 P4 F900", "G3 X6 Y0 I-6 J0", "G1 X0", "G0 Z5",
            "G18", "G1 X10 Z0 F1200", "G2 X20 Z-10 I10 K0", "G3 X30 Z-20 I0 K-10", "G1 Z-5", "G19",
            "G2 Y8 Z3 J0 K8", "G3 Y0 Z-5 J-8 K0", "G17", "G2 X12 Y0 Z2 I-9 J0 P2", "G1 X0 Y0",
        ]  # fmt: skip
    return program(*lines)


def turns() -> str:
    """Rotary axes alone and with others, as joints: by degrees a minute, by time, exact, blended, rapid."""
    lines = []
    for mode in ("G64", "G64 P0.3", "G61", "G61.1"):
        lines += [
            mode, "G1 A20 F1200", "G1 C90", "G1 X10 A10", "G1 X12 Y3", "G1 X10 Y0 C80 F700", "G1 A-5 C20 F2000",
            "G0 X0 A0", "G0 C0", "G93", "G1 X5 C15 F20", "G1 A8 F30", "G1 X6 A9 C16 F200", "G1 X0 A0 C0 F15", "G94",
        ]  # fmt: skip
    return program(*lines)


def mixture(count: int = 90) -> str:
    """Arcs and lines that meet at any angle, long and short, blended within a tolerance."""
    dice = random.Random(8)
    x = y = 0.0
    lines = ["F1400"]
    for k in range(count):
        angle, size = dice.uniform(-math.pi, math.pi), 10.0 ** dice.uniform(-0.3, 1.1)
        end_x, end_y = round(x + size * math.cos(angle), 4), round(y + size * math.sin(angle), 4)
        if dice.random() < 0.5:
            radius = size * dice.uniform(0.6, 2.0)
            lines.append(f"G{dice.choice([2, 3])} X{end_x} Y{end_y} R{radius:.4f}")
        else:
            lines.append(f"G1 X{end_x} Y{end_y}" + (f" F{dice.choice([500, 1400, 3000])}" if k % 7 == 0 else ""))
        x, y = end_x, end_y
    return program(*lines, head="G64 P0.1")


def dense(count: int = 4000) -> str:
    """A spiral of blocks that are shorter than the way of a cycle or two."""
    lines = ["F5000"]
    for i in range(1, count + 1):
        angle = 0.012 * i
        radius = 2.0 + 0.35 * angle
        lines.append(f"G1 X{radius * math.cos(angle) - 2:.4f} Y{radius * math.sin(angle):.4f}")
    return program(*lines, head="G64 P0.005 Q0")


def inches() -> str:
    """In inches: a contour with tangent and sharp corners, by feed a minute and by time."""
    lines = ["G20"]
    for feed, mode in (("F30", "G94"), ("F12", "G93")):
        word = f" {feed}" if mode == "G93" else ""
        lines += [
            mode, "G0 X0 Y0 Z0.1", f"G1 Z-0.05 {feed}", f"X1.5{word}", f"G3 X2 Y0.5 J0.5{word}", f"G1 Y1{word}",
            f"X1.25 Y1.2{word}", f"G2 X0.5 Y1 I-0.375 J-0.1{word}", f"G1 X0 Y0.4{word}", f"Y0{word}", "G94", "G0 Z0.1",
        ]  # fmt: skip
    return program(*lines, "G21", head="G64 P0.05")


AFTER = {
    "surface": surface, "ruled": ruled, "holes": holes, "bores": bores, "turns": turns, "mixture": mixture,
    "dense": dense, "inches": inches,
}  # fmt: skip
