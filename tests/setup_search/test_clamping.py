"""A clamping moves the part as it says, and leaves one solution of the inverse kinematics where it names one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from testbed.curved_pass import curved_pass
from toolpace.common.errors import ReachError
from toolpace.machine.machine import Machine
from toolpace.setup_search.clamping import AS_GIVEN, ROOM, Clamping, orientation, with_side

CENTRE = np.array([0.03, -0.02, 0.05])


def placed_in_bed(machine: Machine, points: np.ndarray) -> np.ndarray:
    """(n, 3) points of the part in the frame of the bed, every joint at zero."""
    chain = machine.file.chain
    return np.array(chain.workpiece_origin) + points @ orientation(chain.workpiece_x, chain.workpiece_z).T


@pytest.mark.parametrize("name", ["xyzac-trunnion", "xyzbc-head", "xyzbc-nutating"])
def test_the_part_turns_about_its_centre_and_is_moved(name):
    machine, clamping = Machine.load(name), Clamping(0.4, 0.7, -1.1, (0.01, -0.02, 0.03))
    points = np.random.default_rng(1).normal(size=(20, 3)) * 0.1
    before, after = placed_in_bed(machine, points), placed_in_bed(clamping.on(machine, CENTRE), points)
    centre = placed_in_bed(machine, CENTRE[None])[0]
    turned = before - centre
    for axis, angle in (([0, 0, 1], 0.4), ([1, 0, 0], 0.7), ([0, 0, 1], -1.1)):
        u = np.array(axis, dtype=float)
        across = np.cross(u, turned)
        turned = turned * math.cos(angle) + across * math.sin(angle) + np.outer(turned @ u, u) * (1.0 - math.cos(angle))
    np.testing.assert_allclose(after, centre + turned + [0.01, -0.02, 0.03], atol=1e-11)


def test_the_given_clamping_leaves_the_machine_as_it_is():
    machine = Machine.load("xyzac-trunnion")
    assert AS_GIVEN.on(machine, CENTRE) == machine
    assert AS_GIVEN.words(machine) == "as given"


def test_a_tool_is_as_long_as_asked_for():
    machine = Clamping(tool_length=0.2).on(Machine.load("xyzac-trunnion"), CENTRE)
    assert machine.tool_length == 0.2


def test_words_name_what_differs():
    machine = Machine.load("xyzac-trunnion")
    words = Clamping(math.radians(10.0), 0.0, 0.0, (0.01, 0.0, 0.0), 0.2, -1).words(machine)
    assert words == "turn 10 deg, moved by 10, 0, 0 mm, tool 200 mm, A on side -1"


@pytest.mark.parametrize("name", Machine.names())
@pytest.mark.parametrize("side", [1, -1])
def test_a_side_leaves_one_solution(name, side):
    """By the sign of (R2 a0) . (u1 x u2), worked out anew from the chosen positions; the room beyond is a degree."""
    machine = Machine.load(name)
    try:
        narrowed = with_side(machine, side)
    except ReachError as error:
        assert f"no travel on side {side:+d}" in str(error)
        return
    low, high = narrowed.travel[narrowed.rotary[1]]
    assert high - low <= math.pi + 2.0 * ROOM + 1e-12
    second = np.concatenate([np.linspace(low, high, 50), np.linspace(0.0, 2.0 * math.pi, 721)])
    u1, u2, a0 = machine.geometry.frame[:3]
    cosine, sine = np.cos(second)[:, None], np.sin(second)[:, None]
    turned = a0 * cosine + np.cross(u2, a0) * sine + u2 * (u2 @ a0) * (1.0 - cosine)
    height = turned @ np.cross(u1, u2)
    ours, room = height[:50] * np.sign(height[:50].sum()), 1.001 * math.sin(ROOM) * np.abs(height).max()
    assert ours.min() >= -room


@pytest.mark.parametrize("name", Machine.names())
def test_both_sides_together_are_the_travel_where_it_is_no_more_than_a_turn(name):
    machine = Machine.load(name)
    low, high = machine.travel[machine.rotary[1]]
    sides = [each.travel[each.rotary[1]] for side in (-1, 1) if (each := with_side_or_none(machine, side)) is not None]
    if high - low <= math.pi:
        assert min(each[0] for each in sides) <= low + ROOM and max(each[1] for each in sides) >= high - ROOM
        assert len(sides) == 1 or sides[1][0] < sides[0][1]


def with_side_or_none(machine: Machine, side: int) -> Machine | None:
    try:
        return with_side(machine, side)
    except ReachError:
        return None


def test_the_rotary_joints_take_the_side():
    machine, toolpath = Machine.load("xyzac-head"), curved_pass()
    tilts = [with_side(machine, side).choose_rotary(toolpath)[:, 1] for side in (1, -1)]
    assert tilts[0].min() > -1.001 * ROOM and tilts[1].max() < 1.001 * ROOM
    assert tilts[0].max() > 0.5 and tilts[1].min() < -0.5


def test_a_machine_with_a_side_is_one_that_a_file_can_say():
    machine = with_side(Machine.load("xyzac-trunnion"), 1)
    assert Machine.from_toml(machine.to_toml()) == machine
