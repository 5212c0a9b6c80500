"""The objects of one run of a program: virtual control, modes, frames, tools, variables."""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.sinumerik.compensation import Compensation
from toolpace.programs.reading.sinumerik.flow.memory import Store
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.motion import Motion
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.blocks import Call
from toolpace.programs.reading.sinumerik.syntax.values import Value
from toolpace.programs.reading.sinumerik.system import System
from toolpace.programs.reading.sinumerik.tooling import Tooling
from toolpace.programs.reading.sinumerik.vocabulary import Vocabulary

Modal = tuple[Call, list[Value | None]]


class Run:
    """Parts of one run, each of which knows those that it needs."""

    def __init__(self, control: Control, controller: Controller, options: ReadOptions) -> None:
        self.control, self.findings = control, control.findings
        self.vocabulary = Vocabulary(controller)
        self.state = State(base_unit=self.vocabulary.base_unit)
        self.frames = Frames(control, self.state)
        self.motion = Motion(control, self.state, self.frames)
        self.tooling = Tooling(control, self.state, options)
        self.compensation = Compensation(control, self.state, self.tooling)
        self.memory = Store(options.setup.variables, System(control, self.state, self.frames, self.motion).read)
        self.modal: Modal | None = None
        """What MCALL asked for, with its arguments."""
