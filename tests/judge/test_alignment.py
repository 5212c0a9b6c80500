"""The matching against a slow oracle that looks at all pairs: no false alarm, no miss, and the distance it reports."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.in_order_distance import distance_of_poses, in_order_distance, within_in_order
from tests.support.random_rows import HABITS, along, place_on, random_program, spoilt
from toolpace.judge.alignment import Lost, align


def aligned(motion, program, within=1.0):
    found = align(np.ascontiguousarray(motion), np.ascontiguousarray(program), within, np.zeros(len(motion)))
    assert not isinstance(found, Lost)
    return found


def case(seed):
    """A program, and a motion that is right in one half of all cases and may be wrong in the other."""
    r = np.random.default_rng(seed)
    program = random_program(r, HABITS[seed % len(HABITS)])
    motion = along(r, program, within=r.choice([0.3, 0.9, 1.0]), corners=r.random() < 0.5)
    if seed % 2:
        motion = spoilt(r, motion)
    if len(motion) < 2:
        motion = np.repeat(motion, 2, axis=0)
    return (motion, program) if r.random() < 0.8 else (program, motion)


def agrees_with_the_oracle(seed):
    motion, program = case(seed)
    distance = in_order_distance(motion, program, 1e-9)
    # no false alarm, and no miss, by a part in a million
    assert not aligned(motion, program, distance * (1.0 + 1e-6) + 1e-12).deviations, seed
    if distance > 1e-9:
        assert aligned(motion, program, distance * (1.0 - 1e-6) - 1e-12).deviations, seed
    found = aligned(motion, program)
    assert bool(found.deviations) == (not within_in_order(motion, program, 1.0)), seed
    if found.deviations:
        # It is found place by place, with the rest of the motion held to the tolerance; so it may be above the
        # distance of the whole, which lets all of it stray. The most seen is 2.33 times that, once in 4360 cases.
        worst = max(far for _, far in found.deviations)
        assert distance * (1.0 - 1e-6) <= worst <= 2.5 * distance, (seed, worst, distance)
        shown = max(each.max() for way in (found.there, found.back) for each in (way.tip, way.axis))
        assert shown <= worst * (1.0 + 1e-6), seed
    places_are_in_order(found, motion, program)


def places_are_in_order(found, motion, program):
    for rows, line, way in ((motion, program, found.there), (program, motion, found.back)):
        assert (way.first <= way.last).all()
        assert (np.diff(way.first) >= -1e-4).all() and (np.diff(way.last) >= -1e-4).all()
        at = place_on(line, way.place)
        np.testing.assert_allclose(np.maximum(way.tip, way.axis), distance_of_poses(rows, at), atol=1e-9)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "part",
    [0, *(pytest.param(part, marks=pytest.mark.sweep if part < 2 else pytest.mark.thorough) for part in range(1, 9))],
)
def test_decides_as_the_oracle_does(part):
    for seed in range(part, 360, 9):
        agrees_with_the_oracle(seed)


@pytest.mark.parametrize(
    "part",
    [pytest.param(-1, marks=pytest.mark.sweep), *(pytest.param(k, marks=pytest.mark.thorough) for k in range(9))],
)
def test_decides_as_the_oracle_does_on_thousands(part):
    for seed in range(1000 + part, 5000, 9) if part >= 0 else range(6000, 6100):
        agrees_with_the_oracle(seed)


@pytest.mark.parametrize("count", [2, 8, 9, 10, 17, 64, 65, 66, 73, 129, 513])
@pytest.mark.parametrize("column", [0, 5])
def test_an_end_that_is_not_reached_is_seen_however_many_points_lie_before_it(count, column):
    """All points but the last lie within the tolerance of each other; rows are seen in parts of 8, 64, ... ways."""
    program = np.zeros((count, 6))
    program[:, column] = np.linspace(0.0, 0.5, count)
    motion = program.copy()
    assert not aligned(motion, program).deviations
    program[-1, column] = 3.0
    # it ends at 0.5, 2.5 tolerances short; or it goes on by so much
    for one, other in ((motion, program), (program, motion)):
        ((_, far),) = aligned(one, other).deviations
        assert far == pytest.approx(2.5, rel=1e-3)


@pytest.mark.parametrize("spike", [1, 7, 8, 9, 16, 64, 72, 511, 512])
@pytest.mark.parametrize("count", [18, 80, 600])
def test_a_single_point_that_is_off_is_seen_wherever_it_lies_among_near_ones(count, spike):
    spike = min(spike, count - 2)
    program = np.zeros((count, 6))
    program[:, 0] = np.linspace(0.0, 0.5, count)
    motion = program[:: max(count // 20, 1)].copy()
    motion[-1] = program[-1]
    program[spike, 1] = 3.0
    for one, other in ((motion, program), (program, motion)):
        assert max(far for _, far in aligned(one, other).deviations) == pytest.approx(3.0, rel=0.05)
