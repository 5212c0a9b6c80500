"""The profile along a chain of blocks: against closed forms, its own limits, and the fastest motion."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import toolpace as tp
from tests.support.timed_programs import A, J, machine
from toolpace.controls.timing.blocks import profile_along
from toolpace.kernels.controls.path_profile import profile_of_chain, stoppable_speeds
from toolpace.kernels.jerk_ramp import ramp_distance, reachable_speed, speed_on_ramp, time_on_ramp
from toolpace.programs.reading import Source, read_source
from toolpace.programs.reading.languages import with_controller
from toolpace.programs.reading.options import ReadOptions


def profile(length, feed, corner, acceleration=A, jerk=J) -> tuple[np.ndarray, np.ndarray]:
    n = len(length)
    rows = [np.broadcast_to(np.asarray(each, dtype=float), (n,)).copy() for each in (feed, acceleration, jerk)]
    return profile_of_chain(np.asarray(length, dtype=float), rows[0], np.asarray(corner, dtype=float), *rows[1:])


def test_a_line_from_rest_to_rest():
    times, ends = profile([0.2], 0.1, [0.0])
    assert times[0] == pytest.approx(0.2 / 0.1 + 0.1 / A + A / J, rel=1e-12) and ends[0] == 0.0


@pytest.mark.parametrize("length", [1e-6, 1e-4, 0.019])
def test_a_line_too_short_for_its_feed(length: float):
    # four phases of jerk alone; with acceleration: d = v (v / a + a / j)
    short = 4.0 * (length / (2.0 * J)) ** (1.0 / 3.0)
    speed = 0.5 * (-A * A / J + math.sqrt((A * A / J) ** 2 + 4.0 * A * length))
    expected = short if speed < A * A / J else 2.0 * (speed / A + A / J)
    assert profile([length], 10.0, [0.0])[0][0] == pytest.approx(expected, rel=1e-9)


def test_two_lines_with_a_corner_speed():
    feed, corner, length = 0.1, 0.03, 0.1
    times, ends = profile([length, length], feed, [corner, 0.0])
    slow, fast = ramp_distance(corner, feed, A, J), ramp_distance(0.0, feed, A, J)
    ramps = 2.0 * math.sqrt((feed - corner) / J) + 2.0 * math.sqrt(feed / J)  # neither reaches the acceleration
    assert feed <= A * A / J
    expected = ramps + (length - slow - fast) / feed
    np.testing.assert_allclose(times, expected, rtol=1e-9)
    assert ends[0] == corner


def test_a_ramp_goes_over_many_blocks_as_over_one():
    whole = profile([0.5], 0.4, [0.0])[0].sum()
    for count in (2, 7, 1000):
        times, _ = profile(np.full(count, 0.5 / count), 0.4, np.append(np.full(count - 1, 9.0), 0.0))
        assert times.sum() == pytest.approx(whole, rel=1e-9)


def test_blocks_with_less_acceleration_slow_only_the_ramps_that_they_are_in():
    weak = np.array([A, 0.1 * A, A])
    steady = profile([0.5, 0.01, 0.5], 0.1, [1.0, 1.0, 0.0], weak, weak * J / A)[0].sum()
    assert steady == pytest.approx(1.01 / 0.1 + 2.0 * math.sqrt(0.1 / J))
    last = profile([0.5, 0.5], 0.1, [1.0, 0.0], weak[:2], weak[:2] * J / A)[0]
    # up in the first block by its limits, down in the second by its own
    expected = 1.0 / 0.1 + math.sqrt(0.1 / J) + 0.5 * (0.1 / weak[1] + 0.1 * A / (0.1 * J))
    assert last.sum() == pytest.approx(expected)


@settings(max_examples=200, deadline=None)
@given(st.floats(0.0, 1.0), st.floats(1e-7, 1.0), st.floats(0.1, 20.0), st.floats(1.0, 1e6))
def test_a_ramp_reaches_just_the_speed_that_its_distance_allows(start, distance, acceleration, jerk):
    end = reachable_speed(start, distance, acceleration, jerk)
    rounding = 1e-13 * (1.0 + end)
    offs = -min(rounding, end - start), rounding
    below, above = (ramp_distance(start, end + off, acceleration, jerk) for off in offs)
    assert below <= distance * (1.0 + 1e-9) and above >= distance * (1.0 - 1e-9)
    if end - start < 1e-6:
        return  # differences of the speed are rounding
    for share in (0.05, 0.3, 0.5, 0.8, 0.99):
        # the speed is the derivative of the way: by differences of the time
        step = 1e-4 * distance
        before, after = (
            time_on_ramp(start, end, share * distance + sign * step, acceleration, jerk) for sign in (-1.0, 1.0)
        )
        speed = speed_on_ramp(start, end, share * distance, acceleration, jerk)
        assert speed == pytest.approx(2.0 * step / (after - before), rel=1e-3)


def random_chain(seed: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 30))
    corner = rng.uniform(0.0, 0.3, n) * (rng.random(n) > 0.1)
    corner[-1] = 0.0
    varied = rng.choice([0.0, 1.0])
    return (
        10.0 ** rng.uniform(-5, -1, n), rng.uniform(0.01, 0.3, n), corner,
        A * rng.uniform(0.3, 1.0, n) ** varied, J * rng.uniform(0.3, 1.0, n) ** varied,
    )  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_no_limit_is_exceeded_anywhere_along_random_chains(seed: int):
    """Each block in many pieces: speeds, and accelerations and jerks as differences of the speeds at their ends."""
    length, feed, corner, acceleration, jerk = random_chain(seed)
    pieces = 200
    many = [np.repeat(each, pieces) for each in (length / pieces, feed, feed, acceleration, jerk)]
    many[2][pieces - 1 :: pieces] = corner
    times, ends = profile_of_chain(*many)
    assert (ends <= np.minimum(many[1], many[2]) * (1.0 + 1e-8)).all()
    speeds = np.concatenate([[0.0], ends])
    mean = np.diff(speeds) / times
    assert (np.abs(mean) <= many[3] * (1.0 + 1e-5)).all()
    between = 0.5 * (times[1:] + times[:-1])
    # mean accelerations of neighbours differ by no more than the jerk allows between their middles
    sharpest = np.maximum(many[4][1:], many[4][:-1])
    assert (np.abs(np.diff(mean)) <= sharpest * between * (1.0 + 1e-3) + 1e-5 * A).all()
    # the speeds are those of the times: the way between two ends, by the trapezoidal rule, is the length
    way = 0.5 * (speeds[1:] + speeds[:-1]) * times
    slack = jerk.max() * times**3 / 12.0
    assert (np.abs(way - many[0]) <= slack + 1e-9 * many[0]).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_more_of_a_limit_in_all_blocks_is_hardly_ever_slower(seed: int):
    length, feed, corner, acceleration, jerk = random_chain(seed)
    least = profile_of_chain(length, feed, corner, acceleration, jerk)[0].sum()
    # time scales: four times the acceleration and eight times the jerk at twice the speed is half the time
    half = profile_of_chain(length, 2.0 * feed, 2.0 * corner, 4.0 * acceleration, 8.0 * jerk)[0].sum()
    assert half == pytest.approx(0.5 * least, rel=1e-9)
    assert profile_of_chain(length, feed, corner, 2.0 * acceleration, 2.0 * jerk)[0].sum() <= least * 1.02


@pytest.mark.parametrize("seed", range(4))
def test_a_straight_line_takes_no_less_than_its_optimum(seed: int):
    """Feeds from block to block: nothing but the path's own limits hold, which the optimum has as well."""
    rng = np.random.default_rng(seed)
    length, feed = np.round(rng.uniform(2.0, 20.0, 6), 3), np.round(rng.uniform(1000.0, 6000.0, 6))
    lines = [f"G1 X{x:.3f} F{f:.0f}" for x, f in zip(np.cumsum(length), feed)]
    text = "\n".join(["G21 G90 G94", "G0 X0 Y0 Z0 A0 C0", *lines, "M2", ""])
    on = machine()
    source = Source.from_text(text, "part.ngc")
    options, _ = with_controller(source, None, ReadOptions.of(on))
    optimum = tp.plan(tp.Path.fit(read_source(source, on, None, options), machine=on), on).duration
    times, _ = profile(length * 1e-3, feed * 1e-3 / 60.0, np.append(np.full(5, 9.0), 0.0))
    assert optimum * (1.0 - 1e-4) <= times.sum() <= 1.05 * optimum


def test_a_hundred_thousand_blocks_take_no_more_than_two_seconds():
    rng = np.random.default_rng(0)
    n = 100_000
    corner = 0.1 + 0.09 * np.sin(np.arange(n) / 300)
    corner[-1] = 0.0
    length = rng.uniform(5e-5, 2e-4, n)
    profile(length[:50], 0.2, np.append(corner[:49], 0.0))
    before = time.process_time()
    profile(length, 0.2, corner)
    assert time.process_time() - before < 2.0


def test_a_control_that_reads_far_enough_ahead_goes_as_one_that_reads_all():
    """Whether the look-ahead limits no block is tested for all at once; else each is limited by itself."""
    rng, limited = np.random.default_rng(0), 0
    for _ in range(100):
        count, depth = int(rng.integers(3, 300)), int(rng.integers(1, 60))
        length, feed = 10.0 ** rng.uniform(-5.0, -1.0, count), 10.0 ** rng.uniform(-3.0, 0.0, count)
        acceleration, jerk = 10.0 ** rng.uniform(-0.3, 0.7, count), 10.0 ** rng.uniform(0.5, 2.0, count)
        corner = np.append(10.0 ** rng.uniform(-3.0, 3.0, count - 1), 0.0)
        least = np.minimum(corner, stoppable_speeds(length, acceleration, jerk, depth))
        expected, _ = profile_of_chain(length, feed, least, acceleration, jerk)
        limited += bool(np.any(least < corner))
        found = profile_along(feed, length, corner, acceleration, jerk, depth)
        assert found.times == pytest.approx(expected, rel=1e-12)
    assert 20 < limited < 100
