"""What one run of a program works on: the virtual control, modes, frames, motion, tools, words, variables."""

from __future__ import annotations

from toolpace.reading.control.control import Control
from toolpace.reading.controllers.controller import Controller
from toolpace.reading.options import ReadOptions
from toolpace.reading.sinumerik.compensation import Compensation
from toolpace.reading.sinumerik.flow.memory import Store
from toolpace.reading.sinumerik.frames import Frames
from toolpace.reading.sinumerik.motion import Motion
from toolpace.reading.sinumerik.state import State
from toolpace.reading.sinumerik.syntax.blocks import Call
from toolpace.reading.sinumerik.syntax.values import Value
from toolpace.reading.sinumerik.system import System
from toolpace.reading.sinumerik.tooling import Tooling
from toolpace.reading.sinumerik.vocabulary import Vocabulary

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
