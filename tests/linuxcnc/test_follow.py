"""A plan followed by the real LinuxCNC and its motion module, while a sensor shows what nobody would wish for."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.linuxcnc.following import follow_law
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.deflection.following import Status

HEAD = "G21 G90 G17 G94\nG0 X2 Y-1 Z2 A0 C0\nG1 Z1 F900\n"
PROGRAM = HEAD + "X18 Y5 A8 C14 F700\nY15 A2\nG4 P0.2\nX10 A-3 C6\nX2 Y2 A4 C-8 F500\nM2\n"
UNITS = np.array([MILLIMETRE] * 3 + [DEGREE] * 2)
BACKLOG, LAG = 180e-3, 5e-3
"""Tests share their computer, and none of its processes is realtime: rows for longer than one is kept waiting."""
ORDERS = ((3.0, "feed-override", 0.6), (4.0, "hold", 1), (4.7, "hold", 0), (5.0, "feed-override", 1.2))
ROUNDING = 1e-3
"""Share of a limit that third differences of a log in mm may have more."""


def law_in(folder, machine):
    """A law of some seconds, as a file."""
    on = machine.reserved(0.1)
    toolpath = tp.read_text(PROGRAM, machine, name="part.ngc")
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=on), on)
    follower = tp.Follower(trajectory, machine, delay=BACKLOG + LAG, gain=0.05, max_correction=0.15e-3)
    assert follower.pace == 1.0 and 5.0 < follower.duration < 10.0
    follower.save(folder / "part.law")
    return folder / "part.law"


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_joints_are_what_step_gave_and_keep_the_limits_whatever_is_measured(tmp_path):
    machine = tp.Machine.load("linuxcnc-xyzac-trt")
    seen = follow_law(law_in(tmp_path, machine), backlog=f"{BACKLOG * 1e3:g}ms", orders=ORDERS, most=0.08)
    given = np.column_stack([seen.given[f"joint_{j}"] for j in range(5)])
    status = np.bitwise_or.reduce(seen.given["status"].astype(int))
    # a disturbed run, to its end: drop-outs, nothing that is a number, and corrections of most of what may be
    assert status & Status.ENDED and status & Status.STALE and status & (Status.NOT_A_NUMBER | Status.ABSURD)
    believable = np.abs(seen.deflection) < 1.0
    assert np.std(seen.deflection[believable]) > 0.02 and not believable.all()
    assert np.abs(seen.given["correction_0"]).max() > 0.04
    # held on the way; whether the path allows 120 percent depends on where it is when that is asked for
    assert (seen.given["pace"][: len(given) // 2] == 0.0).any() and seen.given["pace"].max() <= 1.2 + 1e-9
    # one shift in time, then every cycle is the row that it was given
    first = next(k for k in range(len(seen.joints)) if np.array_equal(seen.joints[k : k + 200], given[:200]))
    logged = seen.joints[first : first + len(given)]
    assert len(logged) == len(given) > 5000
    off = np.abs(logged - given)
    assert off[:, :3].max() <= 1e-3 and off[:, 3:].max() <= 1e-4
    # from before the approach to after the stop
    limits = machine.limits
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        differences = np.abs(np.diff(seen.joints * UNITS, order, axis=0)).max(axis=0) / 1e-3**order
        assert (differences <= limit * (1.0 + ROUNDING)).all()
    assert not seen.messages
