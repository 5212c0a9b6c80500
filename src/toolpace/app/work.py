"""The work of the app, carried out beside its server: inspections, set-up sheets, jobs and comparisons.

Each is what a command does too: `inspect`, `inspect --write-setup`, `feeds`, `plan`, `export --to program`, `compare`.
"""

from __future__ import annotations

import dataclasses
import re
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from toolpace.app.project import COMPARISONS, FEEDS_PAGE, Project
from toolpace.app.records import CUT_FEEDS, AppJob, Part, cut_rules
from toolpace.common.errors import ProgramError, ToolpaceError, printable
from toolpace.common.files import whole_file, write_text
from toolpace.common.files.toml import toml_value
from toolpace.jobs import Step, TimedSteps
from toolpace.jobs.batch.job import BatchRow, Loader
from toolpace.jobs.batch.work import MARK, Place, do_job
from toolpace.programs.reading.source import Source

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.reading.findings import Refusal
    from toolpace.programs.reading.inspection import Inspection

OFTEN = 0.2
"""Time between two words on the share of a step [s]."""
MEMORY = 1e9
"""Of the stock [bytes], as `toolpace feeds` has it unless told."""
OPTION = re.compile(r"--([a-z][a-z-]+)(?:[ ]([^\s,;()]+))?")
"""An option that a message names, with its value."""
VALUES = ("controller", "dialect", "compensation", "columns", "units", "max-blocks", "feed", "setup", "tool-length")


class InspectTask(msgspec.Struct, frozen=True, tag="inspect"):
    """Inspect a part on all machines."""

    part: str


class SheetTask(msgspec.Struct, frozen=True, tag="sheet"):
    """Write a set-up sheet to fill in, for a part."""

    part: str


class JobTask(msgspec.Struct, frozen=True, tag="job"):
    """Carry out a job."""

    job: str


class CompareTask(msgspec.Struct, frozen=True, tag="compare"):
    """Draw the page of plans side by side."""

    folders: tuple[str, ...]
    names: tuple[str, ...]
    page: str


Task = InspectTask | SheetTask | JobTask | CompareTask
Tell = Callable[[dict[str, Any]], None]
"""Takes what is to be said of a task under way: a step with its share, note or seconds."""


class ToldSteps(TimedSteps):
    """Steps that are told as they begin, go on and end."""

    def __init__(self, tell: Tell) -> None:
        super().__init__()
        self._tell = tell

    def say(self, text: str) -> None:
        """A line below that of a step."""
        self._tell({"say": printable(text)})

    @contextmanager
    def step(self, name: str, note: str = "") -> Iterator[Step]:
        """Run the block as a step, and tell how far it is."""
        step, began = Step(), time.perf_counter()
        last = began

        def share(value: float) -> None:
            nonlocal last
            if time.perf_counter() - last > OFTEN:
                last = time.perf_counter()
                self._tell({"step": name, "share": min(max(float(value), 0.0), 1.0)})

        step.share = share
        self._tell({"step": name, "note": note})
        yield step
        took = time.perf_counter() - began
        self.seconds[name] = self.seconds.get(name, 0.0) + took
        self._tell({"step": name, "seconds": took, "note": printable(step.note)})


def carry_out(root: Path, task: Task, tell: Tell) -> dict[str, Any]:
    """What comes of a task, as JSON. Raises ToolpaceError; files are named in it as the user knows them."""
    project = Project(root)
    try:
        return _carried_out(project, task, tell)
    except ToolpaceError as error:
        raise ToolpaceError(with_names_alone(str(error), project)) from None


def _carried_out(project: Project, task: Task, tell: Tell) -> dict[str, Any]:
    if isinstance(task, InspectTask):
        return inspect_part(project, project.part(task.part))
    if isinstance(task, SheetTask):
        return {"sheet": sheet_for(project, project.part(task.part))}
    if isinstance(task, CompareTask):
        return draw_comparison(project, task)
    done: dict[str, Any] = msgspec.to_builtins(do_app_job(project, project.job(task.job), ToldSteps(tell)))
    return done


def with_names_alone(text: str, project: Project) -> str:
    """A message in which files of the folder have their names alone."""
    return re.sub(rf"{re.escape(printable(str(project.root)))}[/\\\\](?:[^/\\\\\s:]+[/\\\\])*", "", text)


def inspect_part(project: Project, part: Part) -> dict[str, Any]:
    """What `toolpace inspect --json` says of a part, with the cures that can be applied. Raises ToolpaceError."""
    from toolpace.jobs.inspection import inspection_record

    found, _, setup = _inspected(project, part)
    record = inspection_record(found)
    # Where the reading ends though unread words are skipped, there is no tip, and skipping them is no cure.
    skips = found.tip is not None and not part.reading.skip_unknown
    record["cures"] = cures(found.refused, found.needs, skips)
    record["cut_lacks"] = cut_lacks(found, setup)
    told: dict[str, Any] = msgspec.to_builtins(record)
    return told


def _inspected(project: Project, part: Part) -> tuple[Inspection, tuple[Machine, ...], SetUp]:
    """A part inspected on each machine, these, and its set-up."""
    from toolpace.jobs.inspection import follow_as_planned
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.reading.inspection import inspect_source, unreadable

    try:
        prepared = Loader().prepare(project.batch_job(part, part.reading))
        source = Source.from_bytes(prepared.data, part.program)
    except ProgramError as error:
        return unreadable(part.program, ProgramError(with_names_alone(str(error), project))), (), SetUp()
    setup = prepared.options.setup
    own = [Machine.load(file) for name, file in project.machines().items() if name != file]
    machines = (*prepared.machines, *(each.mounted(**setup.part) if setup.part else each for each in own))
    # Subprograms lie beside the program, so it is read by its path; people know it by its name.
    source = dataclasses.replace(source, name=prepared.path)
    found = inspect_source(source, prepared.options, machines, part.reading.dialect or None, None, follow_as_planned)
    return dataclasses.replace(found, program=part.program), machines, setup


def cut_lacks(found: Inspection, setup: SetUp) -> list[str]:
    """What neither the program nor its sheet tells, and feeds by the cut need."""
    lacks = [] if setup.workpiece.stock or found.workpiece.stock else ["a stock"]
    tools = [name for name in found.tools or ("",) if setup.figures_of(name) is None and name not in found.shapes]
    return lacks + [f"the shape of tool {printable(name)}".rstrip() for name in tools]


def cures(refused: Sequence[Refusal], needs: Sequence[str], skips: bool) -> list[dict[str, Any]]:
    """Options that cure what is refused or needed, as messages name them: each with its value, null where it is the
    user's to choose, and with the lines at which it is named.

    skips: whether words that are not read can be skipped.
    """
    found: dict[tuple[str, str | None], list[int]] = {}
    for each in refused:
        for option, value in OPTION.findall(each.cure):
            if option in VALUES:
                concrete = value.rstrip(".:") if value and not value.isupper() and _is_value(option, value) else None
                found.setdefault((option, concrete), []).append(each.line)
        if each.certain:
            found.setdefault(("lenient", None), []).append(each.line)
    for need in needs:
        for option, value in OPTION.findall(need):
            found.setdefault((option, value or None), [])
    if refused and skips:
        found.setdefault(("skip-unknown", None), [])
    return [{"option": option, "value": value, "lines": lines} for (option, value), lines in found.items()]


def _is_value(option: str, word: str) -> bool:
    """Whether the word behind an option is its value, and not one of the sentence."""
    from toolpace.programs.reading.controllers.controller import Controller

    known = {"controller": Controller.names(), "dialect": ("gcode", "apt", "csv"), "compensation": ("program",)}
    return word.rstrip(".:") in known.get(option, (word,))


def sheet_for(project: Project, part: Part) -> str:
    """The text of a set-up sheet to fill in, with the mesh that lies beside the program as its stock."""
    from toolpace.jobs.inspection import sheet_to_fill_in

    found, machines, setup = _inspected(project, part)
    text = sheet_to_fill_in([found], machines, lambda machine: setup)
    meshes = [name for name in part.beside if name.lower().endswith((".stl", ".3mf", ".obj"))]
    if meshes and setup.workpiece.stock is None:
        text += f"\n[stock]\nmesh = {toml_value(meshes[0])}\n"
    return text


def do_app_job(project: Project, job: AppJob, steps: TimedSteps) -> AppJob:
    """A job of the app with what came of it: feeds by the cut, where they are wanted, the plan, and the program to
    load. Raises ToolpaceError where it comes to nothing."""
    part = project.part(job.part)
    program: Path | None = None
    notes: list[str] = []
    if job.request.feeds in CUT_FEEDS:
        program, notes = write_cut_feeds(project, part, job, steps)
    prepared = Loader().prepare(project.batch_job(part, job.reading, job.request, program))
    row = do_job(Place(str(project.plans), (project.plans / MARK).read_text(encoding="ascii")), prepared, steps)
    load = ""
    if program is not None:
        load = str(program.relative_to(project.root))
    elif row.folder:
        load, notes = write_planned_program(project, row, steps)
    error = with_names_alone(row.error, project)
    return msgspec.structs.replace(
        job, state="ended", row=row, error=error, program=load, notes=tuple(map(printable, notes))
    )


def write_cut_feeds(project: Project, part: Part, job: AppJob, steps: TimedSteps) -> tuple[Path, list[str]]:
    """The program with feeds by the cut, written into the folder of the job, and what was gained."""
    from toolpace.common.units import format_time
    from toolpace.jobs.cut import CutRequest
    from toolpace.jobs.feeds import new_feeds
    from toolpace.results.cut.feeds_page import feeds_page

    asked = project.batch_job(part, job.reading, job.request)
    prepared = Loader().prepare(asked)
    tip, axis = asked.tolerances()
    request = CutRequest(
        machine=prepared.machine, options=prepared.options,
        tip_tolerance=tip, axis_tolerance=axis,
        effort=asked.effort, feed=None, dialect=asked.dialect, resolution=None, memory=MEMORY,
    )  # fmt: skip
    rules = cut_rules(job.request)
    assert rules is not None
    found = new_feeds(prepared.path, request, rules, True, steps)
    folder = project.job_folder(job.id)
    for name in part.beside:  # subprograms are looked for beside the program
        shutil.copyfile(project.files(part.id) / name, folder / name)
    written = folder / part.program
    with whole_file(written) as temporary:
        temporary.write_bytes(found.written.data)
    cut = dataclasses.replace(found.cut, program=part.program)
    write_text(folder / FEEDS_PAGE, feeds_page(dataclasses.replace(found, cut=cut), prepared.machine.name))
    gained = f"{format_time(found.before.total)} before, {format_time(found.after.total)} after"
    return written, [f"{found.written.changed} blocks have another feed; on the control {gained}", *found.plan.notes]


def write_planned_program(project: Project, row: BatchRow, steps: TimedSteps) -> tuple[str, list[str]]:
    """The program with the feeds of its plan, from the root of the folder; empty, and the reason, where it cannot be
    written."""
    from toolpace.controls.export import PlannedMotion, target_of, write_export

    folder = project.plans / f"{row.folder}-program"
    try:
        with steps.step("exporting"):
            written = write_export(PlannedMotion.load(project.plans / row.folder), target_of("program", {}), folder)
    except ToolpaceError as error:
        return "", [f"no program to load: {with_names_alone(str(error), project)}"]
    return str((folder / written.files[0]).relative_to(project.root)), list(written.notes)


def draw_comparison(project: Project, task: CompareTask) -> dict[str, Any]:
    """The page of plans side by side. Raises ToolpaceError."""
    from toolpace.results.compare.page import comparison_page
    from toolpace.results.compare.plans import compared

    found = compared([project.plans / folder for folder in task.folders])
    page = comparison_page(dataclasses.replace(found, names=task.names))
    write_text(project.root / COMPARISONS / task.page, page)
    return {"page": task.page}
