"""Blocks that change how those behind them are meant: units, planes, feeds, offsets, tools, variables."""

from __future__ import annotations

from testbed.linuxcnc.job import OFFSETS
from testbed.linuxcnc.writer import PLANES, Writer


def unit(writer: Writer) -> None:
    writer.inch = not writer.inch
    writer.put("G20" if writer.inch else "G21", writer.f() if writer.chance(0.3) and writer.mode == "G94" else "")


def distance(writer: Writer) -> None:
    writer.absolute = not writer.absolute
    writer.put("G90" if writer.absolute else "G91")


def planes(writer: Writer) -> None:
    writer.plane = writer.random.choice(list(PLANES))
    writer.put(writer.plane)


def feed(writer: Writer) -> None:
    writer.mode = writer.random.choice(["G93", "G94", "G94", "G95"])
    writer.put(writer.mode, "" if writer.mode == "G93" else writer.f())


def dwell(writer: Writer) -> None:
    writer.put("G4", f"P{writer.random.choice(['0', '.5', '1', '2.25', '[1/4]'])}")


def offset(writer: Writer) -> None:
    writer.put(writer.random.choice(OFFSETS), writer.random.choice(["", "", "G0 " + writer.axes(0.5)]))


def position(writer: Writer) -> None:
    word = writer.random.choice(["G92", "G92", "G52", "G92.1", "G92.2", "G92.3", "G92.2", "G52 X0 Y0 Z0 A0 C0"])
    writer.put(word, writer.axes(0.5) if word in ("G92", "G52") else "")


def origin(writer: Writer) -> None:
    """G10."""
    number = writer.random.choice([0, 0, 1, 2, 3, 5, 9])
    kind = writer.random.choice(["L2", "L2", "L20"])
    turned = f"R{writer.random.uniform(-90, 90):.2f}" if writer.chance(0.3) else ""
    if turned and writer.chance(0.3):
        turned = "R0"
    writer.put("G10", kind, f"P{number}", writer.axes(0.6), turned)


def length(writer: Writer) -> None:
    if writer.inch != writer.length_in_inch:
        # `rs274` alone takes the length before for one of the unit at hand: until the next word of Z it is elsewhere
        writer.put("G49")
        writer.to()
    writer.length_in_inch = writer.inch
    known = "G43 H1" if writer.told_tool else "G43"
    offset = writer.axes(0.3, turning=0.0)
    lift = writer.number(-20, 20)
    words = [known, "G43 H1", "G43 H2", "G43 H0", "G49", "G49", f"G43.1 {offset}", "G43.2 H1", "G43.2 H3"]
    writer.put(writer.random.choice([*words, f"G43.1 Z{lift}", f"G43 H2 G0 Z{lift}"]))


def tool(writer: Writer) -> None:
    writer.length_in_inch = writer.inch
    # `rs274` reads its position back behind M6, as it was told it last: offsets of tools would be forgotten
    writer.put("G49")
    writer.to()
    writer.put(writer.random.choice(["T1 M6", "T2 M6", "M6 T3", "T3", "M6", "M61 Q1", "T0 M6"]))
    writer.told_tool |= any(word in writer.lines[-1].upper() for word in ("M61", "T0"))
    move = f"G1 {writer.axes(0.3, turning=0.0)} {writer.f()}"
    writer.put(writer.random.choice(["G43 H2" if writer.told_tool else "G43", "G43 H1", "", move]))


def mode_of_path(writer: Writer) -> None:
    writer.put(
        writer.random.choice(["G61", "G64", "G64 P.01", "G64 P.02 Q.01", "G61.1", "G40", "M8", "M9", "S500 M3", "M5"])
    )
    if writer.lines[-1].upper().startswith("M5") and writer.mode == "G95":
        writer.put("M3")


def assign(writer: Writer) -> None:
    name = writer.random.choice(["#1", "#2", "#100", "#31", "#<a>", "#<_wide>", "#<two words>", "#[50+3]"])
    writer.put(f"{name}={writer.number(-9, 9)}", writer.random.choice(["", "", f"#5={writer.number(1, 3)}"]))
    if name not in writer.named:
        writer.named.append(name)


def system(writer: Writer) -> None:
    """Variables of the controller itself, but those in units of the machine."""
    name = writer.random.choice([
        "#5420", "#5421", "#5422", "#5423", "#5425", "#<_x>", "#<_y>", "#<_z>", "#<_a>", "#5220", "#5400",
        "#<_metric>", "#<_imperial>", "#<_absolute>", "#<_incremental>", "#<_current_tool>", "#<_coord_system>",
        "#<_feed>", "#<_plane>", "#<_line>", "#<_selected_tool>", "#<_motion_mode>", "#<_rpm>",
        "#<_inverse_time>", "#<_units_per_minute>", "#<_units_per_rev>", "#<_retract_r_plane>",
        "#<_ijk_absolute_mode>", "#<_tool_offset>",
    ])  # fmt: skip
    writer.put("G1", f"X[{name}/10]", writer.f())


def at_once(writer: Writer) -> None:
    """Many words in one block."""
    writer.mode, writer.absolute, writer.plane, writer.inch = "G94", True, "G17", writer.chance(0.5)
    unit = "G20" if writer.inch else "G21"
    offset = writer.random.choice(["", "G54", "G55"])
    writer.put(f"{unit} G90 G94 G17 G64 G1 {writer.axes(0.6)} {writer.f()} S900 M3 M8", offset)
