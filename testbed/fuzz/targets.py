"""What is fuzzed: how an input of each dialect is read, by every way in, and which options it is read with."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec

from testbed.fuzz.oracle import Wrong, tried
from testbed.fuzz.words import words_of
from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_source
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.inspection import inspect_source
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import check_setup, setup_of_text, setup_sheet, setup_text
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

SEEDS = Path(__file__).parent / "seeds"
MACHINES = ("", "xyzac-trunnion", "xyzbc-nutating")
FEEDS = (None, None, "120%", "3000mm/min")
MOST_BLOCKS = 2000
"""An endless loop of the slowest blocks, tilted planes of 0.5 ms, then stays well below what an input may take."""


@dataclass(frozen=True)
class Asked:
    """The options that an input is read with."""

    machine: str = MACHINES[1]
    named: bool = True
    """Whether the dialect is named; else it is told by the content."""
    skip_unknown: bool = False
    compensation: str = ""
    block_delete: bool = True
    feed: str | None = None
    setup: bool = False
    most_blocks: int = MOST_BLOCKS

    @staticmethod
    def at_random(chance: random.Random) -> Asked:
        """Any of them; half the time words that are refused are skipped, so that reading gets further."""
        return Asked(
            machine=chance.choice(MACHINES),
            named=chance.random() < 0.9,
            skip_unknown=chance.random() < 0.5,
            compensation=chance.choice(["", "program"]),
            block_delete=chance.random() < 0.7,
            feed=chance.choice(FEEDS),
            setup=chance.random() < 0.3,
            most_blocks=chance.choice([1, 50, 300, MOST_BLOCKS]),
        )


Read = Callable[[bytes, Asked, int], None]
"""Reads an input by every way in and judges it; raises Wrong. The last is the bytes to weigh the memory by, or 0."""


@dataclass(frozen=True)
class Target:
    """One dialect."""

    name: str
    read: Read
    words: tuple[bytes, ...]

    def seeds(self) -> list[bytes]:
        """Small inputs to begin with; of a controller that has none of its own those of the one that it is like."""
        folder = SEEDS / self.name
        if not folder.is_dir():
            folder = SEEDS / (Controller.load(self.name).like or "iso")
        return [path.read_bytes() for path in sorted(folder.iterdir())]


@cache
def machine_of(name: str) -> Machine | None:
    """A built-in machine; "" is none."""
    return Machine.load(name) if name else None


@cache
def _sheet() -> str:
    return (SEEDS / "setup" / "whole.toml").read_text()


def program(dialect: str, controller: Controller | None) -> Read:
    """Reads an input as a program: to a tool path, and as `inspect` does."""

    def read(data: bytes, asked: Asked, weighed: int) -> None:
        machine = machine_of(asked.machine)
        options = ReadOptions(
            controller=controller if asked.named else None,
            setup=setup_of_text(_sheet()) if asked.setup else ReadOptions().setup,
            skip_unknown=asked.skip_unknown,
            block_delete=asked.block_delete,
            compensation=asked.compensation,
            most_blocks=asked.most_blocks,
        )
        named = dialect if asked.named else None

        def path() -> ToolPath:
            source = Source.from_bytes(data, "fuzz/program")
            return read_source(source, machine, named, options, feed=asked.feed)

        error = tried(path, weighed=weighed)

        def inspected() -> None:
            source = Source.from_bytes(data, "fuzz/program")
            found = inspect_source(source, options, [machine] if machine else [], named, asked.feed)
            if (error is None) != (not found.refused and not found.needs):
                raise Wrong("inspect tells another thing than reading", f"{error!r}: {found.refused!r}"[:600])
            setup_of_text(setup_sheet(source.name, found.used, machine, options.setup))
            for text in (*map(str, found.refused), *found.assumed, *found.not_on.values(), found.reason):
                if not text.isprintable() or len(text) > 2000:
                    raise Wrong("inspect tells what is no printable line", repr(text)[:300])

        if not isinstance(error, UsageError):
            again = tried(inspected)
            if again is not None and error is None:
                raise Wrong("inspect refuses what is read", str(again))

    return read


def set_up(data: bytes, asked: Asked, weighed: int) -> None:
    """Reads an input as a set-up sheet, writes and reads it again, and reads a program with it."""
    machine = machine_of(asked.machine)

    def read() -> ToolPath | None:
        given = setup_of_text(data.decode("utf-8", "replace"))
        again = setup_of_text(setup_text(given))
        if dataclasses.replace(again, source=given.source) != given:
            raise Wrong("a set-up sheet that reads as another when it is written", f"{given}\n{again}")
        if machine is not None:
            check_setup(dataclasses.replace(given, part={}), machine)
        options = ReadOptions(
            Controller.load("fanuc"), dataclasses.replace(given, part={}), most_blocks=asked.most_blocks
        )
        findings = Findings()
        try:
            source = Source.from_text((SEEDS / "fanuc" / "offsets.nc").read_text())
            return read_source(source, machine, None, options, findings=findings)
        finally:
            setup_of_text(setup_sheet("program", findings.used, machine, given))

    tried(read, weighed=weighed)


def controller(data: bytes, asked: Asked, weighed: int) -> None:
    """Reads an input as a controller's file, writes and reads it again, and reads a program of its language."""

    def read() -> ToolPath:
        given = Controller.from_toml(data.decode("utf-8", "replace"))
        again = Controller.from_toml(given.to_toml(), given.source)
        if again != msgspec.structs.replace(given, like=""):
            raise Wrong("a controller that reads as another when it is written", f"{given}\n{again}"[:1000])
        folder = {"word-address": "fanuc"}.get(given.language, given.language)
        (seed, *_) = sorted((SEEDS / folder).iterdir())
        options = ReadOptions(given, skip_unknown=asked.skip_unknown, most_blocks=asked.most_blocks)
        return read_source(Source.from_bytes(seed.read_bytes()), machine_of(asked.machine), None, options)

    tried(read, weighed=weighed)


def targets() -> dict[str, Target]:
    """All, by name; a program's is the name of its controller, or of its kind."""
    found = {}
    for name in Controller.names():
        found[name] = Target(name, program("gcode", Controller.load(name)), tuple(words_of(name, ())))
    found["cldata"] = Target("cldata", program("apt", None), tuple(words_of(None, ("cldata",))))
    found["csv"] = Target("csv", program("csv", None), tuple(words_of(None, ("table.py",))))
    found["setup"] = Target("setup", set_up, tuple(words_of(None, ("setup_file.py", "setup_tables"))))
    words = words_of("fanuc", ("controllers",)) + words_of("sinumerik", ()) + words_of("heidenhain", ())
    found["controller"] = Target("controller", controller, tuple(words))
    return found
