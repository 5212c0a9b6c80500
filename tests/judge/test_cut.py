"""The judge of the cut: what a plan promised is held, and what was changed is found."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

import toolpace as tp
from tests.support.limited_plans import SLOT, limited_slot, machine
from toolpace.cutting.feeds.limited_plan import plan_within_cut
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.judge.cut import (
    CutJudge,
    CutPromise,
    allowed_check,
    cut_checks,
    learned_check,
    limit_checks,
    reached_checks,
    speed_check,
)
from toolpace.judge.cut.stations import arcs_check, chosen_stations, columns_check
from toolpace.judge.cut.stocks import box_stock
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.results.write.cut_limits import cut_arrays, cut_bytes, cut_record
from toolpace.results.write.cut_promise import promise_of


def test_what_a_plan_promised_of_its_cut_is_held_and_what_was_changed_is_found():
    judge, file = slot_judge()
    points, promise = judge.points, judge.promise
    judge = CutJudge(points, SLOT.toolpath(), promise)
    checks = {check.what: check for check in cut_checks(judge, file, 6, 4)}
    assert all(check.ok for check in checks.values()), list(checks.values())
    assert checks["chip of the cut"].ratio == pytest.approx(1.0, abs=2e-3)

    faster = CutJudge(dataclasses.replace(points, t=points.t / 1.05), SLOT.toolpath(), promise)
    assert not speed_check(faster, file).ok
    (check,) = limit_checks(faster, faster.instants(1))
    assert not check.ok and check.ratio == pytest.approx(1.05, abs=5e-3)
    judge.promise = dataclasses.replace(promise, limits={"": {"chip": 0.97 * SLOT.chip}})
    assert not limit_checks(judge, judge.instants(1))[0].ok


ARCS = {
    "shorter": {"exit": lambda file: 0.7 * file["engagement exit"] + 0.3 * file["engagement entry"]},
    "turned": {name: lambda file, name=name: file[f"engagement {name}"] + 0.5 * math.pi for name in ("entry", "exit")},
    "higher": {"slice": lambda file: file["engagement slice"] + 2},
    "thicker": {"slice_height": lambda file: 2.5 * file["engagement slice_height"]},
}
COLUMNS = {
    "station tip": np.array([0.0, 0.0, 1e-3]), "station axis": np.array([0.01, 0.0, 0.0]), "station block": 3,
    "station operation": 1, "station time": 0.1, "engagement across": -0.1, "engagement along": 0.1,
    "engagement feed_direction": np.array([0.0, 0.1, 0.0]),
}  # fmt: skip
"""What each is changed by."""


@cache
def slot_judge():
    plan = limited_slot()
    points, file = plan.plan.trajectory.sample(2e-3), cut_arrays(cut_bytes(plan))
    cell = plan.simulation.resolution
    promise = CutPromise("limits", SLOT.stock, SLOT.tools, {"": {"chip": SLOT.chip}}, {}, {}, cell)
    return CutJudge(points, SLOT.toolpath(), promise), file


@pytest.mark.parametrize("name", COLUMNS)
def test_a_changed_column_of_the_stations_is_found(name):
    judge, file = slot_judge()
    assert columns_check(judge, file).ok and not columns_check(judge, {**file, name: file[name] + COLUMNS[name]}).ok


@pytest.mark.parametrize("change", ARCS)
def test_changed_arcs_are_found(change):
    judge, file = slot_judge()
    chosen = chosen_stations(judge, file, 6)[2:3]
    assert arcs_check(judge, file, chosen).ok
    changed = {f"engagement {name}": make(file) for name, make in ARCS[change].items()}
    assert not arcs_check(judge, {**file, **changed}, chosen).ok


@pytest.mark.sweep
def test_speeds_that_no_station_has_or_that_its_cut_does_not_allow_are_found():
    judge, file = slot_judge()
    assert allowed_check(judge, file, 3).ok
    assert not columns_check(judge, {**file, "speed": 1.01 * file["speed"]}).ok
    both = {**file, "speed": 1.05 * file["speed"], "station most": 1.05 * file["station most"]}
    assert columns_check(judge, both).ok
    assert not allowed_check(judge, both, 3).ok


def test_speeds_below_those_that_the_motion_has_are_found():
    judge, file = slot_judge()
    assert speed_check(judge, file).ok
    assert not speed_check(judge, {**file, "station most": 0.9 * file["station most"]}).ok


@pytest.mark.sweep
def test_a_stock_that_is_larger_than_planned_is_found():
    plan = limited_slot()
    points, file = plan.plan.trajectory.sample(2e-3), cut_arrays(cut_bytes(plan))
    stock = box_stock(np.array([0.0, -20e-3, -20e-3]), np.array([80e-3, 20e-3, 0.0]), 0.0)
    promise = CutPromise("air", stock, SLOT.tools, {}, {}, {}, 1e-3)
    judge = CutJudge(points, SLOT.toolpath(), promise)
    assert "cut above the feed" in {check.what for check in cut_checks(judge, file, 4, 0) if not check.ok}


LEARNING = """G21 G90 G54 G17
T1 M6
S6000 M3
G0 X-12 Y0 Z-2
G1 X52 F600
G0 Z20
G0 X-12 Y-24
G0 Z-2
G1 X52
G0 Z20
M30
"""
"""A slot, and a shoulder 1 mm wide whose chips are thinner at the same feed."""


def test_what_is_learned_is_within_a_teacher():
    setup = setup_of_text(SLOT.sheet)
    toolpath = tp.read_text(LEARNING, machine(), controller="linuxcnc", setup=setup)
    rules = FeedRules("learned", air_feed=0.1, finishing=True)
    plan = plan_within_cut(toolpath, machine(), setup, rules, effort="low", resolution=0.5e-3)
    data = cut_bytes(plan)
    promise = promise_of(cut_record(plan, rules, data, setup), toolpath, setup, machine())
    judge = CutJudge(plan.plan.trajectory.sample(2e-3), toolpath, promise)
    in_shoulder = [judge.instant(row) for row in np.flatnonzero(judge.points.block == 9)[[300, 400]]]
    assert all(each.speed > 0.012 and each.loads["chip"] > 0.0 for each in in_shoulder)
    found = learned_check(judge, in_shoulder)
    assert found.ok and found.value > 0.95, found
    chip, area, edge = np.array(promise.teachers["1"]).max(axis=0)
    judge.promise = dataclasses.replace(promise, teachers={"1": [(0.9 * chip, area, edge)]})
    assert not learned_check(judge, in_shoulder).ok
    file = cut_arrays(data)
    for times, ok in ((1.0, True), (1.05, False)):
        judge.promise = dataclasses.replace(promise, teachers={"1": [(times * chip, times * area, edge)]})
        (check,) = reached_checks(judge, file)
        assert check.ok is ok, check
