"""Blocks at the edge of a rule of LinuxCNC's interpreter: half of them it runs, half it refuses."""

from __future__ import annotations

import math

from testbed.linuxcnc.writer import PLANES, Writer

RADII = {True: 2 * 0.001 * math.sqrt(2.0), False: 2 * 0.01 * math.sqrt(2.0)}
"""Difference of the radii of an arc that is let pass at any radius: in inches, and in millimetres."""
REACH = 0.00005
"""By how much half a chord may be longer than R [inch]."""
LETTERS = "DEHIJKLPQR"
FUNCTIONS = ("SIN", "COS", "TAN", "ABS", "SQRT", "EXP", "LN", "FIX", "FUP", "ROUND", "ASIN", "ACOS")
OPERATIONS = ("+", "-", "*", "/", "MOD", "**", "EQ", "NE", "LT", "LE", "GT", "GE", "AND", "OR", "XOR")


def arc_off_its_circle(writer: Writer) -> None:
    """An arc whose end is off the circle by about as much as is allowed, of any size."""
    place, scale = writer.to(), 25.4 if writer.inch else 1.0
    first, second, _, i, j = PLANES[writer.plane]
    radius = 10 ** writer.random.uniform(-0.5, 4.5) / scale
    least = RADII[writer.inch]
    off = writer.random.choice([least, least, 0.001 * radius, 100 * least]) * writer.random.choice([0.5, 0.98, 1.02])
    begin, sweep = writer.random.uniform(0, 2 * math.pi), writer.random.choice([1.0, 3.0, 6.0, 2 * math.pi])
    word = writer.random.choice(["G2", "G3"])
    end = begin + (sweep if word == "G3" else -sweep)
    spokes = (-radius * math.cos(begin), -radius * math.sin(begin))
    away = [a + (radius + off) * b for a, b in zip(spokes, (math.cos(end), math.sin(end)))]
    base = (place[first], place[second]) if writer.absolute else (0.0, 0.0)
    words = [f"{letter}{b + a:.6f}" for letter, b, a in zip((first, second), base, away)]
    writer.put("G91.1", word, *words, f"{i}{spokes[0]:.6f} {j}{spokes[1]:.6f}", writer.f(), _turns(writer))


def arc_by_radius(writer: Writer) -> None:
    """R about as long as half the chord, shorter by as much as is allowed, or next to nothing."""
    place, scale = writer.to(), 25.4 if writer.inch else 1.0
    first, second, *_ = PLANES[writer.plane]
    chord = writer.random.choice([0.05, 3.0, 20.0, 300.0]) / scale
    reach = REACH * (1.0 if writer.inch else 25.4)
    radius = chord / 2 + writer.random.choice([0.0, -0.7, -1.3, 5.0, 1e4]) * reach
    angle = writer.random.uniform(0, 2 * math.pi)
    base = (place[first], place[second]) if writer.absolute else (0.0, 0.0)
    ends = (base[0] + chord * math.cos(angle), base[1] + chord * math.sin(angle))
    words = [f"{letter}{value:.7f}" for letter, value in zip((first, second), ends)]
    sign = writer.random.choice(["", "-"]) if radius > 1e-6 else ""
    writer.put(writer.random.choice(["G2", "G3"]), *words, f"R{sign}{radius:.7f}", writer.f(), _turns(writer))


def _turns(writer: Writer) -> str:
    return writer.random.choice(["", "", "", "P1", "P2.0004", "P1.0015", "P0", "P0.9995"])


def letter_without_use(writer: Writer) -> None:
    """A letter beside words that may use it or not."""
    letter = writer.random.choice(LETTERS)
    # to its interpreter Q-1 is no Q at all
    value = writer.random.choice(["0", "1", "2", "0.5", "1.00001", "3" if letter == "Q" else "-1"])
    block = writer.random.choice([
        "M8", "G64", "G61", "G4 P0", "G40", "G17", "G80", "M3 S500", "", "S300", "T1", "G0 X1", "G1 Y2 F300",
        "G28", "G30", "G49", "G54", "G92.1", "G98", "M66 P0 L0", "M66 E0 L0", "M19 R10", "M62 P1", "M67 E0 Q1", "M68",
    ])  # fmt: skip
    writer.put(block, f"{letter}{value}")
    writer.mode, writer.plane = "G94", "G17"
    writer.put("G94 G17", writer.f())


def cycle_with_a_letter(writer: Writer) -> None:
    """A cycle whose spindle turns one way or the other, or not, with a letter more."""
    writer.mode, writer.plane = "G94", "G17"
    writer.put("G94 G17", writer.f())
    writer.to()
    writer.put(writer.random.choice(["M3 S100", "M4 S100", "M5", "M3 S100", "", "T1 M6"]))
    word = writer.random.choice(["G81", "G82 P0", "G83 Q2", "G73 Q2", "G84", "G74", "G85", "G86 P0", "G89 P0"])
    letter = writer.random.choice(["", "", "P0", "Q1", "I1", "K2", "L2", "H1", "D1", "L1.00001", "P.5"])
    extra = "" if letter[:1] in word else letter
    writer.put("G90", word, "X1 Y2 Z-5 R2", extra)
    writer.put(writer.random.choice(["", "X3", "X3 P1", "R3", "P1", "X4 Q1"]))
    writer.put("G80", "" if writer.absolute else "G91")


def rounded_words(writer: Writer) -> None:
    """Numbers next to whole ones, as posts write them."""
    f = writer.f()
    blocks = ("G0.99999 X1", "G0.00001 Y1", "G17.00001", "G54.00009", "M8.00001", "G59.10001", "M9.0002", "G1.0009 X1")
    writer.put(writer.random.choice([*blocks, "T1.00001", f"G1.00002 X1 Y1 {f}", f"G1.0002 X2 {f}", "G4 P0.00001"]))


def together_of_one_group(writer: Writer) -> None:
    """Two words of which a block has one, or of which it may have both."""
    words = [
        "M7", "M8", "M9", "M3", "M5", "M48", "M0", "G4 P0", "G53 G0 X1", "G92.1", "G61", "G64", "G98", "G40", "G49",
        "G80", "G17", "G90", "G54", "G21" if not writer.inch else "G20", "M70", "G91.1", "G10 L2 P2 X1", "G28", "G0 X1",
    ]  # fmt: skip
    writer.put(writer.random.choice(words), writer.random.choice(words))
    writer.absolute, writer.plane, writer.mode = True, "G17", "G94"
    writer.put("G90 G17 G94", writer.f())


def rotation_with_position(writer: Writer) -> None:
    """An offset that is turned, G92 before or behind it, and axes one by one."""
    turns = ["G10 L2 P1 R30", "G10 L2 P1 X5 Y2 R-45", "G10 L2 P2 R10"]
    kinds = [*turns, "G92 X3 Y1", "G92.1", "G92.2", "G92.3", "G54", "G55"]
    writer.to()
    for _ in range(writer.random.randint(2, 4)):
        writer.put(writer.random.choice(kinds))
        writer.put("G0", writer.axes(0.3, "XYZ", turning=0.0))
        if writer.chance(0.2):
            writer.put("G28", writer.random.choice("XYZ") + writer.number(-5, 5))
    writer.put("G92.1 ")


def expression(writer: Writer) -> None:
    """A tree of operations and functions, brought into reach, in steps that are longer than what is printed."""
    writer.put("G1", f"X[ROUND[ATAN[{_tree(writer, 4)}]/[1]*10]/10]", writer.f())


def _tree(writer: Writer, depth: int) -> str:
    if depth == 0 or writer.chance(0.2):
        leaves = [f"{writer.random.uniform(-5, 5):.2f}", f"{writer.random.randint(0, 4)}", "0.00005", "#<_metric>"]
        return f"[{writer.random.choice([*leaves, *writer.named])}]"
    if writer.chance(0.3):
        return f"{writer.random.choice(FUNCTIONS)}[{_tree(writer, depth - 1)}]"
    if writer.chance(0.1):
        return f"ATAN[{_tree(writer, depth - 1)}]/[{_tree(writer, depth - 1)}]"
    blank = writer.random.choice(["", " "])
    parts = [_tree(writer, depth - 1) for _ in range(writer.random.choice([2, 2, 3]))]
    text = parts[0]
    for part in parts[1:]:
        text += f"{blank}{writer.random.choice(OPERATIONS)}{blank}{part}"
    return f"[{text}]" if writer.chance(0.5) else text


EDGES = [
    arc_off_its_circle, arc_off_its_circle, arc_by_radius, arc_by_radius, letter_without_use, cycle_with_a_letter,
    rounded_words, together_of_one_group, rotation_with_position, expression, expression,
]  # fmt: skip
