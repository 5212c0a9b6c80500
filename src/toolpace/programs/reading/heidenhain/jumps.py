"""LBL, CALL and FN: jumps, and functions of Q parameters."""

from __future__ import annotations

import re

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.heidenhain.contour.motion import Step
from toolpace.programs.reading.heidenhain.flow import Flow
from toolpace.programs.reading.heidenhain.klartext.expressions import evaluate, formula
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters, UnsetError, named
from toolpace.programs.reading.heidenhain.klartext.program import label_of

_LABEL = re.compile(r"(?:\"([^\"]*)\"|([0-9]+))")
_NAME = r"(?:LBL\s*)?(?:\"([^\"]*)\"|(QS[0-9]+)|(Q[LR]?[0-9]+)|([0-9]+))"
_CALL = re.compile(_NAME + r"(?:\s*REP\s*([0-9]+|Q[LR]?[0-9]+)(?:\s*/\s*[0-9]+)?)?")
_FUNCTION = re.compile(r"([0-9]+)\s*:\s*(.*)")
_RESULT = re.compile(r"(Q[LR]?[0-9]+)\s*=\s*(.+)")
_TEST = re.compile(r"EQU|NE(?!G)|GT|LT")
SELECTS = "write what the table holds: shifts as CYCL DEF 7, places as blocks with M99"
MOST_REPEATS = 65534
"""Of a program section (TNC 640, "Input format and unit of TNC functions")."""
ALARM = 14
RAISED = "the program stops itself with this error: correct what it tests before"
MESSAGES = (15, 16, 19, 20, 29, 38)
"""FN that print, send, and wait for the machine: no motion."""


class Jumps:
    """Compiles what changes the order of blocks."""

    def __init__(self, flow: Flow, parameters: Parameters, control: Control) -> None:
        self.flow, self.parameters, self.control = flow, parameters, control
        self.selected = ""
        """Name of the program that SEL PGM chose."""

    def label(self, text: str) -> Step:
        """LBL: 0 ends a subprogram. Raises BlockError."""
        found = _LABEL.fullmatch(text)
        if found is None:
            raise BlockError("LBL needs a number or a name in quotation marks: write one")
        return self.flow.end_label if label_of(found) == "0" else (lambda: None)

    def target(self, found: re.Match[str]) -> str:
        """The label that is meant, as it stands now."""
        if found[1] is not None:
            return found[1]
        if found[2]:
            return self.parameters.text(found[2])
        return f"{self.parameters.get(found[3]):g}" if found[3] else found[4].lstrip("0") or "0"

    def call(self, text: str) -> Step:
        """CALL LBL, CALL PGM. Raises BlockError."""
        if text.startswith("PGM"):
            name = text[3:].strip()
            if not name:
                raise BlockError("CALL PGM needs the name of a program: write it")
            return lambda: self.flow.call_program(name, self.control.line)
        if text == "SELECTED PGM":
            return self.call_selected
        found = _CALL.fullmatch(text) if text.startswith("LBL") else None
        if found is None:
            cure = "write CALL LBL with a label, or CALL PGM with the name of a file"
            return lambda: self.control.findings.refused(f"CALL {text[:20]}", self.control.line, cure)
        times = found[5]
        if times is None:
            return lambda: self.flow.call(self.target(found), self.control.line)
        count = formula(times, self.parameters)

        def run() -> None:
            value = evaluate(count)
            if value != int(value) or not 0 <= value <= MOST_REPEATS:
                raise BlockError(f"REP {value:g} must be a whole number from 0 to {MOST_REPEATS}: correct it")
            self.flow.repeat(self.target(found), int(value))

        return run

    def select(self, text: str) -> Step:
        """SEL PGM: the program that CALL SELECTED PGM runs; other tables are refused."""
        name = text[3:].strip()
        if not text.startswith("PGM") or not name:
            return lambda: self.control.findings.refused(f"SEL {text[:20]}", self.control.line, SELECTS)

        def run() -> None:
            self.selected = name

        return run

    def call_selected(self) -> None:
        """CALL SELECTED PGM. Raises BlockError."""
        if not self.selected:
            raise BlockError("no program is selected here: write SEL PGM before its call")
        self.flow.call_program(self.selected, self.control.line)

    def function(self, text: str) -> Step:
        """FN. Raises BlockError."""
        found = _FUNCTION.fullmatch(text)
        if found is None:
            raise BlockError("FN needs its number and a colon: write FN 0: Q1 = +5")
        number, rest = int(found[1]), found[2].strip()
        if number <= 8 or number == 13:
            result = _RESULT.fullmatch(rest)
            if result is None:
                raise BlockError(f"FN {number} gives a Q parameter: write FN {number}: Q1 = ..")
            name, value = named(result[1]), formula(result[2], self.parameters)
            return lambda: self.parameters.assign(name, lambda: evaluate(value))
        if number <= 12:
            return self.jump(number, rest)
        if number == ALARM:
            return self.alarm(rest)
        if number in MESSAGES:
            return lambda: self.control.findings.ignored(f"FN {number}")
        cure = "write the value that it gives as Q1 = .., or leave it out where nothing comes back"
        given = re.search(r"Q[LR]?[0-9]+(?=\s*=)", rest)

        def refuse() -> None:
            self.control.findings.refused(f"FN {number}", self.control.line, cure)
            if given:
                self.parameters.forget(given[0])

        return refuse

    def alarm(self, text: str) -> Step:
        """FN 14: ERROR = 1000; the control stops with it."""

        def run() -> None:
            self.control.findings.refused(f"FN {ALARM}: {text[:20]}", self.control.line, RAISED)
            self.flow.state.ended = True

        return run

    def jump(self, number: int, text: str) -> Step:
        """FN 9 to 12: IF a EQU b GOTO LBL."""
        condition, _, label = text.partition("GOTO")
        found = _TEST.search(condition)
        name = re.fullmatch(_NAME, label.strip())
        if found is None or name is None or not text.startswith("IF"):
            raise BlockError(f"FN {number} is written IF +Q1 EQU +Q2 GOTO LBL 5: correct it")
        left = formula(condition[len("IF") : found.start()], self.parameters)
        right, test = formula(condition[found.end() :], self.parameters), found[0]

        def run() -> None:
            try:
                a, b = evaluate(left), evaluate(right)
            except UnsetError:
                self.flow.undecided()
                raise
            if (test == "EQU" and a == b) or (test == "NE" and a != b) or (test == "GT" and a > b) or (
                test == "LT" and a < b
            ):  # fmt: skip
                self.flow.jump(self.target(name))

        return run
