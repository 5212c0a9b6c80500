"""Blocks that move: lines, turns, arcs, machine coordinates, references, cycles."""

from __future__ import annotations

import math

from testbed.linuxcnc.writer import PLANES, Writer


def line(writer: Writer) -> None:
    word = writer.random.choice(["G0", "G1", "G1", "G01", "G00"])
    feed = writer.f() if word in ("G1", "G01") and (writer.mode == "G93" or writer.chance(0.3)) else ""
    writer.put(word, writer.axes(0.5), feed)
    if writer.mode != "G93":
        for _ in range(writer.random.choice([0, 0, 1, 3])):
            writer.put(writer.axes(0.4))


def turn(writer: Writer) -> None:
    writer.put("G1", writer.random.choice("AC") + f"{writer.random.uniform(-200, 200):.2f}", writer.f())


def deleted(writer: Writer) -> None:
    writer.put("/G1", writer.axes(0.5), writer.f())


def machine(writer: Writer) -> None:
    writer.to_machine()
    word = writer.random.choice(["G0", "G1", "G0"])
    if writer.mode == "G93":
        word = "G0"
    was, writer.absolute = writer.absolute, True
    words = writer.axes(0.5)
    writer.absolute = was
    writer.put("G53", word, words)


def reference(writer: Writer) -> None:
    writer.to_machine()
    writer.put(writer.random.choice(["G28", "G30"]), writer.random.choice(["", writer.axes(0.3), writer.axes(0.3)]))


def arc(writer: Writer) -> None:
    place = writer.to()
    first, second, normal, i, j = PLANES[writer.plane]
    scale, digits = (1 / 25.4, 5) if writer.inch else (1.0, 4)
    radius, begin = writer.random.uniform(1, 30) * scale, writer.random.uniform(0, 2 * math.pi)
    word = writer.random.choice(["G2", "G3"])
    full = writer.chance(0.2)
    sweep = 2 * math.pi if full else writer.random.uniform(0.1, 6.1)
    sweep = -sweep if word == "G2" else sweep
    centre = (-radius * math.cos(begin), -radius * math.sin(begin))
    end = (centre[0] + radius * math.cos(begin + sweep), centre[1] + radius * math.sin(begin + sweep))
    words = []
    start = (place[first], place[second])
    if not full or writer.chance(0.3):
        base = start if writer.absolute else (0.0, 0.0)
        shift = (0.0, 0.0) if full else end
        words += [f"{a}{b + s:.{digits}f}" for a, b, s in zip((first, second), base, shift)]
    if writer.chance(0.25):
        words.append(normal + writer.number(-5, 5))
    if writer.chance(0.1):
        words.append(f"{writer.random.choice('AC')}{writer.random.uniform(-40, 40):.2f}")
    by_radius = not full and writer.chance(0.3) and not 3.0 < abs(sweep) < 3.3 and abs(sweep) < 5.5
    if by_radius:
        words.append(f"R{radius * (1 if abs(sweep) < math.pi else -1):.{digits}f}")
    else:
        absolute = writer.chance(0.25)
        base = start if absolute else (0.0, 0.0)
        words += [f"{letter}{b + c:.{digits}f}" for letter, b, c in zip((i, j), base, centre)]
        words.append("G90.1" if absolute else "G91.1")
    if writer.chance(0.15):
        words.append(f"P{writer.random.randint(1, 4)}")
    writer.put(word, *words, writer.f() if writer.mode == "G93" or writer.chance(0.2) else "")


def cycle(writer: Writer) -> None:
    if writer.mode != "G94":
        writer.mode = "G94"
        writer.put("G94", writer.f())
    place = writer.to()
    normal = PLANES[writer.plane][2]
    flat = "".join(PLANES[writer.plane][:2])
    word = writer.random.choice(["G81", "G82", "G83", "G73", "G85", "G89", "G81", "G83", "G86", "G84", "G74"])
    if writer.chance(0.06):
        word = "G87"
    if writer.plane != "G17" and word in ("G84", "G74"):
        word = "G85"  # its interpreter mixes the axes of taps up outside XY
    scale = 25.4 if writer.inch else 1.0
    base = place[normal] if writer.absolute else 0.0
    top = base + writer.random.choice([-8, -3, 0, 4, 9]) / scale
    depth = writer.random.choice([2, 5.5, 12]) / scale
    bottom = top - depth if writer.absolute else -depth
    words = [f"{normal}{bottom:.4f}", f"R{top:.4f}"]
    if word in ("G83", "G73"):
        words.append(f"Q{writer.random.choice([1.37, 2.61, 20, 3.17]) / scale:.4f}")
    if word in ("G82", "G89", "G86", "G84", "G74"):
        words.append(f"P{writer.random.choice(['.5', '1', '0'])}")
    if word in ("G86", "G84", "G74", "G87"):
        writer.put("M4 S800" if word == "G74" else "M3 S800")
    if word == "G87":
        middle = writer.random.choice([0.5, 1.5]) / scale
        level = "IJK"["XYZ".index(normal)]
        words += [f"{letter}{writer.number(-3, 3)}" for letter in "IJK" if letter != level]
        words.append(f"{level}{middle + (bottom if writer.absolute else 0):.4f}")
    if writer.chance(0.3) and word != "G74":  # its interpreter knows no L there
        words.append(f"L{writer.random.choice([1, 2, 3])}")
    writer.put(writer.random.choice(["G98", "G99", ""]), word, writer.axes(0.8, flat, turning=0.01), *words)
    for _ in range(writer.random.choice([0, 0, 1, 2, 3])):
        writer.put(
            writer.random.choice(["", "", "G98", "G99", word]),
            writer.axes(0.6, flat, turning=0.0),
            writer.random.choice(["", "", "", f"R{top + 1:.4f}", f"{normal}{bottom - 1:.4f}"]),
            writer.random.choice(["", "", "", "L2" if word != "G74" else "", "", "L0" if writer.chance(0.05) else ""]),
        )
    if writer.chance(0.2):
        other = writer.random.choice(["G81", "G85"])
        writer.put(other, writer.axes(0.8, flat, turning=0.0), writer.random.choice(["", *[" ".join(words[:2])] * 5]))
    writer.put(writer.random.choice(["G80", "G80", "G0 " + writer.axes(0.5)]))
