"""Drilling cycles: strokes from the Q parameters of a CYCL DEF."""

from __future__ import annotations

import math
from collections.abc import Callable

from toolpace.common.units import DEGREE, MINUTE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import FEED_OUT, RAPID_OUT, Drilling, drill
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.state import State

Items = dict[int, float | str]
"""Q parameters of a cycle by number; feeds may be FMAX or FAUTO."""
BREAK = 0.2
"""How far a chip is broken back where a cycle does not say [mm]."""
FROM_ZERO = frozenset((200, 202, 204, 205, 210, 211, 212, 213, 256, 257, 258, 259, 379))
"""Parameters of drilling cycles whose input begins at zero ("Input range 0 to 99999.9999")."""
OLD = 1
"""The cycle that counts from where the tool is."""


class Refusal(Exception):
    """A form of a cycle that is not read: word and cure."""


class Holes:
    """The cycle that is defined, and its calls."""

    def __init__(self, control: Control, state: State) -> None:
        self.control, self.state = control, state
        self.number = 0
        """Of the cycle in force; 0: none, -1: one that was refused."""
        self.items: Items = {}
        self._made: tuple[tuple[object, ...], Drilling] | None = None
        """Its strokes where it was called last, and what changes them from call to call."""
        self.makers: dict[int, Callable[[], Drilling]] = {
            OLD: self.old_pecking,
            200: self.drilling,
            201: self.reaming,
            202: self.boring,
            203: self.universal,
            205: self.deep,
            206: self.tapping,
            207: self.tapping,
            209: self.tapping,
            240: self.centring,
            241: self.single_lip,
        }

    def define(self, number: int, items: Items) -> None:
        """Keep a cycle until the next one; it runs where it is called."""
        self.number, self.items, self._made = number, items, None
        self.state.calls_everywhere = False

    def amend(self, items: Items) -> None:
        """Change some of its parameters."""
        self.items, self._made = {**self.items, **items}, None

    def call(
        self,
        at: list[float] | None = None,
        *,
        lift: float = 0.0,
        low: bool = False,
        least_back: float = -math.inf,
    ) -> None:
        """Drill here, or at words `at` (3 + rotary). Raises BlockError.

        lift: how much higher the surface is there [m]. low: end at the set-up clearance, not at the second one.
        least_back: the height [m] at which it ends where that is higher.
        """
        if self.number < 0:
            return
        if not self.number:
            raise BlockError("no cycle is defined here: write CYCL DEF before its call")
        try:
            made = self._drilling()
        except Refusal as refusal:
            word, cure = refusal.args
            self.control.refuse(word, cure)
            return
        made = made._replace(
            axis=self.state.tool_axis,
            top=made.top + lift,
            bottom=made.bottom + lift,
            start=None if made.start is None else made.start + lift,
            back=max((made.top if low else made.back) + lift, least_back),
        )
        if made.top != made.bottom:
            self.state.came_from = []
            speed = self.speed(206)
            with self.control.feed.held(speed, speed / self.state.feed_unit * DEGREE):
                drill(self.control, made, list(self.control.words if at is None else at))

    def clearance(self) -> float:
        """The height of the set-up clearance [m]; of a cycle that is not read the lowest of all."""
        try:
            return self._drilling().top if self.number > 0 else -math.inf
        except Refusal:
            return -math.inf

    def _drilling(self) -> Drilling:
        state, control = self.state, self.control
        of = (control.feed.spindle, state.tool_feed, control.words[state.tool_axis] if self.number == OLD else None)
        if self._made is None or self._made[0] != of:
            self._made = of, self.makers[self.number]()
        return self._made[1]

    # Figures

    def value(self, q: int, default: float | None = None) -> float:
        """A figure of the cycle. Raises BlockError where it is missing or no number."""
        found = self.items.get(q, default)
        if found is None:
            raise BlockError(f"CYCL DEF {self.number} lacks Q{q}: write all of its parameters")
        if isinstance(found, str):
            raise BlockError(f"Q{q}={found} of CYCL DEF {self.number} must be a number")
        if found < 0.0 and q in FROM_ZERO and self.number != OLD:
            raise BlockError(f"Q{q} of CYCL DEF {self.number} is {found:g}, and its least is zero: correct it")
        return found

    def length(self, q: int, default: float | None = None) -> float:
        """A length of the cycle [m]."""
        return self.value(q, default) * self.state.unit

    def seconds(self, q: int) -> float:
        """A dwell of the cycle [s]."""
        return max(self.value(q, 0.0), 0.0)

    def speed(self, q: int) -> float:
        """A feed of the cycle [m/s]; FAUTO is the F of TOOL CALL; for tapping, spindle speed times pitch."""
        if q == 206 and self.number in (207, 209):
            spindle = self.control.feed.spindle
            if spindle <= 0.0:
                raise BlockError("tapping needs the spindle speed: write S in TOOL CALL")
            if not self.value(239):
                raise BlockError(f"Q239 of CYCL DEF {self.number}, the pitch, is zero: write it")
            return spindle * abs(self.length(239))
        found = self.items.get(q)
        if found == "FAUTO":
            found = self.state.tool_feed
            if found is None:
                raise BlockError(f"Q{q} takes the F of TOOL CALL (FAUTO), which has none: write one there, or here")
        number = found if isinstance(found, float) else self.value(q)
        if not 0.0 < number <= 1e9:
            raise BlockError(f"Q{q} of CYCL DEF {self.number} is a feed and must be above zero: correct it")
        return number * self.state.feed_unit / MINUTE

    def hole(self) -> Drilling:
        """The levels that all cycles have."""
        surface, depth = self.length(203), self.length(201)
        top = surface + self.length(200)
        if depth > 0.0:
            raise Refusal(
                f"CYCL DEF {self.number} with Q201 above zero", "the depth is below the surface: write Q201 < 0"
            )
        if self.value(395, 0.0):
            raise Refusal(f"CYCL DEF {self.number} with Q395=1", "write the depth of the tip, with Q395=0")
        bottom = surface + depth if depth else top
        return Drilling(top, bottom, max(top, surface + self.length(204, 0.0)), dwell=self.seconds(211))

    def way_out(self, hole: Drilling) -> Drilling:
        """Out at Q208; at Q206 where that is zero, at rapid where it is FMAX or missing."""
        out = self.items.get(208, "FMAX")
        if out == "FMAX":
            return hole._replace(out=RAPID_OUT)
        return hole._replace(out=FEED_OUT, out_speed=self.speed(208) if out else 0.0)

    def pecked(self) -> Drilling:
        """A hole of pecks of Q202, which counts from the surface: the first stroke is longer by the clearance."""
        peck = max(self.length(202), 0.0)
        if 0.0 < peck < abs(self.length(201)):
            self.control.findings.assumed("Q202 of drilling cycles counts from the surface, also for the first peck")
        return self.hole()._replace(peck=peck, first_peck=peck + self.length(200) if peck else 0.0)

    # Cycles

    def drilling(self) -> Drilling:
        """200: pecks, out of the hole between them."""
        return self.pecked()._replace(top_dwell=self.seconds(210), clearance=max(self.length(200), 0.0))

    def reaming(self) -> Drilling:
        """201: in and out at feed."""
        hole = self.hole()
        return self.way_out(hole) if self.items.get(208, 0.0) != 0.0 else hole._replace(out=FEED_OUT)

    def boring(self) -> Drilling:
        """202: as reaming, with the spindle stopped below."""
        if self.value(214, 0.0):
            raise Refusal("CYCL DEF 202 with Q214 of 1 to 4", "write Q214=0: the way aside by 0.2 mm is not read")
        return self.reaming()._replace(stops=True)

    def universal(self) -> Drilling:
        """203: pecks that become shorter, with chips broken between ways out."""
        breaks = int(max(self.value(213, 0.0), 0.0))
        return self.way_out(
            self.pecked()._replace(
                peck_less=max(self.length(212, 0.0), 0.0),
                least_peck=max(self.length(205, 0.0), 0.0),
                chip_break=max(self.length(256, BREAK), 0.0) if breaks else 0.0,
                full_after=breaks,
                top_dwell=self.seconds(210),
                clearance=max(self.length(200), 0.0),
            )
        )

    def deep(self) -> Drilling:
        """205: deep holes; the last depth is approached at rapid up to Q258."""
        if self.value(379, 0.0):
            raise Refusal("CYCL DEF 205 with Q379", "write the starting depth into Q203, with Q379=0")
        if self.value(259, 0.0) != self.value(258, 0.0) and 259 in self.items:
            self.control.findings.assumed("CYCL DEF 205: the distance of Q258 stays the same down to the bottom")
        hole = self.pecked()._replace(
            peck_less=max(self.length(212, 0.0), 0.0),
            least_peck=max(self.length(205, 0.0), 0.0),
            clearance=max(self.length(258, BREAK), 0.0),
        )
        return self.way_out(self.broken(hole))

    def broken(self, hole: Drilling) -> Drilling:
        """Chips broken every Q257 within the strokes of Q202."""
        step = max(self.length(257, 0.0), 0.0)
        if not step or step >= hole.peck:
            return hole
        strokes = round(hole.peck / step)
        if hole.peck_less or abs(strokes * step - hole.peck) > ROUNDING:
            raise Refusal(
                "CYCL DEF 205 with Q257 that does not divide Q202", "write Q212=0 and Q202 as a multiple of Q257"
            )
        back = max(self.length(256, BREAK), 0.0)
        first = step + self.length(200)
        return hole._replace(peck=step, first_peck=first, least_peck=0.0, chip_break=back, full_after=strokes - 1)

    def tapping(self) -> Drilling:
        """206, 207, 209: to the depth, reverse, out; 209 breaks chips every Q257, back by Q256 pitches or out."""
        hole = self.hole()._replace(out=FEED_OUT, stops=True)
        step = max(self.length(257, 0.0), 0.0) if self.number == 209 else 0.0
        if not step:
            return hole
        back = self.value(256, 0.0) * abs(self.length(239))
        # back to the top is a chip broken by the whole depth: at feed, as the thread asks
        return hole._replace(
            peck=step, first_peck=step + self.length(200), chip_break=back or abs(hole.top - hole.bottom)
        )

    def centring(self) -> Drilling:
        """240: to a depth."""
        if self.value(343, 0.0):
            raise Refusal(
                "CYCL DEF 240 with Q343=1", "write the depth as Q201, with Q343=0: the tip angle is not known"
            )
        return self.hole()

    def single_lip(self) -> Drilling:
        """241: at Q253 to a starting point within the hole, in one stroke to the depth, out at Q208.

        The starting point is approached to 0.2 * Q379, at most to Q200 (TNC 640 manual on cycles, "SINGLE-LIP
        D.H.DRLNG", positioning with Q379; the iTNC 530 stops at Q200 above it).
        """
        depth, peck, start = abs(self.length(201)), self.length(202, 0.0), self.length(379, 0.0)
        if 0.0 < peck < depth:
            raise Refusal("CYCL DEF 241 with Q202", "write Q202=0: the whole depth in one stroke")
        if self.value(435, 0.0):
            raise Refusal("CYCL DEF 241 with Q435", "write Q435=0: the dwell on the way is not read")
        hole = self.way_out(self.hole())
        if start <= 0.0:
            return hole
        clearance = self.length(200)
        if 0.2 * start < clearance:
            self.control.findings.assumed("cycle 241 comes to 0.2 * Q379 above the starting point, at most to Q200")
        level = self.length(203) - start + min(clearance, 0.2 * start)
        fast = self.items.get(253, "FMAX") == "FMAX"
        return hole._replace(start=max(level, hole.bottom), start_speed=0.0 if fast else self.speed(253))

    def old_pecking(self) -> Drilling:
        """1: set-up clearance, depth and peck with their signs, from where the tool is."""
        top = self.control.words[self.state.tool_axis]
        clearance, depth, peck = (abs(self.length(q)) for q in (200, 201, 202))
        bottom = top - clearance - depth
        return Drilling(top, bottom, top, peck=peck, clearance=clearance, dwell=self.seconds(211))
