"""Replaces the feeds of a program: by a value, by a factor, or by none."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from toolpace.errors import UsageError
from toolpace.toolpath import ToolPath
from toolpace.units import parse_feed, parse_percent


@dataclass(frozen=True)
class FeedChange:
    """What `--feed` asks for."""

    speed: float | None = None
    """Speed of the tip [m/s] in place of the program's; inf: no caps at all; None: the program's times `factor`."""
    factor: float = 1.0

    @staticmethod
    def parse(text: str) -> FeedChange:
        """`none`, a factor such as `120%`, or a value such as `3000mm/min`; UsageError otherwise."""
        spec = text.strip().lower()
        if spec == "none":
            return FeedChange(speed=np.inf)
        if spec.endswith("%"):
            return FeedChange(factor=parse_percent(spec))
        try:
            return FeedChange(speed=parse_feed(spec))
        except UsageError as error:
            raise UsageError(f"{error}; or a factor like 120%, or none") from None

    def apply(self, toolpath: ToolPath) -> ToolPath:
        """The same points with other feeds; rapids keep having none.

        A value rules where the tip moves, also where inverse times ruled before; rotations in place keep
        their times, since a length per minute says nothing of them.
        """
        feed, least_time = toolpath.feed.copy(), toolpath.least_time.copy()
        if self.speed is None:
            feed, least_time = feed * self.factor, least_time / self.factor
        elif np.isinf(self.speed):
            feed[:], least_time[:] = np.inf, 0.0
        else:
            travels = np.zeros(len(feed), dtype=bool)
            travels[1:] = np.linalg.norm(np.diff(toolpath.tip, axis=0), axis=1) > 1e-12
            ruled = travels & (np.isfinite(feed) | (least_time > 0))
            feed[ruled], least_time[ruled] = self.speed, 0.0
        return dataclasses.replace(toolpath, feed=feed, least_time=least_time)


def apply_feed(toolpath: ToolPath, spec: str) -> ToolPath:
    """The tool path with its feeds changed as `spec` says: `none`, `120%` or `3000mm/min`."""
    return FeedChange.parse(spec).apply(toolpath)
