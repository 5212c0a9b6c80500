"""The folder of the app: parts with their files, and jobs. Each is whole on disk before anything is done with it.

    parts/ID/part.json      a program, and how it is read
    parts/ID/files/         the program, its set-up sheet, and what these name
    jobs/ID/job.json        what is to be made of a part, and what came of it
    machines/NAME.toml      machine files of the user
    plans/                  the folder of a batch: a folder of results for each job
    comparisons/            pages
"""

from __future__ import annotations

import re
import secrets
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import msgspec

from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.files import reason, whole_file
from toolpace.jobs.batch import BatchJob, BatchRow
from toolpace.kernels.lock import FileLock, NoLocksError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller

if TYPE_CHECKING:
    from toolpace.cutting.feeds.rules import FeedRules

PARTS, JOBS, MACHINES, PLANS, COMPARISONS = "parts", "jobs", "machines", "plans", "comparisons"
PART, JOB, FILES = "part.json", "job.json", "files"
MARK = ".toolpace-app"
"""A file by which the folder is known, locked by the server that has it."""
UPLOAD = ".upload-"
"""How the name of a file begins that is being received."""
ID = re.compile(r"[0-9a-f]{12}")
FEEDS_PAGE = ".feeds.html"
"""The page of new feeds in the folder of a job; no file of a part has such a name."""
SHEET = "setup.toml"
"""Name of a set-up sheet that is written in the page."""
LONGEST_NAME = 200
"""Bytes of the name of a file: file systems take 255, and temporary names are longer."""
FORBIDDEN = re.compile(r'[/\\:*?"<>|]')
"""Characters that lead to another folder, or that no name has on Windows."""
CUT_FEEDS = ("air", "learned", "limits")
"""Feeds that follow from the cut; others are those of the option --feed."""
State = Literal["waiting", "ended", "stopped"]
Role = Literal["program", "sheet", "machine", "controller", "tool", "beside"]
Record = TypeVar("Record", bound=msgspec.Struct)


class Reading(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a program is read: options of the commands, as text; empty: not given."""

    controller: str = ""
    dialect: str = ""
    skip_unknown: bool = False
    lenient: bool = False
    compensation: str = ""
    columns: str = ""
    units: str = ""
    max_blocks: int | None = None


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """A program with the files that belong to it, each by its name."""

    id: str
    added: str
    """Time (ISO 8601), by which parts are ordered."""
    program: str
    sheet: str = ""
    controller: str = ""
    """File of a controller."""
    tool: str = ""
    """File of a tool that bends."""
    beside: tuple[str, ...] = ()
    """Meshes, subprograms, tables."""
    reading: Reading = Reading()
    inspection: dict[str, Any] | None = None
    """None: it is to be inspected (again)."""


class Request(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is to be made of a part, as people write it."""

    machine: str
    tip_tolerance: str = ""
    axis_tolerance: str = ""
    """Empty: those that commands take without, 0.01 mm and 0.05 deg or less as the program asks."""
    feeds: str = "program"
    """program: as they are; air, learned, limits: by the cut; else as --feed has it: none, 120%, 3000mm/min."""
    air_feed: str = ""
    """In air, where feeds are by the cut; empty: what the slowest linear axis allows."""
    limits: str = ""
    """Of the cut, where feeds are by them, separated by commas: chip=0.08mm, 3:force=400N."""
    material: str = ""
    """What is cut, for limits of a force."""
    effort: str = "normal"
    tool_length: str = ""
    bend: bool = False
    """Whether the bending of the tool, by the part's file of it, is compensated."""


class AppJob(msgspec.Struct, frozen=True, kw_only=True):
    """A request, and what came of it."""

    id: str
    part: str
    number: int
    """From 1, in the order in which the jobs are done."""
    added: str
    request: Request
    reading: Reading
    state: State = "waiting"
    row: BatchRow | None = None
    """Of the batch's table, once it has ended; None where it came to nothing."""
    error: str = ""
    """One line."""
    program: str = ""
    """The program to load, from the root of the folder; empty where there is none."""
    notes: tuple[str, ...] = ()
    """What is to be said of that program."""


def new_id() -> str:
    """A name that no other part or job has."""
    return secrets.token_hex(6)


def now() -> str:
    """The time, to the microsecond."""
    return datetime.now(UTC).isoformat()


def checked_name(name: str) -> str:
    """The name of a file, found to be one in the folder that it is put into. Raises UsageError."""
    shown = printable(name[:60])
    if not name or name in (".", "..") or name.startswith((".", " ")) or name.endswith((".", " ")):
        raise UsageError(f"'{shown}': no name of a file that is kept here; rename it")
    if FORBIDDEN.search(name) or not name.isprintable():
        raise UsageError(f"'{shown}': a name has no folders and no control characters; rename the file")
    try:
        size = len(name.encode())
    except UnicodeEncodeError:
        raise UsageError(f"'{shown}': this name has letters that no file can keep; rename the file") from None
    if size > LONGEST_NAME:
        raise UsageError(f"'{shown}...': the name has {size} bytes, and {LONGEST_NAME} at most are kept; rename it")
    return name


def role_of(name: str, data: bytes, of_part: bool) -> Role:
    """What a file is for, from its name and its content: a table of TOML by its headings, all else a program, or with
    a part (`of_part`) what lies beside one."""
    if name.lower().endswith(".toml"):
        try:
            tables = tomllib.loads(data.decode("utf-8-sig"))
        except ValueError:  # the reader of sheets says where it is wrong
            return "sheet"
        if "joints" in tables:
            return "machine"
        if {"bending", "cutting"} & set(tables):
            return "tool"
        return "controller" if {"like", "language"} & set(tables) else "sheet"
    return "beside" if of_part or name.lower().endswith((".stl", ".3mf", ".obj")) else "program"


class Project:
    """The parts and jobs of a folder, as they are on disk. One process writes it."""

    def __init__(self, root: Path) -> None:
        """The folder; nothing is read before it is loaded."""
        self.root = root
        self.parts: dict[str, Part] = {}
        self.jobs: dict[str, AppJob] = {}

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep other servers out of the folder, and load it. Raises UsageError where one is there, or the folder holds
        anything else."""
        with FileLock(self.root / MARK) as lock:
            self._take(lock)
            self.load()
            yield

    def _take(self, lock: FileLock) -> None:
        try:
            if self.root.is_dir() and any(self.root.iterdir()) and not (self.root / MARK).is_file():
                raise UsageError(f"{self.root}: is not empty, and no folder of the app; give another --folder")
            if lock.take():
                return
        except NoLocksError:  # nobody can be kept out there
            return
        except (OSError, ValueError) as error:
            raise UsageError(f"{self.root}: {reason(error)}; give another --folder") from None
        raise UsageError(f"{self.root}: the app runs there already; go on in its page, or give another --folder")

    def load(self) -> None:
        """Make what is missing, remove what a killed server left half done, and read the rest. Raises UsageError."""
        try:
            for name in (PARTS, JOBS, MACHINES, PLANS, COMPARISONS):
                (self.root / name).mkdir(parents=True, exist_ok=True)
            for left in self.root.glob(f"{UPLOAD}*"):
                left.unlink(missing_ok=True)
            for left in (self.root / PARTS).iterdir():
                if ID.fullmatch(left.name) and not left.is_symlink() and not (left / PART).exists():
                    shutil.rmtree(left, ignore_errors=True)
            parts, jobs = _records(self.root / PARTS, PART, Part), _records(self.root / JOBS, JOB, AppJob)
        except OSError as error:
            raise UsageError(f"{self.root}: {reason(error)}; give another --folder") from None
        self.parts = {each.id: each for each in parts}
        self.jobs = {each.id: each for each in sorted(jobs, key=lambda job: job.number) if each.part in self.parts}

    def files(self, part: str) -> Path:
        """The folder of the files of a part."""
        return self.root / PARTS / part / FILES

    def job_folder(self, job: str) -> Path:
        """The folder of a job."""
        return self.root / JOBS / job

    @property
    def plans(self) -> Path:
        """The folder of the batch."""
        return self.root / PLANS

    def part(self, part: str) -> Part:
        """A part as it is on disk now. Raises UsageError."""
        return _read(self.root / PARTS / part / PART, Part)

    def job(self, job: str) -> AppJob:
        """A job as it is on disk now. Raises UsageError."""
        return _read(self.job_folder(job) / JOB, AppJob)

    def save_part(self, part: Part) -> None:
        """Write it, whole or not at all."""
        _write(self.root / PARTS / part.id / PART, part)
        self.parts[part.id] = part

    def save_job(self, job: AppJob) -> None:
        """Write it, whole or not at all."""
        _write(self.job_folder(job.id) / JOB, job)
        self.jobs[job.id] = job

    def add_file(self, part: str, name: str, content: Path) -> None:
        """Move a file to those of a part, in place of one of that name. Raises OSError."""
        self.files(part).mkdir(parents=True, exist_ok=True)
        content.replace(self.files(part) / name)

    def remove_part(self, part: str) -> None:
        """Remove a part with all of its jobs."""
        for job in [each.id for each in self.jobs.values() if each.part == part]:
            self.remove_job(job)
        del self.parts[part]
        # Without it the rest is no part: a removal that is interrupted leaves nothing half there.
        (self.root / PARTS / part / PART).unlink(missing_ok=True)
        shutil.rmtree(self.root / PARTS / part, ignore_errors=True)

    def remove_job(self, job: str) -> None:
        """Remove a job, and the folders of its results that no other job has."""
        removed = self.jobs.pop(job)
        (self.job_folder(job) / JOB).unlink(missing_ok=True)
        shutil.rmtree(self.job_folder(job), ignore_errors=True)
        folder = removed.row.folder if removed.row is not None else ""
        if folder and all(each.row is None or each.row.folder != folder for each in self.jobs.values()):
            for name in (folder, f"{folder}-program"):
                shutil.rmtree(self.plans / name, ignore_errors=True)

    def machines(self) -> dict[str, str]:
        """The name of each machine, and what `Machine.load` takes for it: built-in ones, and the user's files."""
        own = sorted(path for path in (self.root / MACHINES).glob("*.toml") if not path.is_symlink())
        return {name: name for name in Machine.names()} | {path.stem: str(path) for path in own}

    def batch_job(
        self, part: Part, reading: Reading, request: Request | None = None, program: Path | None = None
    ) -> BatchJob:
        """The job of a batch that a request comes to, to inspect the part where there is none; `program` stands in for
        the part's. Raises UsageError."""
        files = self.files(part.id)
        if reading.controller and reading.controller not in Controller.names():
            cure = did_you_mean(reading.controller, Controller.names())
            raise UsageError(f"control '{printable(reading.controller[:40])}' is not known; {cure}")
        return BatchJob(
            program=program or files / part.program,
            dialect=reading.dialect or None,
            controller=str(files / part.controller) if part.controller else reading.controller or None,
            setup=str(files / part.sheet) if part.sheet else None,
            skip_unknown=reading.skip_unknown,
            lenient=reading.lenient,
            compensation=reading.compensation,
            max_blocks=reading.max_blocks,
            columns=reading.columns,
            units=reading.units,
            **({"what": "inspect"} if request is None else self._planned(request) | self._bent(part, request)),
        )

    def _bent(self, part: Part, request: Request) -> dict[str, Any]:
        if request.bend and not part.tool:
            raise UsageError("no file of a tool that bends is there; drop one (.toml with [tool] and [bending])")
        return {"bend": str(self.files(part.id) / part.tool) if request.bend else None}

    def _planned(self, request: Request) -> dict[str, Any]:
        """What of a job of a batch a request tells, in SI."""
        from toolpace.common import units

        machines = self.machines()
        if request.machine not in machines:
            raise UsageError(f"machine '{printable(request.machine[:40])}' is not there; choose one of the list")
        cut_rules(request)
        return {
            "machine": machines[request.machine],
            "tip_tolerance": units.parse_length(request.tip_tolerance) if request.tip_tolerance else None,
            "axis_tolerance": units.parse_angle(request.axis_tolerance) if request.axis_tolerance else None,
            "feed": None if request.feeds in ("program", *CUT_FEEDS) else request.feeds,
            "effort": request.effort,
            "tool_length": units.parse_length(request.tool_length) if request.tool_length else None,
        }


def cut_rules(request: Request) -> FeedRules | None:
    """The rules of feeds by the cut; None where it sets none. Raises UsageError."""
    if request.feeds not in CUT_FEEDS:
        return None
    from toolpace.common.units import parse_feed
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.cutting.feeds.schedule import PROGRAM_STEPS
    from toolpace.cutting.forces.material import Material
    from toolpace.jobs.cut_options import cut_limits

    if request.material and request.material not in Material.names():  # no file is named in a request
        cure = did_you_mean(request.material, Material.names())
        raise UsageError(f"material '{printable(request.material[:40])}' is not known; {cure}")
    limits = {} if request.feeds != "limits" else cut_limits(limit_words(request))
    if request.feeds == "limits" and not limits:
        raise UsageError("no limit of the cut is given; add one, such as chip=0.08mm")
    rules = FeedRules(
        way=request.feeds,
        air_feed=parse_feed(request.air_feed) if request.air_feed else None,
        steps=PROGRAM_STEPS,
        limits=limits,
        materials={"": Material.load(request.material).coefficients} if request.material else {},
    )
    for tool in limits:
        rules.limits_of(tool)
    return rules


def limit_words(request: Request) -> list[str]:
    """Its limits of the cut, each as the option --limit has it."""
    return [word.strip() for word in request.limits.split(",") if word.strip()]


def command_of(part: Part, job: AppJob) -> str:
    """The command that does the same in the folder of the part's files."""
    request, reading = job.request, job.reading
    words = ["toolpace", "plan", part.program, "-m", request.machine]
    words += ["--tip-tolerance", request.tip_tolerance] if request.tip_tolerance else []
    words += ["--axis-tolerance", request.axis_tolerance] if request.axis_tolerance else []
    words += ["--effort", request.effort] if request.effort != "normal" else []
    words += ["--tool-length", request.tool_length] if request.tool_length else []
    bend = ["--bend", part.tool] if request.bend else []
    how = ["--setup", part.sheet] if part.sheet else []
    how += ["--controller", part.controller or reading.controller] if part.controller or reading.controller else []
    for name in ("dialect", "compensation", "columns", "units"):
        how += [f"--{name}", getattr(reading, name)] if getattr(reading, name) else []
    how += [f"--{name.replace('_', '-')}" for name in ("skip_unknown", "lenient") if getattr(reading, name)]
    how += ["--max-blocks", str(reading.max_blocks)] if reading.max_blocks else []
    if request.feeds in CUT_FEEDS:
        new = f"new-{part.program}"
        feeds = ["toolpace", "feeds", part.program, *words[3:], "--feeds", request.feeds, "-o", new, *how]
        feeds += ["--air-feed", request.air_feed] if request.air_feed else []
        feeds += [word for limit in limit_words(request) for word in ("--limit", limit)]
        feeds += ["--material", request.material] if request.material else []
        return f"{shlex.join(feeds)} && {shlex.join(['toolpace', 'plan', new, *words[3:], *bend, *how])}"
    return shlex.join([*words, *(["--feed", request.feeds] if request.feeds != "program" else []), *bend, *how])


def _records(folder: Path, name: str, kind: type[Record]) -> list[Record]:
    """The records in the folders of a folder, in the order of their names; what is none is left alone."""
    return list(_each(folder, name, kind))


def _each(folder: Path, name: str, kind: type[Record]) -> Iterator[Record]:
    for each in sorted(folder.iterdir()):
        if not each.is_symlink() and (each / name).is_file():
            try:
                yield _read(each / name, kind)
            except UsageError:
                continue


def _read(path: Path, kind: type[Record]) -> Record:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot be read: {reason(error)}") from None


def _write(path: Path, record: msgspec.Struct) -> None:
    with whole_file(path) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=1) + b"\n")
