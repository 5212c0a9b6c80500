"""Circles and helices of programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints

SAG = 0.45e-6
"""Most distance between an arc and its chords [m]; a tenth below the promised half micrometre."""

PLANE_AXES = ((0, 1), (2, 0), (1, 2))
"""First and second axis of the planes XY, ZX and YZ."""
PLANE_ACROSS = (2, 1, 0)
"""The axis across each of these planes, and the plane across each axis."""
ROUNDING = 1e-9
"""Of lengths [m], angles [rad] and parts of unit vectors: less than this is zero, and values closer are the same."""
MOST_TURNS = 1000
"""Most times that an arc is gone round: more is a slip, and would fill memory with points."""
ONE_RAY = 1e-6
"""Angle [rad] up to which ends are on one ray from the centre."""
ONE_RAY_MM, ONE_RAY_INCH = 1e-14, 6.4516e-12
"""The same in LinuxCNC (`pmCircleInit`, CART_FUZZ): most product of both spokes [m2], 1e-8 in the square of the unit
that the machine counts in. What lies between is a full circle on a machine in inch, next to nothing on another."""
SPIRAL = (
    "where the radius of an arc at its end is another than at its start, within what the control allows, it changes "
    "evenly with the angle"
)
SPIRAL_SAID = 5e-6
"""Difference of radii [m] from which that is said: more than decimals explain."""

Vector = Sequence[float]


class Arc(NamedTuple):
    """centre + r(t) (cos(sweep t) u + sin(sweep t) w) + rise t, 0 <= t <= 1, r from r0 to r1 in proportion."""

    centre: tuple[float, float, float]
    u: tuple[float, float, float]
    w: tuple[float, float, float]
    r0: float
    r1: float
    sweep: float
    rise: tuple[float, float, float]

    def length(self) -> float:
        """Length [m]; the radii of a programmed arc differ by rounding only."""
        return math.hypot(0.5 * (self.r0 + self.r1) * self.sweep, math.hypot(*self.rise))

    def last_direction(self) -> tuple[float, float, float]:
        """Direction (3,) in which it ends, at another length than one."""
        c, s = math.cos(self.sweep), math.sin(self.sweep)
        turning = self.r1 * self.sweep
        x, y, z = (turning * (c * w - s * u) + rise for u, w, rise in zip(self.u, self.w, self.rise))
        return x, y, z

    def pieces(self) -> int:
        """How many chords keep within SAG."""
        radius = max(self.r0, self.r1)
        step = 2 * math.acos(1 - SAG / radius) if radius > 4 * SAG else math.pi / 4
        return max(1, math.ceil(abs(self.sweep) / min(step, math.pi / 4)))


class ArcError(ValueError):
    """An arc that cannot be; the message says why and what to write."""


class Tolerance(NamedTuple):
    """How far the radii of an arc's ends may differ: `least` at any radius, or a share of the larger up to `most`."""

    least: float = 1e-5
    """[m]"""
    share: float = 1e-3
    most: float = math.inf
    """[m]"""
    smallest: float = 1e-9
    """Radius [m] below which an arc has none."""

    def allows(self, r0: float, r1: float) -> bool:
        """Whether ends at these radii [m] are those of an arc."""
        off = abs(r1 - r0)
        return off <= self.least or off <= min(self.share * max(r0, r1), self.most)

    def __str__(self) -> str:
        most = f" up to {self.most * 1e3:.4g} mm" if self.share and self.most < math.inf else ""
        percent = f" or {self.share * 100:g} percent" if self.share else ""
        return f"at most {self.least * 1e3:.4g} mm{percent}{most}"


USUAL = Tolerance()
"""Where a control says nothing else: a hundredth of a millimetre, or a tenth of a percent."""


def plane_arc(
    start: Vector,
    end: Vector,
    centre: Vector,
    plane: int,
    clockwise: bool,
    turns: int = 1,
    *,
    full: bool = False,
    tolerance: Tolerance = USUAL,
) -> Arc:
    """Arc in a plane (0: XY, 1: ZX, 2: YZ) seen from the positive side of its normal; equal ends: a circle."""
    normal = [0.0, 0.0, 0.0]
    normal[(2 + 2 * plane) % 3] = -1.0 if clockwise else 1.0
    return arc_about(start, end, centre, normal, turns, full=full, tolerance=tolerance)


def arc_about(
    start: Vector,
    end: Vector,
    centre: Vector,
    normal: Vector,
    turns: int = 1,
    *,
    full: bool = False,
    tolerance: Tolerance = USUAL,
) -> Arc:
    """Arc from start to end about the unit normal by the right-hand rule, rising evenly along the normal.

    tolerance: of the radii; where they differ, the radius changes evenly with the angle.

    full: ends on one ray from the centre make a full circle, as LinuxCNC has it; else that is an ArcError, for it may
    as well be no arc at all.
    """
    a = [start[i] - centre[i] for i in range(3)]
    b = [end[i] - centre[i] for i in range(3)]
    height0, height1 = _dot(a, normal), _dot(b, normal)
    a = [a[i] - height0 * normal[i] for i in range(3)]
    b = [b[i] - height1 * normal[i] for i in range(3)]
    r0, r1 = math.hypot(*a), math.hypot(*b)
    if min(r0, r1) < tolerance.smallest:
        raise ArcError("the arc has no radius: its centre is its start or its end")
    if not tolerance.allows(r0, r1):
        raise ArcError(
            f"the arc ends {abs(r1 - r0) * 1e3:.4g} mm off its circle (radius {r0 * 1e3:.6g} mm at its "
            f"start, {r1 * 1e3:.6g} mm at its end; {tolerance}): "
            "check the end, the centre and the plane"
        )
    u = (a[0] / r0, a[1] / r0, a[2] / r0)
    w = (
        normal[1] * u[2] - normal[2] * u[1],
        normal[2] * u[0] - normal[0] * u[2],
        normal[0] * u[1] - normal[1] * u[0],
    )
    sweep = math.atan2(_dot(b, w), _dot(b, u)) % (2 * math.pi)
    beside = r0 * r0 * math.sin(sweep) if sweep < 1.0 else math.inf
    if math.dist(a, b) < ROUNDING or (full and beside < ONE_RAY_MM):
        sweep = 2 * math.pi
    elif beside < ONE_RAY_INCH if full else sweep < ONE_RAY:
        raise ArcError(
            f"the arc ends {abs(r1 - r0) * 1e3:.4g} mm beside its start, on the same ray from its centre: a full "
            "circle, or none? Write the end as the start, or leave the block out"
        )
    rise = height1 - height0
    # The centre is moved along the normal to the height of the start, so that the formula starts there.
    return Arc(
        (centre[0] + height0 * normal[0], centre[1] + height0 * normal[1], centre[2] + height0 * normal[2]),
        u,
        w,
        r0,
        r1,
        sweep + 2 * math.pi * (turns - 1),
        (rise * normal[0], rise * normal[1], rise * normal[2]),
    )


def centre_of_radius(
    start: Vector, end: Vector, radius: float, plane: int, clockwise: bool, reach: Tolerance = USUAL
) -> list[float]:
    """Centre of an R-form arc; a negative radius asks for the longer way (Kramer et al. 2000, RS274/NGC 3.5.3).

    reach: by how much half the chord may be longer than the radius; the arc is then half a circle about its middle.
    """
    first, second = PLANE_AXES[plane]
    dx, dy = end[first] - start[first], end[second] - start[second]
    chord = math.hypot(dx, dy)
    if chord < ROUNDING:
        raise ArcError("a full circle cannot be written with R: give its centre with I, J, K")
    if chord > 2 * abs(radius) and not reach.allows(chord / 2, abs(radius)):
        raise ArcError(
            f"radius {abs(radius) * 1e3:.6g} mm is too small for ends {chord * 1e3:.6g} mm apart: "
            f"it takes at least {chord * 500:.6g} mm ({reach} less)"
        )
    height = math.sqrt(max(radius * radius - chord * chord / 4, 0.0))
    # The centre lies left of the chord for a short counter-clockwise arc and for a long clockwise one.
    side = height / chord if clockwise == (radius < 0) else -height / chord
    centre = list(start)
    centre[first] = start[first] + dx / 2 - side * dy
    centre[second] = start[second] + dy / 2 + side * dx
    return centre


def tangent_centre(
    start: Vector, end: Vector, direction: Sequence[float], plane: int, least: float = 0.0
) -> tuple[list[float], bool] | None:
    """Centre of the arc that leaves the start in a unit direction (2,) of the plane, and whether it goes clockwise.

    least: how far the end lies aside [m] where there is an arc. None where it lies straight ahead, or behind.
    """
    first, second = PLANE_AXES[plane]
    u, v = direction
    du, dv = end[first] - start[first], end[second] - start[second]
    aside = u * dv - v * du
    if abs(aside) < max(least, ROUNDING * math.hypot(du, dv)):
        return None
    radius = (du * du + dv * dv) / (2.0 * aside)
    centre = list(start[:3])
    centre[first] -= v * radius
    centre[second] += u * radius
    return centre, aside < 0.0


class ArcTable:
    """Many arcs as arrays, evaluated at once."""

    def __init__(self, arcs: Sequence[Arc]) -> None:
        self.centre = np.array([arc.centre for arc in arcs]).reshape(-1, 3)
        self.u = np.array([arc.u for arc in arcs]).reshape(-1, 3)
        self.w = np.array([arc.w for arc in arcs]).reshape(-1, 3)
        self.r0 = np.array([arc.r0 for arc in arcs])
        self.r1 = np.array([arc.r1 for arc in arcs])
        self.sweep = np.array([arc.sweep for arc in arcs])
        self.rise = np.array([arc.rise for arc in arcs]).reshape(-1, 3)

    def evaluate(self, arc: Ints, t: Floats) -> Floats:
        """Points (k, 3) [m] of arcs `arc` (k,) at fractions t (k,)."""
        angle = self.sweep[arc] * t
        radius = self.r0[arc] + (self.r1 - self.r0)[arc] * t
        spoke = np.cos(angle)[:, None] * self.u[arc] + np.sin(angle)[:, None] * self.w[arc]
        return np.asarray(self.centre[arc] + radius[:, None] * spoke + self.rise[arc] * t[:, None])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
