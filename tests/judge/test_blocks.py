"""What the judge finds does not depend on where the blocks begin on which it works."""

from __future__ import annotations

from dataclasses import astuple, replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.walks import AXIS, TIP, random_walk, set_points
from toolpace.judge import motion_judge, seen_motion, verify
from toolpace.judge.seen_motion import WINDOW, Largest, each_block
from toolpace.motion.setpoints import Block


def judged(points, monkeypatch, rows):
    """All checks of set-points of a right motion that were changed, in blocks of so many rows."""
    monkeypatch.setattr(seen_motion, "ROWS", rows)
    return verify(points, motions.machine(), motions.program(), 10e-6, 1e-3)


def same(one, other):
    """Numbers to rounding, nan to nan, and everything else as it is."""
    return all(
        np.isclose(a, b, rtol=1e-12, atol=0.0, equal_nan=True) if isinstance(a, float) else a == b
        for a, b in zip(one, other, strict=True)
    )


CHANGES = {
    "q": ("velocity", "acceleration", "jerk"),
    "qd": ("velocity column",),
    "qdd": ("acceleration column",),
    "qddd": ("jerk",),
    "tip": ("tip column",),
    "axis": ("axis column",),
    "block": ("block column",),
}
"""Checks one of which must fail where a column is changed."""


@pytest.mark.parametrize("row", [WINDOW - 2, WINDOW - 1, WINDOW, WINDOW + 1, WINDOW + 2])
@pytest.mark.parametrize("name", CHANGES)
def test_a_change_beside_the_border_of_two_blocks_is_found_as_in_one(name, row, monkeypatch):
    points = motions.set_points()
    assert len(points) > 2 * WINDOW
    column = np.array(getattr(points, name))
    column[row] += 1000 if name == "block" else 1e-3 if name in ("q", "tip", "axis") else 1e3
    points = replace(points, **{name: column})
    whole, parts = judged(points, monkeypatch, 1 << 30), judged(points, monkeypatch, WINDOW)
    assert {check.what for check in parts.findings} & set(CHANGES[name])
    assert all(same(astuple(a), astuple(b)) for a, b in zip(whole.checks, parts.checks, strict=True))


def test_a_right_motion_is_found_right_in_any_blocks(monkeypatch):
    points = motions.set_points()
    whole, parts = judged(points, monkeypatch, 1 << 30), judged(points, monkeypatch, WINDOW)
    assert whole.ok and parts.ok
    assert all(same(astuple(a), astuple(b)) for a, b in zip(whole.checks, parts.checks, strict=True))


@pytest.mark.parametrize("count", [1, 2, 3, WINDOW, WINDOW + 1, WINDOW + 2, 2 * WINDOW + 1])
def test_of_any_number_of_set_points_none_is_left_out(count, monkeypatch):
    """Also where the last block is one set-point, to which a step leads and from which none begins."""
    points = motions.set_points().rows(0, count)
    q = np.array(points.q)
    q[-1] += 1e-3
    points = replace(points, q=q)
    whole, parts = judged(points, monkeypatch, 1 << 30), judged(points, monkeypatch, WINDOW)
    assert {check.what for check in parts.findings} >= ({"set-points"} if count == 1 else {"velocity", "tip column"})
    assert all(same(astuple(a), astuple(b)) for a, b in zip(whole.checks, parts.checks, strict=True))


@pytest.mark.parametrize("seed", [1, 3, 5, 9, 13])
@pytest.mark.parametrize("wrong", ["feed", "block", "tolerance"])
def test_walks_with_stops_and_dwells_come_out_alike_in_any_sections(seed, wrong, monkeypatch):
    """Right ones, and such as are too fast, name another block, or leave the program."""
    program, walk, r = random_walk(seed)
    points, machine = set_points(walk)
    if wrong == "feed":
        program = replace(program, feed=0.7 * program.feed)
    if wrong == "block":
        block = np.array(points.block)
        block[int(r.integers(len(block)))] = int(block[-1]) + 1
        points = replace(points, block=block)
    tolerance = 0.1 * TIP if wrong == "tolerance" else TIP
    found = []
    for rows in (1 << 30, WINDOW):
        monkeypatch.setattr(seen_motion, "ROWS", rows)
        found.append(verify(points, machine, program, tolerance, AXIS))
    assert len(points) > WINDOW
    assert all(same(astuple(a), astuple(b)) for a, b in zip(*(each.checks for each in found), strict=True))
    assert wrong == "tolerance" or {"feed": "feed", "block": "block column"}[wrong] in {
        check.what for check in found[0].findings
    }


def test_the_order_in_which_blocks_come_says_nothing():
    points = motions.set_points()
    verdicts = []
    for turn in (1, -1):
        judge = motion_judge(points, motions.machine(), motions.program(), 10e-6, 1e-3)
        for begin in range(0, len(points), WINDOW)[::turn]:
            judge.take(Block.of(points, begin, min(begin + WINDOW, len(points))))
        verdicts.append(judge.judged()[0])
    assert verdicts[0] == verdicts[1] and verdicts[0].ok


def test_the_first_of_the_largest_rows_is_named(monkeypatch):
    monkeypatch.setattr(seen_motion, "ROWS", 10)
    columns = np.zeros((2, 35))
    columns[0, [7, 19, 34]] = columns[1, [30, 34]] = 3.0
    found = Largest.of_all(each_block(lambda begin, end: Largest.of(columns[:, begin:end], begin), 35))
    assert found.value.tolist() == [3.0, 3.0] and found.row.tolist() == [7, 30]


def test_an_error_in_a_block_is_raised(monkeypatch):
    monkeypatch.setattr(seen_motion, "ROWS", 10)

    def work(begin, end):
        if begin == 20:
            raise ValueError("row 20")

    with pytest.raises(ValueError, match="row 20"):
        each_block(work, 35)


def test_a_judge_that_has_not_seen_all_does_not_judge():
    points = motions.set_points()
    halves = [Block.of(points, 0, WINDOW), Block.of(points, WINDOW, len(points))]
    for taken in ([], halves[:1], [halves[0], *halves]):
        judge = motion_judge(points, motions.machine(), motions.program(), 10e-6, 1e-3)
        for block in taken:
            judge.take(block)
        with pytest.raises(ValueError, match=f"of {len(points)} set-points"):
            judge.judged()
