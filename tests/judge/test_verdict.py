"""What a verdict says: each check in words and figures of the shop floor, the worst first, and one line in all."""

from __future__ import annotations

import math

import pytest

from toolpace.common.errors import VerificationError
from toolpace.judge import Check, Verification

SPEED = Check("velocity", 0.06, 0.05, "m/s", False, 1.25, 17, "X")
TURN = Check("velocity", 2.0, 1.0, "rad/s", False, 0.5, 3, "C", note="by the set-point's own derivative")
DWELL = Check("dwell", 0.2, 0.3, "s", False, 2.0, 9, at_least=True)
FINE = Check("jerk", 9.0, 10.0, "m/s3", True, 1.0, 5, "Y")


def verdict(*checks):
    return Verification(checks, 1e-3, 1200)


@pytest.mark.parametrize(
    ("value", "limit", "at_least", "ratio"),
    [
        (0.5, 1.0, False, 0.5), (2.0, 1.0, False, 2.0), (0.5, 1.0, True, 2.0), (2.0, 1.0, True, 0.5),
        (0.0, 0.0, False, 0.0), (0.0, 1.0, False, 0.0), (1.0, 0.0, False, math.inf), (0.0, 1.0, True, math.inf),
        (1.0, 0.0, True, 0.0), (math.nan, 1.0, False, math.inf),
    ],
)  # fmt: skip
def test_ratio_is_1_at_the_limit_and_more_is_worse(value, limit, at_least, ratio):
    assert Check("x", value, limit, "m", True, at_least=at_least).ratio == pytest.approx(ratio)


def test_nothing_is_granted_that_is_not_told():
    assert Check("x", 1.0, 1.0, "m", True).noise == 0.0


def test_a_check_in_words():
    assert str(SPEED) == "velocity of X at 1.25 s, block 17: 60 mm/s, allowed at most 50 mm/s"
    angle = f"{math.degrees(2.0):.6g} deg/s, allowed at most {math.degrees(1.0):.6g} deg/s"
    assert str(TURN) == f"velocity of C at 0.5 s, block 3: {angle} (by the set-point's own derivative)"
    assert str(DWELL) == "dwell at 2 s, block 9: 0.2 s, allowed at least 0.3 s"
    assert str(Check("joints", 0.0, 0.0, "", False, note="columns are named A")) == "joints: columns are named A"
    assert str(Check("share", 2.0, 1.0, "", False)) == "share: 2, allowed at most 1"
    assert "FAILED: velocity of X" in repr(SPEED) and "ok: jerk of Y" in repr(FINE)


def test_a_verdict_in_one_line():
    assert "VERIFIED" in repr(verdict(FINE)) and "FAILED" not in repr(verdict(FINE))
    assert "FAILED in 2 checks" in repr(verdict(FINE, SPEED, TURN)) and "VERIFIED" not in repr(verdict(SPEED))
    assert "worst velocity of C at 0.5 s, block 3" in repr(verdict(FINE, SPEED, TURN))


@pytest.mark.parametrize(
    ("checks", "line"),
    [
        ((SPEED,), f"{SPEED}"), ((FINE, SPEED, DWELL), f"{DWELL}; and 1 more finding"),
        ((SPEED, DWELL, FINE, TURN), f"{TURN}; and 2 more findings"),
    ],
)  # fmt: skip
def test_a_verdict_that_fails_raises_its_worst_finding(checks, line):
    assert not verdict(*checks).ok
    with pytest.raises(VerificationError) as caught:
        verdict(*checks).raise_if_failed()
    assert str(caught.value) == line
    assert verdict(FINE).ok and verdict(FINE).raise_if_failed() == verdict(FINE)


def test_rows_of_a_table():
    none = Check("set-points", math.nan, 0.0, "", False, note="set-point 3: q is not a number")
    assert verdict(SPEED, FINE, none).rows() == [
        ("velocity of X", "60 mm/s", "50 mm/s", "at 1.25 s, block 17", "FAILED"),
        ("jerk of Y", "9000 mm/s3", "10000 mm/s3", "at 1 s, block 5", "ok"),
        ("set-points", "set-point 3: q is not a number", "", "", "FAILED"),
    ]
