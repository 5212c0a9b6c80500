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
import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec

from toolpace.app.records import CUT_FEEDS, AppJob, Part, Reading, Request, cut_rules
from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.files import reason, whole_file
from toolpace.jobs.batch import BatchJob
from toolpace.kernels.lock import FileLock, NoLocksError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller

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
Role = Literal["program", "sheet", "machine", "controller", "tool", "beside"]
Record = TypeVar("Record", bound=msgspec.Struct)


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
