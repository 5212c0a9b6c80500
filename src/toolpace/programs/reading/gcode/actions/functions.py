"""Functions that stop the motion: spindle, and waiting for inputs.

After LinuxCNC's manual, "M3, M4, M5 Spindle Control", "M19 Orient Spindle" and "M66 Wait on Input".
"""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.gcode.actions.modal import Modal
from toolpace.programs.reading.gcode.program.variables import Variables
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, WordError

RESULT = 5399
"""Variable that has what was waited for."""


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
        given = {letter: numbers.pop(letter) for letter in "RPQ" if letter in numbers}
        self._refuse_cycle(numbers, word, arcs=True)
        if not 0.0 <= given.get("R", 0.0) <= 360.0 or round(given.get("P", 0.0)) not in (0, 1, 2):
            raise WordError(f"{word} takes an angle R from 0 to 360 and a direction P of 0, 1 or 2: correct them")
        if given.get("Q", 1.0) <= 0.0:
            raise WordError(f"{word} Q is a time above zero: correct it")
        self.state.turning = ""
        self.control.stop()

    def wait(self, numbers: Numbers, word: str) -> None:
        """M66 P or E, L Q: for how long is not known, nor what is read."""
        shared = {"P": numbers["P"]} if self.state.arc_here and "P" in numbers else {}
        given = {letter: numbers.pop(letter) for letter in "PELQ" if letter in numbers}
        numbers |= shared  # of the turns of an arc too
        self._refuse_cycle(numbers, word)
        inputs = [given[letter] for letter in "PE" if letter in given]
        waits = round(given.get("L", 0.0))
        if len(inputs) != 1 or round(inputs[0]) < 0:
            raise WordError(f"{word} waits for one input: write its number as P, or as E where it is analog")
        if waits and ("E" in given or given.get("Q", 0.0) <= 0.0):
            raise WordError(f"{word} L{waits} waits for a digital input, Q seconds at most: write P, and Q above zero")
        self.variables.common.pop(RESULT, None)
        self.control.stop()

    def _refuse_cycle(self, numbers: Numbers, word: str, *, arcs: bool = False) -> None:
        """Raise WordError where the motion of the block takes the same letters for something else."""
        state = self.state
        moves = not numbers.keys().isdisjoint("XYZABCUVWIJK")
        if moves and (state.drills_here or (arcs and state.arc_here)):
            raise WordError(f"{word} and an arc or a cycle may take the same letters: write two blocks")
