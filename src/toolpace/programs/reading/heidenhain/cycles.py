"""CYCL DEF: cycles that act at once, and those that wait for a call."""

from __future__ import annotations

import re
from collections.abc import Callable

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Step
from toolpace.programs.reading.heidenhain.drilling import Holes, Items
from toolpace.programs.reading.heidenhain.frames import Frames
from toolpace.programs.reading.heidenhain.parameters import Parameters, Value, evaluate
from toolpace.programs.reading.heidenhain.patterns import Patterns
from toolpace.programs.reading.heidenhain.tilting import MOST_ANGLE, Tilting
from toolpace.programs.reading.heidenhain.words import VALUE, signed

_HEAD = re.compile(r"([0-9]+)(?:\.([0-9]+))?(?![0-9])")
_ITEM = re.compile(r"Q([0-9]+)\s*=\s*(?:((?:F\s*)?(?:MAX|AUTO)|PREDEF)|(" + VALUE + "))")
FEEDS = {"MAX": "FMAX", "AUTO": "FAUTO"}
"""Feeds as controls write them into programs, and as manuals name them."""
_AXIS = re.compile(r"(CC|I?)([A-CU-Z])\s*(" + VALUE + ")")
_FIGURE = re.compile(r"(?:[^-+0-9,.Q]|\.(?![0-9]))*+(" + VALUE + r")\s*+")
OLD_PECKING = {1: 200, 2: 201, 3: 202, 4: 211, 5: 206}
"""Lines of cycle 1 to the parameters of cycle 200 that mean the same."""
ORIENTATION = 13
LONGEST_DWELL = 3600.0
"""[s] (TNC 640, "Input format and unit of TNC functions")."""
LINES = ("7", "8", "9", "10", "11", "19", "26", "32")
"""Cycles that are written in lines 7.0, 7.1, ... and act at once."""
PLANE_STAYS = "a preset that comes in force in a tilted plane leaves the plane in force, about the new preset"
PREDEF = "PREDEF"
ONE_LINE = ("8", "10", "11")
"""Those of one line behind their title; a second one would take the place of the first."""
CURE = "export this operation as motions (L and C blocks), or drill with cycles 200 to 207, 240 and 241"


class Cycles:
    """Compiles CYCL DEF."""

    def __init__(
        self,
        control: Control,
        frames: Frames,
        tilting: Tilting,
        holes: Holes,
        patterns: Patterns,
        parameters: Parameters,
        controller: Controller,
    ) -> None:
        self.control, self.frames, self.tilting, self.holes = control, frames, tilting, holes
        self.patterns, self.parameters = patterns, parameters
        self.controller = controller
        self.axial = controller.option("cycle_19_angles", "spatial") == "axes"
        self.in_plane = controller.option("cycle_11_axes", "all") == "plane"
        self.state = tilting.machine.state
        self.general: Items = {}
        """Values of GLOBAL DEF by number."""
        self.takes_general = False
        """Whether the last cycle that was defined took any of them."""
        self.lines: dict[str, Callable[[str], Step]] = {
            "7": self.shift,
            "8": self.mirror,
            "9": self.dwell,
            "10": self.rotate,
            "11": self.scale,
            "19": self.tilt,
            "26": self.scale_axes,
            "32": self.tolerance,
        }

    def compile(self, text: str) -> Step:
        """What stands behind CYCL DEF. Raises BlockError."""
        head = _HEAD.match(text)
        if head is None:
            raise BlockError("CYCL DEF needs the number of its cycle: write one")
        number, line, rest = head[1], int(head[2] or 0), text[head.end() :]
        findings = self.control.findings
        if number in self.lines:
            if line > 1 and number in ONE_LINE:
                raise BlockError(f"CYCL DEF {number} has one line of figures, {number}.1: write all of them there")
            # the title of cycle 19 resets nothing: its angles do
            return self.lines[number](rest) if line else (lambda: None)
        if number == "1":
            return self.old_pecking(line, rest)
        if int(number) == ORIENTATION:
            return lambda: findings.ignored("CYCL DEF 13")
        if f"CYCL DEF {number}" in self.controller.ignored:
            return lambda: findings.ignored(f"CYCL DEF {number}")
        items = self.items(rest)
        if int(number) in self.holes.makers:
            return lambda: self.holes.define(int(number), self.evaluated(items))
        if number in ("220", "221"):
            pattern = self.patterns.circle if number == "220" else self.patterns.grid
            return lambda: pattern(self.evaluated(items))
        if number == "247":
            return lambda: self.preset(self.evaluated(items))
        return lambda: self.refused(number)

    def refused(self, number: str) -> None:
        """A cycle that is not read; nor are its calls."""
        self.control.refuse(f"CYCL DEF {number}", CURE)
        self.holes.define(-1, {})

    def items(self, text: str) -> dict[int, Value | str]:
        """Q parameters of a cycle. Raises BlockError where something else stands behind its title."""
        found: dict[int, Value | str] = {}
        first = _ITEM.search(text)
        rest = _ITEM.sub("", text[first.start() :]).strip() if first else ""
        if rest:
            raise BlockError(f"'{rest[:20]}' is not read in CYCL DEF: does a ~ stand in front of it by mistake?")
        for number, word, value in _ITEM.findall(text):
            joined = "".join(word.split())
            found[int(number)] = FEEDS.get(joined, joined) if word else signed(value, self.parameters)
        return found

    def evaluated(self, items: dict[int, Value | str]) -> Items:
        """Their figures as they are now; the control keeps them in the parameters of their names. PREDEF is the one of
        GLOBAL DEF. Raises BlockError, UnsetError."""
        found: Items = {}
        self.takes_general = PREDEF in items.values()
        for number, item in items.items():
            value = self.general.get(number) if item == PREDEF else item
            if value is None:
                raise BlockError(f"Q{number}=PREDEF takes the value of GLOBAL DEF, which tells none: write it there")
            found[number] = value if isinstance(value, str) else evaluate(value)
            figure = found[number]
            if isinstance(figure, float):
                self.parameters.set(f"Q{number}", figure)
        return found

    def define_general(self, text: str) -> Step:
        """GLOBAL DEF 100 to 125: values that cycles take by PREDEF. Raises BlockError."""
        head = _HEAD.match(text.removeprefix("DEF").strip())
        if not text.startswith("DEF") or head is None:
            raise BlockError("GLOBAL is followed by DEF and a number: write GLOBAL DEF 100")
        items = self.items(text.removeprefix("DEF").strip()[head.end() :])

        def run() -> None:
            if self.takes_general:
                cure = "write it before CYCL DEF: whether the cycle takes the new values is not read"
                self.control.refuse("GLOBAL DEF behind a cycle with PREDEF", cure)
            self.general |= {q: value if isinstance(value, str) else evaluate(value) for q, value in items.items()}

        return run

    def preset(self, items: Items, *, keeps: bool = False) -> None:
        """247: a preset of the table; shifts and turns of the program end with it, but where it keeps them."""
        number = items.get(339)
        if not isinstance(number, float):
            raise BlockError("CYCL DEF 247 lacks Q339, the number of the preset: write it")
        if self.frames.plane is not None:
            self.control.findings.assumed(PLANE_STAYS)
        if not keeps:
            self.frames.new_preset()
        self.control.set_offset(f"{number:g}")
        self.tilting.machine.check_preset()

    def old_pecking(self, line: int, text: str) -> Step:
        """1: a line for each figure."""
        if line == 0:
            return lambda: self.holes.define(1, {})
        key, value = OLD_PECKING.get(line), self.figure(text, "PECKING", "DEPTH -20")
        if key is None:
            raise BlockError(f"CYCL DEF 1 has no line 1.{line}: correct it")
        return lambda: self.holes.amend({key: evaluate(value)})

    # Cycles in lines

    def figure(self, text: str, name: str, example: str) -> Value:
        """The only figure of a line. Raises BlockError."""
        found = _FIGURE.fullmatch(text)
        if found is None:
            raise BlockError(f"{name} has one figure: write it like {example}")
        return signed(found[1], self.parameters)

    def axes(self, text: str) -> list[tuple[str, str, Value]]:
        """Mark (CC, I or none), letter and value of each axis. Raises BlockError where something else is there."""
        if rest := _AXIS.sub("", text).strip():
            raise BlockError(f"'{rest[:20]}' is not read here: write axes with their values")
        return [(mark, letter, signed(value, self.parameters)) for mark, letter, value in _AXIS.findall(text)]

    def by_letter(self, axes: list[tuple[str, str, Value]]) -> dict[str, tuple[float, bool]]:
        """Values in metres and radians as they are now, and whether they add."""
        unit = self.state.unit
        return {
            letter: (evaluate(value) * (unit if letter in "XYZ" else DEGREE), mark == "I")
            for mark, letter, value in axes
        }

    def shift(self, text: str) -> Step:
        """7: datum shift."""
        if "#" in text:
            cure = "write the shift of each axis in place of the number in the datum table"
            return lambda: self.control.refuse("CYCL DEF 7 #", cure)
        axes = self.axes(text)
        return lambda: self.frames.shift(self.by_letter(axes))

    def mirror(self, text: str) -> Step:
        """8: mirror; without an axis not at all."""
        letters = "".join(text.replace(",", " ").split())
        if letters.strip("ABCXYZ"):
            raise BlockError(f"'{letters[:20]}' is not read in a mirror: write the letters of its axes")
        return lambda: self.frames.mirror(letters)

    def dwell(self, text: str) -> Step:
        """9: seconds."""
        value = self.figure(text, "CYCL DEF 9.1", "DWELL 2")

        def run() -> None:
            seconds = evaluate(value)
            if not 0.0 <= seconds <= LONGEST_DWELL:
                raise BlockError(f"a dwell of {seconds:g} s is not between 0 and {LONGEST_DWELL:g}: correct it")
            self.control.dwell(seconds)

        return run

    def rotate(self, text: str) -> Step:
        """10: turn in the plane."""
        value, adds = self.figure(text, "CYCL DEF 10.1", "ROT+30"), "IROT" in text

        def run() -> None:
            angle = evaluate(value)
            if abs(angle) > MOST_ANGLE:
                raise BlockError(f"a rotation by {angle:g} is not between -360 and 360: correct it")
            self.frames.rotate(self.state.tool_axis, angle * DEGREE, adds)

        return run

    def scale(self, text: str) -> Step:
        """11: one factor for all axes."""
        value = self.figure(text, "CYCL DEF 11.1", "SCL 0.99")

        def run() -> None:
            by = [self.factor(evaluate(value))] * 3
            if self.in_plane:
                by[self.state.tool_axis] = 1.0
            if by != [1.0] * 3:
                axes = "the axes of the working plane" if self.in_plane else "X, Y and Z"
                self.control.findings.assumed(f"CYCL DEF 11 scales {axes} (option cycle_11_axes; MP7410 of iTNC 530)")
            self.frames.scale(by)

        return run

    def scale_axes(self, text: str) -> Step:
        """26: a factor for each axis, about a centre."""
        axes = self.axes(text)

        def run() -> None:
            by, centre, named = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0], set()
            for mark, letter, value in axes:
                slot = "XYZ".find(letter)
                if slot < 0:
                    raise BlockError("CYCL DEF 26 scales X, Y and Z only: remove the other axis")
                if mark == "CC":
                    centre[slot] = evaluate(value) * self.state.unit
                else:
                    by[slot] = self.factor(evaluate(value))
                    named.add(slot)
            if any(slot not in named for slot in self.frames.scaled()):
                cure = "name each axis that is scaled, with the factor 1 where that is to end"
                self.control.refuse("CYCL DEF 26 without an axis that is scaled", cure)
            self.frames.scale(by, centre)

        return run

    def factor(self, value: float) -> float:
        """A factor of scale. Raises BlockError."""
        if not 1e-6 <= value <= 99.999999:
            raise BlockError(f"a scale of {value:g} is not between 0.000001 and 99.999999: correct it")
        return value

    def tilt(self, text: str) -> Step:
        """19: tilted plane."""
        if "ABST" in text or "DIST" in text or "SETUP" in text or re.search(r"F\s*[0-9]", text):
            cure = "write PLANE SPATIAL .. TURN, or position A, B, C by Q120 to Q122 in a block of its own"
            return lambda: self.control.refuse("CYCL DEF 19 with a feed", cure)
        axes = self.axes(text)
        return lambda: self.tilting.cycle_19({x: evaluate(value) for _, x, value in axes}, axial=self.axial)

    def tolerance(self, text: str) -> Step:
        """32: T of the tip, TA of the rotary axes; a line 32.1 without T ends both. Noted, and obeyed where asked."""
        named = [
            (name, signed(found[1], self.parameters))
            for name, letters in (("tip", "T"), ("axis", "TA"))
            if (found := re.search(rf"(?<![A-Z]){letters}\s*(" + VALUE + ")", text))
        ]

        def note() -> None:
            self.control.findings.ignored("CYCL DEF 32")
            units = {"tip": self.state.unit, "axis": DEGREE}
            values = {name: evaluate(value) * units[name] for name, value in named}
            if values or not text.strip():
                self.control.moves.ask(**(values or {"tip": 0.0, "axis": 0.0}))

        return note
