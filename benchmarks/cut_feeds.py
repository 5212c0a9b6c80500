"""New feeds of public programs: by air, by what the program teaches, by a limit of the chip.

    python -m benchmarks.cut_feeds PROGRAM... [--way air learned limits] [--controls] [--keep FOLDER]

The programs cannot be kept here; each is given by its path, and known by its name (`CASES`, with where it is from). Its
set-up sheet is in benchmarks/sheets. Writes benchmarks/results/cut_feeds.md; rows of programs that are not given stay.
Programs with new feeds are kept in a folder, for a control (`python -m testbed.linuxcnc.times --program FILE...`).
"""

from __future__ import annotations

import argparse
import re
import sys
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from toolpace.common.arrays import Floats
from toolpace.common.units import MILLIMETRE
from toolpace.controls.export.cut_feeds import with_cut_feeds
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import figures_for, moves_of, time_of_moves
from toolpace.controls.timing.speeds import ControlSpeeds
from toolpace.cutting.feeds.feed_plan import plan_feeds
from toolpace.cutting.feeds.limited_plan import plan_within_cut
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.jobs import TimedSteps
from toolpace.jobs.cut import CutRequest, cut_program
from toolpace.machine.machine import Machine
from toolpace.programs.reading import ReadOptions, Source
from toolpace.programs.reading.languages import with_controller
from toolpace.programs.reading.setup_file import load_setup
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

SHEETS = Path(__file__).parent / "sheets"
PAGE = RESULTS / "cut_feeds.md"
MODELS = ("linuxcnc", "heidenhain", "lookahead")
"""Of three kinds: cycle by cycle, with filters, with limited jerk."""
WAYS = ("program", "air", "learned", "limits")
TIP, AXIS = Tolerances(10e-6, tighter=True), Tolerances(1e-3, tighter=True)
"""Those of the command: [m], [rad]."""
EFFORT = "low"


@dataclass(frozen=True)
class Case:
    """A public program, and what is asked of it."""

    machine: str
    cell: float
    """Of the stock [mm]."""
    chips: Mapping[str, float]
    """Limit of the chip by tool [mm]: the feed per tooth of its roughing."""
    controller: str | None = None
    """None: the program tells."""
    without_teachers: frozenset[str] = field(default_factory=frozenset)


CASES = {
    # CC BY 4.0: "Production data set for five-axis CNC milling with multiple changeovers", doi 10.5281/zenodo.15735480
    "Bottle_opener": Case("xyzbc-trunnion", 0.4, {"SCHAFT_D8_N_AP20": 0.055, "SCHAFT_D4_N_AP20": 0.05}),
    "Coordinate_system_representation_Achskreuz": Case(
        "xyzbc-trunnion", 1.0, {"PLAN_D50_N_AP4": 0.1, "SCHAFT_D12_N_AP30": 0.04, "SCHAFT_D6_N_AP15": 0.02}
    ),
    # GPL: an example of LinuxCNC's (FC Hermle, 2011)
    "boat-xyzac": Case("linuxcnc-xyzac-trt", 0.5, {"1": 0.24}),
    # GPL: an example of LinuxCNC's (Gordon, Drew, Corner), whose F is far above the feed that its comment tells
    "3D_Chips": Case("linuxcnc-xyzac-trt", 0.8, {"1": 0.14}),
    # no licence is told: a program by hand for a table with A and C
    "gu_cutting": Case("xyzac-trunnion", 0.4, {"": 0.025}),
    # no licence is told: github.com/Epictetzu/GCodePosts, posted by Fusion for a mill with GRBL
    "NozzleDeepADOC_OP1": Case("xyzac-trunnion", 0.5, {"1": 0.028, "3": 0.028}),
    # no licence is told: github.com/Mheaton92/PMC, posted by Fusion for a Haas
    "1001": Case("xyzac-trunnion", 2.0, {"7": 0.34}),
}
"""By the name of its file, without its suffix."""

HEADS = [
    "program", "feeds", *(f"{model} [s]" for model in MODELS), "blocks changed", "divided", "computing [s]",
    "ideal [s]", "computing [s]",
]  # fmt: skip


def rules_of(case: Case, way: str) -> FeedRules:
    """Those of the command without other options; limits of the chip."""
    limits = {tool: CutLimits(chip=chip * MILLIMETRE) for tool, chip in case.chips.items()}
    return FeedRules(way, limits=limits if way == "limits" else {}, not_teaching=case.without_teachers)


def measured(program: Path, ways: Sequence[str], ideal: bool, keep: Path | None = None) -> Iterator[list[str]]:
    """A line of the table for each way; programs with new feeds go into the folder `keep`."""
    case = CASES[program.stem]
    machine = Machine.load(case.machine)
    options = ReadOptions.of(machine, case.controller, SHEETS / f"{program.stem}.toml")
    request = CutRequest(machine, options, TIP, AXIS, EFFORT, None, None, case.cell * MILLIMETRE, 1e9)
    source = Source.load(program)
    options, _ = with_controller(source, None, options)
    began = time.process_time()
    cut = cut_program(str(program), request, TimedSteps(), None, lambda operation, stock: None)
    seconds = time.process_time() - began
    tools = [options.setup.figures_of(each.tool, each.figures) for each in cut.toolpath.operations]
    figures = figures_for(options, None)
    reached = ControlSpeeds.of(cut.toolpath, machine, figures).mean
    for way in ways:
        words, data = ["", ""], source.data
        if way != "program":
            began = time.process_time()
            rules = rules_of(case, way).for_machine(machine)
            plan = plan_feeds(cut.simulation, cut.toolpath, tools, rules, reached)
            written = with_cut_feeds(
                source, machine, None, options, cut.toolpath, plan,
                times=lambda path: ControlSpeeds.of(path, machine, figures).times,
            )  # fmt: skip
            seconds, data = time.process_time() - began, written.data
            words = [str(written.changed), str(written.divided)]
            if keep is not None:
                (keep / f"{program.stem}-{way}{program.suffix}").write_bytes(data)
            for note in plan.notes:
                print(f"  {program.name}, {way}: {note}", file=sys.stderr)
        moves = moves_of(Source.from_bytes(data, source.name), machine, options)
        controls = [time_of_moves(moves, machine, figures_of({}, "", model)).total for model in MODELS]
        best = [f"{cut.trajectory.duration:.1f}" if way == "program" else "", ""]
        if ideal and way != "program":
            began = time.process_time()
            duration = within_cut(cut.toolpath, case, reached, way)
            best = [f"{duration:.1f}", f"{time.process_time() - began:.1f}"]
        yield [
            f"`{program.name}`", way, *(f"{each:.1f}" for each in controls), *words, f"{seconds:.1f}", *best
        ]  # fmt: skip


def within_cut(toolpath: ToolPath, case: Case, reached: Floats, way: str) -> float:
    """How long the fastest motion takes within what the cut allows in place of the feeds [s]."""
    machine = Machine.load(case.machine)
    setup = load_setup(SHEETS / f"{Path(toolpath.source).stem}.toml")
    found = plan_within_cut(
        toolpath, machine, setup, rules_of(case, way).for_machine(machine), TIP, AXIS, effort=EFFORT,
        resolution=case.cell * MILLIMETRE, reached=reached if way == "learned" else None,
    )  # fmt: skip
    return found.plan.trajectory.duration


def kept() -> dict[tuple[str, str], list[str]]:
    """Lines of the page by program and way."""
    text = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    found = re.findall(r"^\| (`.*) \|$", text, re.MULTILINE)
    lines = [[word.strip() for word in line.split("|")] for line in found]
    return {(line[0], line[1]): line for line in lines}


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+", type=Path, help=f"files named {', '.join(CASES)}")
    parser.add_argument("--way", nargs="*", default=WAYS, choices=WAYS, help="which feeds (default: all)")
    parser.add_argument("--controls", action="store_true", help="no ideal motion within what the cut allows")
    parser.add_argument("--keep", type=Path, help="folder for the programs with new feeds")
    asked = parser.parse_args()
    if unknown := [str(each) for each in asked.programs if each.stem not in CASES]:
        parser.error(f"{', '.join(unknown)}: not one of {', '.join(CASES)}")
    warnings.simplefilter("ignore")
    for program in asked.programs:
        for line in measured(program, asked.way, not asked.controls, asked.keep):
            print(" | ".join(line), flush=True)
            write({**kept(), (line[0], line[1]): line})


def write(lines: Mapping[tuple[str, str], list[str]]) -> None:
    """The page, programs and ways in their order."""
    names = list(CASES)
    in_order = sorted(
        lines.values(), key=lambda line: (names.index(Path(line[0].strip("`")).stem), WAYS.index(line[1]))
    )
    table = Table("Times before and after", HEADS, in_order, words=2)
    about = (
        "Times by the controls' models, of the program as it is and with new F words; then the ideal motion, that of "
        "`plan --effort low`, and of `plan --feeds` in the other rows (empty: not planned). Computing is processor "
        "time: of the plan and the cut in the first row, of the feeds alone in the others, and of the ideal motion. "
        "Limits are of the chip, at the feed per tooth of each tool's roughing. Programs, licences and sheets: "
        "benchmarks/cut_feeds.py, benchmarks/sheets. Rows may have been measured one by one."
    )
    PAGE.write_text(
        f"# New feeds of public programs\n\n{written_by('python -m benchmarks.cut_feeds PROGRAM...')}\n\n{about}\n\n"
        f"{table.markdown()}",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
