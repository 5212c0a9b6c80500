"""A job with all its inputs read, and the key that identifies them."""

from __future__ import annotations

import hashlib
import json
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path

from toolpace.common import __version__
from toolpace.jobs.batch.job import BatchJob
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import load_setup, setup_text
from toolpace.programs.reading.source import Source

DIGITS = 10
"""Of the key, in the name of a folder."""
LONGEST_STEM = 60
"""Characters of a program's name in that of a folder."""


@dataclass(frozen=True)
class Prepared:
    """A job, checked and read."""

    job: BatchJob
    path: str
    """Of the program, from the root: subprograms lie beside it."""
    data: bytes
    """The program."""
    machines: tuple[Machine, ...]
    """The machine, with tool and part as the job has them; several of `inspect` without one."""
    options: ReadOptions
    tool: CuttingTool | None
    key: str
    """Hash of program, machine, options and version."""

    @property
    def machine(self) -> Machine:
        """The one that the job names."""
        return self.machines[0]

    @property
    def folder(self) -> str:
        """Name of the folder of its results: what a person reads, and what tells it from all others."""
        stem = re.sub(r"[^\w.+-]", "_", Path(self.path).stem)[:LONGEST_STEM].lstrip(".") or "program"
        return f"{stem}-{self.key[:DIGITS]}"

    @property
    def source(self) -> Source:
        """The program as text. Raises ProgramError."""
        return Source.from_bytes(self.data, self.path)

    @property
    def lines(self) -> int:
        """As many as blocks, or more."""
        return self.data.count(b"\n") + 1


class Loader:
    """Reads what jobs depend on, each file once."""

    def __init__(self) -> None:
        self._machines: dict[tuple[str, float | None], Machine] = {}
        self._controllers: dict[str, Controller] = {}
        self._setups: dict[str, SetUp] = {}
        self._tools: dict[str, CuttingTool] = {}
        self._texts: dict[int, tuple[Machine, str]] = {}

    def prepare(self, job: BatchJob) -> Prepared:
        """Read what a job depends on. Raises ToolpaceError."""
        source = Source.load(os.fspath(job.program))
        machines = self._on(job)
        options = self._how(job, machines[0] if job.machine is not None else None)
        part = options.setup.part
        machines = tuple(machine.mounted(**part) for machine in machines) if part else machines
        tool = None if job.bend is None else self._tool(job.bend)
        prepared = Prepared(job, str(Path(job.program).absolute()), source.data, machines, options, tool, "")
        return replace(prepared, key=self._key(prepared))

    def _on(self, job: BatchJob) -> tuple[Machine, ...]:
        if isinstance(job.machine, Machine):
            named: tuple[Machine, ...] = (job.machine,)
        elif job.machine is None:
            named = tuple(self._machine(name, None) for name in Machine.names())
        else:
            return (self._machine(os.fspath(job.machine), job.tool_length),)
        return named if job.tool_length is None else tuple(each.with_tool(job.tool_length) for each in named)

    def _machine(self, name: str, tool_length: float | None) -> Machine:
        if (name, tool_length) not in self._machines:
            machine = Machine.load(name)
            self._machines[name, tool_length] = machine if tool_length is None else machine.with_tool(tool_length)
        return self._machines[name, tool_length]

    def _how(self, job: BatchJob, machine: Machine | None) -> ReadOptions:
        if job.controller is not None and job.controller not in self._controllers:
            self._controllers[job.controller] = Controller.load(job.controller)
        if job.setup is not None and job.setup not in self._setups:
            self._setups[job.setup] = load_setup(job.setup)
        controller = None if job.controller is None else self._controllers[job.controller]
        setup = None if job.setup is None else self._setups[job.setup]
        return ReadOptions.of(
            machine, controller, setup, job.skip_unknown, True, job.compensation, job.max_blocks, job.lenient,
            job.columns, job.units,
        )  # fmt: skip

    def _tool(self, name: str) -> CuttingTool:
        if name not in self._tools:
            from toolpace.cutting.tool_file import load_tool

            self._tools[name] = load_tool(name)
        return self._tools[name]

    def _text(self, machine: Machine) -> str:
        if id(machine) not in self._texts:
            self._texts[id(machine)] = machine, machine.to_toml()
        return self._texts[id(machine)][1]

    def _key(self, prepared: Prepared) -> str:
        """Hash of all that a job depends on; two jobs with one key have one result."""
        job, options = prepared.job, prepared.options
        plain = {
            name: value for name, value in vars(job).items() if name not in ("machine", "bend", "setup", "controller")
        }
        parts: dict[str, object] = {
            **plain,
            "version": __version__,
            "program": Path(prepared.path).name,
            "sha256": hashlib.sha256(prepared.data).hexdigest(),
            "machines": [self._text(machine) for machine in prepared.machines],
            "controller": "" if options.controller is None else options.controller.to_toml(),
            "setup": setup_text(options.setup),
            "tool": "" if prepared.tool is None else hashlib.sha256(prepared.tool.data).hexdigest(),
        }
        return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
