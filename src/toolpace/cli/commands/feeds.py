"""The command `feeds`: a program with the feeds that its cut allows."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.console import Console

from toolpace.cli import options
from toolpace.cli.commands.cut import MEMORY, Memory, Resolution, cell, size
from toolpace.cli.console import Steps, new_console, print_json
from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.units import parse_feed, parse_length

if TYPE_CHECKING:
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.jobs.cut_options import CutOptions
    from toolpace.machine.cutting_tool import Coefficients
    from toolpace.results.write import StatedPromise

SPINDLE = ("program", "range")
Way = Annotated[
    str,
    Parameter(
        name="--feeds",
        help="air: faster only where nothing can be cut. learned: as fast as the same tool is loaded elsewhere in the "
        "program. limits: as the limits of --limit allow.",
    ),
]
Limits = Annotated[
    list[str],
    Parameter(
        name="--limit",
        help="A limit of the cut, for all tools or, in its place, for one: chip=0.08mm, 3:force=400N; chip, "
        "feed_per_tooth [mm], removal_rate [mm3/s], force [N], torque, moment [Nm], power [W], stress [MPa], "
        "deflection, surface_deflection, compensated_deflection, feed_marks [um]. Repeat it.",
        negative=(),
        consume_multiple=False,
    ),
]


Out = Annotated[
    str | None, Parameter(name=["--out", "-o"], help="File for the program with new feeds; never the input.")
]
Report = Annotated[
    str | None, Parameter(help="File for a page (x.html): feed and loads before and after over time, by operation.")
]


def limit_words(limit: list[str] | None, max_deflection: str | None) -> list[str]:
    """What --limit and --max-deflection tell, as words of --limit."""
    return [*(limit or []), *([f"surface_deflection={max_deflection}"] if max_deflection else [])]


@Parameter(name="*")
@dataclass(frozen=True)
class Allowed:
    """What feeds may become."""

    feeds: Way = "air"
    limit: Limits | None = None
    max_deflection: Annotated[
        str | None, Parameter(help="Most deflection that is left on the surface: 20um; as --limit surface_deflection.")
    ] = None
    material: Annotated[
        str | None, Parameter(help="What is cut, for forces: Al7075-T6, or a file of coefficients (.toml).")
    ] = None
    air_feed: Annotated[
        str | None, Parameter(help="Feed in air, and the most in the cut: 6000mm/min. By default as the slowest axis.")
    ] = None
    margin: Annotated[
        str, Parameter(help="How far before and behind the material the feed of the cut holds: 1mm.")
    ] = "1mm"
    raise_at_most: Annotated[
        float | None, Parameter(help="Factor by which a feed is raised at most where something may be cut: 2.")
    ] = None
    lower: Annotated[
        bool, Parameter(negative=(), help="Lower feeds too where they are above what is allowed (always with limits).")
    ] = False
    finishing: Annotated[
        bool, Parameter(negative=(), help="Raise feeds, too, where the tool makes a surface that stays.")
    ] = False
    teacher: Annotated[
        list[str] | None,
        Parameter(
            help="Folder of another program's teachers (--save-teachers), of the same shop and material: a tool with "
            "the same name, figures and spindle speed may be loaded as there. Repeat it.",
            negative=(), consume_multiple=False,
        ),
    ] = None
    without_teacher: Annotated[
        list[str] | None,
        Parameter(
            help="Operation, or line, that teaches nothing. Repeat it.", negative=(), consume_multiple=False
        ),
    ] = None
    leave: Annotated[
        list[str] | None,
        Parameter(help="Operation whose feeds stay, by name. Repeat it.", negative=(), consume_multiple=False),
    ] = None

    def rules(self) -> FeedRules:
        """The same, checked. Raises UsageError."""
        from toolpace.cutting.feeds.rules import FeedRules
        from toolpace.cutting.feeds.schedule import PROGRAM_STEPS
        from toolpace.cutting.feeds.teaching import load_teachers
        from toolpace.jobs.cut_options import cut_limits

        limits = cut_limits(limit_words(self.limit, self.max_deflection))
        if self.feeds == "limits" and not limits:
            raise UsageError("--feeds limits: no limit is given; add one, such as --limit chip=0.08mm")
        if (self.teacher or self.without_teacher) and self.feeds != "learned":
            raise UsageError(f"--teacher and --without-teacher go with --feeds learned; the feeds are '{self.feeds}'")
        if limits and self.feeds != "limits":
            raise UsageError(f"--limit goes with --feeds limits, and the feeds are '{self.feeds}'")
        return FeedRules(
            way=self.feeds,
            air_feed=None if self.air_feed is None else parse_feed(self.air_feed),
            steps=replace(PROGRAM_STEPS, margin=parse_length(self.margin)),
            limits=limits,
            materials={} if self.material is None else {"": coefficients_of(self.material)},
            raise_at_most=math.inf if self.raise_at_most is None else self.raise_at_most,
            lower=self.lower,
            finishing=self.finishing,
            left_alone=frozenset(self.leave or []),
            not_teaching=frozenset(self.without_teacher or []),
            teachers=tuple(each for folder in self.teacher or [] for each in load_teachers(folder)),
        )


AS_IN_AIR = Allowed()


PROGRAM = "program"


@Parameter(name="*")
@dataclass(frozen=True)
class AllowedInPlan(Allowed):
    """What the speeds of a plan may become."""

    feeds: Annotated[
        str,
        Parameter(
            name="--feeds",
            help="program: the feeds are those of the program. air, learned, limits: as fast as the cut allows, as "
            "`toolpace feeds` has it; the sheet tells stock and tools.",
        ),
    ] = PROGRAM
    margin: Annotated[
        str, Parameter(help="How far before and behind a place what its cut allows holds, beyond one cell: 0.5mm.")
    ] = "0mm"

    def of_plan(self, resolution: str | None, memory: str, bend: str | None) -> CutOptions | None:
        """What the cut allows a plan; None where the program's feeds hold. Raises UsageError."""
        from toolpace.jobs.cut_options import CutOptions

        if self.feeds == PROGRAM:
            for name in (each.name for each in fields(self) if each.name != "feeds"):
                if getattr(self, name) != getattr(AS_PROGRAMMED, name):
                    option = "--" + name.replace("_", "-")
                    raise UsageError(f"{option} goes with --feeds air, learned or limits")
            return None
        cell_size = None if resolution is None else cell(resolution)
        rules = self.rules()
        if bend is not None:
            # what is compensated counts by what is left of it
            rules = replace(rules, limits={tool: each.compensated for tool, each in rules.limits.items()})
        return CutOptions(rules, parse_length(self.margin), cell_size, size(memory), self.material or "")


AS_PROGRAMMED = AllowedInPlan()


@Parameter(name="*")
@dataclass(frozen=True)
class StatedCut:
    """What a plan's cut was promised to be."""

    limit: Limits | None = None
    max_deflection: Annotated[
        str | None, Parameter(help="Most deflection that is left on the surface, as the plan was to hold it: 20um.")
    ] = None
    material: Annotated[
        str | None, Parameter(help="What is cut: Al7075-T6, or a file of coefficients (.toml).")
    ] = None

    def promise(self) -> StatedPromise:
        """The same, read. Raises UsageError."""
        from toolpace.jobs.cut_options import cut_limits
        from toolpace.results.write import StatedPromise

        limits = cut_limits(limit_words(self.limit, self.max_deflection))
        return StatedPromise(
            {tool: {name: getattr(each, name) for name in each.names} for tool, each in limits.items()} or None,
            None if self.material is None else coefficients_of(self.material),
        )


NOTHING_STATED = StatedCut()


def feeds_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    allowed: Allowed = AS_IN_AIR,
    spindle: Annotated[
        str,
        Parameter(
            help="program: the spindle speeds are those of the program. range: each operation gets the speed at which "
            "its cut is fastest, within spindle_range and cutting_speed of its tool and what the spindle gives."
        ),
    ] = "program",
    whole_blocks: Annotated[bool, Parameter(negative=(), help="Divide no block.")] = False,
    out: Out = None,
    report: Report = None,
    save_teachers: Annotated[
        str | None, Parameter(help="Folder for what was learned from this program, for others (--teacher).")
    ] = None,
    resolution: Resolution = None,
    memory: Memory = MEMORY,
    tolerances: options.Tolerances = options.TIGHTER_TOLERANCES,
    effort: options.Effort = "normal",
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    json: Annotated[
        bool, options.Switch, Parameter(name="--json", help="Print what was found as JSON: one object.")
    ] = False,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Write a program anew with the feeds that its cut allows.

    The stock and the tools are those of the set-up sheet. The program is planned, the
    stock is cut along the motion, and each block gets the feed that air, the program's
    own heaviest cut, or limits allow. Text and path stay; long straight blocks may be
    divided. The times before and after are those of the control's model. On a guessed
    stock no feed is raised.

    For example:

        toolpace feeds part.ngc -m xyzac-trunnion --setup setup.toml --out part-air.ngc
        toolpace feeds part.ngc -m my-mill.toml --setup setup.toml --feeds learned --raise-at-most 2 -o new.ngc
        toolpace feeds part.ngc -m my-mill.toml --setup setup.toml --feeds limits --limit chip=0.08mm -o new.ngc
        toolpace feeds part.ngc -m my-mill.toml --setup setup.toml -o new.ngc --report feeds.html
    """
    from toolpace.cli import arguments
    from toolpace.cli.feeds_summary import show_feeds
    from toolpace.common.files import whole_file
    from toolpace.cutting.feeds import teaching
    from toolpace.jobs.cut import CutRequest
    from toolpace.jobs.feeds import feeds_record, new_feeds

    if spindle not in SPINDLE:
        raise UsageError(f"--spindle {spindle[:40]} is not known; {did_you_mean(spindle[:40], SPINDLE)}")
    if save_teachers is not None and allowed.feeds != "learned":
        raise UsageError(f"--save-teachers goes with --feeds learned, and the feeds are '{allowed.feeds}'")
    if out is not None:
        program_file(out, {"program": program, "set-up sheet": reading.setup, "machine file": machine})
    if report is not None:
        page_file(report, out, program)
    tip, axis = arguments.tolerances(tolerances)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    rules = allowed.rules()
    request = CutRequest(
        machine=on, options=how, tip_tolerance=tip, axis_tolerance=axis, effort=arguments.effort_named(effort),
        feed=None, dialect=dialect,
        resolution=None if resolution is None else cell(resolution), memory=size(memory),
    )  # fmt: skip
    console = new_console()
    steps = Steps(Console(stderr=True, highlight=False, markup=False) if json else console)
    found = new_feeds(program, request, rules, not whole_blocks, steps, spindle == "range")
    if out is not None:
        with whole_file(out) as temporary:
            temporary.write_bytes(found.written.data)
    if report is not None:
        from toolpace.results.cut.feeds_page import feeds_page

        with steps.step("writing"), whole_file(report) as temporary:
            temporary.write_text(feeds_page(found, on.name), encoding="utf-8")
    if save_teachers is not None:
        teaching.save_teachers(found.plan.teachers, Path(program).name, save_teachers)
    if json:
        print_json(feeds_record(found, on.name))
    else:
        show_feeds(console, found)
        written = ", ".join(printable(name) for name in (out, report) if name is not None)
        if written:
            console.print(f"\nwritten   {written}", soft_wrap=True)
    return 0


def program_file(out: str, read: dict[str, str | None]) -> None:
    """Raise UsageError where a program cannot be written to a file, or what is read is that file."""
    for what, file in read.items():
        if file is not None and Path(out).exists() and Path(file).exists() and Path(out).samefile(file):
            raise UsageError(f"--out {out}: that is the {what} itself, which is never written over; name another")
    if Path(out).is_dir():
        raise UsageError(f"--out {out}: that is a folder; name a file in it")
    if not Path(out).absolute().parent.is_dir():
        raise UsageError(f"--out {out}: its folder does not exist; make it first")


def page_file(report: str, out: str | None, program: str) -> None:
    """Raise UsageError where a page cannot be written to a file, before the work that makes it."""
    if not report.lower().endswith((".html", ".htm")):
        raise UsageError(f"--report {report[:80]}: it is a page; name it like feeds.html")
    if not Path(report).absolute().parent.is_dir():
        raise UsageError(f"--report {report[:80]}: its folder does not exist; make it first")
    if any(name is not None and Path(report).resolve() == Path(name).resolve() for name in (out, program)):
        raise UsageError(f"--report {report[:80]}: that is the program; name another file")


def coefficients_of(material: str) -> Coefficients:
    """Those of a material by its name, or in a file. Raises UsageError."""
    from toolpace.cutting.forces.material import Material

    return Material.load(material).coefficients
