"""Jobs from a TOML file, and programs from a file, a folder or a pattern.

[all]
machine = ["xyzac-trunnion", "my-mill.toml"]

[[jobs]]
programs = ["parts/*.ngc"]
tip_tolerance = ["5um", "10um"]
"""

from __future__ import annotations

import functools
import glob
import itertools
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from toolpace.common import units
from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import is_folder
from toolpace.common.files.toml import TableFile, Tables
from toolpace.jobs.batch.job import BatchJob
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.languages import SUFFIXES

FILE = TableFile("file of jobs", longest=10_000_000)
MOST = 1_000_000
"""Jobs of one file: more is a slip in a list."""
LISTS = (
    "machine", "planner", "effort", "tip_tolerance", "axis_tolerance", "feed", "controller", "setup", "tool_length",
)  # fmt: skip
"""Keys that may be lists: there is a job for each combination."""
UNITS: dict[str, Callable[[str], float]] = {
    "tip_tolerance": units.parse_length,
    "axis_tolerance": units.parse_angle,
    "tool_length": units.parse_length,
    "prove_within": units.parse_time,
    "dt": units.parse_time,
}
"""Keys that are quantities, written with their units."""
WORDS = (
    "what", "planner", "effort", "feed", "bend", "dialect", "controller", "setup", "compensation", "model", "to",
    "machine", "columns", "units", "npz",
)  # fmt: skip
SWITCHES = ("csv", "report", "skip_unknown", "lenient", "optimum")
KEYS = ("programs", *dict.fromkeys((*WORDS, *UNITS, *SWITCHES)), "max_blocks", "export")


@functools.cache
def suffixes() -> frozenset[str]:
    """With which names of programs end, in lower case."""
    built_in = (Controller.load(name).suffixes for name in Controller.names())
    return frozenset(SUFFIXES).union(*built_in)


def programs_in(named: str) -> list[str]:
    """The programs that a name stands for, in the order of their names; none where nothing fits.

    A file is itself, whatever it is called, and so is what is not there: whoever reads it says so. Of a folder it is
    the files whose names end like those of programs, of a pattern (*.ngc) those that fit.
    """
    path = Path(named)
    if is_folder(path):
        return sorted(str(each) for each in path.iterdir() if each.is_file() and _is_program(each))
    if os.path.lexists(path) or not glob.has_magic(named):
        return [named]
    # Not Path's: its ** stands for folders alone, and its * for hidden files too.
    return sorted(each for each in glob.glob(named, recursive=True) if Path(each).is_file())  # noqa: PTH207


def _is_program(path: Path) -> bool:
    return path.suffix.lower() in suffixes() and not path.name.startswith(".")


def jobs_of_file(path: str | Path) -> list[BatchJob]:
    """The jobs in a file, in its order. Raises UsageError naming file, table, key and cure."""
    source = str(path)
    return _File(source, FILE.table(FILE.text(path), source), Path(path).parent).read()


class _File(Tables):
    """One reading of one file."""

    longest = 1000

    def __init__(self, source: str, raw: Mapping[str, Any], folder: Path) -> None:
        super().__init__(source, raw)
        self.folder = folder

    def read(self) -> list[BatchJob]:
        self.known("the file", self.raw, ("all", "jobs"))
        common = self.table("all")
        self.check("[all]", common)
        tables = self.raw.get("jobs", [{}] if common else [])
        if not isinstance(tables, list) or not tables or not all(isinstance(each, dict) for each in tables):
            self.fail("jobs", "are missing; write each table of jobs under the heading [[jobs]]")
        found: list[BatchJob] = []
        for number, each in enumerate(tables, start=1):
            place = f"[[jobs]] number {number}"
            self.check(place, each)
            found += self.jobs(place, {**common, **each})
            if len(found) > MOST:
                self.fail(place, f"makes more than {MOST} jobs; split the file")
        return found

    def check(self, place: str, table: Mapping[str, Any]) -> None:
        self.known(place, table, KEYS)
        for key, value in table.items():
            if isinstance(value, list) and key not in (*LISTS, "programs"):
                self.fail(place, f"{key} is a list; one value, or a table of jobs for each")
            if isinstance(value, list) and not value:
                self.fail(place, f"{key} = [] leaves nothing to do; name at least one")

    def jobs(self, place: str, table: dict[str, Any]) -> list[BatchJob]:
        programs = table.pop("programs", None)
        if programs is None:
            self.fail(place, "has no programs; write programs = [\"part.ngc\", \"parts/*.ngc\"]")  # fmt: skip
        named = programs if isinstance(programs, list) else [programs]
        if not all(isinstance(each, str) for each in named):
            self.fail(place, f"programs = {programs!r:.60}: write names of files, folders or patterns in quotes")
        files: list[str] = []
        for each in named:
            found = programs_in(str(self.folder / each))
            if not found:
                self.fail(place, f"programs = '{each[:60]}': nothing there fits; check the pattern")
            files += found
        lists = {key: value if isinstance(value, list) else [value] for key, value in table.items()}
        found_jobs = []
        for program in files:
            for values in itertools.product(*lists.values()):
                words = {key: self.value(place, key, value) for key, value in zip(lists, values)}
                try:
                    found_jobs.append(BatchJob(program=program, **words))
                except ToolpaceError as error:
                    self.fail(place, f"is wrong: {error}")
        return found_jobs

    def value(self, place: str, key: str, value: Any) -> Any:
        """A value as a job has it: quantities in SI, files found."""
        if key in UNITS:
            if not isinstance(value, str):
                self.fail(place, f"{key} = {value!r:.40}: write it with its unit, in quotes, like '0.01mm' or '5s'")
            try:
                return UNITS[key](value)
            except UsageError as error:
                self.fail(place, f"{key}: {error}")
        if key in SWITCHES:
            if not isinstance(value, bool):
                self.fail(place, f"{key} = {value!r:.40}: write true or false")
            return value
        if key == "npz" and isinstance(value, bool):
            return value
        if key == "max_blocks":
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                self.fail(place, f"{key} = {value!r:.40}: write a whole number, 1 or more")
            return value
        if key == "export":
            if not isinstance(value, dict):
                self.fail(place, "export is not a table; write it like export = { period = 0.004 }")
            return {name: tuple(each) if isinstance(each, list) else each for name, each in value.items()}
        if not isinstance(value, str):
            self.fail(place, f"{key} = {value!r:.40}: write a word in quotes")
        if key in ("bend", "setup") or (key in ("machine", "controller") and value.endswith(".toml")):
            return str(self.folder / value)
        return value
