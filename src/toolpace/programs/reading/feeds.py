"""Replacement of a program's feeds: by a value, a factor, or none."""

from __future__ import annotations

import dataclasses
import reprlib
from dataclasses import dataclass

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.common.units import MILLIMETRE, MINUTE, format_time, parse_feed, parse_percent
from toolpace.programs.toolpath import ToolPath

SLOWEST, FASTEST = 1e-6 * MILLIMETRE / MINUTE, 1e6 / MINUTE
"""Between which a feed lies [m/s]: what is slower is a slip, and squares of what is faster lose all digits."""
SLOW, LONG = 20.0 * MILLIMETRE / MINUTE, 300.0
"""A feed below the one [m/s], for longer than the other [s], is seldom meant: F3 for 3 m/min."""
LEAST, MOST = 1e-6, 1e6
"""Between which a factor of feeds lies."""
LONGEST_DWELL = 86400.0
"""A day [s]: a longer dwell is a slip of units."""
LONGEST = 86400.0 * 366
"""Most time of one block [s]."""


def feed_fault(speed: float) -> str:
    """What is wrong with a feed [m/s], and the cure; empty where nothing is."""
    if SLOWEST <= speed <= FASTEST:
        return ""
    shown = f"feed {speed * MINUTE / MILLIMETRE:.3g} mm/min is"
    if speed < SLOWEST:
        return f"{shown} below {SLOWEST * MINUTE / MILLIMETRE:g} mm/min: correct it, or check its units"
    return f"{shown} above {FASTEST * MINUTE / MILLIMETRE:g} mm/min: correct it; for no feed limit give --feed none"


def with_doubt_of_slow_feeds(toolpath: ToolPath) -> ToolPath:
    """With an assumption that tells how long feeds below 20 mm/min take, where that is more than five minutes."""
    slow = np.isfinite(toolpath.feed) & (toolpath.feed < SLOW) & ~toolpath.rapid
    time = float((toolpath.way_length[slow] / toolpath.feed[slow]).sum())
    if time <= LONG:
        return toolpath
    least, line = float(toolpath.feed[slow].min()), int(toolpath.block[np.argmax(slow)])
    said = (
        f"feeds of {least * MINUTE / MILLIMETRE:.3g} mm/min and more are meant, though they take {format_time(time)} "
        f"(first line {line}): is F in metres or inches, or a revolution? --feed gives another"
    )
    return dataclasses.replace(toolpath, assumed=(*toolpath.assumed, said))


@dataclass(frozen=True)
class FeedChange:
    """What `--feed` asks for."""

    speed: float | None = None
    """Speed of the tip [m/s] in place of the program's; inf: no caps at all; None: the program's times `factor`."""
    factor: float = 1.0

    @staticmethod
    def parse(text: str) -> FeedChange:
        """`none`, a factor such as `120%`, or a value such as `3000mm/min`; UsageError otherwise."""
        if not isinstance(text, str):
            raise UsageError(f"feed is {reprlib.repr(text)[:40]}; write text with its unit, like '3000mm/min'")
        spec = text.strip().lower()
        if spec == "none":
            return FeedChange(speed=np.inf)
        if spec.endswith("%"):
            factor = parse_percent(spec)
            if not LEAST <= factor <= MOST:
                raise UsageError(f"factor '{text.strip()[:40]}' must be between 0.0001% and 100000000%, like 120%")
            return FeedChange(factor=factor)
        try:
            speed = parse_feed(spec)
        except UsageError as error:
            raise UsageError(f"{error}; or a factor like 120%, or none") from None
        if fault := feed_fault(speed):
            raise UsageError(f"'{text.strip()[:40]}': {fault}")
        return FeedChange(speed=speed)

    def apply(self, toolpath: ToolPath) -> ToolPath:
        """The same points with other feeds; rapids keep having none.

        A value rules where the tip moves, also where inverse times ruled before; rotations in place keep
        their times, since a length per minute says nothing of them.
        """
        feed, least_time = toolpath.feed.copy(), toolpath.least_time.copy()
        if self.speed is None:
            feed, least_time = feed * self.factor, least_time / self.factor
            if fault := feed_fault(float(feed.min())) if feed.min() < SLOWEST else "":
                raise UsageError(f"with --feed {100.0 * self.factor:g}%: {fault}")
        elif np.isinf(self.speed):
            feed[:], least_time[:] = np.inf, 0.0
        else:
            travels = toolpath.way_length > 1e-12
            ruled = travels & (np.isfinite(feed) | (least_time > 0))
            feed[ruled], least_time[ruled] = self.speed, 0.0
        return dataclasses.replace(toolpath, feed=feed, least_time=least_time)


def apply_feed(toolpath: ToolPath, spec: str) -> ToolPath:
    """The tool path with its feeds changed as `spec` says: `none`, `120%` or `3000mm/min`."""
    return FeedChange.parse(spec).apply(toolpath)
