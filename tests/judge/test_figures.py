"""Figures of a plan.json, by themselves: bounds, and places where time could be gained."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support import motions
from toolpace.judge.figures import EARLY, Figures
from toolpace.judge.usage import TOGETHER, UsageFigures

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


@pytest.mark.parametrize(("more", "good"), [(0.5e-9, True), (3e-9, False)])
def test_figures_are_the_same_to_a_billionth(more, good):
    """What is found, times that much more or less; times and shares that much beyond where they may be."""
    for sign in (1.0, -1.0):
        for right in (0.125, 1e-6, -40.0):
            assert figures(x=right * (1.0 + sign * more)).same("x", right).ok == good
        late = replace(POINTS, t=POINTS.t + sign * more * 1e-3)
        said = {"duration_s": float(late.t[-1]), "dt_s": 1e-3 * (1.0 + sign * more), "set_points": len(POINTS)}
        found = replace(figures(**said), points=late).of_time()
        wrong = {check.what for check in found if not check.ok}
        assert wrong == (set() if good else {"begin of time", "plan.json dt_s"})
    bounds = {"lower_bound_s": None, "lower_bound_of": None, "gap": None}
    bounds = figures(**bounds, continuous_bound_s=DURATION * (1.0 + more)).of_bounds()
    assert all(check.ok for check in bounds) == good
    for key in ("tip_at_tolerance", "axis_at_tolerance"):
        shares = {"tip_at_tolerance": None, "axis_at_tolerance": None, key: 1.0 + more}
        (check,) = figures(effort="normal", rounds=[], **shares).of_rounds()
        assert check.ok == good
    assert fine(place(0.2, DURATION * (1.0 + more))) == good
    assert fine(place(0.2, 0.2), place(0.2 - more, 0.3)) == good


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


def usage_of(jerk, limit):
    """Checks of usage where plan.json says so much of each jerk, with limits that are so many peaks; and the shares."""
    peaks = motions.peaks(POINTS)
    machine = motions.with_limits(motions.machine(), **{kind: 1.3 * peak for kind, peak in peaks.items()})
    machine = motions.with_limits(machine, jerk=limit * peaks["jerk"])
    said = {kind: dict.fromkeys(machine.joints, 1.0 / 1.3) for kind in ("velocity", "acceleration")}
    given = {"usage": {**said, "jerk": dict.fromkeys(machine.joints, jerk), "feed": 0.0}}
    found = UsageFigures(given, POINTS, machine, None, None, 1e-3)
    known = ["feed", *(f"{kind} {joint}" for kind in ("velocity", "acceleration", "jerk") for joint in machine.joints)]
    return found.of_usage(), found.shares(known)[1]


def test_of_a_jerk_limit_that_is_none_nothing_is_used():
    for said, good in ((0.0, True), (1e-3, False), (1.0, False), (None, False)):
        checks, shares = usage_of(said, np.inf)
        assert all(check.ok for check in checks) == good, said
        assert not sum(shares.values())


def test_jerks_that_no_number_bounds_fail_and_hold_nothing_back():
    """What a plan without jerk limits says, `null`, is above any limit; its jerks are not what binds."""
    for limit in (0.1, 1.0, 10.0):
        checks, shares = usage_of(None, limit)
        assert {(check.what, check.ok, check.value) for check in checks} == {("plan.json usage jerk", False, np.inf)}
        assert {check.joint for check in checks} == set(motions.machine().joints)
        assert not sum(shares.values())
    assert sum(usage_of(1.0, 0.1)[1].values()) > 0.1


def test_the_share_of_what_binds_is_that_of_its_set_points():
    """An acceleration at twice its limit now and then, and the feed in one step, whatever is said of jerks."""
    peaks, n = motions.peaks(POINTS), len(POINTS)
    machine = motions.with_limits(motions.machine(), **{kind: 1.3 * peak for kind, peak in peaks.items()})
    limit = np.append(1.3 * peaks["acceleration"][:-1], 0.5 * peaks["acceleration"][-1])
    machine = motions.with_limits(machine, acceleration=limit)
    last = machine.joints[-1]
    known = ["feed", *(f"{kind} {joint}" for kind in ("velocity", "acceleration", "jerk") for joint in machine.joints)]
    still = int(np.flatnonzero(np.abs(POINTS.qdd[:, -1]) < 1e-3 * limit[-1])[5])
    use = np.zeros(n - 1)
    use[still] = 1.0
    for jerk in (None, 0.5):
        said = {"usage": {"jerk": dict.fromkeys(machine.joints, jerk)}}
        least, most = UsageFigures(said, POINTS, machine, None, SimpleNamespace(ratio=use), 1e-3).shares(known)
        binds = np.abs(POINTS.qdd[:, -1]) >= 0.995 * limit[-1]
        assert least == most and {name: share for name, share in most.items() if share} == {
            "feed": 2.0 / n, f"acceleration {last}": binds.sum() / n, TOGETHER: pytest.approx((binds.sum() + 2) / n)
        }  # fmt: skip


@pytest.mark.parametrize(
    ("first", "second", "good"),
    [(1.0, 0.0, True), (0.0, 1.0, True), (0.3, 0.7, True), (0.0, 0.0, False), (0.5, 0.0, False)],
)
def test_of_joints_on_a_diagonal_either_may_be_what_binds(first, second, good):
    """Both reach their limits at once; that one of them does is certain."""
    peaks, machine = motions.peaks(POINTS), motions.machine()
    x, y = machine.joints[:2]
    still, both = np.zeros_like(POINTS.qd), np.arange(len(machine.joints)) < 2
    diagonal = replace(POINTS, qd=still, qdd=still, qddd=still + peaks["jerk"][0] * both)
    machine = motions.with_limits(machine, jerk=np.full(len(machine.joints), peaks["jerk"][0]))
    said = {f"jerk {x}": first, f"jerk {y}": second, "nothing": 1.0 - first - second}
    figures = {"limited_by": said, "usage": {"jerk": dict.fromkeys(machine.joints, 1.0)}}
    (check,) = UsageFigures(figures, diagonal, machine, None, None, 1e-3).of_shares()
    assert check.ok == good


def test_where_no_feed_is_asked_for_none_is_used():
    """A program of rapids uses none of its feed; with times of its blocks it may use all of them, and no more."""
    free = motions.program(feed=np.inf)
    timed = replace(free, least_time=np.full(len(free), 1e-3))
    for program, said, good in ((free, 0.0, True), (free, 0.5, False), (timed, 1.0, True), (timed, 1.01, False)):
        found = UsageFigures({"usage": {"feed": said}}, POINTS, motions.machine(), program, None, 1e-3).of_feed()
        assert (not found) == good, said


@pytest.mark.parametrize(
    ("rounds", "good"),
    [
        ([(2.0, True)], True), ([(2.0, True), (1.5, True), (1.8, False)], True), ([(2.0, False)], False),
        ([(2.0, True), (1.5, True), (1.8, True)], False), ([(2.0, True), (1.5, False)], False),
        ([(2.0, True), (-1.0, True)], False), ([(np.inf, True)], False),
    ],
)  # fmt: skip
def test_a_round_is_kept_where_it_is_the_fastest_so_far(rounds, good):
    said = [{"duration_s": duration, "kept": kept} for duration, kept in rounds]
    shares = {"tip_at_tolerance": 0.5, "axis_at_tolerance": None}
    (check,) = figures(effort="normal", rounds=said, **shares).of_rounds()
    assert check.ok == good
