"""Cutter radius compensation: G40, G41, G42, G41.1, G42.1."""

from __future__ import annotations

from toolpace.programs.reading.compensation.linuxcnc import LeavingLinuxcnc, LinuxcncStage, Uncompensated
from toolpace.programs.reading.compensation.stage import ACROSS, ARC, AROUND, INSIDE, LINES, OffsetStage, Rules
from toolpace.programs.reading.compensation.tool_centre_path import Departing, Follower, follow, leave
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError
from toolpace.programs.reading.options import PROGRAM, ReadOptions

OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
FORBIDDEN = frozenset(
    (
        *("work offset", "numbered offset", "no offset", "set offset", "local shift", "set position"),
        *("clear position", "suspend position", "restore position", "exact stop mode", "continuous path"),
        *("to initial level", "to R level", "tool length", "told offset", "added offset", "tip mode", "length off"),
        *("tool change", "tool at hand", "reference", "second reference", "machine coordinates"),
        *("cubic spline", "quadratic spline", "nurbs", "save modes", "save modes for return", "restore modes"),
    )
)
"""Meanings that LinuxCNC's interpreter refuses under compensation."""
FORBIDDEN_FUNCTIONS = frozenset((*(f"M{number}" for number in (*range(48, 54), *range(62, 69))),))
"""M48 to M53 and M62 to M68, which it refuses too."""
NO_RADIUS = (
    "cutter compensation needs the tool's radius: write it on the set-up sheet ([tools.N] radius), let the CAM system "
    "compensate and {}, or give --compensation program where the program is the path of the tool's centre"
)
TYPES = {
    "type A": (ACROSS, False),
    "type B": (AROUND, False),
    "type C": (ACROSS, True),
    "type C as B": (AROUND, True),
}
"""How it begins and ends, and whether a block without a motion shifts the tool: parameter 5003#0 and #1 (Fanuc
B-63944EN, "Details of cutter or tool nose radius compensation")."""
ALARM = "the control stops with an alarm (PS0041)"
UNKNOWN_CORNERS = (
    "how this control compensates is not known here: name another with --controller, or let the CAM system compensate"
)
WITHOUT_D = "compensation without D is not read: write the number of the tool whose radius counts, like {} D1"


class Compensation:
    """Carries out the words of compensation."""

    def __init__(self, control: Control, state: Modal, options: ReadOptions, by: Controller) -> None:
        self.control, self.state = control, state
        self.as_programmed = options.compensation == PROGRAM
        self.rs274 = by.option("rs274_checks", False)
        self.by = by.option("compensation", "")
        """Whose rules are followed; "" is refused."""
        self.corners = ARC if by.option("compensation_corners", "lines") == "arcs" else LINES
        self.in_xy = by.option("compensation_in_xy", False)
        self.ends_before_stops = by.option("compensation_ends_before_stops", False)
        self.said = by.option("compensation_said", "")
        self.word = ""
        """G41 or G42, while it is in force, with a radius of zero too."""

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "compensation": self.begin,
            "compensation by diameter": self.begin_by_diameter,
            "compensation off": self.end,
        }

    @property
    def stage(self) -> OffsetStage | None:
        """What compensates now."""
        stage = self.control.stage
        return stage if isinstance(stage, OffsetStage) else None

    def guarded(self, handlers: dict[str, Handler]) -> dict[str, Handler]:
        """The handlers, of which those that a control forbids under compensation look whether it is on."""
        if not self.rs274:
            return handlers
        return handlers | {meaning: self._guarded(handlers[meaning]) for meaning in FORBIDDEN if meaning in handlers}

    def _guarded(self, handler: Handler) -> Handler:
        def guarded(numbers: Numbers, word: str) -> None:
            on_contour = word == "G53" and isinstance(self.control.stage, Uncompensated)
            if not on_contour and not self._of_other_offset(numbers, word):
                self.refuse(word)
            if word == "M6" and isinstance(self.control.stage, LeavingLinuxcnc):
                self.control.stage.ask_machine()
            handler(numbers, word)

        return guarded

    def _of_other_offset(self, numbers: Numbers, word: str) -> bool:
        """Whether G10 sets an offset that is not in force."""
        number = numbers.get("P", 0.0)
        offset = self.control.coordinates.offset or OFFSETS[0]
        return word == "G10" and 1.0 <= number <= len(OFFSETS) and OFFSETS[int(number) - 1] != offset

    def refuse(self, word: str) -> None:
        """Raise BlockError where compensation is on."""
        if self.stage is not None:
            raise BlockError(f"{word} cannot stand under cutter compensation: write G40 before it")

    def begin(self, numbers: Numbers, word: str) -> None:
        """G41, G42: by the radius of the tool of D, or of that in the spindle."""
        number = numbers.pop("D", None)
        if self._as_programmed():
            return
        try:
            self._begin(1 if word == "G41" else -1, self._radius(number, word), word)
        except RefusedError as error:  # the motion of the block is still read
            self.control.refuse(error.word, error.cure)

    def _as_programmed(self) -> bool:
        if self.as_programmed:
            self.control.findings.assumed("what G41 and G42 follow is the programmed contour, as --compensation says")
        return self.as_programmed

    def begin_by_diameter(self, numbers: Numbers, word: str) -> None:
        """G41.1, G42.1: D is the diameter; below zero it is that of the other side."""
        diameter = numbers.pop("D", None)
        if diameter is None:
            raise BlockError(f"{word} needs the diameter of the tool as D: write it like {word} D6")
        if "L" in numbers:
            raise BlockError(f"{word} with L is for turning tools: remove L")
        if self._as_programmed():
            return
        side = 1 if word == "G41.1" else -1
        self._begin(-side if diameter < 0.0 else side, 0.5 * abs(diameter) * self.state.unit, word)

    def _radius(self, number: float | None, word: str) -> float:
        """Of the tool that D names [m]. Raises RefusedError where no radius is told."""
        control = self.control
        if number is not None and (number != int(number) or number < 0.0):
            raise BlockError(f"D{number:g} of {word} is the number of a tool: write a whole one, from 0")
        if not self.rs274 and number is None:
            number = self.state.radius_number
            if number is None:
                raise RefusedError(word, WITHOUT_D.format(word) if self.by else UNKNOWN_CORNERS)
        self.state.radius_number = number
        name = f"{number:g}" if number else control.tool if self.rs274 else ""
        if name in ("", "0"):
            return 0.0
        if number in self.state.programmed_radii:
            raise RefusedError(f"{word} D{number:g}", "G10 tells its radius: write it on the set-up sheet, without G10")
        control.findings.used.tools.setdefault(name)
        found = control.setup.tool(name)
        if found is None and number and self.rs274 and control.setup.tools:
            raise BlockError(f"D{number:g} of {word} is no tool of the set-up sheet: list it there")
        if found is None or found.radius is None:
            raise RefusedError(word, NO_RADIUS.format("remove it" if self.rs274 else "write D0"))
        return found.radius

    def choose(self, number: float) -> None:
        """D without G41 or G42: of the compensation to come. Raises BlockError where it changes the one at hand.

        Fanuc: "the vector at the end point of the block is calculated for the new cutter compensation value", and D0
        cancels (B-63784EN, 14.4.1): which corners there are between two radii is not said.
        """
        before, self.state.radius_number = self.state.radius_number, number
        if self.word and number != before:
            stage = self.stage
            at_hand = 0.0 if stage is None else stage.radius
            try:
                radius = self._radius(number, self.word)
            except RefusedError as error:
                raise BlockError(error.cure) from None
            if radius != at_hand:
                raise BlockError(
                    f"D{number:g} changes the radius from {at_hand * 1e3:.6g} to {radius * 1e3:.6g} mm under "
                    f"{self.word}: write G40 and {self.word} D{number:g}, each with a straight motion"
                )

    def _begin(self, side: int, radius: float, word: str) -> None:
        control, state = self.control, self.state
        if self.stage is not None:
            raise BlockError(f"{word} stands where compensation is on already: remove it, or write G40 before it")
        self.word = "" if self.by == "linuxcnc" else word
        if self.by == "linuxcnc":
            self._begin_linuxcnc(side, radius, word)
        elif radius and self.by not in TYPES:
            raise RefusedError(word, UNKNOWN_CORNERS)
        elif radius and state.plane and self.in_xy:
            raise BlockError(f"{word} compensates in the plane of G17 alone (alarm 344): write G17 before it")
        elif radius:
            ends, shifts = TYPES[self.by]
            rules = Rules(self.corners, ends, INSIDE, shifts=shifts, gouge=ALARM, assumed=self.said)
            follow(control, side, radius, state.plane, rules)

    def _begin_linuxcnc(self, side: int, radius: float, word: str) -> None:
        control, state = self.control, self.state
        if state.plane == 2:
            raise BlockError(f"{word} compensates in the planes of G17 and G18: choose one of them")
        if radius:
            control.begin_here()
            control.stage = LinuxcncStage(control, side, radius, state.plane, state.unit)
        else:
            control.stage = Uncompensated(control, side, radius, state.plane)

    def end(self, numbers: Numbers, word: str) -> None:
        """G40."""
        numbers.pop("D", None)
        self.word = ""
        self.control.findings.ignored(word)
        stage = self.control.stage
        if isinstance(stage, Follower) and numbers.keys() & {"I", "J", "K"}:
            raise BlockError(
                "I, J, K beside G40 tell in which direction the contour would go on, which is not read: write that "
                "element out before G40"
            )
        if isinstance(stage, Follower):
            leave(stage)
        elif isinstance(stage, (LinuxcncStage, Uncompensated)):
            stage.leave()

    def pause(self) -> None:
        """A stop of the program, or its end."""
        stage = self.control.stage
        if self.ends_before_stops and isinstance(stage, Follower):
            raise BlockError(
                "the program stops or ends under compensation (alarm 349): write G40 with a motion in X or Y before it"
            )
        if isinstance(stage, (LinuxcncStage, Uncompensated, Follower)):
            stage.pause()

    def behind_block(self, moves: int) -> None:
        """A block ends, before which there were so many motions."""
        stage = self.control.stage
        if isinstance(stage, (Follower, Departing)):
            stage.behind_block(len(self.control.moves) != moves)
