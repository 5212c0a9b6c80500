"""Commands with arguments: MSG, TRAORI, FGROUP, cycles, references, system variables."""

from __future__ import annotations

import math
from collections.abc import Callable

from toolpace.programs.reading.arcs import ArcError
from toolpace.programs.reading.control.machine_moves import reference
from toolpace.programs.reading.coordinates.affine import IDENTITY
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.cycles.hole_geometry import mill_thread, places
from toolpace.programs.reading.sinumerik.cycles.holes import Holes
from toolpace.programs.reading.sinumerik.cycles.swivel import initial_rotary, swivel
from toolpace.programs.reading.sinumerik.orientation import need_turned, turn_along_tool
from toolpace.programs.reading.sinumerik.run import Run
from toolpace.programs.reading.sinumerik.syntax.values import Axis, Unread, Value, text, whole
from toolpace.programs.reading.sinumerik.word_values import Arguments, Words, number

OLD_MODE = 1000
"""CYCLE832 modes from here on are those of old controls, whose hundreds switch TRAORI."""
TOP_SURFACE = 1_000_000
BOTH = "TRAORI and a plane of CYCLE800 together: the plane stays where it lies on the part"
PRECISION = 4
"""Mode of CYCLE832, the last one; 1 is finishing, 2 semi-finishing, 3 roughing."""
STILL = ("MSG", "FGROUP", "SETMS", "CYCLE832")
"""Commands that may stand beside motion, and change no place."""
MOST_TRANSFORMATIONS = 4
"""Numbers of TRAORI that machines have."""


class Commands:
    """Names that are called, with or without arguments."""

    def __init__(self, run: Run) -> None:
        self.run, self.control, self.state = run, run.control, run.state
        self.holes = Holes(self.control, self.state, strict=run.vocabulary.controller.option("strict_cycles", False))
        self.known: dict[str, Callable[[list[Value | None]], None]] = {
            "MSG": self._message,
            "TRAORI": self._traori,
            "TRAFOOF": lambda values: self.tip_mode(False),
            "ORIRESET": self._initial_orientation,
            "TOROT": self._turn_along_tool,
            "TOROTZ": self._turn_along_tool,
            "TOFRAME": self._frame_along_tool,
            "TOFRAMEZ": self._frame_along_tool,
            "TOROTOF": lambda values: self.run.frames.end_tool_frame("TOROTOF"),
            "PAROTOF": lambda values: self.run.frames.end_tool_frame("PAROTOF"),
            "FGROUP": self._feed_group,
            "SETMS": self._master_spindle,
            "CYCLE800": self._swivel,
            "CYCLE832": self._high_speed,
            "CYCLE90": self._thread,
            "HOLES1": lambda values: self._pattern("HOLES1", values),
            "HOLES2": lambda values: self._pattern("HOLES2", values),
            "CYCLE801": lambda values: self._pattern("CYCLE801", values),
        }
        for name in (*self.holes.cycles, *self.holes.drillings):
            self.known[name] = self._cycle(name)
        self._exact_stop_before: bool | None = None

    def perform(self, name: str, values: list[Value | None]) -> None:
        """Do a command. Raises Unread, BlockError."""
        try:
            if name in STILL:
                self.known[name](values)
            else:
                with self.run.motion.placed(frames=name == "CYCLE800"):
                    self.known[name](values)
        except ArcError as error:
            raise BlockError(f"{name}: {error}") from None

    def _cycle(self, name: str) -> Callable[[list[Value | None]], None]:
        def perform(values: list[Value | None]) -> None:
            need_turned(self.control, self.run.frames)
            self.holes.perform(name, values)

        return perform

    def _master_spindle(self, values: list[Value | None]) -> None:
        """SETMS(3), or SETMS for that of the machine's data."""
        self.run.tooling.master_spindle = 1 if not values or values[0] is None else whole(values[0])

    def _message(self, values: list[Value | None]) -> None:
        said = text(values[0]).strip() if values and values[0] is not None else ""
        self.run.findings.ignored("MSG")
        if said:
            self.control.operations.begin(name=said)

    def _traori(self, values: list[Value | None]) -> None:
        """TRAORI(n, x, y, z, A, B): the number of the transformation, the direction of the tool when the rotary axes
        are at zero, and offsets of these (Job Planning, "Orientation transformation TRAORI")."""
        arguments = Arguments("TRAORI", values, 6)
        number = arguments.code(0, 1)
        if not 1 <= number <= MOST_TRANSFORMATIONS:
            raise BlockError(f"TRAORI({number}): transformations are numbered from 1: write TRAORI(1)")
        if number > 1:
            self.control.findings.assumed(f"TRAORI({number}) is the transformation of the machine, as TRAORI(1) is")
        x, y, z = (arguments.number(place) for place in (1, 2, 3))
        if x or y or z < 0.0:
            raise Unread("TRAORI with another direction of the tool than Z", "write TRAORI alone, and G17")
        if arguments.number(4) or arguments.number(5):
            raise Unread("TRAORI with offsets of the rotary axes", "put them on the set-up sheet ([machine_zero])")
        self.tip_mode(True)

    def tip_mode(self, on: bool) -> None:
        """TRAORI, TRAFOOF: the machine stays where it is, and the frames in force stay (posts count on it)."""
        coordinates, state = self.control.coordinates, self.state
        if on != coordinates.tip_mode:
            for fault, cure in (
                (state.motion == "BSPLINE", "a spline (alarm 14402): write G1 before"),
                (state.compensation != "G40", "G41 or G42 (alarm 14400): write G40 before"),
            ):
                if fault:
                    raise BlockError(f"TRAORI and TRAFOOF under {cure}")
        if on and not coordinates.tip_mode and self.run.frames.tilted:
            self.control.findings.assumed(BOTH)
        elif on and not coordinates.tip_mode and (self.run.frames.offset or coordinates.frame != IDENTITY):
            self.control.findings.assumed("TRAORI keeps the offset and the frame in force (MD10602)")
        with self.run.motion.placed(frames=True):
            self.control.set_tip_mode(on)

    def _initial_orientation(self, values: list[Value | None]) -> None:
        """ORIRESET(first, second): the rotary axes to these positions, or to zero, whatever frames shift them."""
        if not self.control.coordinates.tip_mode:
            raise BlockError("ORIRESET needs TRAORI (alarm 14101): switch it on before")
        wanted = initial_rotary(self.control, Arguments("ORIRESET", values, 3))
        self.control.straight([*self.control.words[:3], *wanted], 0, rapid=self.state.motion == "G0")

    def _turn_along_tool(self, values: list[Value | None], *, bound: bool = False) -> None:
        rule = self.run.vocabulary.controller.option("toframe_mode", "2000")
        turn_along_tool(self.control, self.run.frames, self.state, rule, bound=bound)

    def _frame_along_tool(self, values: list[Value | None]) -> None:
        """TOFRAME: as TOROT, but that it takes the programmed frame's place (Programming Manual Fundamentals, 12.8)."""
        frames = self.run.frames
        if frames.tilted or frames.tool != IDENTITY or frames.programmed() != IDENTITY or frames.turns_words:
            raise Unread("TOFRAME upon another frame", "whether its shift stays is not sure: write TOROT")
        self.control.findings.assumed("TOFRAME turns the coordinates about their origin, as TOROT does")
        self._turn_along_tool(values, bound=True)

    def _feed_group(self, values: list[Value | None]) -> None:
        rotary = [value for value in values if isinstance(value, Axis) and value.letter not in ("X", "Y", "Z")]
        feed = self.control.feed
        feed.rules = feed.rules._replace(turning="vector" if rotary else "xyz")
        self.run.findings.ignored("FGROUP")

    def _swivel(self, values: list[Value | None]) -> None:
        if self.control.coordinates.tip_mode and values:
            self.control.findings.assumed(BOTH)
        swivel(values, self.control, self.run.frames, self.state)

    def _high_speed(self, values: list[Value | None]) -> None:
        """CYCLE832(tolerance, mode, ...): it asks for a tolerance, and for blending unless the mode is 0 (off)."""
        arguments = Arguments("CYCLE832", values, 24)
        mode = arguments.code(1) % TOP_SURFACE
        self.control.findings.ignored("CYCLE832")
        off = not values or mode % 10 == 0
        turning = mode // 10 % 10 > 0
        self.control.moves.ask(
            tip=0.0 if off else arguments.number(0) * self.state.unit,
            axis=math.radians(arguments.number(2)) if turning and not off else 0.0,
        )
        # the cycle switches SOFT, roundings and the limits of its mode on (Cycles, CYCLE832)
        named = {} if off else {"brisk": 0.0, "rounded": 1.0}
        self.control.moves.drive(mode=float(mode % 10 if mode % 10 <= PRECISION else 0), **named)
        if off:
            if self._exact_stop_before is not None:
                self.state.exact_stop, self._exact_stop_before = self._exact_stop_before, None
            return
        if self.state.exact_stop:
            self.control.findings.assumed("CYCLE832 switches blending on (G64x), and off what it was before")
            self._exact_stop_before = True
            self.state.exact_stop = False
        if mode >= OLD_MODE and mode // 100 % 10 in (1, 2):
            self.control.findings.assumed("CYCLE832 with 1 or 2 in the hundreds of its mode switches TRAORI on")
            self.tip_mode(True)

    def _thread(self, values: list[Value | None]) -> None:
        need_turned(self.control, self.run.frames)
        if self.run.tooling.edge == 0:
            raise BlockError("CYCLE90 reckons with the radius of the tool, and D0 with none (alarm 61000): write D1")
        # the cycle compensates itself, whatever path G41 follows
        tool = self.control.setup.tool(self.control.tool)
        mill_thread(values, self.control, self.state, None if tool is None else tool.radius)

    def _pattern(self, name: str, values: list[Value | None]) -> None:
        modal = self.run.modal
        need_turned(self.control, self.run.frames)
        if modal is not None and modal[0].name not in self.known:
            raise Unread(f"{name} with a subprogram under MCALL", "write the places as blocks of their own")
        if name == "CYCLE801":
            self.run.findings.assumed("CYCLE801 goes from the nearer corner along the shorter distance, there and back")
        for words in places(name, values, self.control, self.state):
            self.control.straight(words, 7, rapid=True)
            if modal is not None:
                self.perform(modal[0].name, modal[1])

    def reference(self, code: str, words: Words) -> None:
        """G74 X1=0: the reference point; G75 FP=n X1=0: a fixed point, the n + 1st of the set-up sheet."""
        if self.control.coordinates.tip_mode:
            raise Unread(f"{code} under TRAORI", "controls go there without a transformation: write TRAFOOF before")
        fixed = round(number(words, "FP", 1.0) or 1.0) if code == "G75" else 0
        letters = []
        for address in list(words):
            letter = Axis(address).letter
            if letter in self.control.slots:
                letters.append(letter)
                words.pop(address)
        if fixed:
            self.control.findings.assumed("fixed points (G75 FP=n) are the reference points n + 1 of the set-up sheet")
        reference(self.control, fixed + 1, letters)

    def write(self, name: str, index: tuple[Value, ...], value: Value) -> None:
        """$NAME[index]=value. Raises Unread."""
        writes = {"$P_UIFR": self.run.frames.write, "$P_PFRAME": self.run.frames.write_programmed}
        if name in writes:
            unit = self.state.unit_of_control()
            if isinstance(value, tuple) and unit != self.state.unit:
                raise Unread(f"{name}= in another unit than the control's", "of which its lengths are is not told: G71")
            writes[name](index, value, unit)
            return
        raise Unread(f"{name}=", "it sets data of the control that may shift positions: put them on the set-up sheet")
