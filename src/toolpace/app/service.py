"""What the page can ask for: parts, their reading and inspection, jobs, comparisons, and the state of all of it."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from toolpace.app.project import (
    COMPARISONS,
    FEEDS_PAGE,
    MACHINES,
    PLANS,
    SHEET,
    Project,
    checked_name,
    new_id,
    now,
    role_of,
)
from toolpace.app.records import CUT_FEEDS, AppJob, Part, Reading, Request, command_of
from toolpace.app.work import CompareTask, InspectTask, JobTask, SheetTask
from toolpace.app.worker import Line, Worker
from toolpace.common import __version__
from toolpace.common.errors import ToolpaceError, UsageError, printable
from toolpace.common.files import write_text
from toolpace.cutting.forces.material import Material
from toolpace.jobs.batch.folder import RESULTS
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.results.compare.plans import FEWEST, MOST
from toolpace.results.report.words import at_most, limit_words, percent

LONGEST_TEXT = 1_000_000
"""Bytes of a set-up sheet, as its reader takes."""
MOST_PARTS, MOST_WAITING = 1000, 1000
"""More of them are a slip, or come from elsewhere."""
LIMITS_SHOWN = 2
USUAL = "usual tolerance"


class NotFoundError(UsageError):
    """A part, a job or a file that is not there."""


class Service:
    """A project and the two lines of tasks that work on it: one for jobs, one for what the page waits for."""

    def __init__(self, project: Project, jobs: Worker, aside: Worker) -> None:
        """Go on with what has not ended."""
        self.project = project
        self._lock = threading.RLock()
        self._jobs, self._aside = Line(jobs), Line(aside)
        self._failed: dict[str, str] = {}
        """What went wrong aside, by the key of the task."""
        for part in project.parts.values():
            if part.inspection is None:
                self._inspect(part.id)
        for job in project.jobs.values():
            if job.state == "waiting":
                self._begin(job.id)

    def stop(self) -> None:
        """End both lines; what has not ended goes on with the next start."""
        self._jobs.stop()
        self._aside.stop()

    # parts

    def add_file(self, name: str, content: Path, part: str = "") -> str:
        """Take a file that was uploaded: a program makes a part, others go to one; the id of the part, or empty for a
        machine. Raises UsageError, NotFoundError, OSError."""
        name = checked_name(name)
        with content.open("rb") as file:
            role = role_of(name, file.read(LONGEST_TEXT) if name.lower().endswith(".toml") else b"", bool(part))
        with self._lock:
            if role == "machine":
                self._add_machine(name, content)
                return ""
            if role != "program" and not part:
                raise UsageError(f"{name}: belongs to a program; drop the program first, and this onto it")
            if role == "program":
                return self._new_part(name, content)
            found = self._part(part)
            self.project.add_file(part, name, content)
            if role == "sheet":
                found = msgspec.structs.replace(found, sheet=name)
            elif role == "controller":
                found = msgspec.structs.replace(found, controller=name)
            elif role == "tool":
                found = msgspec.structs.replace(found, tool=name)
            elif name != found.program:
                found = msgspec.structs.replace(found, beside=tuple(dict.fromkeys([*found.beside, name])))
            self._changed(found)
            return part

    def _add_machine(self, name: str, content: Path) -> None:
        """Take a machine file under the name that stands in it; all parts are inspected on it too."""
        try:
            machine = Machine.load(content).name
        except ToolpaceError as error:
            raise UsageError(str(error).replace(printable(str(content)), name)) from None
        if machine in Machine.names():
            raise UsageError(f"{name}: '{machine}' is the name of a built-in machine; write another into the file")
        content.replace(self.project.root / MACHINES / f"{checked_name(machine)}.toml")
        for each in list(self.project.parts.values()):
            self._changed(each)

    def _new_part(self, name: str, content: Path) -> str:
        if len(self.project.parts) >= MOST_PARTS:
            raise UsageError(f"there are {MOST_PARTS} programs already; remove some, or take another folder")
        part = Part(id=new_id(), added=now(), program=name)
        self.project.add_file(part.id, name, content)
        self._changed(part)
        return part.id

    def set_reading(self, part: str, reading: Reading) -> None:
        """Read a part otherwise from now on. Raises UsageError."""
        with self._lock:
            found = self._part(part)
            self.project.batch_job(found, reading)  # which refuses what is not known
            self._changed(msgspec.structs.replace(found, reading=reading))

    def set_sheet(self, part: str, text: str) -> None:
        """Put a text in place of the set-up sheet of a part; an empty one takes the sheet away. Raises UsageError."""
        if len(text.encode("utf-8", "replace")) > LONGEST_TEXT:
            raise UsageError(f"the set-up sheet has more than {LONGEST_TEXT} bytes; nobody fills in so much")
        with self._lock:
            found = self._part(part)
            name = (found.sheet or SHEET) if text.strip() else ""
            if name:
                write_text(self.project.files(part) / name, text)
            self._changed(msgspec.structs.replace(found, sheet=name))

    def sheet(self, part: str) -> str:
        """The set-up sheet of a part; empty where it has none."""
        found = self._part(part)
        if not found.sheet:
            return ""
        return self._own_file(self.project.files(part) / found.sheet).read_text(encoding="utf-8-sig", errors="replace")

    def fill_in_sheet(self, part: str) -> None:
        """Have a set-up sheet written, as `inspect --write-setup` does, in place of that of a part."""
        self._part(part)
        key = f"sheet {part}"
        self._failed.pop(key, None)

        def ended(done: dict[str, Any] | None, error: str) -> None:
            if done is None:
                self._failed[key] = error
            elif part in self.project.parts:
                self.set_sheet(part, done["sheet"])

        self._aside.submit(key, SheetTask(part), ended)

    def remove_part(self, part: str) -> None:
        """Remove a part with its jobs and their results. Raises NotFoundError."""
        with self._lock:
            self._part(part)
            for job in [each.id for each in self.project.jobs.values() if each.part == part]:
                self._jobs.cancel(job)
            self._aside.cancel(f"inspect {part}")
            self.project.remove_part(part)

    def _changed(self, part: Part) -> None:
        """Keep a part that has another file or is read otherwise, and inspect it."""
        self.project.save_part(msgspec.structs.replace(part, inspection=None))
        self._inspect(part.id)

    def _inspect(self, part: str) -> None:
        key = f"inspect {part}"
        asked = self.project.parts[part]

        def ended(done: dict[str, Any] | None, error: str) -> None:
            with self._lock:
                now_there = self.project.parts.get(part)
                if now_there != asked or (done is None and not error):  # changed meanwhile: it is inspected again
                    return
                record = done if done is not None else {"error": error}
                self.project.save_part(msgspec.structs.replace(asked, inspection=record))

        self._aside.cancel(key)
        self._aside.submit(key, InspectTask(part), ended)

    # jobs

    def add_job(self, part: str, request: Request) -> str:
        """Put a job at the end of the queue; its id. Raises UsageError where it can come to nothing."""
        with self._lock:
            found = self._part(part)
            self.project.batch_job(found, found.reading, request)
            if len(self._jobs.entries()) >= MOST_WAITING:
                raise UsageError(f"{MOST_WAITING} jobs wait already; let some of them end")
            number = max((job.number for job in self.project.jobs.values()), default=0) + 1
            job = AppJob(
                id=new_id(), part=part, number=number, added=now(), request=request, reading=found.reading
            )
            self.project.save_job(job)
            self._begin(job.id)
            return job.id

    def again(self, job: str) -> None:
        """Do a job that was stopped, or came to nothing, again, as the part is now. Raises UsageError."""
        with self._lock:
            found = self._job(job)
            if found.state == "waiting":
                return
            reading = self._part(found.part).reading
            kept = msgspec.structs.replace(found, state="waiting", reading=reading, row=None, error="", program="")
            self.project.save_job(kept)
            self._begin(job)

    def stop_job(self, job: str) -> None:
        """End a job that waits or is under way; it stays, as stopped. Raises NotFoundError."""
        self._job(job)
        self._jobs.cancel(job)

    def remove_job(self, job: str) -> None:
        """Remove a job with its results. Raises NotFoundError, UsageError."""
        with self._lock:
            if self._job(job).state == "waiting":
                raise UsageError("the job has not ended; stop it first")
            self.project.remove_job(job)

    def _begin(self, job: str) -> None:
        def ended(done: dict[str, Any] | None, error: str) -> None:
            with self._lock:
                found = self.project.jobs.get(job)
                if found is None:
                    return
                if done is not None:
                    kept = msgspec.convert(done, AppJob)
                else:
                    kept = msgspec.structs.replace(found, state="ended" if error else "stopped", error=error)
                self.project.save_job(kept)

        self._jobs.submit(job, JobTask(job), ended)

    # what comes of jobs

    def report(self, job: str) -> Path:
        """The report of a job. Raises NotFoundError."""
        row = self._job(job).row
        if row is None or not row.folder:
            raise NotFoundError("this job has no report")
        return self._own_file(self.project.root / PLANS / row.folder / RESULTS["plan"])

    def feeds_page(self, job: str) -> Path:
        """The page of what feeds by the cut are and gain. Raises NotFoundError."""
        self._job(job)
        return self._own_file(self.project.job_folder(job) / FEEDS_PAGE)

    def program(self, job: str) -> tuple[Path, str]:
        """The program of a job that a control loads, and a name for it. Raises NotFoundError."""
        found = self._job(job)
        if not found.program:
            raise NotFoundError("this job has no program to load")
        name = Path(self._part(found.part).program)
        return self._own_file(self.project.root / found.program), f"{name.stem}-{found.number}{name.suffix}"

    def compare(self, jobs: Sequence[str]) -> str:
        """Have a page of two to eight plans drawn; its name, under which it will be there. Raises UsageError."""
        found = [self._job(each) for each in dict.fromkeys(jobs)]
        plans = {each.row.folder: each for each in found if each.row is not None and each.row.folder}
        if len(plans) != len(found) or not FEWEST <= len(found) <= MOST:
            raise UsageError(f"choose {FEWEST} to {MOST} jobs that have a plan, each for something else")
        name = "-".join(each.id for each in found)
        names = tuple(
            f"job {each.number}: {each.request.tip_tolerance or USUAL}, feeds {each.request.feeds}"
            for each in plans.values()
        )
        key = f"compare {name}"
        self._failed.pop(key, None)

        def ended(done: dict[str, Any] | None, error: str) -> None:
            if done is None:
                self._failed[key] = error

        (self.project.root / COMPARISONS / f"{name}.html").unlink(missing_ok=True)
        self._aside.submit(key, CompareTask(tuple(plans), names, f"{name}.html"), ended)
        return name

    def comparison(self, name: str) -> Path | None:
        """The page of a comparison; None where it is not drawn yet. Raises NotFoundError, UsageError."""
        jobs = name.split("-")
        for job in jobs:
            self._job(job)
        if error := self._failed.get(f"compare {name}"):
            raise UsageError(error)
        page = self.project.root / COMPARISONS / f"{name}.html"
        return self._own_file(page) if page.exists() else None

    # state

    def state(self) -> dict[str, Any]:
        """All that the page shows, as JSON."""
        with self._lock:
            running = {each.key: each for each in self._jobs.entries()}
            aside = {each.key for each in self._aside.entries()}
            order = list(running)
            parts = [self._part_record(each, aside) for each in sorted(self.project.parts.values(), key=_added)]
            jobs = []
            for job in self.project.jobs.values():
                entry = running.get(job.id)
                under_way = entry is not None and bool(entry.began)
                jobs.append({
                    "id": job.id, "part": job.part, "number": job.number, "added": job.added,
                    "request": msgspec.to_builtins(job.request),
                    "state": "running" if under_way else job.state,
                    "before": order.index(job.id) if entry is not None else 0,
                    "began": entry.began if entry is not None else 0.0,
                    "steps": list(entry.steps) if entry is not None else [],
                    "error": job.error, "notes": list(job.notes), "program": bool(job.program),
                    "feeds_page": bool(job.program) and job.request.feeds in CUT_FEEDS,
                    "command": command_of(self.project.parts[job.part], job) if job.part in self.project.parts else "",
                    **_row_record(job),
                })  # fmt: skip
            return {
                "version": __version__, "folder": shown_folder(self.project.root),
                "machines": list(self.project.machines()), "controllers": Controller.names(),
                "materials": Material.names(),
                "parts": parts, "jobs": jobs,
            }  # fmt: skip

    def _part_record(self, part: Part, aside: set[str]) -> dict[str, Any]:
        record: dict[str, Any] = msgspec.to_builtins(part)
        record["inspecting"] = part.inspection is None
        record["sheet_error"] = self._failed.get(f"sheet {part.id}", "")
        record["writing_sheet"] = f"sheet {part.id}" in aside
        return record

    def _part(self, part: str) -> Part:
        if part not in self.project.parts:
            raise NotFoundError("there is no such program here any more")
        return self.project.parts[part]

    def _job(self, job: str) -> AppJob:
        if job not in self.project.jobs:
            raise NotFoundError("there is no such job here any more")
        return self.project.jobs[job]

    def _own_file(self, path: Path) -> Path:
        """A file of the folder, which no link leads out of. Raises NotFoundError."""
        root = self.project.root.resolve()
        try:
            real = path.resolve(strict=True)
        except (OSError, RuntimeError, ValueError):
            raise NotFoundError("this file is not there any more") from None
        if real != root / path.relative_to(self.project.root) or not real.is_file():
            raise NotFoundError("this file is not one that toolpace wrote here")
        return real


def shown_folder(folder: Path) -> str:
    """A folder as people write it."""
    with contextlib.suppress(ValueError, RuntimeError):
        return printable(f"~/{folder.relative_to(Path.home())}")
    return printable(str(folder))


def _added(part: Part) -> str:
    return part.added


def _row_record(job: AppJob) -> dict[str, Any]:
    """What of a row the page shows."""
    row = job.row
    if row is None:
        return {"verdict": "", "duration_s": None, "air_s": None, "gap": "", "limits": "", "report": False, "wider": ""}
    binding = [(name, share) for name, share in row.limited_by.items() if name not in ("nothing", "dwell")]
    limits = sorted(binding, key=lambda item: -item[1])[:LIMITS_SHOWN]
    return {
        "verdict": row.verdict,
        "duration_s": row.duration_s,
        "air_s": row.air_s,
        "gap": "" if row.gap is None else at_most(row.gap),
        "limits": ", ".join(f"{limit_words(name)} {percent(share)}" for name, share in limits if share >= 0.01),
        "report": bool(row.folder),
        # twice the tolerance, for those who ask what it would bring
        "wider": f"{2e3 * row.tip_tolerance_mm:.6g}um" if row.tip_tolerance_mm else "",
    }
