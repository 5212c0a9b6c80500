"""The reader of cutter-location data, and the operations that its statements begin."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from toolpace.programs.reading.cldata.motion import PARTS, ClCurves, ClMotion
from toolpace.programs.reading.cldata.state import SYSTEMS, ClFeed, ClFrame
from toolpace.programs.reading.cldata.tools import tool_shape
from toolpace.programs.reading.cldata.track import Track
from toolpace.programs.reading.cldata.words import (
    CANCELLABLE,
    DATA,
    ENDS,
    FRAMES,
    NOTE,
    NUMBER,
    PASSED,
    PASSED_BUT_SAID,
    STOPS,
    TOOLS,
    Statement,
    cure,
    statements,
    without_cards,
)
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import PROGRAM, ReadOptions
from toolpace.programs.reading.points import ToolLengths
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import Operation, ToolPath

_NAME = re.compile(r"OPERATION NAME\s*+:(.*)", re.IGNORECASE)
CHANGE = "a tool change is a stop; the machine's own motion in it is left out"
_REMARK = re.compile(r"[/\s]*(?:\[HOLDER=|STOCK SIZE\b)")
"""What SolidWorks CAM tells of tools and stock, which no control reads as code."""
_HARMLESS = re.compile(r"(?:\([^()]*+\)|[NST][0-9]++|M(?!9[789])[0-9]{1,2}(?![0-9])|;.*|[\s/%$])*+")
"""Code of the control that moves nothing: comments, numbers of blocks, spindle and tools, M but calls."""
END_OF_PATH = "END-OF-PATH"
_END_OF_CIRCLE = frozenset(("GOTO", "GODLTA"))


class ClOperations:
    """TOOL PATH and LOADTL, and what NX, Creo and CATIA write in their place."""

    def __init__(self, motion: ClMotion, lengths: ToolLengths) -> None:
        self.motion, self.track, self.lengths = motion, motion.track, lengths
        self._tool_named = False
        """Whether TOOL PATH named the tool: a number that is loaded then is the same tool's."""
        self._loaded = ""

    def tool_path(self, statement: Statement) -> None:
        """TOOL PATH/name,TOOL,tool: begins an operation, and stops where it takes another tool."""
        words = [word.strip() for word in statement.text.split(",")]
        at = next((i for i, word in enumerate(words) if word.upper() == "TOOL"), len(words))
        name, tool = ",".join(words[:at]), ",".join(words[at + 1 :])
        if tool != self.track.operation.tool and self.track.points:
            self.motion.findings.assumed(CHANGE)
            self.track.stop()
        self._tool_named, self._loaded = tool != "", ""
        self.motion.begin_operation()
        self.motion.frame.centre_line = False
        self.track.begin(Operation(name, tool), always=True)

    def load(self, statement: Statement) -> None:
        """LOADTL/3, LOAD/TOOL,3: the tool of what follows; the stop is the reader's."""
        words = [word for word in statement.minors if word != "TOOL"]
        tool = next((word for word in words if NUMBER.fullmatch(word)), words[0] if words else "")
        changed, self._loaded = tool != self._loaded, tool
        if not tool or not changed:
            return
        current, begins = self.track.operation, self.track.begins
        if not begins:
            self.motion.findings.assumed(CHANGE)
            self.motion.drilling.end()
            self._tool_named = False
        if not self._tool_named or (self.lengths.lists(tool) and not self.lengths.lists(current.tool)):
            # what is told of a tool before it is loaded is told of this one
            self.track.begin(replace(current, tool=tool, figures=current.figures if begins else None))

    def shape(self, statement: Statement) -> None:
        """TLDATA, CUTTER: the shape of the tool of what follows."""
        self.motion.findings.ignored(statement.major)
        figures = tool_shape(statement, self.motion.frame.unit, self.track.source.name, self.motion.findings)
        if figures is not None:
            self.track.begin(replace(self.track.operation, figures=figures))

    def feature(self, statement: Statement) -> None:
        """`$$-> FEATNO / 31` of Creo: a sequence of its own."""
        self._named(f"FEATNO {statement.text.strip()}")

    def note(self, statement: Statement) -> None:
        """`$$ OPERATION NAME : drilling` of CATIA."""
        match = _NAME.match(statement.text)
        if match is not None:
            self._named(match[1].strip())

    def _named(self, name: str) -> None:
        self.track.begin(replace(self.track.operation, name=name))


class ClReader:
    """One reading of one program; `run` does it. Points are tips in the workpiece frame: a machine tells no more than
    the length of tools that are not on the set-up sheet.

    What is refused is noted in `findings`, and the reading goes on, so that one run names all of it; with
    `skip_unknown` it is left out, and said.
    """

    def __init__(self, source: Source, machine: Kinematics | None, options: ReadOptions, findings: Findings) -> None:
        self.source, self.options, self.findings = source, options, findings
        self.lengths = ToolLengths(source, options.setup, machine, findings)
        self.track = Track(source)
        self.frame = ClFrame(source, self.findings, options.compensation == PROGRAM)
        self.feed = ClFeed(source, options.default_feed, self.findings)
        self.motion = ClMotion(source, self.track, self.feed, self.frame, self.findings)
        self.curves = ClCurves(source, self.motion, self.findings)
        self.operations = ClOperations(self.motion, self.lengths)
        self.moves: dict[str, Callable[[Statement], None]] = {
            "GOTO": self.motion.goto,
            "GODLTA": self.motion.increment,
            "FROM": self.motion.start,
            "GOHOME": self.motion.home,
            "CIRCLE": self.curves.circle,
            "GOFWD": self.curves.drive,
            "TLON,GOFWD": self.curves.drive,
            "NURBS": self.curves.nurbs,
            "FNURBS": self.curves.nurbs,
            "CYCLE": self._cycle,
            "TOOL PATH": self.operations.tool_path,
        }
        self.states: dict[str, Callable[[Statement], None]] = {
            **dict.fromkeys(PASSED, self._passed),
            **dict.fromkeys(STOPS, self._stop),
            **dict.fromkeys(SYSTEMS, self._system),
            **dict.fromkeys(CANCELLABLE | FRAMES, self.frame.shift),
            **dict.fromkeys(PARTS, self.curves.part),
            "CUTCOM": self.frame.cutcom,
            "INDIRV": self.curves.direction,
            "MOVNRB": self.curves.points_of_spline,
            "TLAXIS": self.motion.tool_axis,
            "TLDATA": self.operations.shape,
            "CUTTER": self.operations.shape,
            "RAPID": self._rapid,
            "FEDRAT": self._fedrat,
            "DELAY": self._delay,
            "UNITS": self.frame.units,
            "UNIT": self.frame.units,
            "INSERT": self._insert,
            f"{DATA}CUTCOM_GEOMETRY_TYPE": self.frame.geometry,
            f"{DATA}FEATNO": self.operations.feature,
        }

    def run(self) -> ToolPath:
        """Execute every statement, then lay out the points of curves."""
        lines, cards = without_cards(self.source.lines)
        if cards:
            self.findings.assumed("columns 73 to 80 are taken for sequence numbers")
        count, major = 0, ""
        for statement in statements(self.source, lines):
            major = statement.major
            if major == NOTE:
                self._note(statement)
                continue
            count += 1
            if major not in PARTS:
                self.curves.end()
            if major in ENDS:
                break
            self._execute(statement)
        if major not in (*ENDS, END_OF_PATH) and not self.source.last_line_ended:
            self.findings.assumed("the file is whole, though neither FINI nor END-OF-PATH nor a line end closes it")
        self.curves.end()
        self._refuse_open_circle()
        self.findings.raise_if_refused(self.source, self.options.skip_unknown)
        return self.track.toolpath(count, self.lengths)

    def _execute(self, statement: Statement) -> None:
        major = statement.major
        move = self.moves.get(major)
        if move is not None:
            if major not in _END_OF_CIRCLE:
                self._refuse_open_circle()
            move(statement)
        elif major in self.states:
            self.states[major](statement)
        elif not major.startswith(DATA):
            self.findings.refused(major[:40], statement.line, cure(major))

    def _refuse_open_circle(self) -> None:
        if self.motion.circle is not None:
            line = self.motion.circle.line
            self.source.fail("CIRCLE is not followed by the GOTO to its end: the program is cut off", line)

    def _cycle(self, statement: Statement) -> None:
        self.motion.drilling.cycle(statement, self.frame.unit)

    def _rapid(self, statement: Statement) -> None:
        self.motion.rapid = True

    def _fedrat(self, statement: Statement) -> None:
        self.feed.set(statement, self.frame.unit)

    def _delay(self, statement: Statement) -> None:
        self.track.stop(self.feed.delay(statement))

    def _system(self, statement: Statement) -> None:
        self.frame.system(statement, self.track.points > 0)

    def _note(self, statement: Statement) -> None:
        self.frame.note(statement, self.track.points > 0)
        self.operations.note(statement)

    def _stop(self, statement: Statement) -> None:
        self.feed.spindle(statement)
        self.track.spindle = self.feed.signed_revolutions
        self.track.stop()
        if statement.major in TOOLS:
            self.operations.load(statement)

    def _insert(self, statement: Statement) -> None:
        """Code of the control within the program: a stop where none of its words moves anything."""
        if _REMARK.match(statement.text.upper()):
            self.findings.ignored("INSERT")
        elif _HARMLESS.fullmatch(statement.text.upper()):
            self.findings.assumed("INSERT of code without G words and axis words moves nothing")
            self.findings.ignored("INSERT")
            self.track.stop()
        else:
            self.findings.refused("INSERT", statement.line, cure("INSERT"))

    def _passed(self, statement: Statement) -> None:
        major = statement.major
        if major in ("MODE", "SET") and "INCR" in statement.minors:
            self.findings.refused(f"{major}/INCR", statement.line, cure(major))
            return
        if major == END_OF_PATH:
            self.motion.drilling.end()
        if major in PASSED_BUT_SAID and statement.minors != ["OFF"]:
            self.findings.assumed(PASSED_BUT_SAID[major])
        self.findings.ignored(major)
