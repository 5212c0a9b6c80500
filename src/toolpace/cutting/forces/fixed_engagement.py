"""Cutting forces of a cylindrical end mill, by the mechanistic model with linear edge forces.

Altintas, Manufacturing Automation (2nd edition, 2012), chapter 2; the chip that runout leaves to each tooth is that of
Kline and DeVor (The effect of runout on cutting geometry and forces in end milling, International Journal of Machine
Tool Design and Research 23, 1983).

    phi           angle of an edge, from the normal to the feed, in the sense in which the tool turns
    h(phi)        = c sin(phi): thickness of the chip, c the feed per tooth
    tangential    dF = (Ktc h + Kte) dz     against the motion of the edge
    radial        dF = (Krc h + Kre) dz     towards the axis of the tool
    axial         dF = (Kac h + Kae) dz     away from the spindle, as a right-hand helix pulls a tool out

Forces act on the tool. They have three components: along the feed; along the normal, which is on the left of the feed
seen from the spindle; and along the axis, from the tip to the spindle. Where the spindle turns counterclockwise, all is
mirrored: the force along the normal has the other sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import FASTEST_FEED, METRES_PER_SECOND, refuse_other_unit
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.cutting_tool import FORCES, Cut, Force

LAG = math.radians(1.5)
"""Most lag of the helix over one slice [rad]."""
TURN = 720
"""Angles at which the force of a turn is looked at."""
CHIPS = 33
"""Chip loads for which mean and peak are worked out where they have no closed form; between them is interpolated."""


@dataclass(frozen=True, eq=False, repr=False)
class CuttingForces(ByValue):
    """The forces of a cut over the turn of the tool, and what of them bends it: the mean, or the peak."""

    cut: Cut
    tables: dict[str, tuple[Floats, Floats]] = field(default_factory=dict, init=False, compare=False)
    """Forces over feeds per tooth, by kind, as far as they were asked for."""

    def __repr__(self) -> str:
        mean = self.feed_forward(np.array([1e-5]))[0]
        shown = " ".join(f"{value:.3g}" for value in mean)
        return one_line(self, f"mean {shown} N along feed, normal and axis at 0.01 mm a tooth")

    @property
    def immersion(self) -> tuple[float, float]:
        """Angles at which an edge enters the material and leaves it [rad]."""
        if self.cut.engagement.milling == "slot":
            return 0.0, math.pi
        wide = math.acos(1.0 - 2.0 * self.cut.width / self.cut.cutter.diameter)
        return (0.0, wide) if self.cut.engagement.milling == "up" else (math.pi - wide, math.pi)

    def feed_per_tooth(self, speed: npt.ArrayLike) -> Floats:
        """Chip load [m] at a speed, or at speeds (n,), across the tool axis [m/s], in the shape of what is given."""
        speeds = numbers(speed, "cutting forces: speed", ("n",), (), unit="m/s")
        fastest = float(np.abs(speeds).max(initial=0.0))
        refuse_other_unit(fastest, FASTEST_FEED, "cutting forces: speed", METRES_PER_SECOND)
        return speeds / (
            self.cut.cutter.teeth * self.cut.spindle_speed
        )

    def over_time(self, t: npt.ArrayLike, speed: float) -> Floats:
        """Forces (n, 3) [N] at times t (n,) [s] at one feed [m/s]: the teeth pass, runout and all."""
        return self.at(
            2.0 * math.pi * self.cut.spindle_speed * numbers(t, "cutting forces: t", ("n",), unit="s"),
            float(self.feed_per_tooth(number(speed, "cutting forces: speed", unit="m/s"))),
        )

    def at(self, angle: npt.ArrayLike, chip: float) -> Floats:
        """Forces (n, 3) [N] with the first tooth at angles (n,) [rad] at the tip, at one feed per tooth [m]."""
        k, dz = self.cut.coefficients, self.cut.engagement.axial_depth / len(self._lags)
        angle, chip = numbers(angle, "cutting forces: angle", ("n",), unit="rad"), number(chip, "cutting forces: chip")
        forces = np.zeros((len(angle), 3))
        if not chip > 0.0:
            return forces
        for tooth in range(self.cut.cutter.teeth):
            pitch = 2.0 * math.pi * tooth / self.cut.cutter.teeth
            phi, share = self._immersed(angle[:, None] + pitch - self._lags)
            sine, cosine = np.sin(phi), np.cos(phi)
            thick = self._thickness(tooth, chip, sine)
            share = np.where(thick > 0.0, share, 0.0)
            tangential = share * (k.tangential * thick + k.tangential_edge)
            radial = share * (k.radial * thick + k.radial_edge)
            axial = share * (k.axial * thick + k.axial_edge)
            forces[:, 0] -= (tangential * cosine + radial * sine).sum(axis=1)
            forces[:, 1] += (tangential * sine - radial * cosine).sum(axis=1)
            forces[:, 2] -= axial.sum(axis=1)
        forces *= dz
        return forces if self.cut.clockwise else forces * np.array([1.0, -1.0, 1.0])

    def feed_forward(self, chip: npt.ArrayLike, kind: Force = "mean") -> Floats:
        """Forces (n, 3) [N] that bend the tool at feeds per tooth (n,) [m]; none where there is no feed.

        `mean` is that over a turn. `peak` points as the mean does, and is as large across the tool as the force of a
        turn is at most: the angle at which it is largest can jump with the feed, and a path cannot.
        """
        chip = numbers(chip, "cutting forces: chip", ("n",), unit="m")
        if kind not in FORCES:
            raise UsageError(f"force '{kind}' is not known; {did_you_mean(str(kind), FORCES)}")
        if kind == "mean" and self.cut.cutter.runout == 0.0:
            slope, edge = self._closed_form()
            return np.where(chip[:, None] > 0.0, chip[:, None] * slope + edge, 0.0)
        chips, forces = self._table(kind, float(chip.max(initial=0.0)))
        found = np.stack([np.interp(chip, chips, column) for column in forces.T], axis=1)
        return np.where(chip[:, None] > 0.0, found, 0.0)

    def _closed_form(self) -> tuple[Floats, Floats]:
        """Mean forces per feed per tooth (3,) [N/m], and those of the edges (3,) [N]; Altintas, chapter 2."""
        start, end = self.immersion
        k, depth, teeth = self.cut.coefficients, self.cut.engagement.axial_depth, self.cut.cutter.teeth

        def from_start(f: Floats) -> float:
            return float(f[1] - f[0])

        phi = np.array([start, end])
        double, twice = from_start(np.cos(2.0 * phi)), from_start(2.0 * phi - np.sin(2.0 * phi))
        sine, cosine = from_start(np.sin(phi)), from_start(np.cos(phi))
        slope = np.array(
            [
                k.tangential * double - k.radial * twice,
                k.tangential * twice + k.radial * double,
                4.0 * k.axial * cosine,
            ]
        ) * (teeth * depth / (8.0 * math.pi))
        edge = np.array(
            [
                -k.tangential_edge * sine + k.radial_edge * cosine,
                -k.tangential_edge * cosine - k.radial_edge * sine,
                -k.axial_edge * (end - start),
            ]
        ) * (teeth * depth / (2.0 * math.pi))
        sense = np.array([1.0, 1.0 if self.cut.clockwise else -1.0, 1.0])
        return slope * sense, edge * sense

    def _table(self, kind: str, largest: float) -> tuple[Floats, Floats]:
        """Feeds per tooth (k,) up to `largest`, evenly spaced, and the forces (k, 3) that bend the tool there."""
        if kind not in self.tables or self.tables[kind][0][-1] < largest:
            angle = np.asarray(np.arange(TURN) * (2.0 * math.pi / TURN), dtype=np.float64)
            chips = np.asarray(np.linspace(1e-6, 1.0, CHIPS) * (1.25 * max(largest, 1e-9)), dtype=np.float64)
            forces = np.empty((CHIPS, 3))
            for j, chip in enumerate(chips):
                turn = self.at(angle, float(chip))
                mean = turn.mean(axis=0)
                most_across = np.hypot(turn[:, 0], turn[:, 1]).max()
                forces[j] = mean if kind == "mean" else mean * float(most_across / np.hypot(mean[0], mean[1]))
            self.tables[kind] = chips, forces
        return self.tables[kind]

    def _immersed(self, phi: Floats) -> tuple[Floats, Floats]:
        """Of slices with their middles at angles phi (n, slices): the middle of what is in the material, its share."""
        start, end = self.immersion
        # within half a turn of the middle of the immersion
        middle = 0.5 * (start + end)
        phi = middle + (phi - middle + math.pi) % (2.0 * math.pi) - math.pi
        lag = abs(float(self._lags[1] - self._lags[0])) if len(self._lags) > 1 else 0.0
        if lag == 0.0:
            return phi, np.where((phi >= start) & (phi <= end), 1.0, 0.0)
        low, high = np.clip(phi - 0.5 * lag, start, end), np.clip(phi + 0.5 * lag, start, end)
        return 0.5 * (low + high), (high - low) / lag

    @cached_property
    def _lags(self) -> Floats:
        """(slices,) by how much the edge lags behind its tip in the middle of each slice of the depth [rad]."""
        whole = 2.0 * math.tan(self.cut.cutter.helix) * self.cut.engagement.axial_depth / self.cut.cutter.diameter
        slices = max(math.ceil(abs(whole) / LAG), 1)
        return whole * (np.arange(slices) + 0.5) / slices

    def _thickness(self, tooth: int, chip: float, sine: Floats) -> Floats:
        """Thickness (n, slices) of the chip of a tooth: of what the teeth before it left, the least."""
        if self.cut.cutter.runout == 0.0:
            return chip * sine
        teeth = self.cut.cutter.teeth
        pitch = 2.0 * math.pi / teeth

        def reach(which: int) -> Floats:
            """By how much more a tooth reaches than without runout (slices,) [m]."""
            out: Floats = self.cut.cutter.runout * np.cos(self.cut.cutter.runout_angle - which * pitch + self._lags)
            return out

        own = reach(tooth)
        # What the tooth itself left a turn ago is always there; a longer one in between leaves less.
        thick = teeth * chip * sine
        for before in range(1, teeth):
            thick = np.minimum(thick, before * chip * sine + own - reach(tooth + before))
        return np.asarray(thick)
