"""The folder of a set-up search, with its programs as cutter-location data (APT)."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common import __version__
from toolpace.common.errors import UsageError, printable
from toolpace.common.files import whole_folder
from toolpace.common.units import DEGREE, MILLIMETRE, MINUTE, format_time
from toolpace.programs.reading.setup_file import setup_text
from toolpace.programs.toolpath import ToolPath
from toolpace.results.report.set_up_page import map_svg, set_up_page
from toolpace.setup_search.found_set_up import sheet_of, with_sheet

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.setup_search.found_set_up import FoundSetUp, PlannedSetUp

RECORD, PAGE, MAP, SHEET, MACHINE, PROGRAM = (
    "setup.json", "setup.html", "map.svg", "setup.toml", "machine.toml", "program.apt",
)  # fmt: skip
"""Names of its files."""
TIP, AXIS, FEED = 9, 12, 9
"""Decimals of mm, of a direction's parts, and of mm/min or motions a minute."""


def write_set_up(
    directory: str | os.PathLike[str],
    found: FoundSetUp,
    program: str,
    setup: SetUp | None = None,
    others: Sequence[tuple[str, FoundSetUp | str]] = (),
    reports: Sequence[str] = (),
) -> list[str]:
    """Write the folder and return the names of its files, the page last.

    setup.toml is the set-up sheet of the best set-up, machine.toml the machine with it, program.apt the program as tips
    and tool axes for it, setup.html the page, map.svg the map where there is one, setup.json all figures. `setup` is
    the sheet that the program was read with; `others` are all machines that were searched, `reports` those of the plans
    of the best set-ups, as they are reached from the folder. Raises UsageError.
    """
    if not hasattr(found, "best"):
        raise UsageError(f"write_set_up: {type(found).__name__} in place of what search_setup returns")
    best = found.best[0]
    sheet = sheet_words(program, found) + setup_text(sheet_of(best.machine, setup))
    with whole_folder(directory, seal=RECORD) as folder:
        texts = {
            SHEET: sheet,
            MACHINE: with_sheet(best.machine, setup).to_toml(),
            PROGRAM: cldata_text(found.toolpath, f"{program}: tips and tool axes, for any clamping"),
            PAGE: set_up_page(found, program, sheet, others, reports),
            RECORD: json.dumps(record(found, program, others), indent=2, allow_nan=False) + "\n",
        }
        if found.places is not None:
            texts[MAP] = map_svg(found.places) + "\n"
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    return [name for name in (RECORD, MAP, SHEET, MACHINE, PROGRAM, PAGE) if name in texts]


def sheet_words(program: str, found: FoundSetUp) -> str:
    """The head of the set-up sheet: how to clamp the part, with which tool, and what no sheet can tell."""
    best = found.best[0]
    chain, clamping = best.machine.file.chain, best.clamping
    shown = program if program.isprintable() else ascii(program)
    x, y, z = (f"{each / MILLIMETRE:.3f}" for each in chain.workpiece_origin)
    lengths = [f"{each / MILLIMETRE:g}mm" for each in best.tool_lengths]
    lines = [
        f"Set-up sheet of {shown} on {best.machine.name}, as found by `toolpace setup`: {format_time(best.duration)}.",
        f"From how the part is clamped now: {clamping.words(best.machine)}.",
        f"Its zero then is at X {x}, Y {y}, Z {z} mm, in the bed's frame with every joint at zero; [part] has",
        "the same in metres, and where X and Z of the part point.",
        "Work offsets are left out: measure them when the part is clamped.",
        f"Tool: {', '.join(lengths)} from the spindle nose to the tip"
        + (f"; give it with --tool-length {lengths[0]}." if clamping.tool_length is not None else "."),
        "It goes with program.apt: rotary words of the program as it was hold for the old clamping only.",
    ]
    if clamping.side:
        joint = best.machine.geometry.rotary_joints[1]
        low, high = (f"{each / DEGREE:g}" for each in best.machine.travel[best.machine.joints.index(joint)])
        lines.append(
            f"{joint} keeps to {low} to {high} deg, which a sheet cannot hold: use machine.toml, which has it all."
        )
    return "".join(f"# {line}\n" for line in lines) + "\n"


def record(found: FoundSetUp, program: str, others: Sequence[tuple[str, FoundSetUp | str]]) -> dict[str, object]:
    """All figures, in mm, deg and s."""
    best, given, places = found.best[0], found.given, found.places
    return {
        "program": program,
        "machine": best.machine.name,
        "duration_s": best.duration,
        "lower_bound_s": best.lower_bound,
        "given_duration_s": None if given is None else given.duration,
        "given_error": found.why,
        "gain": None if given is None else found.gain,
        "trials": found.trials,
        "seed": found.seed,
        "search_s": found.seconds,
        "set_ups": [_set_up(each) for each in found.best],
        "limited_by": {"before": {} if given is None else dict(given.limited_by), "after": dict(best.limited_by)},
        "map": None
        if places is None
        else {
            "x_mm": _list(places.x / MILLIMETRE),
            "y_mm": _list(places.y / MILLIMETRE),
            "seconds": [[None if math.isnan(each) else float(each) for each in row] for row in places.seconds],
        },
        "machines": [_machine(name, each) for name, each in others],
        "toolpace_version": __version__,
    }


def _set_up(each: PlannedSetUp) -> dict[str, object]:
    chain = each.machine.file.chain
    return {
        "duration_s": each.duration,
        "lower_bound_s": each.lower_bound,
        **{f"{name}_deg": angle / DEGREE for name, angle in each.clamping.angles()},
        "moved_mm": _list(np.array(each.clamping.shift) / MILLIMETRE),
        "tool_length_mm": each.machine.tool_length / MILLIMETRE,
        "tool_lengths_mm": _list(np.array(each.tool_lengths) / MILLIMETRE),
        "solution": each.clamping.side,
        "origin_mm": _list(np.array(chain.workpiece_origin) / MILLIMETRE),
        "x": list(chain.workpiece_x),
        "z": list(chain.workpiece_z),
        "limited_by": dict(each.limited_by),
        "joints": _used(each),
    }


def _used(each: PlannedSetUp) -> Mapping[str, list[float]]:
    """Lowest and highest position of each joint [mm or deg]."""
    machine: Machine = each.machine
    scale = np.where(machine.is_rotary, DEGREE, MILLIMETRE)
    return {joint: _list(each.used[j] / scale[j]) for j, joint in enumerate(machine.joints)}


def _machine(name: str, found: FoundSetUp | str) -> dict[str, object]:
    if isinstance(found, str):
        return {"machine": name, "error": found}
    given = None if found.given is None else found.given.duration
    return {"machine": name, "duration_s": found.best[0].duration, "given_duration_s": given, **_set_up(found.best[0])}


def _list(values: Iterable[float]) -> list[float]:
    return [float(each) for each in values]


def cldata_text(toolpath: ToolPath, note: str = "") -> str:
    """The statements, one a line, in mm; read again they are the same points, feeds, stops and dwells.

    Rotary joints, where the tool path names them, are left to whoever reads it: another machine has others.
    """
    head = [f"PPRINT {printable(line)[:60]}" for line in note.splitlines()]
    return "\n".join([*head, "UNITS/MM", "MULTAX", *_statements(toolpath), "FINI", ""])


def _statements(toolpath: ToolPath) -> Iterator[str]:
    feed, begun = "", -1
    for i in range(len(toolpath)):
        if toolpath.operation[i] != begun:
            begun = int(toolpath.operation[i])
            yield from _operation(toolpath, begun)
        if i > 0 and not toolpath.rapid[i]:
            wanted = _feed(toolpath, i)
            if wanted != feed:
                yield wanted
            feed = wanted
        elif i > 0:
            yield "RAPID"
        numbers = [_plain(each / MILLIMETRE, TIP) for each in toolpath.tip[i]]
        numbers += [_plain(each, AXIS) for each in toolpath.axis[i]]
        yield f"GOTO/{','.join(numbers)}"
        if toolpath.dwell[i] > 0.0 or (toolpath.stop[i] and 0 < i < len(toolpath) - 1):
            yield f"DELAY/{_plain(float(toolpath.dwell[i]), FEED)}"


def _operation(toolpath: ToolPath, number: int) -> Iterator[str]:
    operation = toolpath.operations[number]
    name = "".join(c for c in printable(operation.name) if c not in "$,/").strip()
    tool = "".join(c for c in printable(operation.tool) if c not in "$,/").strip()
    if name or tool:
        yield f"TOOL PATH/{name or f'OPERATION-{number + 1}'}" + (f",TOOL,{tool}" if tool else "")


def _feed(toolpath: ToolPath, i: int) -> str:
    """FEDRAT of the way to a point: its feed, or the inverse of its least time."""
    if np.isfinite(toolpath.feed[i]):
        return f"FEDRAT/{_plain(float(toolpath.feed[i]) / MILLIMETRE * MINUTE, FEED)},MMPM"
    return f"FEDRAT/INVERS,{_plain(MINUTE / float(toolpath.least_time[i]), FEED)}"


def _plain(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text
