"""Words that are no motion: spindle, waiting for inputs and saved modes of LinuxCNC, and words that move nothing.

After LinuxCNC's manual, "M3, M4, M5 Spindle Control", "M19 Orient Spindle", "M66 Wait on Input", "M70 Save Modal
State", "M72 Restore Modal State" and "M73 Save and Autorestore Modal State".
"""

from __future__ import annotations

from toolpace.common.units import DEGREE, MINUTE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import PER_MINUTE
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.gcode.frames.frames import Frames
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.flow import Flow
from toolpace.programs.reading.gcode.program.variables import Variables
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError, WordError

RESULT = 5399
"""Variable that has what was waited for."""
MODES = ("unit", "absolute", "arc_absolute", "plane", "exact_stop", "to_initial", "length_word", "turning")
"""Of `Modal`; the motion in force is not among them."""
SHIFTED_BY_TABLES = (
    "it shifts by tables of the control, which no set-up sheet has: let the CAM system shift the path, or remove it "
    "where they are zero"
)


class Functions:
    """Carries out M3, M4, M5, M19 and M66 of LinuxCNC."""

    def __init__(self, control: Control, state: Modal, variables: Variables) -> None:
        self.control, self.state, self.variables = control, state, variables

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {"turn spindle": self.turn, "orient spindle": self.orient, "wait for input": self.wait}

    def turn(self, numbers: Numbers, word: str) -> None:
        """M3, M4, M5."""
        self.state.turning = "" if word == "M5" else word
        self.control.stop()

    def orient(self, numbers: Numbers, word: str) -> None:
        """M19 R P Q: to an angle, by a direction, within a time."""
        words = {letter: numbers.pop(letter) for letter in "RPQ" if letter in numbers}
        self._refuse_cycle(numbers, word, arcs=True)
        if not 0.0 <= words.get("R", 0.0) <= 360.0 or round(words.get("P", 0.0)) not in (0, 1, 2):
            raise WordError(f"{word} takes an angle R from 0 to 360 and a direction P of 0, 1 or 2: correct them")
        if words.get("Q", 1.0) <= 0.0:
            raise WordError(f"{word} Q is a time above zero: correct it")
        self.state.turning = ""
        self.control.stop()

    def wait(self, numbers: Numbers, word: str) -> None:
        """M66 P or E, L Q: for how long is not known, nor what is read."""
        shared = {"P": numbers["P"]} if self.state.arc_here and "P" in numbers else {}
        words = {letter: numbers.pop(letter) for letter in "PELQ" if letter in numbers}
        numbers |= shared  # of the turns of an arc too
        self._refuse_cycle(numbers, word)
        inputs = [words[letter] for letter in "PE" if letter in words]
        waits = round(words.get("L", 0.0))
        if len(inputs) != 1 or round(inputs[0]) < 0:
            raise WordError(f"{word} waits for one input: write its number as P, or as E where it is analog")
        if waits and ("E" in words or words.get("Q", 0.0) <= 0.0):
            raise WordError(f"{word} L{waits} waits for a digital input, Q seconds at most: write P, and Q above zero")
        self.variables.common.pop(RESULT, None)
        self.control.stop()

    def _refuse_cycle(self, numbers: Numbers, word: str, *, arcs: bool = False) -> None:
        """Raise WordError where the motion of the block takes the same letters for something else."""
        state = self.state
        moves = not numbers.keys().isdisjoint("XYZABCUVWIJK")
        if moves and (state.drills_here or (arcs and state.arc_here)):
            raise WordError(f"{word} and an arc or a cycle may take the same letters: write two blocks")


class SavedModes:
    """Carries out M70, M71, M72 and M73."""

    def __init__(self, control: Control, state: Modal, frames: Frames, flow: Flow) -> None:
        self.control, self.state, self.frames, self.flow = control, state, frames, flow
        self.offsets = frames.offsets

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "save modes": self.save,
            "save modes for return": self.save_for_return,
            "forget modes": self.forget,
            "restore modes": self.restore,
        }

    def save(self, numbers: Numbers, word: str) -> None:
        """M70."""
        control = self.control
        feed, coordinates = control.feed, control.coordinates
        modes = {name: getattr(self.state, name) for name in MODES}
        rates = feed.mode, feed.value, feed.turn, feed.unit, feed.spindle
        tool = coordinates.compensated, coordinates.length_of, coordinates.programmed
        offset, position_on = self.offsets.offset, self.frames.position_on
        joining = control.moves.joining

        def restore() -> None:
            for name, value in modes.items():
                setattr(self.state, name, value)
            feed.mode, feed.value, feed.turn, feed.unit, feed.spindle = rates
            number = 0.0 if feed.value is None else feed.turn / DEGREE * (MINUTE if feed.mode == PER_MINUTE else 1.0)
            if feed.unit != self.state.unit or abs(number - round(number, 1)) > 1e-9:
                # its interpreter writes F anew, as a number of one decimal in the unit of the saved modes
                feed.value = None
            coordinates.compensated, coordinates.length_of, coordinates.programmed = tool
            control.moves.join(joining)
            if position_on != self.frames.position_on:
                self.frames.put_position(position_on)
            if offset != self.offsets.offset:
                self.offsets.take(offset)
            else:
                self.offsets.changed()

        self.flow.frame.saved = restore

    def save_for_return(self, numbers: Numbers, word: str) -> None:
        """M73: restored where this level returns."""
        self.save(numbers, word)
        self.flow.frame.restores = True

    def forget(self, numbers: Numbers, word: str) -> None:
        """M71."""
        self.flow.frame.saved = None

    def restore(self, numbers: Numbers, word: str) -> None:
        """M72."""
        restore = self.flow.frame.saved
        if restore is None:
            raise WordError(f"{word} restores modes, and none were saved at this level: write M70 before it")
        restore()


class IdleWords:
    """Counts words that move nothing; what beside them might move is refused."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {"limits": self.limits, "no motion": self.no_motion, "only off": self.only_off}

    def limits(self, numbers: Numbers, word: str) -> None:
        """Fanuc G22: X, Y, Z, I, J, K are corners of a zone that the axes may not enter."""
        numbers.clear()
        self.findings.ignored(word)

    def no_motion(self, numbers: Numbers, word: str) -> None:
        """A word that moves nothing on one control, and with axes moves on another (G8 of Fagor is an arc)."""
        if not numbers.keys().isdisjoint("XYZABCUVW"):
            numbers.clear()
            raise RefusedError(f"{word} beside axes", "some controls move by it otherwise: give --controller NAME")
        numbers.pop("P", None)
        self.findings.ignored(word)

    def only_off(self, numbers: Numbers, word: str) -> None:
        """A word whose P0 (or X0) switches off what is not read."""
        letter = "P" if "P" in numbers else "X"
        number = numbers.pop(letter, 0.0)
        if number:
            raise RefusedError(f"{word} {letter}{number:g}", SHIFTED_BY_TABLES)
        self.findings.ignored(word)
