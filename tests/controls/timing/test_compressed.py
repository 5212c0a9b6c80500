"""Blocks within a tolerance of one line are one line to a control, and what is no noise stays what it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.timed_programs import MACHINE, A, J, machine, timed
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.kernels.controls.chains import MOST, chains_of
from toolpace.programs.reading import Source, read_commanded

FEED = 2.0 / 60.0
"""Of the programs [m/s]."""
OFF = {"compress": 0.0}
FREE = {"jerk": 1e6}


def zigzag(count: int, step: float = 0.01, aside: float = 0.01, word: str = "Y") -> str:
    """So many blocks along X, every second one beside it [mm]."""
    return "G1 F2000\n" + "".join(f"X{step * k:.4f} {word}{aside * (k % 2):.4f}\n" for k in range(1, count + 1))


def rest_to_rest(way: float, feed: float = FEED) -> float:
    """A line at constant acceleration, with what jerk adds to a ramp on which it is reached."""
    return way / feed + feed / A + 2.0 * math.sqrt(feed / J) - feed / A


@pytest.mark.parametrize("aside", [0.0, 0.002, 0.01])
def test_a_zigzag_within_the_tolerance_takes_what_its_line_does(aside):
    """50 mm at 2000 mm/min from rest to rest: no acceleration is reached at 40 m/s^3."""
    assert FEED * J < A**2
    time = timed(zigzag(5000, aside=aside))
    assert time.total == pytest.approx(rest_to_rest(0.05), rel=1e-4)
    assert time.total == pytest.approx(timed("G1 X50 F2000\n").total, rel=1e-4)
    # each block is a part of it, alike where the feed is reached
    assert np.ptp(time.times[2000:3000]) < 1e-9


def test_without_it_every_corner_of_the_zigzag_counts():
    """Y turns about at each block: the change is over within half of the blocks beside it, at constant acceleration.

    Blocks of 14 um, 45 degrees to X: D = sqrt(2) v, t = D / a, and v t is at most the block's length. Between two
    corners both axes speed up and slow down at a.
    """
    length, along = math.hypot(0.01, 0.01) * 1e-3, math.sqrt(2.0) * A
    v = math.sqrt(length * A / math.sqrt(2.0))
    each = 2.0 * (math.sqrt(v**2 + along * length) - v) / along
    time = timed(zigzag(4000), figures_of(OFF | FREE, "", "lookahead"))
    assert time.total == pytest.approx(4000 * each, rel=0.01)
    assert timed(zigzag(4000)).total < time.total / 3.0


def test_what_is_beyond_the_tolerance_is_no_noise():
    wide = timed(zigzag(500, step=0.05, aside=0.0101)).total
    assert wide == pytest.approx(timed(zigzag(500, step=0.05, aside=0.0101), figures_of(OFF, "", "lookahead")).total)
    told = timed(zigzag(500, step=0.05, aside=0.0101), figures_of({"compress": 0.02}, "", "lookahead")).total
    assert told == pytest.approx(rest_to_rest(0.025), rel=1e-3) and told < 0.8 * wide


def test_the_tolerance_of_the_program_goes_before_that_of_the_control():
    none = timed("G64 P0.01 Q0\n" + zigzag(1000)).total
    assert none == pytest.approx(timed(zigzag(1000), figures_of(OFF, "", "lookahead")).total)
    assert timed("G64 P0.01 Q0.01\n" + zigzag(1000), figures_of(OFF, "", "lookahead")).total < none / 3.0


def test_a_corner_between_two_noisy_legs_is_that_of_the_legs():
    legs = zigzag(2000) + "".join(f"Y{0.01 * k:.4f} X{20 + 0.004 * (k % 2):.4f}\n" for k in range(1, 2001))
    plain = "G1 F2000 X20\nY20\n"
    for figures in ({}, FREE, {"tolerance": 0.05}):
        both = [timed(body, figures_of({"compress": 0.01} | figures, "", "lookahead")).total for body in (legs, plain)]
        assert both[0] == pytest.approx(both[1], rel=5e-3)


def test_rests_stay_where_they_are():
    body = zigzag(1000)
    once = timed(body).total
    stopped = timed(body + "G4 P1\n" + body.replace("X", "X1").replace("X10.", "X2.")).sum("dwell")
    assert stopped == 1.0
    twice = "G1 F2000\n" + "".join(
        f"X{0.01 * k:.4f} Y{0.01 * (k % 2):.4f}\n" + ("G4 P1\n" if k == 500 else "") for k in range(1, 1001)
    )
    assert timed(twice).total - 1.0 == pytest.approx(2.0 * rest_to_rest(0.005), rel=2e-3)
    assert timed(twice).total - 1.0 > once


def test_a_curve_in_short_blocks_is_no_polygon():
    """Chords of its sagitta would have corners that jerk slows down; noise on it is taken off none the less."""
    turn = np.linspace(0.0, 2.0 * math.pi, 1441)[1:]

    def circle(noise: float) -> str:
        radius = 2.0 + noise * (np.arange(len(turn)) % 2)
        return "G1 X2 F30000\n" + "".join(
            f"G1 X{r * math.cos(a):.7f} Y{r * math.sin(a):.7f}\n" for r, a in zip(radius, turn)
        )

    arc = timed("G1 X2 F30000\nG3 X2 Y0 I-2 J0\n").total
    assert timed(circle(0.0)).total == pytest.approx(arc, rel=0.05)
    noisy, apart = timed(circle(0.005)).total, timed(circle(0.005), figures_of(OFF, "", "lookahead")).total
    assert arc < noisy < 0.7 * apart


def test_turning_noise_in_tip_mode_is_smoothed_in_the_joints():
    """Half a hundredth of a degree beside a steady turn, where 0.05 degrees are the tolerance."""
    on = machine()
    text = "G21 G90 G94\nG0 X0 Y0 Z100 A0 C0\nG43.4 H1\nG0 X0 Y0 Z0 A10 C0\nG1 F2000\n{}M30\n"
    blocks = [
        "".join(f"X{0.02 * k:.4f} A{10 + 0.002 * k + noise * (k % 2):.5f}\n" for k in range(1, 1001))
        for noise in (0.0, 0.005)
    ]
    moves = [read_commanded(Source.from_text(text.format(each), "part.nc"), on) for each in blocks]
    plain, noisy = (time_of_moves(each, on, figures_of({}, "", "lookahead")).total for each in moves)
    apart = time_of_moves(moves[1], on, figures_of(OFF, "", "lookahead")).total
    assert noisy == pytest.approx(plain, rel=0.01) and apart > 2.0 * noisy


def test_it_never_slows_a_program_down():
    rng = np.random.default_rng(3)
    for _ in range(30):
        step = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-3.0, 0.5, (200, 1)) + [0.05, 0.0, 0.0]
        place = np.cumsum(step, axis=0)
        body = "G1 F6000\n" + "".join(f"X{x:.4f} Y{y:.4f} Z{z:.4f}\n" for x, y, z in place)
        with_it, without = (timed(body, figures_of(each, "", "lookahead")).total for each in ({}, OFF))
        assert with_it <= without * 1.02


def test_chains_end_where_the_line_is_left():
    place = np.array([[0.0, 0.0], [1.0, 0.1], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 2.0]])
    none = np.zeros(6, dtype=bool)
    one = np.full(6, 0.11)
    assert chains_of(place, one, none, none).tolist() == [0, 1, 1, 1, 2, 2]
    assert chains_of(place, np.full(6, 0.05), none, none).tolist() == [0, 1, 2, 2, 3, 3]
    assert chains_of(place, one, none, np.array([0, 0, 1, 0, 0, 0], dtype=bool)).tolist() == [0, 1, 1, 2, 3, 3]
    assert chains_of(place, one, np.array([0, 0, 1, 0, 0, 0], dtype=bool), none).tolist() == [0, 1, 2, 3, 4, 4]
    assert chains_of(place, np.zeros(6), none, none).tolist() == [0, 1, 2, 3, 4, 5]
    line = np.linspace(0.0, 1.0, 500)[:, None]
    free = np.zeros(500, dtype=bool)
    assert np.bincount(chains_of(line, np.ones(500), free, free)).max() == MOST + 1 - 1


def test_the_figure_is_checked():
    from toolpace.common.errors import UsageError

    for wrong in (-1.0, "much", 11.0):
        with pytest.raises(UsageError, match=r"\[time\].*compress"):
            figures_of({"compress": wrong}, "my.toml", "lookahead")
    assert figures_of({}, "").compress is None and len(MACHINE.joints) == 5
