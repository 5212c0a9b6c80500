"""Motions of a block: axes, polar positions, machine coordinates, tool vectors, splines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_AXES, ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import EDGE, ROUND, SIDES, Corners
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.control.machine_moves import straight_in_machine
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik import circles
from toolpace.programs.reading.sinumerik.circles import LETTERS, end_by_pole
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.orientation import ANGLES, VECTOR, Vectors, turned_alone
from toolpace.programs.reading.sinumerik.state import GREAT_CIRCLE, State
from toolpace.programs.reading.sinumerik.syntax.values import Unread
from toolpace.programs.reading.sinumerik.word_values import Words, WordValue, bounded, number
from toolpace.programs.reading.splines import CurveError, curves_of, even_knots

CURE = "let the CAM system write lines and arcs"
HEAVIEST = 3.0
"""Most weight PW."""
OF_ARCS = ("CR", "AR", "TURN", "I", "J", "K", "I1", "J1", "K1")
"""Addresses that only arcs take."""
OF_CORNERS = {"RND": ROUND, "CHR": SIDES, "CHF": EDGE}
"""Corners at the end of a block: radius, side of a chamfer, its edge (NC Programming, "Chamfer, rounding")."""
CORNER_WORDS = frozenset((*OF_CORNERS, "RNDM"))
AXES = frozenset((*LETTERS, "AP", "RP", *VECTOR, *ANGLES))
"""Addresses that ask for motion."""


class BSplines:
    """Gathers control points until another motion follows, then moves along the spline."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.points: list[list[float]] = []
        self.weights: list[float] = []
        self.steps: set[float] = set()
        """Distances of knots (PL) that are written."""
        self.end: list[float] = []
        """Words (3 + rotary) of the last control point."""
        self.named = self.line = 0
        self.degree = 3

    def point(self, target: list[float], named: int, words: Words, inverse: float | None) -> None:
        """One block: the target (3 + rotary) is the next control point. Raises Unread, BlockError."""
        control = self.control
        if inverse is not None:
            raise Unread("BSPLINE under G93", "write G94")
        if target[3:] != control.words[3:]:
            raise Unread("BSPLINE that turns rotary axes", CURE)
        degree = number(words, "SD")
        weight, step = number(words, "PW", 1.0), number(words, "PL")
        if not self.points:
            self.points, self.weights, self.steps = [list(control.words[:3])], [1.0], set()
            self.degree, self.named, self.line = 3, 0, control.line
        if degree is not None:
            if degree not in (2.0, 3.0):
                raise BlockError(f"SD={degree:g} is no degree of BSPLINE: write SD=2 or SD=3")
            self.degree = int(degree)
        if weight is None or not 0.0 < weight <= HEAVIEST:
            raise BlockError(f"PW is the weight of a control point, above 0 and at most {HEAVIEST:g}: correct it")
        if step is not None:
            if step <= 0.0:
                raise BlockError(f"PL={step:g} is no distance of knots (alarms 10891, 14093): write one above zero")
            self.steps.add(step)
        self.points.append(target[:3])
        self.weights.append(weight)
        self.end, self.named = list(target), self.named | named

    def close(self) -> None:
        """Move along what was gathered, if anything. Raises ProgramError."""
        points, self.points, self.end = self.points, [], []
        if not points:
            return
        control, here = self.control, self.control.line
        if len(self.steps) > 1:
            control.findings.refused("PL=", self.line, f"which span each PL belongs to is not known: {CURE}")
            return
        control.findings.assumed("knots of BSPLINE are evenly spaced between its ends, where it touches its points")
        control.line = self.line
        try:
            # a spline of few points is of a lower degree
            order = min(self.degree + 1, len(points))
            control.spline(curves_of(order, even_knots(order, len(points)), points, self.weights), self.named)
        except CurveError as error:
            control.source.fail(str(error), self.line)
        finally:
            control.line = here


class Motion:
    """Makes motions of words."""

    def __init__(self, control: Control, state: State, frames: Frames) -> None:
        self.control, self.state, self.frames = control, state, frames
        self.vectors = Vectors(control, state)
        self.splines = BSplines(control)
        self.corners = Corners(control, "it is read between two straight lines of the plane: write the corner out")
        self.programmed = list(control.words)
        """End of the last motion, in the coordinates of then: IC() and G91 count from it, so that a new frame
        shifts them too (SD42440 = 1)."""
        self.unsure: set[int] = set()
        """Slots that a frame has shifted, and no word has named behind it: whether their next distance counts from the
        shifted place is not told."""

    @contextmanager
    def placed(self, *, frames: bool = False) -> Iterator[None]:
        """Within, something else than words of a block moves the machine, or changes its frames: distances count from
        where it is then."""
        before, shifted = self.control.words, self.shifted()
        yield
        changed = {slot for slot, value in enumerate(self.control.words) if value != before[slot]}
        self.unsure = self.unsure | shifted | changed if frames else (self.unsure | shifted) - changed
        self.programmed, self.state.tangent = self.control.words, None

    def shifted(self) -> set[int]:
        """Slots whose words a frame has changed since the last motion."""
        return {slot for slot, value in enumerate(self.control.words) if abs(self.programmed[slot] - value) > ROUNDING}

    def has_axes(self, words: Words) -> bool:
        """Whether words ask for motion."""
        if not AXES.isdisjoint(words):
            return True
        # a full circle may name its centre alone
        return self.state.motion in ("G2", "G3") and not {"I", "J", "K", "AR"}.isdisjoint(words)

    def execute(self, words: Words, *, stop: bool) -> bool:
        """Move as the words of a block say, which are taken out; whether an axis of the path was named."""
        control, state = self.control, self.state
        start, polar = control.words, "AP" in words or "RP" in words
        rotary = (letter for letter in control.slots if letter not in "XYZ")
        turned = self.vectors.names_a_direction(words) and any(letter in words for letter in rotary)
        if self.splines.end:
            control.words, present = self.splines.end, start
            try:
                target, named = self.target(words)
            finally:
                control.words = present
        else:
            target, named = self.target(words)
        path_axis = bool(named)
        if self.frames.tilted and turned_alone(control, self.frames, state, target, named):
            if self.corners.waiting is not None:
                self._before(target, False)
            self.programmed = control.words
            if stop:
                control.stop()
            return False
        if state.motion == "BSPLINE":
            if not len(control.moves):
                control.begin_here()
            self.splines.point(target, named, words, self._number())
            self.programmed, state.tangent = target, None
            return path_axis
        corner = self._corner(words)
        vector = self.vectors.taken(words)
        if vector is not None and turned:
            raise BlockError("a block turns the tool by rotary words or by a vector (A3=, A2=), not both (alarm 14111)")
        arcs = state.motion in ("G2", "G3", "CIP", "CT")
        if not len(control.moves):
            self._first(arcs)
        straight = state.motion == "G1" and vector is None
        if self.corners.waiting is not None:
            self._before(target, straight)
        if state.motion in ("G331", "G332"):
            self._tap(target, named, words)
        elif arcs:
            self._arc(target, named, words, vector, polar)
        else:
            self._straight(target, named, vector, words)
        if corner is not None:
            self.corners.put(*corner, start if straight else [])
        self.programmed = control.words
        if stop:
            control.stop()
        return path_axis

    def _first(self, arcs: bool) -> None:
        """Before the first motion of a program."""
        control = self.control
        if control.setup.offsets and not self.frames.selected:
            control.findings.assumed("the program names no settable offset (G54) before it moves: it moves at the part")
        if arcs or not self.state.absolute:
            control.begin_here()

    # Corners

    def _corner(self, words: Words) -> tuple[str, str, float] | None:
        """Name, kind and size [m] of the corner at the end of a block."""
        state = self.state
        if not state.rounding and CORNER_WORDS.isdisjoint(words):
            return None
        modal = number(words, "RNDM")
        if modal is not None:
            state.rounding = modal * state.unit
        for name, kind in OF_CORNERS.items():
            size = number(words, name)
            if size is not None:
                return f"{name}=", kind, size * state.unit
        return ("RNDM=", ROUND, state.rounding) if state.rounding and state.motion != "G0" else None

    def round_from_here(self, words: Words) -> None:
        """RNDM in a block without motion: the radius of every corner from the next block on, 0 for none."""
        if "RNDM" in words and not self.has_axes(words):
            self.state.rounding = (number(words, "RNDM") or 0.0) * self.state.unit

    def _before(self, target: list[float], straight: bool) -> None:
        if straight:
            self.corners.before(target, self.state.plane)
        else:
            self.corners.refuse()

    # Where to

    def target(self, words: Words) -> tuple[list[float], int]:
        """Words (3 + rotary) of the end of a motion [m, rad], and bits of X, Y, Z that it names."""
        control = self.control
        target, named = list(control.words), 0
        slots = control.slots
        unsure = self.unsure | (set() if self.programmed is control.words else self.shifted())
        for address in [address for address in words if len(address) == 1 and address in LETTERS]:
            slot = slots.get(address)
            if slot is None:
                slot = control.slot(address)
            target[slot] = self._coordinate(address, slot, words.pop(address))
            if slot < 3:
                named |= 1 << slot
            unsure.discard(slot)
        if "AP" in words or "RP" in words:
            polar = end_by_pole(self.state, words, target)
            if polar & named:
                raise BlockError("AP and RP beside the axes of their plane (alarm 14280): write one or the other")
            named |= polar
            unsure.difference_update(PLANE_AXES[self.state.plane])
        self.unsure = unsure
        return target, named

    def _coordinate(self, address: str, slot: int, word: WordValue) -> float:
        value = bounded(word, address)
        form = word.form
        value *= self.state.unit if slot < 3 else DEGREE
        if form == "IC" or (not form and not self.state.absolute):
            if slot in self.unsure:
                raise BlockError(
                    f"{address} is a distance, and {address} was not named since a frame or a length changed and "
                    f"something else moved: whether that shift counts is not told; write {address}=AC() once before"
                )
            return self.programmed[slot] + value
        if form in ("", "AC"):
            return value
        if slot < 3:
            raise BlockError(f"{address}={form}() is for rotary axes: write {address}=AC()")
        present, turn = self.control.words[slot], 2.0 * math.pi
        if value < 0.0 or value >= turn - 1e-12:
            self.control.findings.assumed(
                f"{address}={form}() beyond 0 to 360 is counted modulo 360 (MD30455 bit 0 = 1; else alarm 16830)"
            )
        if form == "DC":
            return present + math.remainder(value - present, turn)
        ahead = (value - present) % turn
        ahead = 0.0 if turn - ahead < ROUNDING else ahead
        return present + (ahead if form == "ACP" or ahead == 0.0 else ahead - turn)

    # How

    def _number(self) -> float | None:
        return self.state.inverse if self.control.feed.mode == INVERSE else None

    def _straight(self, target: list[float], named: int, vector: list[float] | None, words: Words) -> None:
        control, state = self.control, self.state
        rapid, start = state.motion == "G0", control.words
        if vector is not None:
            self.vectors.straight(target, named, vector, rapid=rapid, number=self._number())
        else:
            if control.coordinates.tip_mode and target[3:] != start[3:] and not rapid and state.turning == GREAT_CIRCLE:
                control.findings.assumed("rotary words under TRAORI move in proportion, also under ORIWKS")
            control.straight(target, named, rapid=rapid, number=self._number())
        if named:
            way = (target[0] - start[0], target[1] - start[1], target[2] - start[2])
            state.tangent = way if any(way) else state.tangent

    def _arc(self, target: list[float], named: int, words: Words, vector: list[float] | None, polar: bool) -> None:
        control, state = self.control, self.state
        if vector is not None:
            control.findings.assumed("on arcs tool vectors are reached with the rotary axes in proportion")
            target[3:] = self.vectors.rotary(vector)
        if state.motion == "CT":
            tangential = circles.tangent(control, state, target)
            if tangential is None:
                self._straight(target, named, None, words)
                return
            arc = tangential
        elif state.motion == "CIP":
            passing = circles.through(control, state, words, target)
            if passing is None:
                self._straight(target, named, None, words)
                return
            arc = passing
        else:
            arc = circles.circle(control, state, words, target, named=self._in_plane(named), polar=polar)
        control.arc(target, named, arc, self._number())
        state.tangent = arc.last_direction()

    def _in_plane(self, named: int) -> int:
        first, second = PLANE_AXES[self.state.plane]
        return named & (1 << first | 1 << second)

    def _tap(self, target: list[float], named: int, words: Words) -> None:
        """G331 and G332: the axis moves one lead K a turn of the spindle."""
        lead = None
        for letter in "IJK":
            value = number(words, letter)
            lead = value if value is not None else lead
        if not lead or self.control.feed.spindle <= 0.0:
            raise BlockError(f"{self.state.motion} needs its lead as K and the spindle speed as S: write both")
        with self.control.feed.held(abs(lead) * self.state.unit * self.control.feed.spindle):
            self.control.straight(target, named, rapid=False)
        self.control.stop()
        self.state.tangent = None

    def in_machine(self, words: Words, *, stop: bool) -> bool:
        """SUPA, G53, G153: a motion to machine coordinates."""
        control = self.control
        if self.state.motion not in ("G0", "G1"):
            raise BlockError("machine coordinates (SUPA, G53) are reached with G0 or G1: write one of them")
        coordinates = {}
        for address in [address for address in words if len(address) == 1 and address in LETTERS]:
            word = words.pop(address)
            slot = control.slot(address)
            if word.form == "IC" or (not word.form and not self.state.absolute):
                raise BlockError(
                    f"{address} is a distance, but SUPA and G53 need a place: write G90, or {address}=AC()"
                )
            coordinates[address] = bounded(word, address) * (self.state.unit if slot < 3 else DEGREE)
        if not coordinates:
            return False
        if control.coordinates.tip_mode and not coordinates.keys().isdisjoint("XYZ"):
            raise Unread(
                "machine coordinates (SUPA, G53) under TRAORI",
                "it stays on there, so that X, Y and Z would be of the tip: write TRAFOOF before",
            )
        if control.coordinates.compensated and control.poses.machine is not None:
            control.findings.assumed("machine coordinates (SUPA, G53) are those of the axes, without tool length")
        with self.placed():
            straight_in_machine(control, coordinates, rapid=self.state.motion == "G0")
        if stop:
            control.stop()
        return any(address in "XYZ" for address in coordinates)
