"""The reader of Sinumerik programs."""

from __future__ import annotations

import re

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import FeedRules
from toolpace.programs.reading.control.state import Rules
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.sinumerik.executor import Executor
from toolpace.programs.reading.sinumerik.flow.interpreter import Interpreter
from toolpace.programs.reading.sinumerik.flow.routines import Library
from toolpace.programs.reading.sinumerik.run import Run
from toolpace.programs.reading.source import Source

_CHANGES = re.compile(r"(?:^|[^A-Z_$])(?:M0*6(?![0-9])|L0*6(?![0-9]))", re.IGNORECASE)
"""A word that changes the tool, in a block without comment."""


class SinumerikReader:
    """One reading of one program; `executed` does it."""

    def __init__(
        self,
        source: Source,
        machine: Kinematics | None,
        controller: Controller,
        options: ReadOptions,
        findings: Findings,
    ) -> None:
        self.source, self.options, self.findings = source, options, findings
        rules = Rules(FeedRules(controller.option("feed_turning", "xyz")))
        self.control = Control(source, machine, controller, options, findings, rules)
        self.parts = Run(self.control, controller, options)

    def executed(self) -> Control:
        """The control, with the whole program executed. Raises ProgramError."""
        run = self.parts
        executor = Executor(run)
        if not any(_CHANGES.search(line.split(";", 1)[0]) for line in self.source.lines):
            run.tooling.at_once = True
        library = Library(self.source)
        self.control.effort.lines_beside = library.lines_beside
        executor.interpreter = Interpreter(self.source, library, executor, run.memory, self.options.block_delete)
        executor.interpreter.run()
        run.motion.splines.close()
        run.motion.corners.refuse()
        if not executor.interpreter.ended:
            self.source.must_be_ended("M2, M30, M17 nor RET")
        if not run.state.stop_programmed and len(self.control.moves):
            self.findings.assumed("the program says neither G60 nor G64: blocks are taken to meet without a stop (G64)")
        if not run.state.unit_programmed and len(self.control.moves):
            self.findings.assumed(
                "the program does not say its unit of lengths (G70, G71, G700, G710): they are millimetres"
            )
        self.findings.raise_if_refused(self.source, self.options.skip_unknown)
        return self.control
