"""What one run of a program has: the controller's words, modes, motion, tools, memory and system variables."""

from __future__ import annotations

import math

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import DEGREE, INCH, MILLIMETRE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import Tool
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.sinumerik.compensation import Compensation, Tooling
from toolpace.programs.reading.sinumerik.flow.memory import Store
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.motion import Motion
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.blocks import Call
from toolpace.programs.reading.sinumerik.syntax.values import Axis, Unread, Value, whole

IGNORED = "ignored"
UNITS = {"program": None, "mm": MILLIMETRE, "inch": INCH}
SIMULATED = ("$P_SEARCH", "$P_ISTEST", "$P_SIM", "$P_DRYRUN", "$P_SEARCHL")
"""Whether the program is searched through or tried: it is not."""
_CURE = "what the control holds there is not known: put it on the set-up sheet as a variable, or write a number"
Modal = tuple[Call, list[Value | None]]


class Vocabulary:
    """Words of one controller; a name that ends in * stands for all that begin so."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self._meanings = dict(controller.meanings) | dict.fromkeys(controller.ignored, IGNORED)
        self._refused = dict(controller.refused)
        self._beginnings = tuple(name[:-1] for name in self._refused if name.endswith("*"))
        self.base_unit = UNITS[controller.option("base_unit", "program")]

    def check(self, meanings: tuple[str, ...]) -> None:
        """UsageError where the file gives a word a meaning that does not exist."""
        for word, meaning in self.controller.meanings.items():
            if meaning not in meanings:
                near = did_you_mean(meaning, meanings)
                raise UsageError(f"{self.controller.source}: {word} = '{meaning}' is no meaning: {near}")

    def meaning(self, word: str) -> str:
        """What a word does, "ignored", or "" where the file does not say."""
        return self._meanings.get(word, "")

    def refusal(self, word: str) -> str:
        """The cure for a word that is not read; "" where the file does not name it."""
        found = self._refused.get(word)
        if found is not None:
            return found
        for beginning in self._beginnings:
            if word.startswith(beginning):
                return self._refused[beginning + "*"]
        return ""


class System:
    """Reads $ variables as they stand at a block."""

    def __init__(self, control: Control, state: State, frames: Frames, motion: Motion) -> None:
        self.control, self.state, self.frames, self.motion = control, state, frames, motion

    def read(self, name: str, index: tuple[Value, ...]) -> Value:
        """The value of a variable. Raises Unread."""
        if name in SIMULATED:
            return False
        if name == "$PI":
            return math.pi
        if name in ("$P_EP", "$AA_IW", "$AA_IM", "$P_EPM") and len(index) == 1:
            return self._position(name, index[0])
        if name == "$P_TOOLR":
            tool = self.control.setup.tool(self.control.tool)
            if tool is not None:
                return self._radius(name, tool) / self.state.unit_of_control()
        if name == "$P_TOOLNO" and self.control.tool.isdecimal():
            return int(self.control.tool)
        if name in ("$TC_DP3", "$TC_DP6") and index:
            tool = self.control.setup.tools.get(str(whole(index[0])))
            if tool is not None:
                length = self._length if name == "$TC_DP3" else self._radius
                return length(name, tool) / self.state.unit_of_control()
        if name == "$P_PFRAME" and not index and not self.frames.turns_words:
            return self.frames.programmed()
        if name == "$P_UIFR" and len(index) == 1 and whole(index[0]) in self.frames.settable:
            return self.frames.settable[whole(index[0])]
        raise Unread(name, _CURE)

    @staticmethod
    def _length(name: str, tool: Tool) -> float:
        """Length of a tool of the sheet [m]; Unread where it tells none."""
        if tool.length is None:
            raise Unread(name, "the set-up sheet tells no length of the tool: write it there")
        return tool.length

    @staticmethod
    def _radius(name: str, tool: Tool) -> float:
        """Radius of a tool of the sheet [m]; Unread where it tells none, lest a contour is reckoned without one."""
        if not tool.radius:
            raise Unread(name, "the set-up sheet tells no radius of the tool: write it there")
        return tool.radius

    def _position(self, name: str, axis: Value) -> float:
        letter = axis.letter if isinstance(axis, Axis) else ""
        slot = self.control.slots.get(letter)
        if slot is None:
            raise Unread(f"{name}[{letter}]", "the machine has no such axis: name one of its axes")
        unit = self.state.unit_of_control() if slot < 3 else DEGREE
        if name != "$P_EP" and self.control.stage is not None:
            raise Unread(f"{name}[{letter}]", "the radius is compensated here: read it behind G40 and a motion")
        if name == "$P_EP" and slot in self.motion.shifted():
            raise Unread(f"$P_EP[{letter}] behind a change of frames", "in which it is is not told: read it before")
        if name in ("$P_EP", "$AA_IW"):
            return self.control.words[slot] / unit
        control = self.control
        place = control.placement.place(control.words)
        if control.placement.tip_mode:
            place = control.poses.to_joints(place, control.placement.tool_length)
        return (place[slot] - control.datum.zero[slot]) / unit


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
