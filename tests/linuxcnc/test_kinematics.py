"""Joints that the real LinuxCNC commands while it holds the tip are those of our kinematics, on three machines."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.machines import xyzbc_trt
from testbed.linuxcnc.run import Log, run_program
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.machine import Machine

PLACES = ((10.0, 5.0, 3.0, -25.0, 40.0), (-6.0, 12.0, -4.0, 18.0, -70.0), (4.0, -9.0, 2.0, -41.0, 15.0))
"""X, Y, Z [mm], tilt, C [deg]: on the way to each every axis moves."""
NEAR = 2e-7
"""[m], and [rad]: its joints are means of three cycles (1, 4, 1 of 6): a sixth of acceleration times cycle^2."""


def _program(tilt: str) -> str:
    blocks = [f"G1 X{x} Y{y} Z{z} {tilt}{a} C{c} F3000" for x, y, z, a, c in PLACES]
    # the dwell lets the means of three cycles come to rest: a switch at once, now and then, leaves micrometres undriven
    return "\n".join(["G21 G90 G94 G61", "M428", *blocks, "G4 P0.1", "M429", "M2", ""])


def _words(machine: Machine, log: Log) -> np.ndarray:
    """(n, 5) tip [m], tilt, C [rad] by our forward kinematics."""
    joints = log.of(machine.joints)
    tip, _ = machine.forward(joints)
    return np.column_stack([tip, log.of(("A" if "A" in machine.joints else "B", "C"))])


def _off(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Most distance of points from a straight way."""
    way = end - start
    share = np.clip((points - start) @ way / (way @ way), 0.0, 1.0)
    return float(np.abs(points - start - share[:, None] * way).max())


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    "machine",
    [
        Machine.load("linuxcnc-xyzac-trt"),
        pytest.param(xyzbc_trt(), marks=pytest.mark.sweep),
        pytest.param(Machine.load("linuxcnc-xyzbc-bridgemill"), marks=pytest.mark.sweep),
    ],
    ids=lambda machine: machine.name,
)
def test_the_tip_goes_straight_where_linuxcnc_holds_it(machine):
    """Its joints, through our kinematics, are the straight ways of the program, each cycle."""
    log = run_program(_program("A" if "A" in machine.joints else "B"), Configuration.tip(machine))
    found = _words(machine, log)
    units = np.array([MILLIMETRE] * 3 + [DEGREE] * 2)
    places = np.vstack([np.zeros(5), np.array(PLACES) * units])
    ways = np.sort(np.unique(log.line[log.line > 2]))
    assert list(ways) == [3, 4, 5]
    for number, line in enumerate(ways):
        here = found[log.line == line]
        assert len(here) > 100
        assert _off(here, places[number], places[number + 1]) < NEAR
    assert np.abs(found[-1] - places[-1]).max() < NEAR
    # far from what the words are as joints: the test would not pass without kinematics
    assert np.abs(log.of(machine.joints)[-1, machine.linear] - places[-1, :3]).max() > MILLIMETRE
