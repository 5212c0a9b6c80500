"""Cutting forces, deflection and what it leaves on the surface, from the engagement of a tool along a motion.

edge of the tool                 points by slice: radius, normal of the surface, lag of the helix         cutting_edge
motion per tooth                 feed per tooth across and along the axis; turn of the axis
at each station, by angle        chip of each point in an arc of its slice; force on it                   kernels
mean, peaks                      of forces, torque, moment at the holder, deflection at three heights
left on the surface              deflection where the chip is nothing, along the normal

Forces act on the tool, along the feed, the normal (on the left of the feed, seen from the spindle), and the axis (from
the tip to the spindle), as in `CuttingForces`. At the share o of the speeds they are slope * o + constant at each
angle; with runout that holds as long as the same tooth as now leaves the chip to each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, integers, number, numbers
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.forces.cutting_edge import CuttingEdge
from toolpace.cutting.forces.tool_beam import ToolBeam, bends
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

if TYPE_CHECKING:
    from toolpace.kernels.cutting.forces import Arcs, Edge, Teeth

STEP = math.radians(0.2)
"""Most between two angles at which the forces of a turn are looked at [rad]. Of 100 random engagements peaks are within
0.06 percent of the largest force in the median, and within 0.7 at worst; of twelve more one was at 1.1."""
LAG = 3.75
"""Most lag of the helix over a piece of the edge, in such steps."""
BLOCK = 2000
"""Stations that one call of the kernel takes."""
THREADS = 2


@dataclass(frozen=True)
class CutLoads:
    """What n stations take, all at the speeds that they were worked out for; nothing where nothing is in material."""

    mean: Floats
    """(n, 3) force along feed, normal and axis over a turn [N]."""
    peak: Floats
    """(n, 3) the largest of each over a turn, with its sign [N]."""
    resultant: Floats
    """(n,) largest size of the force [N]."""
    mean_torque: Floats
    """(n,) [N m]"""
    torque: Floats
    """(n,) largest [N m]."""
    power: Floats
    """(n,) that the spindle gives, mean over a turn [W]."""
    moment: Floats
    """(n,) largest bending moment at the holder [N m]; nan without a stick-out, like deflections."""
    mean_deflection: Floats
    """(n, 2) of the tip along feed and normal over a turn [m]."""
    deflection: Floats
    """(n,) largest of the tip [m]."""
    surface: Floats
    """(n, 2) material that deflection leaves on the surface, along its normal: least and most over the places where the
    edge generates it [m]; below zero: cut too deep. nan where no surface is generated."""
    surface_height: Floats
    """(n, 2) how high above the tip these places are [m]."""
    chip: Floats
    """(n,) thickest chip [m]."""
    chip_area: Floats
    """(n,) largest area of the chips of all teeth at one time [m2]."""
    edge_length: Floats
    """(n,) most of the edge in material at one time, as width of the chips [m]."""


@dataclass(frozen=True, eq=False)
class EngagedForces:
    """The forces of a tool in an engagement of n stations, at any speed.

    Raises UsageError where a figure of the tool is missing (teeth, spindle speed), and for a table that contradicts
    itself.
    """

    engagement: EngagementTable
    tool: ToolFigures
    coefficients: Coefficients
    spindle_speed: float | None = None
    """Turns per second [1/s]; None: the tool's."""
    runout_angle: float = 0.0
    """Where the axis of the tool is off to, from the first tooth at the tip, in the sense in which it turns [rad]."""
    youngs_modulus: float | None = None
    """Of the tool [Pa]; None: by its material."""
    step: float = STEP
    """Most between two angles at which a turn is looked at [rad]; finer finds peaks closer, and takes longer."""
    threads: int = field(default=THREADS, compare=False)

    def __post_init__(self) -> None:
        table, count = self.engagement, len(self.engagement.along)
        first = integers(table.first_arc, "engagement: first_arc", (count + 1,))
        arcs = int(first[-1])
        # the kernel reads the arcs that first_arc points at
        if first[0] != 0 or (np.diff(first) < 0).any():
            raise UsageError("engagement: first_arc must ascend from 0 to the number of arcs")
        if integers(table.slice, "engagement: slice", (arcs,)).min(initial=0) < 0:
            raise UsageError("engagement: slice must be 0 or more")
        entry, leave = (numbers(getattr(table, name), f"engagement: {name}", (arcs,)) for name in ("entry", "exit"))
        if (leave < entry).any() or (leave > entry + 2.0 * math.pi + 1e-9).any():
            raise UsageError("engagement: exit must be at entry or up to a turn above it [rad]")
        for name in ("across", "along", "bottom"):
            numbers(getattr(table, name), f"engagement: {name}", (count,))
        number(table.slice_height, "engagement: slice_height", least=0.0, above=True, unit="m")

    @cached_property
    def turns_per_second(self) -> float:
        """Spindle speed [1/s]."""
        speed = self.tool.spindle_speed if self.spindle_speed is None else self.spindle_speed
        if speed is None:
            raise UsageError("cutting forces: the spindle speed is not known; give spindle_speed in the tool table")
        return number(speed, "cutting forces: spindle_speed", least=0.0, above=True, unit="1/s")

    @cached_property
    def tooth_count(self) -> int:
        """How many teeth."""
        if self.tool.teeth is None or self.tool.teeth < 1:
            raise UsageError("cutting forces: the number of teeth is not known; give teeth in the tool table")
        return self.tool.teeth

    @cached_property
    def _points(self) -> CuttingEdge:
        """Its points, up to the highest slice in material."""
        slices = int(self.engagement.slice.max(initial=0)) + 1
        return CuttingEdge.of(self.tool, self.engagement.slice_height, slices, LAG * self.step)

    @cached_property
    def _beam(self) -> ToolBeam | None:
        """The bar that bends; None where its stick-out or its material is not known."""
        known = bends(self.tool) if self.youngs_modulus is None else self.tool.stick_out is not None
        return ToolBeam.of(self.tool, self.youngs_modulus) if known else None

    @property
    def bends(self) -> bool:
        """Whether moments and deflections are known: the tool's stick-out and its material are."""
        return self._beam is not None

    @property
    def section_modulus(self) -> float:
        """Of the shank at the holder [m3]; nan where it is not known."""
        return math.nan if self._beam is None else math.pi * float(self._beam.diameter[-1, 1]) ** 3 / 32.0

    def loads(self, speed: npt.ArrayLike, turning: npt.ArrayLike | None = None) -> CutLoads:
        """Loads at speeds (n,) of the tip [m/s], with the axis turning at (n, 2) along feed and normal [rad/s].

        See `turning_of`. Raises UsageError for other shapes.
        """
        from toolpace.kernels.cutting import forces as kernel
        from toolpace.kernels.cutting.loads import DEFLECTION, MOMENT, PEAKS, RESULTANT, THICKNESS, loads

        motion = self._motion(speed, turning)
        count, channels = len(motion), self._channels
        mean, peak, left = np.empty((count, channels)), np.empty((count, PEAKS)), np.empty((count, 4))

        def work(at: slice) -> None:
            teeth, arcs = self._teeth(), self._arcs(at)
            loads(mean[at], peak[at], left[at], self._edge, teeth, arcs, motion[at], self.cells)

        with ThreadPoolExecutor(self.threads) as pool:
            list(pool.map(work, self._blocks(count)))
        bends = self._beam is not None
        none = np.full(count, np.nan)
        tip = kernel.WEIGHTED + 2 * kernel.TIP
        return CutLoads(
            mean=mean[:, :3],
            peak=peak[:, :3],
            resultant=peak[:, RESULTANT],
            mean_torque=mean[:, kernel.TORQUE],
            torque=peak[:, kernel.TORQUE],
            power=mean[:, kernel.TORQUE] * 2.0 * math.pi * self.turns_per_second,
            moment=peak[:, MOMENT] if bends else none,
            mean_deflection=mean[:, tip : tip + 2] if bends else np.stack([none, none], axis=1),
            deflection=peak[:, DEFLECTION] if bends else none,
            surface=left[:, 0::2],
            surface_height=left[:, 1::2],
            chip=self._thickest(speed, peak[:, THICKNESS]),
            chip_area=peak[:, kernel.AREA],
            edge_length=peak[:, kernel.LENGTH],
        )

    def _thickest(self, speed: npt.ArrayLike, of_points: Floats) -> Floats:
        """(n,) thickest chips at speeds (n,) [m]; of_points: those at points of the edge whose slice is in material."""
        share = self.engagement.chip_share
        if not len(share) or not self.alike:
            return of_points
        told = np.asarray(speed) * share / (self.tooth_count * self.turns_per_second)
        # of the flat end, and where only the axis turns, the points alone tell
        at_end = self.engagement.bottom > 0.0
        return np.where(at_end, np.maximum(told, of_points), np.where(told > 0.0, told, of_points))

    def along(self, stations: Stations) -> CutLoads:
        """Loads at stations (n,), at the speed of the way to each and with its axis turning; none to the first.

        Raises UsageError where the table is not of these stations.
        """
        if len(stations) != len(self.engagement.along):
            raise UsageError(
                f"cutting forces: {len(stations)} stations and an engagement of {len(self.engagement.along)}; "
                "give those that it was found at"
            )
        duration = np.diff(stations.time, prepend=stations.time[:1])
        moves = duration > 0.0
        way = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
        speed = np.divide(way, duration, where=moves, out=np.zeros_like(way))
        return self.loads(speed, turning_of(stations.axis, stations.time, self.engagement))

    def over_turn(
        self, stations: npt.ArrayLike, speed: npt.ArrayLike, turning: npt.ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Slope and constant (m, angles, 4) of force along feed, normal, axis [N] and torque [N m], of some stations.

        At the share o of the speeds (n,) the force is slope * o + constant. Angles are even over one pitch where all
        teeth are alike, else over a turn.
        """
        from toolpace.kernels.cutting.loads import turns

        count = len(self.engagement.along)
        chosen = np.atleast_1d(integers(stations, "cutting forces: stations", (), ("m",)))
        if chosen.min(initial=0) < 0 or chosen.max(initial=-1) >= count:
            raise UsageError(f"cutting forces: stations must be from 0 to {count - 1}")
        motion, arcs = self._motion(speed, turning), self._arcs(slice(0, count))
        slope = np.empty((len(chosen), self.cells, self._channels))
        constant = np.empty_like(slope)
        turns(slope, self._edge, self._teeth(constant=0.0), arcs, motion, chosen)
        turns(constant, self._edge, self._teeth(slope=0.0), arcs, motion, chosen)
        return slope[:, :, :4], constant[:, :, :4]

    def chips_together(self, speed: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Area of the chips [m2] and engaged edge [m] at one time, (n, 2) each: where the area is largest over a turn,
        and where the edge is."""
        from toolpace.kernels.cutting import forces as kernel
        from toolpace.kernels.cutting.loads import turns

        motion, teeth = self._motion(speed, None), self._teeth()
        area, edge = np.empty((len(motion), 2)), np.empty((len(motion), 2))
        for at in self._blocks(len(motion)):
            turn = np.empty((at.stop - at.start, self.cells, self._channels))
            turns(turn, self._edge, teeth, self._arcs(at), motion[at], np.arange(len(turn)))
            both = turn[:, :, [kernel.AREA, kernel.LENGTH]]
            row = np.arange(len(turn))
            for k in range(2):
                found = both[row, both[:, :, k].argmax(axis=1)]
                area[at, k], edge[at, k] = found.T
        return area, edge

    @property
    def alike(self) -> bool:
        """Whether all teeth cut the same: evenly spaced, without runout."""
        return not self.tool.pitch and self.tool.runout == 0.0

    @property
    def cells(self) -> int:
        """Angles at which forces are looked at: of a pitch where all teeth are alike, else of a turn."""
        whole = 2.0 * math.pi / self.tooth_count if self.alike else 2.0 * math.pi
        return math.ceil(whole / self.step - 1e-9)

    @property
    def _channels(self) -> int:
        from toolpace.kernels.cutting.forces import WEIGHTED

        return WEIGHTED + 2 * int(self._edge.weight.shape[1])

    def _motion(self, speed: npt.ArrayLike, turning: npt.ArrayLike | None) -> Floats:
        """(n, 4) per tooth: across, along [m], turn of the axis along feed and normal [rad]."""
        count = len(self.engagement.along)
        speeds = numbers(speed, "cutting forces: speed", (), (count,), unit="m/s")
        per_tooth = 1.0 / (self.tooth_count * self.turns_per_second)
        motion = np.zeros((count, 4))
        motion[:, 0] = speeds * per_tooth * self.engagement.across
        motion[:, 1] = speeds * per_tooth * self.engagement.along
        if turning is not None:
            motion[:, 2:] = per_tooth * numbers(turning, "cutting forces: turning", (count, 2), unit="rad/s")
        return motion

    @cached_property
    def _edge(self) -> Edge:
        from toolpace.kernels.cutting.forces import Edge

        edge, k = self._points, self.coefficients
        sine, cosine = np.sin(edge.kappa), np.cos(edge.kappa)

        def along(tangential: float, radial: float, axial: float) -> list[Floats]:
            # the radial force is along the normal of the surface, the axial one along its meridian
            return [
                tangential * edge.width,
                -(radial * sine + axial * cosine) * edge.width,
                (radial * cosine - axial * sine) * edge.width,
            ]

        force = np.stack(
            along(k.tangential, k.radial, k.axial) + along(k.tangential_edge, k.radial_edge, k.axial_edge), axis=1
        )
        top = float(edge.height.max())
        node = np.array([0.0, 0.5, 1.0]) * max(top, self.engagement.slice_height)
        weight = np.zeros((len(edge.height), 0))
        if self._beam is not None:
            bent = self._beam.compliance(node, edge.height).T
            weight = np.concatenate([self._beam.length - edge.height[:, None], bent], axis=1)
        return Edge(
            edge.first, edge.height, edge.radius, sine, cosine, edge.lag, edge.span, edge.width, force,
            np.ascontiguousarray(weight), node,
        )  # fmt: skip

    def _teeth(self, slope: float = 1.0, constant: float = 1.0) -> Teeth:
        from toolpace.kernels.cutting.forces import Teeth

        count, sense = self.tooth_count, 1.0 if self.tool.clockwise else -1.0
        pitch = np.array(self.tool.pitch) if self.tool.pitch else np.full(count, 2.0 * math.pi / count)
        if len(pitch) != count or abs(pitch.sum() - 2.0 * math.pi) > 1e-6:
            raise UsageError(
                f"cutting forces: pitch has {len(pitch)} angles of {math.degrees(pitch.sum()):g} degrees in all; "
                f"give {count} of 360 degrees"
            )
        angle = np.concatenate([[0.0], np.cumsum(pitch)[:-1]])
        share = np.ones((count, 1))
        if not self.alike:
            twice = np.concatenate([pitch, pitch]) * count / (2.0 * math.pi)
            share = np.stack([np.cumsum(twice[tooth : tooth + count]) for tooth in range(count)])
        return Teeth(sense * angle, share, self.tool.runout, sense * self.runout_angle, sense, slope, constant)

    def _arcs(self, at: slice) -> Arcs:
        from toolpace.kernels.cutting.forces import Arcs

        table = self.engagement
        first = np.ascontiguousarray(table.first_arc[at.start : at.stop + 1])
        entry, leave, bottom = (
            np.ascontiguousarray(each, dtype=float) for each in (table.entry, table.exit, table.bottom[at])
        )
        slices = np.ascontiguousarray(table.slice, dtype=np.int64)
        return Arcs(first, slices, entry, leave, self._shares, bottom)

    @cached_property
    def _shares(self) -> Floats:
        """(k,) of the height of its slice that is in material, of each arc: of all slices but the lowest and the
        highest of a station the whole."""
        table, found = self.engagement, np.ones(len(self.engagement.slice))
        count = np.diff(table.first_arc)
        cuts = count > 0
        if not len(table.top) or not cuts.any():
            return found
        begin = table.first_arc[:-1][cuts]
        for extreme, end, sign in ((np.maximum, table.top, 1.0), (np.minimum, table.top - table.depth, -1.0)):
            slices = extreme.reduceat(table.slice, begin)
            covered = end[cuts] / table.slice_height - slices
            at_end = table.slice == np.repeat(slices, count[cuts])
            found[at_end] += np.repeat(sign * covered - (sign > 0.0), count[cuts])[at_end]
        return np.asarray(np.clip(found, 0.0, 2.0))

    def _blocks(self, count: int) -> Iterator[slice]:
        for begin in range(0, count, BLOCK):
            yield slice(begin, min(begin + BLOCK, count))


def turning_of(axis: Floats, time: Floats, engagement: EngagementTable) -> Floats:
    """Turn of the tool axis per second (n, 2) [rad/s] along feed and normal, from axes (n, 3) at times (n,) [s]."""
    rate = np.zeros_like(axis)
    duration = np.diff(time)
    moves = duration > 0.0
    rate[1:][moves] = np.diff(axis, axis=0)[moves] / duration[moves, None]
    feed = engagement.feed_direction
    normal = np.cross(axis, feed)
    return np.stack([np.einsum("nc,nc->n", rate, feed), np.einsum("nc,nc->n", rate, normal)], axis=1)
