"""Plans, verifications and machines as tables on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.table import Table
from rich.text import Text

from toolpace.cli.console import cells, new_table
from toolpace.common.errors import printable
from toolpace.common.units import DEGREE, MILLIMETRE, format_angle, format_length, format_time
from toolpace.common.value_objects import counted
from toolpace.judge.figures import AS_SAID, DEFAULT_AXIS_DEG, DEFAULT_TIP_MM
from toolpace.machine.limit_curves import CURVE
from toolpace.machine.limits import CONTINUOUS, KINDS, MOTORS
from toolpace.motion.set_point_files import COMPACT_FILE, FULL_FILE, full_size
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.programs.tolerances import TIGHTER
from toolpace.results.report.words import WORTH_A_WORD, limits_now, mesh_gap, motion_gap, savings

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rich.console import Console

    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.results.write import PlanRecord
    from toolpace.results.write.plan_json import BendingRecord, CutRecord, OpenPlaceRecord

LEAST_GAIN = 5e-4
"""Share of the duration from which the iterations count as a saving."""
PLACES_SHOWN = 3
"""How many of these places are named."""
SHOWN = 6
"""How many limits are named."""
SENTENCES = 12
"""How many operations, and how many assumptions, are listed."""
LEAST_UNSURE = 0.05
"""Time that depends on where the stock ends from which it is shown [s]."""
FULL = 0.999
"""Utilisation from which a limit counts as fully used."""


def show_plan(console: Console, record: PlanRecord, verification: Verification) -> None:
    """Duration, what limits, how much of each axis is used, deviations and the verdict."""
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    stops = f", {record.stops} stop{'s' * (record.stops != 1)} on the way" if record.stops else ""
    grid.add_row("program", Text(f"{record.program}, {record.blocks} blocks{stops}"))
    grid.add_row("machine", Text(f"{record.machine}, planner {record.planner}"))
    if None in record.usage.jerk.values():
        grid.add_row("", Text("JERK LIMITS ARE NOT HELD by this planner: accelerations jump", style="bold red"))
    grid.add_row("duration", Text(format_time(record.duration_s), style="bold"))
    if record.lower_bound_s and record.gap is not None:
        grid.add_row("", mesh_gap(record.gap))
        if record.gap > WORTH_A_WORD and record.open_places:
            grid.add_row("", Text(places_in_words(record.open_places)))
        if record.continuous_bound_s:
            grid.add_row("", motion_gap(record.duration_s, record.continuous_bound_s))
    else:
        grid.add_row("", f"gap to the best possible not known: the planner {record.planner} gives no lower bound")
    if record.operations:
        for k, sentence in enumerate(times_in_words(record)):
            grid.add_row("" if k else "operations", Text(sentence))
    if record.cut is not None:
        for k, sentence in enumerate(cut_in_words(record.cut)):
            grid.add_row("" if k else "at feed", Text(sentence, style="bold red" if "collision" in sentence else ""))
    for k, sentence in enumerate(record.assumed[:SENTENCES]):
        grid.add_row("" if k else "assumed", Text(sentence))
    if len(record.assumed) > SENTENCES:
        grid.add_row("", f"and {len(record.assumed) - SENTENCES} more: see plan.json")
    grid.add_row("limited by", Text(limits_in_words(record.limited_by)))
    if record.tip_deviation_mm is not None:
        deviation = _within(record.tip_deviation_mm, record.tip_tolerance_mm, MILLIMETRE, format_length)
        grid.add_row("tip", Text(deviation + near_in_words(record.tip_at_tolerance)))
    if record.axis_deviation_deg is not None:
        deviation = _within(record.axis_deviation_deg, record.axis_tolerance_deg, DEGREE, format_angle)
        grid.add_row("tool axis", Text(deviation + near_in_words(record.axis_at_tolerance)))
    if record.rounds:
        grid.add_row("effort", Text(rounds_in_words(record)))
    if record.bending is not None:
        grid.add_row("bending", Text(bending_in_words(record.bending)))
    console.print()
    console.print(grid)
    console.print()
    console.print(usage_table(record))
    console.print()
    line = verdict(record, verification)
    if verification.ok and record.usage.worst > PROMISED:
        more = f"  between the set-points a limit is exceeded: {100.0 * record.usage.worst:.2f} % of it"
        if None in record.usage.jerk.values():
            more = "  between the set-points accelerations jump: jerk limits are not held"
        line = Text.assemble(("FAILED", "bold red"), more)
    console.print(line, soft_wrap=True)


def times_in_words(record: PlanRecord) -> list[str]:
    """ "cutting 2 min 03.1 s, rapid 12.3 s, dwell 0 ms", and a line for each operation where there are several."""
    parts = (("cutting", record.cutting_s), ("rapid", record.rapid_s), ("dwell", record.dwell_s))
    lines = [", ".join(f"{name} {format_time(seconds)}" for name, seconds in parts if seconds)]
    several = record.operations if len(record.operations) > 1 else []
    for each in several[:SENTENCES]:
        parts = (("cutting", each.cutting_s), ("rapid", each.rapid_s), ("dwell", each.dwell_s))
        times = ", ".join(f"{name} {format_time(seconds)}" for name, seconds in parts if seconds)
        name = " ".join(word for word in (each.name, f"tool {each.tool}" if each.tool else "") if word) or "before"
        lines.append(f"{name}: {format_time(each.time_s)} ({times})")
    more = len(several) - SENTENCES
    return lines + ([f"and {more} more: see plan.json"] if more > 0 else [])


def cut_in_words(cut: CutRecord) -> list[str]:
    """ "in material 3 min 10 s, in air 1 min 2 s; not sure 0.4 s, by where the stock ends", and whether there are
    collisions."""
    times = f"in material {format_time(cut.cutting_s)}, in air {format_time(cut.air_s)}"
    if cut.uncertain_s >= LEAST_UNSURE:
        ends = format_length(cut.uncertainty_mm * MILLIMETRE)
        times += f", either of both {format_time(cut.uncertain_s)}, as the stock ends within {ends}"
    lines = [f"{times}; {cut.removed_mm3 / 1e3:.4g} cm3 removed"]
    if cut.collisions:
        lines.append(f"{counted(cut.collisions, 'collision')} with the stock or what is around it: see toolpace cut")
    return lines


def near_in_words(share: float | None) -> str:
    """ "; more than 90 % of it is used on 31 % of the path", where that is known."""
    return "" if share is None else f"; more than 90 % of it is used on {100.0 * share:.0f} % of the path"


def rounds_in_words(record: PlanRecord) -> str:
    """ "normal: 4 iterations of path and speed, 14.5 % less time than the first path"."""
    iterations = counted(len(record.rounds) - 1, "iteration") if len(record.rounds) > 1 else "no iterations"
    gained = 1.0 - record.duration_s / record.rounds[0].duration_s
    saved = f"{100.0 * gained:.1f} % less time" if gained >= LEAST_GAIN else "no less time"
    return f"{record.effort}: {iterations} of path and speed, {saved} than the first path"


def bending_in_words(bending: BendingRecord) -> str:
    """ "compensated for the bending of the tool: at most 0.088 mm; 1 iteration, known to 0.15 µm"."""
    largest, change = format_length(bending.largest_mm * MILLIMETRE), format_length(bending.change_um * 1e-6)
    iterations = counted(bending.rounds, "iteration")
    return f"compensated for the bending of the tool: at most {largest}; {iterations}, known to {change}"


def limit_in_words(name: str) -> str:
    """ "jerk C" is "jerk of C"."""
    kind, _, joint = name.partition(" ")
    if name == "nothing":
        return "no limit reached"
    if name.startswith(CONTINUOUS):
        return CONTINUOUS + limit_in_words(name.removeprefix(CONTINUOUS))
    if kind in KINDS and joint.startswith(CURVE):
        return f"{kind} of {joint.removeprefix(CURVE)} at its speed"
    return f"{kind} of {joint}" if kind in (*KINDS, *MOTORS) else name


def limits_in_words(shares: dict[str, float]) -> str:
    """ "feed 62 %, jerk of C 21 %, ..."; what binds for less than a percent is summed up."""
    words: list[str] = []
    rest = 0.0
    for name, share in sorted(shares.items(), key=lambda item: -item[1]):
        if len(words) < SHOWN and share >= 0.01:
            words.append(f"{limit_in_words(name)} {100.0 * share:.0f} %")
        else:
            rest += share
    return ", ".join(words + ([f"others {100.0 * rest:.0f} %"] if rest >= 0.005 else []))


def places_in_words(places: list[OpenPlaceRecord]) -> str:
    """ "largest parts of this gap: 40 ms at 5.30 s (block 120), ..., the rest at 2 more places"; the largest first."""
    largest = sorted(places, key=lambda place: -place.gain_s)[:PLACES_SHOWN]
    words = [
        f"{format_time(place.gain_s)} at {format_time(place.from_s)}"
        + (f" (block {place.block})" if place.block else "")
        for place in largest
    ]
    more = len(places) - len(largest)
    words += [f"the rest at {more} more place{'s' * (more != 1)}"] if more else []
    return "largest parts of this gap: " + ", ".join(words)


def usage_table(record: PlanRecord) -> Table:
    """Peak of each axis in percent of its limit."""
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="dim")
    table.add_column("% of limit", style="dim", no_wrap=True)
    usage = record.usage
    kinds: dict[str, Mapping[str, float | None]] = {
        "velocity": usage.velocity, "acceleration": usage.acceleration, "jerk": usage.jerk
    }  # fmt: skip
    for joint in usage.velocity:
        table.add_column(joint, justify="right", no_wrap=True, min_width=6)
    for kind, values in kinds.items():
        table.add_row(kind, *(_percent(value) for value in values.values()))
        over_speed = {name.removeprefix(f"{kind} {CURVE}"): each for name, each in usage.curves.items() if kind in name}
        if over_speed:
            cells_of_joints = (_percent(over_speed[joint]) if joint in over_speed else "" for joint in values)
            table.add_row("  at its speed", *cells_of_joints)
    if usage.motor:
        of_motors = (_percent(usage.motor[joint]) if joint in usage.motor else Text("-") for joint in usage.velocity)
        table.add_row("torque, force", *of_motors)
    if usage.continuous:
        rated = (_percent(usage.continuous[joint]) if joint in usage.continuous else "" for joint in usage.velocity)
        table.add_row("  continuously", *rated)
    if usage.feed > 0.0:
        table.add_row("feed", _percent(usage.feed), *[""] * (len(usage.velocity) - 1))
    return table


def show_prices(console: Console, record: PlanRecord, machine: Machine) -> None:
    """What more of each limit would save, the most first, where that was worked out; what would save nothing is summed
    up in a line."""
    if not record.prices_s:
        return
    now = limits_now(machine)
    headings = ("limit", "now", "1 % more saves", "10 % more saves, up to")
    table = new_table(headings, left=("limit",))
    dear = savings(record.prices_s, record.duration_s)
    for name, saved in dear.items():
        shown = (f"{format_time(time)}, {100.0 * time / record.duration_s:.2f} %" for time in saved)
        table.add_row(*cells([limit_in_words(name), now.get(name, "of the program"), *shown]))
    console.print("\nmore of one limit, on this path, all others as they are")
    console.print(table)
    nothing = [limit_in_words(name) for name in record.prices_s if name not in dear]
    if nothing:
        console.print(Text.assemble(("nothing saved by more of", "dim"), f"   {', '.join(nothing)}"))


def _percent(ratio: float | None) -> Text:
    if ratio is None:
        return Text("jumps", style="bold red")
    text = f"{100.0 * ratio:.2f}" if ratio >= FULL else f"{100.0 * ratio:.0f}"
    return Text(text, style="bold red" if ratio > PROMISED else "bold" if ratio >= FULL else "")


def _within(value: float, tolerance: float | None, scale: float, show: Callable[[float], str]) -> str:
    allowed = f", allowed {show(tolerance * scale)}" if tolerance else ""
    return f"at most {show(value * scale)} off the program{allowed}"


def verdict(record: PlanRecord, verification: Verification) -> Text:
    """Passed, or what is worst, and by which tolerances and options that was judged; wide tolerances in words."""
    within = f"within {printable(reading_in_words(record))}"
    wide = wider_than_default(record)
    words = [f"WIDER THAN THE DEFAULT: {wide}"] if wide else []
    words += [f"NOT JUDGED: {printable(each)}" for each in verification.unjudged]
    warning = ("".join(f"\n{each}" for each in words), "bold yellow")
    if verification.ok:
        count = len(verification.checks) - len(verification.unjudged)
        points = f"{verification.set_points} set-points at {format_time(verification.dt)}"
        return Text.assemble(("VERIFIED", "bold green"), f"  {within}; {count} checks on {points}", warning)
    found = verification.findings
    more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    return Text.assemble(("FAILED", "bold red"), f"  {printable(str(found[0]))}{more}; judged {within}", warning)


def reading_in_words(record: PlanRecord) -> str:
    """Tolerances, feeds and dialect that a plan was made with: "tip 0.01 mm, axis 0.05 deg, feeds of the program"."""
    words = []
    if record.program_file:
        for part, value, unit, places in (
            ("tip", record.tip_tolerance_mm, "mm", record.tip_tolerances),
            ("axis", record.axis_tolerance_deg, "deg", record.axis_tolerances),
        ):
            tolerance = f"{part} {value:.6g} {unit}" if value else f"{part} tolerance not given"
            words.append(f"{part} {_places_in_words(places)}" if places else tolerance)
        words.append("feeds of the program" if record.feed is None else f"feeds changed to {record.feed}")
        if record.cut_limits is not None:
            words[-1] = f"speeds by its cut ({record.cut_limits.feeds})"
    else:
        words.append("limits of the machine alone, no program")
    words += [f"the tool bent as {record.bending.tool_file} says"] if record.bending is not None else []
    words += [f"read as {record.dialect}"] if record.dialect else []
    words += [f"for {record.controller}"] if record.controller else []
    how = record.reading
    words += ["by its set-up sheet"] if how.setup_file else []
    words += ["unknown words skipped"] if how.skip_unknown else []
    words += ["read on where the control stops"] if how.lenient else []
    words += [f"G41 and G42 as the {how.compensation}med contour"] if how.compensation else []
    words += [f"columns {how.columns}"] if how.columns else []
    words += [f"table in {how.units}"] if how.units else []
    words += [f"at most {how.max_blocks} blocks"] if how.max_blocks is not None else []
    return ", ".join(words)


def _places_in_words(places: str) -> str:
    """Tolerances by place: "10um,finish:5um"; "10um, less where the program asks for less" of tighter ones."""
    parts = places.split(",")
    left = ",".join(part for part in parts if part != TIGHTER)
    return f"{left}, less where the program asks for less" if TIGHTER in parts else left


def wider_than_default(record: PlanRecord) -> str:
    """The tolerances that are looser than those of a plan without options; empty where none is."""
    words = []
    for part, value, usual, unit in (
        ("tip", record.tip_tolerance_mm, DEFAULT_TIP_MM, "mm"),
        ("axis", record.axis_tolerance_deg, DEFAULT_AXIS_DEG, "deg"),
    ):
        if value is not None and value > usual * (1.0 + 1e-9):
            words.append(f"{part} tolerance {value:.6g} {unit}, {value / usual:.3g} times {usual:g} {unit}")
    return "; ".join(words)


def show_verification(console: Console, record: PlanRecord, verification: Verification) -> None:
    """Every check, one a row, what was not checked, and the verdict."""
    table = new_table(("check", "worst", "allowed", "where", ""), left=("check", "where", ""))
    for row in verification.rows():
        table.add_row(*cells(row, {"ok": "", "FAILED": "bold red"}.get(row[-1], "bold yellow")))
    console.print(table)
    unchecked = ", ".join(AS_SAID)
    console.print(f"taken from the planner, checked against the other figures only: {unchecked}", soft_wrap=True)
    console.print("not checked: report.html", soft_wrap=True)
    console.print(verdict(record, verification), soft_wrap=True)


def show_machine(console: Console, machine: Machine) -> None:
    """The chain, and travel and limits of each joint."""
    _head(console, machine)
    table_rows = machine.summary()
    motors = [kind for kind in MOTORS if any(kind in row for row in table_rows)]
    headings = ("joint", "travel", "velocity", "acceleration", "jerk", *motors)
    table = new_table(headings, left=("joint",))
    for row in table_rows:
        table.add_row(*cells(row.get(heading, "-") for heading in headings))
    console.print(table)


def show_poses(console: Console, machine: Machine) -> None:
    """The chain, and poses to compare with the real machine; lines are not broken, so that columns stay aligned."""
    from toolpace.machine.file_writer import pose_table

    _head(console, machine)
    console.print(Text(f"Tip and tool axis in the frame of the part:\n{pose_table(machine.geometry)}"), soft_wrap=True)


def _head(console: Console, machine: Machine) -> None:
    """Name, note and chain."""
    from toolpace.machine.file_writer import title

    name, _, rest = title(machine.file, machine.kind).partition(": ")
    name, rest, note = printable(name), printable(rest), printable(machine.file.note)
    console.print(Text.assemble((name, "bold"), f"  {note + '; ' if note else ''}{rest}"), soft_wrap=True)


def show_files(console: Console, folder: Path, names: list[str], record: PlanRecord | None = None) -> None:
    """What was written, the report last; of a plan's compact set-points also how to have them as arrays."""
    line = f"   {printable(str(folder))}: {', '.join(names)}"
    console.print(Text.assemble(("written", "dim"), line), soft_wrap=True)
    if record is not None and COMPACT_FILE in names:
        console.print(Text.assemble(("set-points", "dim"), f"{compact_in_words(folder, record)}"), soft_wrap=True)


def compact_in_words(folder: Path, record: PlanRecord) -> str:
    """ "setpoints.compact, 20 MB: tp.read_set_points reads it; --npz full writes setpoints.npz, about 630 MB"."""
    small = (folder / COMPACT_FILE).stat().st_size
    full = full_size(record.set_points, len(record.usage.velocity))
    return (
        f" {COMPACT_FILE}, {small / 1e6:.3g} MB: tp.read_set_points reads it; --npz full writes {FULL_FILE}, about "
        f"{full / 1e6:.3g} MB"
    )
