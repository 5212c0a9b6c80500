"""Tool change, tool length, tool-centre-point mode."""

from __future__ import annotations

from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError

WHERE_CHANGED = (
    "M6 leaves the axes where they are: a Haas goes to Z zero before it, others as their builders chose (write G28 or "
    "G53 before M6, and the way there is planned)"
)


class Tools:
    """Carries out the words of tools."""

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.h_stays = by.option("length_word_stays", True)
        self.with_tool = by.option("length_with_tool", False)
        self.tip_in_planes = by.option("tip_mode_in_planes", False)
        """Whether tool-centre-point mode may begin in a tilted plane."""
        self.changes_elsewhere = by.option("changes_elsewhere", False)
        """Whether M6 may go to the place where tools are changed."""
        self.rs274 = by.option("rs274_checks", False)
        """Whether number 0 of H and D, and a length without H, mean the tool in the spindle (LinuxCNC's manual)."""
        self.lengths_move: str = by.option("lengths_move", "")
        """What a change of the length does to a block under G91: "with the block" it is gone as well, "refused"."""

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "tool length": self.length,
            "tip mode": self.tip_mode,
            "tip mode that stands": self.tip_mode_that_stands,
            "tool vector mode": self.vector_mode,
            "length off": self.length_off,
            "tip mode ends": self.tip_mode_off,
            "stop": self.stop,
            "unknown function": self.unknown_function,
            "tool change": self.change,
            "tool at hand": self.take,
            "told offset": self.told_offset,
            "added offset": self.added_offset,
            "tip mode on": self.switch_on,
            "tip mode off": self.switch_off,
        }

    def stop(self, numbers: Numbers, word: str) -> None:
        """Spindle, coolant, clamps: the motion comes to rest."""
        self.control.stop()
        self.control.turn_spindle(word=word)

    def unknown_function(self, numbers: Numbers, word: str) -> None:
        """An M word of the machine's builder."""
        self.control.findings.assumed(f"{word} is not known here: it is taken to switch something at rest")
        self.control.stop()

    def change(self, numbers: Numbers, word: str) -> None:
        """M6: the tool that T named last."""
        numbers.pop("T", None)
        self.state.turning = ""
        if self.changes_elsewhere and len(self.control.moves) and not self.state.level_by_machine:
            self.control.findings.assumed(WHERE_CHANGED)
        self.control.change_tool(self.state.next_tool)
        if self.with_tool:
            self.control.set_length(self.state.next_tool)

    def take(self, numbers: Numbers, word: str) -> None:
        """M61: the tool in the spindle is this one, without a change."""
        number = numbers.pop("Q", None)
        if number is None or number != int(number) or number < 0:
            raise BlockError(f"{word} needs the number of the tool as Q: write it like {word} Q5")
        if self.rs274 and self.state.drills_here and not numbers.keys().isdisjoint("XYZ"):
            raise BlockError(f"{word} and a cycle may take the same letters: write two blocks")
        self.control.change_tool(f"{number:g}")

    def length(self, numbers: Numbers, word: str) -> None:
        """G43: the length of H, or of the tool at hand."""
        self.control.findings.ignored(word)
        before = self.control.words[:3]
        self._length(numbers, word)
        self._tip(self.state.switched_tip_mode, False)
        self._settle(before, numbers, word)

    def number_alone(self, numbers: Numbers) -> None:
        """H without G43: under it the offset of that number takes the place of the one before, number 0 ends it."""
        control, number = self.control, numbers["H"]
        if not self.lengths_move or not control.coordinates.compensated:
            return
        if self.state.tip_mode and f"{number:g}" == self.state.length_word:
            return
        if self.state.tip_mode or (number and self.lengths_move == "refused"):
            numbers.clear()
            raise RefusedError(f"H{number:g} alone", "it may change the length: write it with G43, G43.4 or G43.5")
        self.length(numbers, f"H{number:g}")

    def _settle(self, before: list[float], numbers: Numbers, word: str) -> None:
        """What becomes of the words (3,) [m] that the machine had before its length changed."""
        control, state = self.control, self.state
        off = [a - b for a, b in zip(before, control.words[:3])]
        if not self.lengths_move or not len(control.moves) or not any(abs(each) > ROUNDING for each in off):
            return
        named = [letter in numbers for letter in "XYZ"]
        if any(abs(each) > ROUNDING and not there for each, there in zip(off, named)):
            if state.level_by_machine:
                return  # at a reference point no length is in force, and none can be gone by
            control.findings.assumed(
                f"{word} without Z moves nothing, and the next Z counts with the new length (on Fanuc where parameter "
                "5006#6 is 1; else the axis goes by the difference at once)"
            )
        elif not state.absolute and self.lengths_move == "refused":
            numbers.clear()
            raise RefusedError(f"{word} under G91", "controls differ in where it ends: write G90 before it")
        elif not state.absolute:
            for slot, letter in enumerate("XYZ"):
                if named[slot]:
                    numbers[letter] += off[slot] / state.unit

    def _length(self, numbers: Numbers, word: str) -> None:
        control, state = self.control, self.state
        words = numbers.pop("H", None)
        if words is not None and not (words >= 0.0 and words == int(words)):
            raise BlockError(f"H{words:g} of {word} is no number of a tool: write a whole one, from 0")
        if words == 0.0 and self.rs274:
            words, state.length_word = None, None
        if words is not None or not self.h_stays:
            state.length_word = None if words is None else f"{words:g}"
        tool = state.length_word or control.tool or ""
        if words is None and (not self.rs274):
            taken = f"that of H{state.length_word} before" if state.length_word else f"that of tool {tool}"
            taken = taken if tool else "that of the machine's own tool, since no T or H names one"
            control.findings.assumed(f"{word} without H: the length is {taken}")
        # no tool, or number 0 of a table: its length is zero
        without = tool in ("", "0") and control.setup.tells_lengths and control.setup.tool(tool) is None
        control.set_length(None if without else tool)

    def told_offset(self, numbers: Numbers, word: str) -> None:
        """G43.1: the offset of the axes that are named, in place of the present one."""
        self._need_tools(word)
        offset = list(self.control.coordinates.tool_offset(self.control.tool))
        words = self._offset_words(numbers, word)
        for slot, value in words.items():
            offset[slot] = value
        self._offset(offset)

    def added_offset(self, numbers: Numbers, word: str) -> None:
        """G43.2: the length of H, or the axes that are named, added to the present one."""
        self._need_tools(word)
        control = self.control
        offset = list(control.coordinates.tool_offset(control.tool))
        tool = numbers.pop("H", None)
        words = self._offset_words(numbers, word)
        if tool is not None and words:
            raise BlockError(f"{word} has the number of a tool as H, or axes: write one of both")
        if tool is None and not words:
            raise BlockError(f"{word} needs the number of a tool as H: write it like {word} H5")
        if tool:
            found = control.setup.tool(f"{tool:g}")
            if found is None or found.length is None:
                raise BlockError(f"{word} H{tool:g} has no length on the set-up sheet: list the tool there")
            offset[2] += found.length
        for slot, value in words.items():
            offset[slot] += value
        self._offset(offset)

    def _offset_words(self, numbers: Numbers, word: str) -> dict[int, float]:
        """X, Y and Z of an offset [m], by their slots."""
        turned = next((letter for letter in numbers if letter in "ABCUVW"), None)
        if turned is not None:
            raise RefusedError(f"{word} with {turned}", "offsets of X, Y and Z are read: write them alone")
        unit = self.state.unit
        return {slot: numbers.pop(letter) * unit for slot, letter in enumerate("XYZ") if letter in numbers}

    def _need_tools(self, word: str) -> None:
        if not self.control.setup.tells_lengths:
            raise RefusedError(word, "it counts from the spindle: list the tools on the set-up sheet (--setup)")

    def _offset(self, offset: list[float]) -> None:
        x, y, length = offset
        self.control.set_tool_offset(x, y, length)
        self._tip(self.state.switched_tip_mode, False)

    def tip_mode(self, numbers: Numbers, word: str) -> None:
        """G43.4: X, Y, Z are the tip."""
        if self.control.coordinates.tilted and not self.tip_in_planes:
            numbers.clear()
            raise RefusedError(f"{word} in a tilted plane", "the control has either: write G255 or G269 before it")
        self._length(numbers, word)
        self._tip(self.state.switched_tip_mode, True)
        self.state.vectors = self.state.stands = False

    def vector_mode(self, numbers: Numbers, word: str) -> None:
        """G43.5: I, J, K are the tool axis."""
        self.tip_mode(numbers, word)
        self.state.vectors = True

    def tip_mode_that_stands(self, numbers: Numbers, word: str) -> None:
        """G141 of MillPlus: the tip, in coordinates that stand while the table turns."""
        for letter in ("L2", "F2"):
            numbers.pop(letter, None)
        self._tip(self.state.switched_tip_mode, True)
        self.state.stands = True
        self.control.findings.assumed(
            f"under {word} X, Y and Z are those of the part after the table has turned it, not fixed to the table"
        )

    def length_off(self, numbers: Numbers, word: str) -> None:
        """G49."""
        self.control.findings.ignored(word)
        self.state.vectors = self.state.stands = False
        self.state.length_word = None
        before = self.control.words[:3]
        was_tip = self.state.tip_mode
        self._tip(self.state.switched_tip_mode, False)
        self.control.set_length(None)
        if not was_tip:
            self._settle(before, numbers, word)

    def tip_mode_off(self, numbers: Numbers, word: str) -> None:
        """G40 of MillPlus: the length stays."""
        numbers.pop("D", None)
        self.control.findings.ignored(word)
        self.state.vectors = self.state.stands = False
        self._tip(self.state.switched_tip_mode, False)

    def switch_on(self, numbers: Numbers, word: str) -> None:
        """M428."""
        self._tip(True, self.state.length_tip_mode)

    def switch_off(self, numbers: Numbers, word: str) -> None:
        """M429."""
        self._tip(False, self.state.length_tip_mode)

    def _tip(self, switched: bool, by_length: bool) -> None:
        """Switch tool-centre-point mode, by either of its words."""
        self.state.switched_tip_mode, self.state.length_tip_mode = switched, by_length
        self.control.set_tip_mode(switched or by_length)
