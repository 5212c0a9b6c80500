"""Figures of a plan.json, by themselves: bounds, and places where time could be gained."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from tests.support import motions
from toolpace.judge.figures import EARLY, Figures
from toolpace.judge.usage import UsageFigures

POINTS = motions.set_points()
DURATION = float(POINTS.t[-1])


def figures(**said):
    return Figures({"duration_s": DURATION, **said}, POINTS, motions.machine(), None, SimpleNamespace(dt=1e-3), None)


def place(start, end, gain=0.01, block=None):
    block = int(POINTS.block[int(start / 1e-3)]) if block is None else block
    return {"from_s": start, "to_s": end, "gain_s": gain, "block": block}


def fine(*places):
    (check,) = figures(open_places=list(places)).of_places()
    return check.ok


def test_places_in_order_within_the_motion_and_in_their_blocks_are_fine():
    assert not figures(open_places=[]).of_places()
    assert fine(place(0.0, 0.1), place(0.2, 0.2, 0.0), place(0.2, DURATION, DURATION))


@pytest.mark.parametrize(
    "bad",
    [
        place(0.4, 0.3), place(0.3, DURATION + 0.01), place(0.1, 0.2), place(-0.1, 0.2, block=10),
        place(0.3, 0.4, -0.001), place(0.3, 0.4, DURATION + 0.01), place(0.3, 0.4, block=10**6),
        place(0.0, 0.1, block=int(POINTS.block[-1])),
    ],
)  # fmt: skip
def test_a_place_that_cannot_be_is_found(bad):
    first = place(0.2, 0.25)
    assert fine(first) and not fine(first, bad) and not fine(first, bad, place(0.5, 0.6))


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_the_block_of_a_place_is_passed_within_a_few_set_points(start):
    k = int(start / 1e-3)
    later = int(POINTS.block[k + EARLY])
    assert fine(place(start, start, block=later))
    assert not fine(place(start, start, block=int(POINTS.block[k + 3 * EARLY]) + 1))


@pytest.mark.parametrize(
    ("bound", "good"),
    [(0.5 * DURATION, True), (1e-3, True), (DURATION, True), (0.0, False), (-1.0, False), (1.0001 * DURATION, False)],
)
def test_a_bound_lies_above_nothing_and_not_above_the_duration(bound, good):
    for key, other in (("lower_bound_s", "continuous_bound_s"), ("continuous_bound_s", "lower_bound_s")):
        said = {key: bound, other: None, "lower_bound_of": "this mesh" if key == "lower_bound_s" else None}
        gap = DURATION / bound - 1.0 if key == "lower_bound_s" and bound else None
        found = {check.what: check.ok for check in figures(**said, gap=gap).of_bounds()}
        assert found[f"plan.json {key}"] == good


@pytest.mark.parametrize(("factor", "good"), [(1.0, True), (0.9, False), (1.15, False)])
def test_a_peak_may_lie_between_set_points_by_what_half_a_step_can_add(factor, good):
    """The true peaks, where every twentieth set-point does not show them all; less, and more than can hide."""
    peaks = motions.peaks(motions.set_points(dt=1e-4))
    machine = motions.with_limits(motions.machine(), **{kind: 1.3 * peak for kind, peak in peaks.items()})
    coarse = motions.set_points(dt=0.02)
    said = {kind: dict.fromkeys(machine.joints, 1.0 / 1.3) for kind in peaks}
    said["velocity"] = dict.fromkeys(machine.joints, factor / 1.3)
    given = {"usage": {**said, "feed": 0.0}}
    found = UsageFigures(given, coarse, machine, None, None, 0.02).of_usage()
    assert all(check.ok for check in found) == good
    shown = motions.peaks(coarse)
    assert min((shown[kind] / peaks[kind]).min() for kind in ("velocity", "acceleration")) < 0.999
