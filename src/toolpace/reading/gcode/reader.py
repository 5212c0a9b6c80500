"""Reads G-code as a controller would: block by block, in the order of execution of RS274/NGC."""

from __future__ import annotations

import re

from toolpace.reading.arcs import ArcError
from toolpace.reading.control.control import Control
from toolpace.reading.control.feed import INVERSE, PER_MINUTE
from toolpace.reading.control.kinematics import Kinematics
from toolpace.reading.control.setup import SetUp
from toolpace.reading.findings import Findings
from toolpace.reading.gcode import codes
from toolpace.reading.gcode.modal import Modal
from toolpace.reading.gcode.motion import MotionReader
from toolpace.reading.gcode.words import WordError, without_comments, words
from toolpace.reading.source import Source
from toolpace.toolpath import ToolPath

_PROGRAM_NUMBER = re.compile(r"O[ \t]*[0-9]+|:[ \t]*[0-9]+")


class GcodeReader:
    """One reading of one program; `run` does it."""

    def __init__(
        self,
        source: Source,
        machine: Kinematics | None = None,
        *,
        block_delete: bool = True,
        default_feed: float | None = None,
        setup: SetUp | None = None,
        findings: Findings | None = None,
    ) -> None:
        self.source, self.block_delete = source, block_delete
        self.findings = findings or Findings()
        self.control = Control(
            source, machine, setup, findings=self.findings, default_feed=default_feed, controller="linuxcnc"
        )
        self.moves = self.control.moves
        self.state = Modal()
        self.motion = MotionReader(self.control, self.state)

    def run(self) -> ToolPath:
        """Interpret every block, then lay the points."""
        tape_line, tape_closed = 0, False
        for line, text in enumerate(self.source.lines, start=1):
            if "%" in text and text.lstrip().startswith("%"):
                if tape_line or len(self.moves):
                    tape_closed = True
                    break
                tape_line = line
                continue
            self.control.line = line
            try:
                block = without_comments(text)
                if block.startswith("/"):
                    block = "" if self.block_delete else block.lstrip("/0123456789 \t")
                    self.findings.skipped["/"] += self.block_delete
                if block:
                    self.block(block, line)
            except (WordError, ArcError) as error:
                self.source.fail(str(error), line)
            if self.state.ended:
                break
        self._refuse_cut_off(tape_line, tape_closed)
        return self.control.toolpath()

    def _refuse_cut_off(self, tape_line: int, tape_closed: bool) -> None:
        if self.state.ended or tape_closed:
            return
        if tape_line:
            self.source.fail(
                "the program is cut off: % opens it here, but neither %, M2 nor M30 ends it; export it again",
                tape_line,
            )
        if not self.source.last_line_ended:
            self.source.fail(
                "the program looks cut off: neither M2, M30 nor % ends it, and its last line has no end; "
                "export it again, or end the line if it is complete",
                len(self.source.lines),
            )

    def block(self, block: str, line: int) -> None:
        """Execute one block."""
        state, fail = self.state, self.source.fail
        if block[0] in "O:" and _PROGRAM_NUMBER.fullmatch(block):
            self.control.begin_block(line)
            self.findings.ignored("O")
            return
        numbers: dict[str, float] = {}
        g_codes: list[int] = []
        m_codes: list[int] = []
        for letter, text in words(block):
            value = float(text)
            if letter == "G":
                code = round(value * 10) if 0 <= value < 1000 else -1
                if abs(value * 10 - code) > 1e-6 or code not in codes.GROUP_OF:
                    reason = codes.REFUSED.get(code, codes.UNKNOWN_G)
                    fail(f"G{text} cannot be read: {reason}", line)
                g_codes.append(code)
            elif letter == "M":
                m_codes.append(int(value) if 0 <= value < 100000 and value == int(value) else -1)
            elif letter in numbers:
                fail(f"word {letter} stands twice in one block: remove one", line)
            else:
                numbers[letter] = value
        self.control.begin_block(line)
        numbers.pop("N", None)
        new_motion, dwell, stop_here = (None, False, False)
        if g_codes:
            new_motion, dwell, stop_here = self._modes(g_codes, numbers, line)
        number = numbers.pop("F", None)
        if number is not None:
            self.control.feed.set(number, state.unit, line)
        ends = self._machine_functions(m_codes, line) if m_codes else False
        for letter in codes.PASSED_WORDS:
            if numbers.pop(letter, None) is not None:
                self.findings.ignored(letter)
        if dwell:
            self._dwell(numbers, line)
            if numbers and new_motion is None:
                fail("G4 takes P alone: write the motion in a block of its own", line)
        if new_motion is not None:
            state.motion = None if new_motion == 800 else new_motion
        if numbers:
            self.motion.execute(numbers, number, stop_here or state.exact_stop, line)
        elif stop_here:
            self.moves.stop()
        if m_codes and not codes.STOPS_AFTER.isdisjoint(m_codes):
            self.moves.stop()
        state.ended = ends

    def _modes(self, g_codes: list[int], numbers: dict[str, float], line: int) -> tuple[int | None, bool, bool]:
        """Apply the modes of a block; returns its motion code, whether it dwells, and whether it has G9."""
        state = self.state
        seen: dict[str, int] = {}
        for code in g_codes:
            group = codes.GROUP_OF[code]
            if group == "passed over":
                self.findings.ignored(codes.code_text(code))
            elif seen.setdefault(group, code) != code:
                both = f"{codes.code_text(seen[group])} and {codes.code_text(code)}"
                self.source.fail(f"{both} exclude each other in one block: write two blocks", line)
        if "feed" in seen:
            self.control.feed.set_mode(INVERSE if seen["feed"] == 930 else PER_MINUTE)
        if "plane" in seen:
            state.plane = (170, 180, 190).index(seen["plane"])
        if "units" in seen:
            state.set_units(seen["units"])
        if "distance" in seen:
            state.absolute = seen["distance"] == 900
        if "arc distance" in seen:
            state.arc_absolute = seen["arc distance"] == 901
        if "path control" in seen:
            code = seen["path control"]
            state.exact_stop = code != 640
            if code == 640 and (numbers.pop("P", None) is not None) | (numbers.pop("Q", None) is not None):
                # The tolerance of the path is given to the fit, not by the program.
                self.control.tolerance("G64 P")
        if "tool length" in seen:
            self.findings.skipped["G43"] += seen["tool length"] == 430
            self._tip_mode(state.switched_tip_mode, seen["tool length"] == 434)
        return seen.get("motion"), "dwell" in seen, "exact stop" in seen

    def _machine_functions(self, m_codes: list[int], line: int) -> bool:
        """Apply the M words of a block that act before its motion; returns whether one ends the program."""
        ends = False
        for code in m_codes:
            if code in codes.STOPS_BEFORE:
                self.moves.stop()
            elif code in codes.TIP_MODE:
                self._tip_mode(codes.TIP_MODE[code], self.state.length_tip_mode)
            elif code in codes.PASSED_M:
                self.findings.ignored(f"M{code}")
            elif code in codes.ENDS:
                ends = True
            elif code not in codes.STOPS_AFTER:
                reason = codes.REFUSED_M.get(code, codes.UNKNOWN_M)
                self.source.fail(f"M{code} cannot be read: {reason}" if code >= 0 else "M has no whole number", line)
        return ends

    def _tip_mode(self, switched: bool, by_length: bool) -> None:
        """Switch tool-centre-point mode, by either of its words."""
        self.state.switched_tip_mode, self.state.length_tip_mode = switched, by_length
        self.control.set_tip_mode(switched or by_length)

    def _dwell(self, numbers: dict[str, float], line: int) -> None:
        seconds = numbers.pop("P", None)
        if seconds is None:
            self.source.fail("G4 needs its time as P in seconds: write it like G4 P0.5", line)
        self.control.dwell(seconds)
