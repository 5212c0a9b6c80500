"""The built-in machines: their zero, their positive directions, and that typical parts of their class fit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.machines import oracle
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath

OURS = sorted(set(Machine.names()) - {"paper-ab", "linuxcnc-xyzac-trt", "linuxcnc-xyzbc-bridgemill"})
"""All but those that were taken from elsewhere with their own conventions."""
ALONG = {"A": (1.0, 0.0, 0.0), "B": (0.0, 1.0, 0.0), "C": (0.0, 0.0, 1.0)}
RADIUS = {
    "xyzab-trunnion-inch": 0.075,
    "xyzbc-table": 0.1,
    "xyzab-table": 0.1,
    "xyzac-head": 0.6,
    "xyzbc-nutating-large": 0.3,
    "xyzbc-millturn": 0.1,
}
"""Of a dome that a typical part of the class is about as large as [m]."""


@pytest.mark.parametrize("name", OURS)
def test_joint_words_are_tip_coordinates_while_rotary_joints_are_at_zero(name: str) -> None:
    machine = Machine.load(name)
    rng = np.random.default_rng(14)
    q = np.zeros((20, 5))
    q[1:, machine.linear] = rng.uniform(-0.2, 0.2, (19, 3))
    tip, axis = machine.forward(q)
    np.testing.assert_allclose(tip, q[:, [machine.joints.index(x) for x in "XYZ"]], atol=1e-15)
    np.testing.assert_allclose(axis, np.tile([0.0, 0.0, 1.0], (20, 1)), atol=1e-15)


@pytest.mark.parametrize("name", OURS)
def test_positive_angles_turn_the_tool_positively_as_seen_from_the_part(name: str) -> None:
    """ISO 841: A, B and C turn about X, Y and Z. Seen from the part, by the oracle and differences."""
    machine = Machine.load(name)
    first, second = machine.geometry.rotary_joints
    for joint in (first, second):
        along = ALONG["C" if name == "xyzab-trunnion-inch" and joint == "B" else joint]
        if "nutating" in name and joint == "B":
            along = (0.0, math.sqrt(0.5), math.sqrt(0.5))
        # A joint that turns about the upright tool shows its sense when the other one has tilted it.
        at = np.where((np.array(machine.joints) == second) & (joint == first), 0.4, 0.0)
        step = np.where(np.array(machine.joints) == joint, 1e-4, 0.0)
        speed = (oracle(machine, at + step)[1] - oracle(machine, at - step)[1]) / 2e-4
        np.testing.assert_allclose(speed, np.cross(along, oracle(machine, at)[1]), atol=1e-7)
        assert np.linalg.norm(speed) > 0.2, "the joint moves the tool axis here"


@pytest.mark.parametrize("name", RADIUS)
def test_a_dome_of_typical_size_fits(name: str) -> None:
    """A ball finished from its top to 80 degrees in a spiral, tool upright on it; and half of it at 30 degrees lead."""
    machine = Machine.load(name)
    turn = np.linspace(0.0, 4 * math.pi if machine.kind != "head-head" else 1.9 * math.pi, 4000)
    for most, lead in ((80.0, 0.0), (40.0, 30.0)):
        tilt = np.linspace(math.radians(1.0), math.radians(most), len(turn))

        def direction(tilt: np.ndarray) -> np.ndarray:
            return np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=1)

        tip = RADIUS[name] * (direction(tilt) - [0.0, 0.0, 1.0])
        n, still = len(turn), np.zeros(len(turn))
        path = ToolPath(
            tip, direction(tilt + math.radians(lead)), np.full(n, 0.05), still, np.arange(1, n + 1),
            np.isin(np.arange(n), (0, n - 1)), still.copy(), source="dome.cls",
        )  # fmt: skip
        rotary = machine.choose_rotary(path)
        machine.check_travel(machine.joints_at(path.tip, rotary), path.block)
        assert np.abs(np.diff(rotary, axis=0)).max() < 0.3


def test_every_machine_says_what_it_is() -> None:
    notes = [Machine.load(name).file.note for name in Machine.names()]
    assert all(0 < len(note) <= 100 for note in notes) and len(set(notes)) == len(notes)
    small = Machine.load("xyzab-trunnion-inch")
    np.testing.assert_allclose(small.travel[0], [-0.381, 0.381])
    assert small.tool_length == pytest.approx(0.127)
