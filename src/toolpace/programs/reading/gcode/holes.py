"""Canned drilling cycles, hole after hole."""

from __future__ import annotations

import math
from dataclasses import dataclass

from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.commanded import EXACT_PATH
from toolpace.programs.reading.arcs import PLANE_AXES, ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import (
    FEED_BACK,
    FEED_OUT,
    MOST_HOLES,
    RAPID_OUT,
    Drilling,
    back_bore,
    bore_backwards,
    drill,
    fine_bore,
    on_circle,
)
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.control.moves import Joining
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.motion import MotionReader
from toolpace.programs.reading.gcode.program.words import RefusedError

DIRECTIONS = {"first": (0, 1.0), "first negative": (0, -1.0), "second": (1, 1.0), "second negative": (1, -1.0)}
"""Of a shift Q: which axis of the plane, and its sign (parameters 5101#4, #5 and 5148 of Fanuc, Setting 27 of Haas)."""
R_ALONE = "R in a block without an axis, under a cycle, drills nothing: it holds from the next hole on"


class BoringShift:
    """The shift of G76, G87 (Fanuc) and G77 (Haas): Q in a direction of the control's, else I, J and K."""

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.axis, self.sign = DIRECTIONS[by.option("boring_shift", "first")]

    def beside(self, hole: list[float], words: dict[str, float]) -> list[float] | None:
        """The place (3 + rotary) beside the hole; None where the words of the cycle tell no shift.

        Raises BlockError for Q below zero, RefusedError in turned, scaled or mirrored coordinates.
        """
        q, unit = words.get("Q", 0.0), self.state.unit
        if q < 0.0:
            raise BlockError("Q is the shift of a boring tool and has no sign: write it above zero")
        found, plane = list(hole), PLANE_AXES[self.state.plane]
        if q:
            found[plane[self.axis]] += self.sign * q * unit
            self.control.findings.assumed(
                f"Q shifts a boring tool along {'+' if self.sign > 0 else '-'}{'XYZ'[plane[self.axis]]} of the "
                "coordinates in force (boring_shift in the controller's file: parameters 5101 and 5148 of Fanuc, "
                "Setting 27 of Haas)"
            )
        else:
            for slot in plane:
                found[slot] += words.get("IJK"[slot], 0.0) * unit
        if found == hole:
            return None
        self._need_plain()
        return found

    def _need_plain(self) -> None:
        """The spindle is oriented in the machine: what is turned or mirrored is not the direction of its tool."""
        frame, tilted = self.control.coordinates.frame, self.control.coordinates.tilted
        if not tilted and any(abs(frame[i][j] - (i == j)) > ROUNDING for i in range(3) for j in range(3)):
            raise RefusedError(
                "the shift of an oriented tool in turned, scaled or mirrored coordinates",
                "its direction is that of the spindle: end those before the cycle (G69, G50, G50.1)",
            )


@dataclass(frozen=True)
class Kind:
    """What a cycle does at the bottom and on its way out."""

    pecks: str = ""
    """"out": back to the top after each peck; "break": a little back."""
    dwells: bool = False
    stops: bool = False
    out: str = RAPID_OUT
    needs: str = ""
    """Words of it that LinuxCNC's interpreter wants, beside R and the depth."""


KINDS = {
    "drill": Kind(),
    "drill and dwell": Kind(dwells=True, needs="P"),
    "peck": Kind("out", dwells=True, needs="Q"),
    "break chips": Kind("break", dwells=True, needs="Q"),
    "tap": Kind(dwells=True, stops=True, out=FEED_OUT),
    "bore": Kind(out=FEED_OUT),
    "bore and dwell": Kind(dwells=True, out=FEED_OUT, needs="P"),
    "bore and stop": Kind(dwells=True, stops=True, needs="P"),
    "bore and orient": Kind(dwells=True, stops=True),
    "bore backwards": Kind(dwells=True, stops=True, needs="IJK"),
    "bore by hand": Kind(dwells=True, stops=True, needs="P"),
}
PECKS_OF_TAPS = Kind("break")
PECKED_TAP = (
    "a tap with Q goes back by chip_break_mm behind each peck, at feed (on Fanuc where parameter 5200#5 is 0, by 5213)"
)
TURNED = {"G74": ("M4",), "G84": ("M3",), "G86": ("M3", "M4"), "G87": ("M3", "M4"), "G88": ("M3", "M4")}
"""How the spindle has to turn for LinuxCNC's interpreter."""
FED_BACK = ("tap", "bore and dwell")
"""Cycles in which LinuxCNC's interpreter feeds out to the level that is gone back to."""


class Holes:
    """The words of a cycle, which stay in force until it ends, and the holes drilled with them."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader, controller: Controller) -> None:
        self.control, self.state, self.motion = control, state, motion
        self.repeats = controller.option("repeats", "K")
        self.clearance = controller.option("peck_clearance_mm", 1.0) * MILLIMETRE
        self.chip_break = controller.option("chip_break_mm", 1.0) * MILLIMETRE
        self.peck_words: str = controller.option("peck_words", "")
        """What I, J, K of pecks are: "shorter", the first, by how much each is shorter, the least; K a "clearance"."""
        self.rs274 = controller.option("rs274_cycles", False)
        """Whether cycles are those of LinuxCNC's interpreter."""
        self.from_here = controller.option("cycle_without_r", False)
        """Whether R may be missing: the feed then begins where the tool is."""
        self.shift = BoringShift(control, state, controller)
        self.words: dict[str, float] = {}
        self.absolute: dict[str, bool] = {}
        """Whether G90 was in force where a word was written: G91 behind a cycle places holes, and leaves depths."""
        self.level: float | None = None
        """Along the drill axis, where the cycle began [m]."""
        self.dwelt = 0.0
        """P of the last cycle that waits [s]: to LinuxCNC's interpreter that of a tap without P too."""
        self.unit = state.unit
        """In which its words are written [m]."""

    def begin(self) -> None:
        """Forget the words of the cycle before."""
        self.words, self.absolute, self.level, self.unit = {}, {}, None, self.state.unit

    def change(self) -> None:
        """Another cycle follows without an end of the one before: Q stays, of a peck and of a shift (B-63944EN-2)."""
        if self.rs274:
            self.words = {}
        for letter in "IJK":
            self.words.pop(letter, None)

    def execute(self, numbers: dict[str, float], dwell: float | None) -> None:
        """A block under a cycle: its words, its repeats, and a hole where it names an axis.

        dwell: P in seconds, where the block has it.
        """
        control, state = self.control, self.state
        if control.feed.mode == INVERSE:
            raise BlockError("canned cycles need feeds per minute: write G94 before them")
        letter = "XYZ"[state.drill_axis]
        plane = [axis for axis in numbers if axis in control.slots and axis != letter]
        repeats, fewest = self._repeats(numbers), int(self.rs274)
        if repeats != int(repeats) or not fewest <= repeats <= MOST_HOLES:
            raise BlockError(
                f"{self.repeats}{repeats:g} counts holes: write a whole number from {fewest} to {MOST_HOLES}"
            )
        if state.unit != self.unit:
            raise BlockError("a change of the unit within a cycle changes what its words mean: write G80 before it")
        if self.level is None:
            self.level = control.words[state.drill_axis]
        drills = bool(plane) or letter in numbers
        if self.rs274:
            self._refuse_in_rs274(plane, drills)
        elif "R" in numbers and not drills:
            control.findings.assumed(R_ALONE)
        for name in (letter, *"RQIJK"):
            if name in numbers:
                self.words[name] = numbers.pop(name)
                self.absolute[name] = state.absolute
        if dwell is not None and dwell < 0.0:
            raise BlockError(f"the dwell P of a cycle is {dwell:g} s: write it from zero")
        if dwell is not None:
            self.words["P"] = dwell
        if not drills:
            return
        if self.rs274 and state.turning not in (wanted := TURNED.get(state.motion_word, (state.turning,))):
            turns = f"turns by {state.turning}" if state.turning else "is at rest"
            cure = f"write {' or '.join(wanted)} before it"
            control.findings.stops(f"{state.motion_word} while the spindle {turns}", control.line, cure)
        cycle = self._cycle(letter)
        joining = control.moves.joining
        if self.rs274:  # its interpreter has cycles on the exact path, whatever mode is in force
            control.moves.join(Joining(EXACT_PATH))
        for _ in range(int(repeats)):
            target, _ = self.motion.target(dict(numbers))
            if not self.rs274:
                self._hole(cycle, target)
            elif state.cycle == "bore backwards":
                bore_backwards(control, self._arriving(cycle), target, *self._aside(target, cycle.bottom))
            else:
                drill(control, self._arriving(cycle), target)
        control.moves.join(joining)

    def _repeats(self, numbers: dict[str, float]) -> float:
        """How many holes a block drills, by K or L."""
        if self.repeats == "L" and not self.rs274:
            assert self.state.cycle is not None
            if numbers.get("K", 1.0) != 1.0 and not KINDS[self.state.cycle].pecks:
                raise RefusedError(f"K{numbers.pop('K'):g} of a cycle", "on Fanuc it counts holes: write L here")
        elif "L" in numbers:
            self.control.findings.assumed("L of a cycle counts holes, as in the tape format of Fanuc's 15")
        return numbers.pop(self.repeats, numbers.pop("L", 1.0))

    def _hole(self, cycle: Drilling, hole: list[float]) -> None:
        """One hole of the cycle in force at a place (3 + rotary)."""
        control, backwards = self.control, self.state.cycle == "bore backwards"
        oriented = backwards or self.state.cycle == "bore and orient"
        beside = self.shift.beside(hole, self.words) if oriented else None
        if beside is not None:
            (back_bore if backwards else fine_bore)(control, cycle, hole, beside)
            return
        if backwards:
            control.straight([*hole[: cycle.axis], control.words[cycle.axis], *hole[cycle.axis + 1 :]], 7, rapid=True)
        drill(control, cycle, hole)

    def _arriving(self, cycle: Drilling) -> Drilling:
        """The cycle with the level at which LinuxCNC's interpreter (`convert_cycle_xy`) has the tool over the hole.

        Where the cycle began below R, the tool first goes to R, up or down; it arrives at the level that is gone back
        to, but never lower than it is.
        """
        control, axis = self.control, cycle.axis
        assert self.level is not None
        if self.level < cycle.top:
            control.straight([*control.words[:axis], cycle.top, *control.words[axis + 1 :]], 7, rapid=True)
        begins = self.level if self.state.to_initial else cycle.top
        return cycle._replace(over=max(begins, cycle.top, control.words[axis]))

    def _aside(self, hole: list[float], bottom: float) -> tuple[list[float], float]:
        """Place (3 + rotary) beside the hole, and the upper level, of boring backwards: I, J and K, in XY."""
        words, unit = self.words, self.state.unit
        place = list(hole)
        axis = self.state.drill_axis
        for slot, letter in enumerate("IJK"):
            place[slot] += words[letter] * unit if slot != axis else 0.0
        return place, words["IJK"[axis]] * unit + (0.0 if self.state.absolute else bottom)

    def _refuse_in_rs274(self, plane: list[str], drills: bool) -> None:
        """Words on which its interpreter ends: "All axes missing", "Cannot put an A in canned cycle"; and on which
        it moves elsewhere than its manual says."""
        if self.state.cycle_word and not drills:
            raise BlockError("a cycle without an axis drills nothing: write where, like G81 X1 Y1 Z-5 R2")
        if self.state.cycle == "tap" and self.state.drill_axis != 2:
            raise BlockError(
                f"{self.state.motion_word} outside the plane of G17: LinuxCNC's interpreter moves other axes than the "
                "manual says; write the strokes out"
            )
        turned = next((axis for axis in plane if axis in "ABC"), None)
        if turned is not None:
            raise BlockError(f"{turned} in a block of a cycle: turn the axis in a block before it")

    def on_circle(self, numbers: dict[str, float], *, each: bool) -> None:
        """Holes on a circle of radius I about the place at hand, the first at the angle J [deg], L of them.

        each: K is the angle from one to the next; else they are evenly spaced (Haas mill operator's manual, G70, G71:
        a radius is "+CCW/-CW").
        """
        count = numbers.pop("L", 1.0)
        if count != int(count) or not 1 <= count <= MOST_HOLES:
            raise BlockError(f"L{count:g} counts holes: write a whole number from 1 to {MOST_HOLES}")
        radius, first = numbers.pop("I") * self.state.unit, numbers.pop("J") * DEGREE
        step = numbers.pop("K", 0.0) * DEGREE if each else 2.0 * math.pi / count
        if radius < 0.0 and step < 0.0:
            raise RefusedError("I and K below zero", "either tells that the holes go clockwise: write one above zero")
        radius, step = abs(radius), math.copysign(step, radius * step)
        centre, _ = self.motion.target(numbers)
        a, b = PLANE_AXES[self.state.plane]
        cycle = self._cycle("XYZ"[self.state.drill_axis])
        for place in on_circle(centre[a], centre[b], radius, (first + k * step for k in range(int(count)))):
            target = list(centre)
            target[a], target[b] = place
            self._hole(cycle, target)

    def _is_absolute(self, name: str) -> bool:
        """Whether a level counts as under G90; LinuxCNC's interpreter asks what is in force at the hole."""
        return self.state.absolute if self.rs274 else self.absolute.get(name, self.state.absolute)

    def _cycle(self, letter: str) -> Drilling:
        """The cycle in force, with the words in force."""
        state, words, unit = self.state, self.words, self.state.unit
        assert state.cycle is not None and self.level is not None
        kind = KINDS[state.cycle]
        wanted = (letter, "R", *kind.needs) if self.rs274 else (letter, "R") if state.absolute else (letter,)
        missing = next((name for name in wanted if name not in words), None)
        if missing == "R" and self.from_here:
            self.control.findings.assumed("the feed of a cycle without R begins at the height where the cycle began")
            words["R"], self.absolute["R"], missing = self.level / unit, True, None
        if missing in (letter, "R"):
            raise BlockError(f"the cycle lacks {missing}: write where its feed begins as R and its depth as {letter}")
        if missing is not None:
            raise BlockError(f"the cycle lacks {missing}: pecks need Q, dwells P, and boring backwards I, J and K")
        waits = (state.cycle == "tap" or "P" in kind.needs) if self.rs274 else kind.dwells
        dwell = words.get("P", self.dwelt if self.rs274 else 0.0) if waits else 0.0
        self.dwelt = dwell if waits else self.dwelt
        top = words.get("R", 0.0) * unit + (0.0 if self._is_absolute("R") else self.level)
        bottom = words[letter] * unit + (0.0 if self._is_absolute(letter) else top)
        from_above = self.rs274 or state.cycle != "bore backwards"
        back = max(self.level, top) if state.to_initial or not from_above else top
        if bottom > top and from_above:
            raise BlockError(f"the cycle's depth {letter} is above R: correct {letter} or R")
        made = Drilling(
            top=top,
            bottom=bottom,
            back=back,
            axis=state.drill_axis,
            dwell=dwell,
            out=FEED_BACK if self.rs274 and state.cycle in FED_BACK else kind.out,
            stops=kind.stops,
        )
        if state.cycle == "tap" and words.get("Q") and not self.rs274:
            self.control.findings.assumed(PECKED_TAP)
            kind = PECKS_OF_TAPS
        return self._with_pecks(made, kind) if kind.pecks else made

    def _with_pecks(self, made: Drilling, kind: Kind) -> Drilling:
        words, unit = self.words, self.state.unit
        peck = words.get("Q", 0.0) * unit
        if peck < 0.0:
            raise BlockError("Q is the depth of a peck and has no sign: write it above zero")
        first, less, least = (words.get(name, 0.0) * unit for name in "IJK")
        clearance, chip_break = self.clearance, self.chip_break
        if self.peck_words == "clearance" and least:
            self.control.findings.assumed("K of pecks is how far the tool goes back, or stops above the last depth")
            clearance, chip_break, least = least, least, 0.0
        if (first or less or least) and self.peck_words != "shorter":
            raise RefusedError("I, J, K of pecks", "controls differ in what they mean: write Q alone")
        return made._replace(
            peck=peck or first,
            first_peck=first,
            peck_less=less,
            least_peck=least,
            chip_break=chip_break if kind.pecks == "break" else 0.0,
            clearance=clearance,
            over_top=self.rs274,
        )
