"""CYCLE81 to CYCLE89 and CYCLE840 as motions (Programming Manual Cycles, chapter 2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from toolpace.common.units import MILLIMETRE, MINUTE
from toolpace.programs.reading.arcs import PLANE_ACROSS, PLANE_AXES
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import FEED_OUT, MOST_PECKS, RAPID_OUT, Drilling, drill
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.cycles.hole_geometry import (
    Along,
    Levels,
    pitch_of,
    stop_distance,
    strokes_by_factor,
    strokes_of,
)
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value
from toolpace.programs.reading.sinumerik.word_values import Arguments

MOST = 24
"""Arguments of a cycle: newer controls append theirs (_GMODE, _DMODE, _AMODE)."""


class Holes:
    """Makes the motions of the cycles of holes."""

    def __init__(self, control: Control, state: State, *, strict: bool) -> None:
        self.control, self.state, self.strict = control, state, strict
        self.cycles: dict[str, Callable[[Arguments, Levels], None]] = {
            "CYCLE84": self._rigid_tap,
            "CYCLE840": self._floating_tap,
            "CYCLE85": self._ream,
            "CYCLE86": self._bore,
            "CYCLE76": self._builders_bore,
        }
        self.drillings: dict[str, Callable[[Arguments, Levels], Drilling]] = {
            "CYCLE81": self._plain,
            "CYCLE82": self._plain,
            "CYCLE83": self._deep,
            "CYCLE87": self._bore_with_stop,
            "CYCLE88": self._bore_with_stop,
            "CYCLE89": self._plain,
        }
        """Cycles whose strokes are the same in every hole."""
        self.name = ""
        self._made: tuple[tuple[object, ...], Drilling] | None = None
        """The last of these, and what it was made of."""

    @property
    def axis(self) -> int:
        """Of X, Y, Z, the one along which the tool works."""
        return PLANE_ACROSS[self.state.plane]

    def perform(self, name: str, values: list[Value | None]) -> None:
        """One cycle where the tool stands. Raises BlockError, Unread."""
        if not len(self.control.moves):
            self.control.begin_here()
        self.name = name
        if name in self.drillings:
            number = self.state.inverse if self.control.feed.mode == INVERSE else None
            drill(self.control, self._drilling(values), list(self.control.words), number)
        else:
            arguments = Arguments(name, values, MOST)
            self.cycles[name](arguments, self._levels(arguments))

    def _drilling(self, values: list[Value | None]) -> Drilling:
        of = (self.name, tuple(values), self.state.unit, self.state.plane, self.control.feed.spindle)
        if self._made is None or self._made[0] != of:
            arguments = Arguments(self.name, values, MOST)
            self._made = of, self.drillings[self.name](arguments, self._levels(arguments))
        return self._made[1]

    def _levels(self, arguments: Arguments) -> Levels:
        unit = self.state.unit
        for place, what in ((0, "RTP, the retraction plane,"), (1, "RFP, the reference plane,")):
            if not arguments.has(place):
                raise BlockError(f"{self.name} lacks {what} its argument {place + 1}: write it")
        back, reference = arguments.number(0) * unit, arguments.number(1) * unit
        safety = abs(arguments.number(2)) * unit
        depth = abs(arguments.number(4)) * unit
        if not depth and not arguments.has(3):
            raise BlockError(f"{self.name} lacks its depth: write DP or DPR, its arguments 4 and 5")
        bottom = reference - depth if depth else arguments.number(3) * unit
        down = -1.0 if bottom <= reference else 1.0
        if depth and back == reference:
            self._tolerate(
                "RTP at RFP and a relative depth",
                "alarm 61101: raise RTP, or write DP",
                "where the retraction plane RTP is the reference plane RFP, DPR counts downwards",
            )
        top = reference - down * safety
        if down > 0.0 and back > reference:
            raise BlockError(
                f"{self.name}: its depth lies above RFP, where RTP lies too (alarm 61101): correct DP or RFP"
            )
        if (back - reference) * -down < -1e-12:
            self._tolerate(
                "RTP below RFP",
                "alarm 61101: raise RTP",
                "where the retraction plane RTP lies below the reference plane RFP, a cycle goes back to RFP + SDIS",
            )
            back = top
        if (back - top) * -down < 0.0:
            back = top
        return Levels(back, reference, top, bottom)

    def _tolerate(self, what: str, cure: str, sentence: str) -> None:
        """Take a cycle that controls stop at for what it must mean, and say so; refuse it where that is asked for."""
        if self.strict:
            raise Unread(f"{self.name} with {what}", f"the control stops there ({cure})")
        self.control.findings.assumed(f"{sentence} (controls may stop there: {cure})")

    def _along(self, levels: Levels) -> Along:
        return Along(self.control, self.state, self.axis, levels)

    def _dwell(self, time: float) -> float:
        """Seconds of a dwell; negative values are turns of the spindle."""
        if time >= 0.0:
            return time
        spindle = self.control.feed.spindle
        if spindle <= 0.0:
            raise BlockError(f"{self.name} dwells for turns of the spindle: write S before it")
        return -time / spindle

    def _hole(self, levels: Levels) -> Drilling:
        return Drilling(levels.top, levels.bottom, levels.back, axis=self.axis)

    def _plain(self, arguments: Arguments, levels: Levels) -> Drilling:
        dwell = 0.0 if self.name == "CYCLE81" else self._dwell(arguments.number(5))
        out = FEED_OUT if self.name == "CYCLE89" else RAPID_OUT
        return self._hole(levels)._replace(dwell=dwell, out=out)

    def _deep(self, arguments: Arguments, levels: Levels) -> Drilling:
        unit = self.state.unit
        whole = abs(levels.reference - levels.bottom)
        first = abs(arguments.number(6)) * unit
        if not first and arguments.has(5):
            down = math.copysign(1.0, levels.bottom - levels.reference)
            first = (arguments.number(5) * unit - levels.reference) * down
            if first < 0.0:
                raise BlockError("CYCLE83: its first depth FDEP lies above RFP (alarm 61107): correct FDEP")
        if first > whole:
            self._tolerate(
                "a first stroke below its depth",
                "alarm 61107: correct FDEP",
                "CYCLE83 whose first stroke FDEP lies below the whole depth DP drills in one stroke",
            )
        factor = arguments.number(10, 1.0)
        if factor not in (0.0, 1.0):
            self.control.findings.assumed("CYCLE83: the feed of the first stroke is taken as that of the others (FRF)")
        safety = abs(levels.top - levels.reference)
        strokes = self._strokes(arguments, whole, first or whole)
        clear = arguments.code(11)
        if clear not in (0, 1):
            raise BlockError(f"CYCLE83 with VARI {clear} (alarm 61002): write 0 to break chips, 1 to remove them")
        back = abs(arguments.number(14)) * unit or MILLIMETRE
        ahead = abs(arguments.number(16)) * unit or stop_distance(whole)
        dwell = self._dwell(arguments.number(8))
        return self._hole(levels)._replace(
            ends=tuple(safety + depth for depth in strokes),
            chip_break=0.0 if clear else back,
            breaks_at_feed=True,
            clearance=ahead,
            peck_dwell=dwell,
            top_dwell=self._dwell(arguments.number(9)) if clear else 0.0,
            dwell=self._dwell(arguments.number(15)) if arguments.has(15) else dwell,
        )

    def _strokes(self, arguments: Arguments, whole: float, first: float) -> list[float]:
        """Depths [m] of the strokes of CYCLE83: DAM takes a length from each, or is minus a factor."""
        less, unit = arguments.number(7), self.state.unit
        if -1.0 <= less < 0.0:
            self.control.findings.assumed("DAM of CYCLE83 from -1 to 0 is the factor of each stroke to the next one")
            return strokes_by_factor(whole, first, -less, abs(arguments.number(13)) * unit)
        return strokes_of(whole, first, abs(less) * unit)

    def _ream(self, arguments: Arguments, levels: Levels) -> None:
        per_minute = self.state.unit / MINUTE
        if not (arguments.number(6) and arguments.number(7)):
            self._tolerate("no FFR or RFF", "write both", "CYCLE85 without FFR or RFF goes at the feed in force")
        way = self._along(levels)
        way.over()
        way.feed(levels.bottom, arguments.number(6) * per_minute)
        way.pause(self._dwell(arguments.number(5)))
        way.feed(levels.top, arguments.number(7) * per_minute)
        way.rapid(levels.back)

    def _bore(self, arguments: Arguments, levels: Levels) -> None:
        """CYCLE86: at the bottom the spindle is oriented, and the bar lifted off by RPA, RPO, RPAP."""
        unit = self.state.unit
        first, second = PLANE_AXES[self.state.plane]
        off = [0.0, 0.0, 0.0]
        off[first], off[second] = arguments.number(7) * unit, arguments.number(8) * unit
        off[self.axis] = arguments.number(9) * unit
        if self.name == "CYCLE86":
            self._spindle(arguments, 6, (3, 4), "SDIR")
        way = self._along(levels)
        way.over()
        hole = list(self.control.words)
        way.feed(levels.bottom)
        way.pause(self._dwell(arguments.number(5)))
        self.control.stop()
        lifted = [a + b for a, b in zip(self.control.words[:3], off)]
        self.control.straight([*lifted, *hole[3:]], 7, rapid=True)
        way.rapid(levels.back)
        hole[self.axis] = levels.back
        self.control.straight(hole, 7, rapid=True)

    def _builders_bore(self, arguments: Arguments, levels: Levels) -> None:
        """CYCLE76 mills a rectangular spigot; without its width it cannot, and posts mean a boring cycle by it."""
        if any(arguments.has(place) for place in range(6, MOST)):
            raise Unread("CYCLE76", "cycles that clear areas are not read: let the CAM system write them out")
        self._tolerate(
            "neither width nor radius",
            "CYCLE76 mills a spigot",
            "CYCLE76 without the size of a spigot is a boring cycle of the machine's builder, that moves as CYCLE86",
        )
        self._bore(arguments, levels)

    def _bore_with_stop(self, arguments: Arguments, levels: Levels) -> Drilling:
        self._spindle(arguments, 6 if self.name == "CYCLE88" else 5, (3, 4), "SDIR")
        dwell = self._dwell(arguments.number(5)) if self.name == "CYCLE88" else 0.0
        return self._hole(levels)._replace(dwell=dwell, stops=True)

    def _rigid_tap(self, arguments: Arguments, levels: Levels) -> None:
        if not arguments.number(7) and not arguments.number(8):
            self._tolerate(
                "neither MPIT nor PIT",
                "write the pitch",
                "CYCLE84 without a pitch (MPIT, PIT) taps at the feed in force",
            )
            self._tap(levels, 0.0, 0.0, self._dwell(arguments.number(5)))
            return
        self._spindle(arguments, 6, (3, 4, 5), "SDAC")
        pitch = pitch_of(arguments, self.state.unit, size=7, pitch=8, kind=13)
        speed = arguments.number(10) or self.control.feed.spindle * MINUTE
        back = arguments.number(11) or speed
        strokes = self._tapping_strokes(arguments, levels)
        self._tap(levels, pitch * speed / MINUTE, pitch * back / MINUTE, self._dwell(arguments.number(5)), strokes)

    def _spindle(self, arguments: Arguments, place: int, allowed: tuple[int, ...], name: str) -> None:
        """Tolerate a direction of the spindle that is none: it moves nothing."""
        if arguments.code(place) not in allowed:
            self._tolerate(
                f"{name} {arguments.code(place)}",
                f"alarm 61102: write {' or '.join(map(str, allowed))}",
                f"{self.name} without a direction of the spindle ({name}) moves as with one",
            )

    def _tapping_strokes(self, arguments: Arguments, levels: Levels) -> list[tuple[float, float]]:
        """Levels of the strokes before the last, and levels that are gone back to behind them.

        _VARI 1 breaks chips: back by _VRT; 2 removes them: back to the top. Each stroke is _DAM deeper ("max. depth
        infeed"), the first from the reference plane (PZ, CYCLE84, "Sequence: tapping with chip breaking").
        """
        kind, unit = arguments.code(15) % 10, self.state.unit
        step, retract = abs(arguments.number(16)) * unit, abs(arguments.number(17)) * unit
        whole = abs(levels.reference - levels.bottom)
        if not kind or not 0.0 < step < whole:
            return []
        if whole > MOST_PECKS * step:
            raise BlockError(f"CYCLE84 taps in more than {MOST_PECKS} strokes: correct _DAM, its argument 17")
        if kind == 1 and not retract:
            raise Unread("CYCLE84 with chip breaking without _VRT", "write how far it goes back, argument 18")
        down = math.copysign(1.0, levels.bottom - levels.reference)
        ends = [levels.reference + down * step * k for k in range(1, math.ceil(whole / step - 1e-9))]
        most = math.inf if kind == 2 else retract
        return [(end, end - down * min(most, abs(end - levels.top))) for end in ends]

    def _floating_tap(self, arguments: Arguments, levels: Levels) -> None:
        spindle = self.control.feed.spindle
        if arguments.number(9) or arguments.number(10):
            speed = pitch_of(arguments, self.state.unit, size=9, pitch=10, kind=12) * spindle
        else:
            # without a pitch the feed of the program is the one that fits (G63)
            speed = self.control.feed.rate(self.state.inverse, self.control.line).speed
        self._tap(levels, speed, speed, self._dwell(arguments.number(5)))

    def _tap(
        self, levels: Levels, into: float, out: float, dwell: float, strokes: Sequence[tuple[float, float]] = ()
    ) -> None:
        way = self._along(levels)
        way.over()
        self.control.stop()
        for end, back in strokes:
            way.feed(end, into)
            self.control.stop()
            way.feed(back, out)
            self.control.stop()
        way.feed(levels.bottom, into)
        self.control.stop()
        way.pause(dwell)
        way.feed(levels.top, out)
        self.control.stop()
        way.rapid(levels.back)
