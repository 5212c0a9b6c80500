"""What a controller remembers from block to block."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from toolpace.reading.gcode.moves import Rate
from toolpace.reading.source import Source
from toolpace.units import DEGREE, INCH, MILLIMETRE, MINUTE


@dataclass(slots=True)
class Modal:
    """The state of the interpreter; defaults are millimetres, absolute, G94, XY plane, continuous path."""

    position: list[float]
    """X, Y, Z [m] and the rotary joints [rad], zero before they are named."""
    default_feed: float | None
    """Speed of motions for which the program gives no F [m/s]; None makes that an error."""
    unit: float = MILLIMETRE
    absolute: bool = True
    arc_absolute: bool = False
    plane: int = 0
    motion: int | None = None
    inverse_time: bool = False
    exact_stop: bool = False
    switched_tip_mode: bool = False
    """By M428, M429."""
    length_tip_mode: bool = False
    """By G43.4, G49."""
    feed: float | None = None
    """F [m/s] as a length; in inverse time it is not remembered."""
    turn_feed: float = 0.0
    """The same F as degrees per minute [rad/s]."""
    named: int = 0
    """Bits of X, Y, Z named so far."""
    ended: bool = False
    blocks: int = 0
    skipped: Counter[str] = field(default_factory=Counter)

    @property
    def tip_mode(self) -> bool:
        return self.switched_tip_mode or self.length_tip_mode

    def set_feed(self, value: float) -> None:
        """Remember F, in units or degrees per minute."""
        self.feed = value * self.unit / MINUTE
        self.turn_feed = value * DEGREE / MINUTE

    def set_units(self, code: int) -> None:
        self.unit = INCH if code == 200 else MILLIMETRE

    def set_feed_mode(self, code: int) -> None:
        """G93 or G94; an F of the one says nothing in the other."""
        inverse = code == 930
        if inverse != self.inverse_time:
            self.inverse_time, self.feed = inverse, None

    def rate(self, source: Source, line: int, number: float | None) -> Rate:
        """Rate of a motion at feed whose block has F `number`, or none."""
        if self.inverse_time:
            if number is not None:
                return Rate(time=MINUTE / number)
            if self.default_feed is None:
                source.fail("feed missing: under G93 every G1, G2, G3 needs its own F [1/min]", line)
        elif self.feed is not None:
            return Rate(self.feed, self.turn_feed)
        if self.default_feed is None:
            source.fail(
                "feed missing: no F before this motion; write one, or give --feed 3000mm/min (feed= in Python)",
                line,
            )
        # Of rotations in place a length per minute says nothing: the axes' own limits rule them.
        return Rate(self.default_feed)
