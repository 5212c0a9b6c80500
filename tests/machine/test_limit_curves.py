"""Limits over speed in a machine file: what they come to, exact round trip, and each mistake in a line."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import MachineError
from toolpace.machine.machine import FOLDER

TEXT = (FOLDER / "xyzac-trunnion.toml").read_text()
FIGURES = "acceleration = 5000"
"""Of X [mm/s^2], where velocity is 500."""
CURVE = "acceleration = [[0, 5000], [300, 5000], [500, 2000]]"


def machine(acceleration, text=TEXT):
    assert FIGURES in text
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tp.UnitWarning)
        return tp.Machine.from_toml(text.replace(FIGURES, acceleration, 1), "mill.toml")


def test_a_curve_is_in_the_units_of_the_file():
    limits = machine(CURVE).limits
    (curve,) = limits.curves
    x = limits.joints.index("X")
    assert (curve.joint, curve.kind, curve.sides) == ("X", "acceleration", "at any")
    assert np.allclose(curve.curves[0].speed, [0.0, 0.3, 0.5]) and np.allclose(curve.curves[0].limit, [5.0, 5.0, 2.0])
    assert limits.acceleration[x] == 2.0 and limits.largest.acceleration[x] == 5.0
    of_rotary = TEXT.replace("acceleration = 600", "acceleration = [[0, 600], [90, 300]]", 1)
    of_rotary = tp.Machine.from_toml(of_rotary).limits.curves[0]
    assert np.allclose(of_rotary.curves[0].speed, [0.0, math.pi / 2.0])
    assert np.allclose(of_rotary.curves[0].limit, np.radians([600.0, 300.0]))


def test_both_sides_and_jerk():
    limits = machine("acceleration = { speeding_up = [[0, 5000], [500, 2000]], braking = 6000 }").limits
    speed = np.array([0.5, 0.5, -0.5, -0.5])
    assert np.allclose(limits.curves[0].at(speed, np.array([1.0, -1.0, -1.0, 1.0])), [2.0, 6.0, 2.0, 6.0])
    limits = machine("acceleration = { upwards = 4000, downwards = [[0, 5000], [500, 3000]] }").limits
    assert np.allclose(limits.curves[0].at(speed, np.array([1.0, -1.0, -1.0, 1.0])), [4.0, 3.0, 3.0, 4.0])
    jerk = machine(FIGURES, TEXT.replace("jerk = 50000", "jerk = [[0, 50000], [500, 20000]]", 1)).limits
    assert jerk.curves[0].kind == "jerk" and jerk.jerk[jerk.joints.index("X")] == pytest.approx(20.0)


@pytest.mark.parametrize("written", [
    CURVE, "acceleration = { speeding_up = [[0, 5000], [499.9, 1999.7]], braking = 6000.1 }",
    "acceleration = { upwards = 4000, downwards = [[0, 5000], [100, 4500], [500, 3000]] }",
])  # fmt: skip
def test_the_round_trip_is_exact(written):
    before = machine(written)
    assert written in before.to_toml()
    # factors of which the products are no short decimals
    for mill in (before, before.with_limits(before.limits.scaled(0.7, 1.1 / 3.0, 0.9))):
        after = tp.Machine.from_toml(mill.to_toml())
        assert after == mill and hash(after) == hash(mill)


def test_machines_with_other_limits_keep_or_lose_curves():
    mill = machine(CURVE)
    x = mill.joints.index("X")
    reserved = mill.reserved(0.2)
    assert reserved.limits.acceleration[x] == pytest.approx(1.6)
    assert np.allclose(reserved.limits.curves[0].curves[0].speed, [0.0, 0.24, 0.4])
    assert mill.with_limits(mill.limits.over_speed()) == mill
    assert not mill.with_limits(mill.limits.largest).limits.curves
    assert mill.summary()[0]["acceleration"] == "5000 .. 2000 mm/s^2"


@pytest.mark.parametrize(("written", "message"), [
    ("[]", "no corners"), ("[[0, 5000], [300, 6000]]", "rises from 5000 to 6000 at speed 300"),
    ("[[0, 5000], [300, -1]]", "is -1 at speed 300"), ("[[0, 5000], [501, 3000]]", "beyond velocity = 500"),
    ("[[10, 5000], [300, 3000]]", "begins at speed 10"), ("[[0, 2], [0, 1]]", "speed 0 comes after 0"),
    ("{ up = 3 }", "give both speeding_up and braking"), ("{ braking = 3 }", "give both speeding_up and braking"),
    ("{ speeding_up = 5000, braking = 'x' }", "braking is 'x'"), ("[[0, 5000, 3]]", "no corners"),
    ("[5000]", "no corners"), ("[['a', 3]]", "something else than numbers"), ("[[0, nan]]", "is nan"),
    ("[[0, 1e-30]]", "beyond any joint"), ("[[0, 1e300], [1, 5]]", "beyond any joint"),
    ("{}", "give both"), ("true", "acceleration"),
])  # fmt: skip
def test_each_mistake_is_one_line(written, message):
    with pytest.raises(MachineError, match=message) as told:
        machine(f"acceleration = {written}")
    assert "\n" not in str(told.value) and str(told.value).startswith("mill.toml: ")
    with pytest.raises(MachineError, match="unknown key 'curves'"):
        machine(f"{FIGURES}\ncurves = []")
