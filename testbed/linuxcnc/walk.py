"""A walk along our points and the motions of LinuxCNC's interpreter, to the first place where they differ."""

from __future__ import annotations

import math

import numpy as np

from testbed.linuxcnc.canon import Judged, Motion
from testbed.linuxcnc.job import Cartesian
from toolpace.common.arrays import Floats
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.toolpath import ToolPath

PRINTED = 3e-4
"""Rounding of a place, in units: four decimals of it and of up to three offsets."""


BOW = 5e-4
"""Most distance of our points' chords from their arc [mm]."""


class Walk:
    """Our points, one motion of the interpreter after the other."""

    def __init__(self, ours: ToolPath, theirs: Judged, *, numbered: bool = True) -> None:
        """numbered: whether the N of each line is its number, which is then compared too."""
        self.numbered = numbered
        assert ours.rotary is not None
        self.ours, self.theirs = ours, theirs
        turned = ours.rotary / DEGREE
        # the axis of its tool is +z wherever the joints are
        lengths = np.where(np.isnan(ours.tool_length), Cartesian.tool_length, ours.tool_length)
        nose = ours.tip + np.outer(lengths, [0.0, 0.0, 1.0])
        self.points = np.column_stack([nose / MILLIMETRE, turned[:, 0], np.zeros(len(turned)), turned[:, 1]])
        self.times = np.maximum(np.append(0.0, ours.way_length[1:] / ours.feed[1:]), ours.least_time)
        self.at = 0
        self.waited = float(ours.dwell[0])

    def difference(self) -> str:
        """The first; empty where there is none."""
        if np.abs(self.points[0]).max() > 1e-9:
            return f"our path begins at {self.points[0]}, not at the machine's zero"
        for number, motion in enumerate(self.theirs.motions):
            before = self.at, self.waited
            found = self._motion(motion)
            if found and not self.theirs.exact and (other := motion.otherwise(PRINTED * motion.unit)):
                self.at, self.waited = before
                found = self._motion(other) and found
            if found:
                return f"motion {number} ({_said(motion)}): {found}"
        last = self.theirs.motions[-1] if self.theirs.motions else None
        rest = self.points[self.at + 1 :]
        if last is not None and len(rest) and np.abs(rest - last.end).max() > 2 * PRINTED * last.unit:
            return f"we go on to {rest[0].round(4)} (line {self.ours.block[self.at + 1]}), rs274 has ended"
        waited = float(self.ours.dwell.sum())
        return "" if math.isclose(waited, self.theirs.waited, abs_tol=1e-3) else (
            f"we wait {waited:g} s in all, rs274 {self.theirs.waited:g} s"
        )  # fmt: skip

    def _motion(self, motion: Motion) -> str:
        near = PRINTED * motion.unit
        if motion.normal < 0 and np.abs(motion.end - motion.start).max() <= near:
            while self.at + 2 < len(self.points) and np.abs(self.points[self.at + 1] - motion.end).max() <= near:
                self._pass_over()
            return ""
        if not math.isclose(self.waited, motion.waited, abs_tol=1e-3):
            return f"we waited {self.waited:g} s before it, rs274 {motion.waited:g} s"
        self._finish_motion_before(motion, near)
        way = _Way(motion)
        spent, first = 0.0, self.at + 1
        while not way.done(self.points[self.at], near) or self.at < first:
            self.at += 1
            if self.at >= len(self.points):
                return "our path ends before it"
            off = way.off(self.points[self.at])
            line = int(self.ours.block[self.at])
            if off > 3 * near:
                return f"we go to {self.points[self.at].round(4)} (line {line}), {off:.4g} mm off"
            if bool(self.ours.rapid[self.at]) != motion.rapid:
                return f"rapid with one, feed with the other (line {line})"
            if self.numbered and motion.line and line != motion.line:
                return f"we are on line {line}, it is of {motion.line}"
            spent += self._step()
        while self._still_there(motion, near):
            self.at += 1
            spent += self._step()
        return "" if motion.rapid else self._of_time(motion, spent, near, self.theirs.exact)

    def _finish_motion_before(self, motion: Motion, near: float) -> None:
        """Pass over points that are of the motion before, which ended by the printed decimals: all are at its end."""
        while self.at + 2 < len(self.points):
            at = self.at + 1
            other = bool(self.ours.rapid[at]) != motion.rapid or (
                self.numbered and motion.line and int(self.ours.block[at]) != motion.line
            )
            if not other or np.abs(self.points[at] - motion.start).max() > 2 * near:
                return
            self._pass_over()

    def _pass_over(self) -> None:
        """Go on to the next point."""
        self.at += 1
        self._step()

    def _step(self) -> float:
        """Time of the way to the point at hand [s]; its dwell is counted."""
        self.waited += float(self.ours.dwell[self.at])
        return float(self.times[self.at])

    def _still_there(self, motion: Motion, near: float) -> bool:
        """Whether the next point is one more of the same block, at the motion's end as far as it is printed."""
        following = self.at + 1
        return (
            following < len(self.points)
            and self.ours.block[following] == self.ours.block[self.at]
            and bool(self.ours.rapid[following]) == motion.rapid
            and not self.ours.dwell[self.at]
            and float(np.abs(self.points[following] - motion.end).max()) <= near
        )

    @staticmethod
    def _of_time(motion: Motion, spent: float, near: float, exact: bool) -> str:
        wanted = motion.seconds()
        rate = (motion.rate / motion.unit) if motion.travels() else motion.turn
        size = min(motion.radius(), motion.length()) if motion.normal >= 0 else motion.length()
        doubt = 4 * near / max(size, near)
        if motion.normal >= 0:
            doubt += BOW / (3.0 * motion.radius())  # chords are so much shorter than their arc
        if not exact:
            doubt += 1e-4 / max(rate, 1e-4)
        if abs(spent - wanted) <= wanted * (1e-6 + doubt):
            return ""
        return f"we take {spent:g} s, rs274 {wanted:g} s"


class _Way:
    """The places of a motion, and how far along a place is."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.progress = 0.0
        """Share of the motion that was gone."""
        self.way = motion.end - motion.start
        self.size = float(self.way @ self.way)
        if motion.normal >= 0:
            self.axis = np.array(motion.axis)
            spoke = motion.start[:3] - np.array(motion.centre)
            self.height = float(spoke @ self.axis)
            self.u = spoke - self.height * self.axis
            self.w = np.cross(self.axis, self.u)
            self.rise = float(self.way[:3] @ self.axis)
            self.radius = motion.radius()
            # ends that differ in radius are those of a spiral, evenly widened (LinuxCNC's pmCirclePoint)
            self.growth = motion.radius(at_end=True) / self.radius - 1.0

    def off(self, point: Floats) -> float:
        """Distance of a place from the way; progress goes on to it."""
        if self.motion.normal < 0:
            share = float((point - self.motion.start) @ self.way) / self.size
            near = PRINTED * self.motion.unit / math.sqrt(self.size)
            if share < self.progress - near:
                return float(np.linalg.norm(point - self.motion.start))
            self.progress = max(self.progress, share)
            return float(np.linalg.norm(point - self.motion.start - min(share, 1.0) * self.way))
        spoke = point[:3] - np.array(self.motion.centre)
        angle = math.atan2(float(spoke @ self.w), float(spoke @ self.u))
        sweep = self.motion.sweep
        share = angle / sweep
        turn = 2 * math.pi / abs(sweep)
        # the same angle one turn later, where it lies behind what was gone
        share += turn * math.ceil((self.progress - share) / turn - 1e-3)
        beyond = (share - 1.0) * abs(sweep) * self.radius
        if beyond > 4 * PRINTED * self.motion.unit + 1e-6 * self.radius:
            return beyond  # of the way on the other side of the circle too
        self.progress = max(self.progress, share)
        wanted = self.motion.start + share * self.way
        turned = math.cos(share * sweep) * self.u + math.sin(share * sweep) * self.w
        turned = turned * (1.0 + self.growth * share)
        wanted[:3] = np.array(self.motion.centre) + turned + (self.height + share * self.rise) * self.axis
        # what the rounding of the centre makes of the share gone, the rotary axes show too,
        doubt = 4 * PRINTED * self.motion.unit / (self.radius * abs(sweep))
        rotary = np.abs(point - wanted)[3:] - doubt * np.abs(self.way[3:])
        aside = (point - wanted)[:3]
        along = float(aside @ self.axis)
        # and the height of a helix
        risen = max(abs(along) - doubt * abs(self.rise), 0.0)
        return max(math.hypot(float(np.linalg.norm(aside - along * self.axis)), risen), float(rotary.max()))

    def done(self, point: Floats, near: float) -> bool:
        """Whether a place is the end."""
        if self.motion.normal >= 0:
            missing = (1.0 - self.progress) * abs(self.motion.sweep) * self.radius
            return missing < 4 * near + 1e-6 * self.radius and bool(np.abs(point - self.motion.end).max() <= 2 * near)
        return bool(np.abs(point - self.motion.end).max() <= near)


def _said(motion: Motion) -> str:
    kind = "rapid" if motion.rapid else "arc" if motion.normal >= 0 else "feed"
    return f"{kind} from {motion.start.round(4)} to {motion.end.round(4)}, N{motion.line}"
