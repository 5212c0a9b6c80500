"""Speeds and times of LinuxCNC 2.10's planner with limited jerk (PLANNER_TYPE = 1), in closed form.

After its documents ("TRAJ Section", PLANNER_TYPE, SCURVE_PEAK_SCALE; "G64 R") and what its source does (src/emc/tp:
sp_scurve.c, tc.c, tp.c). Each segment has an S-curve of its own: the acceleration along the way is zero at both ends.
Without a limit of jerk (control.jerk 0) speeds are those of the planner of constant acceleration.
"""

from __future__ import annotations

import math

from toolpace.kernels.jerk_ramp import ramp_distance, ramp_time, reachable_speed
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import TANGENTIAL, Control


@jit()
def speed_from_rest(acceleration: float, jerk: float, distance: float, control: Control) -> float:
    """Highest speed over a distance, from rest to rest."""
    triangle = math.sqrt(acceleration * distance)
    if control.jerk <= 0.0:
        return triangle
    peak = reachable_speed(0.0, 0.5 * distance, acceleration, min(jerk, control.jerk))
    return float(min(control.peak_scale * peak, triangle))


@jit()
def speed_at_start(final: float, acceleration: float, jerk: float, distance: float, control: Control) -> float:
    """Highest speed at the start of a segment that ends at a speed; at limited jerk it is not above that from rest."""
    steady = math.sqrt(final * final + 2.0 * acceleration * distance)
    if control.jerk <= 0.0:
        return steady
    sharpest = min(jerk, control.jerk)
    peak = control.peak_scale * reachable_speed(0.0, 0.5 * distance, acceleration, sharpest)
    return float(min(max(final, min(reachable_speed(final, distance, acceleration, sharpest), peak)), steady))


@jit()
def arc_speed(acceleration: float, radius: float, sweep: float, control: Control) -> float:
    """Highest speed on an arc by jerk.

    v^3 / r^2 of its turning, with both ends; 3 v a / r while the speed changes; v^2 / r, which begins within a cycle.
    """
    turning = (radius * radius * control.jerk * sweep / (2.0 + sweep)) ** (1.0 / 3.0)
    changing = control.jerk * radius / (3.0 * TANGENTIAL * acceleration)
    return float(min(turning, changing, math.sqrt(control.jerk * radius * control.cycle)))


@jit()
def time_to_rest(speed: float, acceleration: float, control: Control) -> float:
    """Time in which a speed comes to rest [s]."""
    return ramp_time(speed, acceleration, control.jerk) if control.jerk > 0.0 else speed / acceleration


@jit()
def speed_after(time: float, acceleration: float, jerk: float, control: Control) -> float:
    """Speed that an overlap counts on after a time from rest: a time, and with jerk a (time / jerk)^(1/2)."""
    if control.jerk <= 0.0:
        return acceleration * time
    return min(acceleration * time, acceleration * math.sqrt(time / min(jerk, control.jerk)))


@jit()
def speed_near(distance: float, acceleration: float, jerk: float, control: Control) -> float:
    """Speed from which an overlap stays within a distance: (2 a d)^(1/2), with jerk (6 d j^(1/2))^(2/3)."""
    if control.jerk <= 0.0:
        return math.sqrt(2.0 * acceleration * distance)
    return float((6.0 * distance * math.sqrt(min(jerk, control.jerk))) ** (2.0 / 3.0))


@jit()
def last_time(speed: float, acceleration: float, jerk: float) -> float:
    """How long before its end a ramp to rest goes at a speed [s]."""
    if 2.0 * speed * jerk <= acceleration * acceleration:
        return math.sqrt(2.0 * speed / jerk)
    return speed / acceleration + 0.5 * acceleration / jerk


@jit()
def s_curve_time(start: float, end: float, peak: float, distance: float, acceleration: float, jerk: float) -> float:
    """Time of a segment [s]: a ramp to its peak, that speed, and a ramp to its end."""
    up, down = ramp_distance(start, peak, acceleration, jerk), ramp_distance(peak, end, acceleration, jerk)
    time = ramp_time(peak - start, acceleration, jerk) + ramp_time(peak - end, acceleration, jerk)
    return float(time + max(distance - up - down, 0.0) / peak if peak > 0.0 else time)
