"""Checks of paths and limits, and questions about values that look like another unit."""

from __future__ import annotations

import math
import warnings

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UnitWarning, UsageError
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun

LOOKED_AT = 65
"""Places of a run."""


def check_count(limits: Limits, path: AxisPath) -> None:
    """Raise UsageError where there are not as many limits as joints, or where they have the names in another order."""
    count = len(path.joints)
    if len(limits) == count:
        if limits.joints != path.joints and set(limits.joints) == set(path.joints):
            raise UsageError(
                f"plan: limits are of the joints {', '.join(limits.joints)}, the path's are {', '.join(path.joints)}; "
                "give limits in the order of path.joints"
            )
        return
    cure = f"give {count} figures of each kind"
    if len(limits) == 1:
        v, a, j = (f"{getattr(limits, kind)[0]:g}" for kind in KINDS)
        cure = f"for the same of all of them give Limits({v}, {a}, {j}, path.joints)"
    raise UsageError(
        f"plan: limits for {len(limits)} joint{'' if len(limits) == 1 else 's'}, path of {count} joints; {cure}"
    )


def check_held(limits: Limits, path: AxisPath) -> None:
    """Raise UsageError where no joint moves along a run, and where nothing at all holds the motion: in no time."""
    free = np.all([np.isinf(getattr(limits, kind)) for kind in KINDS], axis=0)
    for k, run in enumerate(path.runs):
        # runs of programs move: what does not was left out by the fit
        if run.blocks and len(path.runs) > 1 and not free.any():
            continue
        joints, cap = run.with_cap(places_along(run))
        moving = joints[1:].any(axis=(0, 1))
        if not moving.any():
            raise UsageError(
                f"plan: no joint moves along run {k}, from s = {run.s0:g} to s = {run.s1:g}; leave it out, or give "
                "positions that differ: a wait is a dwell of a program"
            )
        if not (moving & ~free).any() and not np.isfinite(cap).any():
            names = ", ".join(name for name, each in zip(path.joints, free) if each)
            raise UsageError(
                f"plan: run {k} moves only joints without any limit ({names}), and no feed or speed_cap holds it: it "
                "would take no time; give these joints finite limits"
            )


def ask_about_degrees(path: AxisPath, machine: Machine) -> None:
    """Warn where rotary joints leave their travel, and would keep it if their positions were degrees."""
    if path.machine is not None:
        return
    lowest, highest = np.full(len(path.joints), np.inf), np.full(len(path.joints), -np.inf)
    for run in path.runs:
        q = run.evaluate(places_along(run))[0]
        lowest, highest = np.minimum(lowest, q.min(axis=0)), np.maximum(highest, q.max(axis=0))
    for joint in np.flatnonzero(machine.is_rotary):
        low, high = machine.travel[joint]
        outside = lowest[joint] < low or highest[joint] > high
        if outside and math.radians(lowest[joint]) >= low and math.radians(highest[joint]) <= high:
            far = max(lowest[joint], highest[joint], key=abs)
            warnings.warn(
                f"plan: joint {machine.joints[joint]} of {machine.name} goes to {far:g} rad ({math.degrees(far):.0f} "
                f"deg), beyond its travel of {math.degrees(low):g} to {math.degrees(high):g} deg; is it {far:g} deg? "
                "Then give radians: np.radians(q)",
                UnitWarning,
                stacklevel=3,
            )


def places_along(run: AxisRun) -> Floats:
    """Parameters along a run, with its breaks and hints."""
    even = np.linspace(run.s0, run.s1, LOOKED_AT)
    found: Floats = np.unique(np.concatenate([even, run.breaks, run.hints]))
    return found
