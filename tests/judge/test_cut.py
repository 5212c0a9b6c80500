"""The judge of the cut: sections against closed forms, loads against the library's, and what it must find."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import toolpace as tp
from tests.support.engagements import engagement
from tests.support.limited_plans import SLOT, limited_slot, machine
from toolpace.cutting.feeds.limited_plan import plan_within_cut
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.judge.cut import CutJudge, CutPromise, cut_checks, learned_check, round_stock
from toolpace.judge.cut.sections import Poses, Section, Surface, shape_of
from toolpace.judge.cut.turning import Cutting, loads_of
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.tool_figures import ToolFigures
from toolpace.results.write.cut_limits import cut_arrays, cut_bytes, cut_record, promise_of

ALUMINIUM = Coefficients(800e6, 250e6, 100e6, 15e3, 20e3, 3e3)
FEED = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])


def straight(figures, stock, y=0.0, z=-2e-3, axis=UP):
    """The surface of a tool on its way along x through a stock."""
    x = np.arange(-20e-3, 20e-3, 0.1e-3)
    poses = Poses(
        np.column_stack([x, np.full_like(x, y), np.full_like(x, z)]), np.tile(axis, (len(x), 1)),
        np.zeros(len(x), dtype=np.int64),
    )  # fmt: skip
    return Surface(len(x) - 1, poses, (shape_of(figures),), stock, 0.01 * FEED, np.zeros(3))


def box(low, high, uncertainty=0.0):
    return round_stock((np.array(low), np.array(high)), None, uncertainty)


WIDE = box([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])


def test_a_slot_is_half_a_turn_up_to_the_top_of_the_stock():
    surface = straight(ToolFigures("flat", 10e-3, flute_length=20e-3), WIDE)
    section = surface.section((np.arange(8) + 0.5) * 0.5e-3)
    assert [j for j, _, _ in section.arcs] == [0, 1, 2, 3]
    for _, entry, leave in section.arcs:
        assert entry % (2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
        assert leave - entry == pytest.approx(math.pi, abs=1e-4)
    assert surface.top() == pytest.approx(2e-3, abs=0.2e-3)


@pytest.mark.parametrize("width", [0.5e-3, 3e-3, 7e-3])
def test_a_shoulder_begins_where_its_width_says(width):
    """The stock is on the right of the feed: the edge leaves it where the chip is nothing."""
    stock = box([-1.0, -1.0, -1.0], [1.0, -5e-3 + width, 0.0])
    section = straight(ToolFigures("flat", 10e-3, flute_length=20e-3), stock).section(np.array([0.5e-3, 1e-3]))
    arc = math.acos(1.0 - width / 5e-3)
    for _, entry, leave in section.arcs:
        assert leave == pytest.approx(math.pi, abs=1e-4) and leave - entry == pytest.approx(arc, abs=2e-3)


def test_a_ball_cuts_below_the_surface_it_is_tilted_on():
    """Against the circle in which a ball at depth meets a plane: the highest slice ends at the depth."""
    tool = ToolFigures("ball", 10e-3, flute_length=20e-3)
    section = straight(tool, WIDE, z=-1e-3).section(np.linspace(0.05e-3, 1.45e-3, 15))
    assert max(j for j, _, _ in section.arcs) == 9
    assert section.immersion[:10] == pytest.approx(np.full(10, math.pi), abs=1e-3)


def test_a_stock_is_larger_by_its_uncertainty_with_round_edges():
    stock = box([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 0.1)
    corner = 0.1 / math.sqrt(3.0)
    place = np.array([[-0.099, 0.5, 0.5], [-0.101, 0.5, 0.5], [-corner] * 3, [-0.1, -0.1, 0.5]]) * (1.0 - 1e-9)
    assert stock(place).tolist() == [True, False, True, False]
    round_bar = round_stock(None, (np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.4), 0.1)
    place = np.array([[0.299, 0.0, 0.5], [0.301, 0.0, 0.5], [0.0, 0.0, 1.099], [0.29, 0.0, 1.09]])
    assert round_bar(place).tolist() == [True, False, True, False]


@pytest.mark.parametrize(
    "tool",
    [
        ToolFigures("flat", 10e-3, teeth=3, helix=0.5, stick_out=40e-3, flute_length=20e-3, material="carbide"),
        ToolFigures("bull", 8e-3, corner_radius=1e-3, teeth=2, helix=0.4, runout=5e-6, stick_out=30e-3, material="HSS"),
        ToolFigures("ball", 6e-3, teeth=2, helix=-0.5, clockwise=False, stick_out=25e-3, material="carbide"),
    ],
)  # fmt: skip
def test_loads_are_those_of_the_library(tool):
    """Two simulations that share no code, on one engagement."""
    heights = (np.arange(10) + 0.5) * 0.2e-3
    arcs = [(j, 0.4, 2.2) for j in range(10)]
    section = Section(heights, 0.2e-3, tuple((j, a, b) for j, a, b in arcs))
    speed, turns = 0.02, 100.0
    found = loads_of(section, Cutting(tool, shape_of(tool), ALUMINIUM, turns), speed * FEED, UP, np.zeros(3))
    theirs = tp.EngagedForces(engagement(arcs, 0.2e-3), tool, ALUMINIUM, turns).loads([speed])
    for name, value in (
        ("force", theirs.resultant), ("torque", np.abs(theirs.torque)), ("power", np.abs(theirs.power)),
        ("moment", theirs.moment), ("deflection", theirs.deflection), ("chip", theirs.chip),
    ):  # fmt: skip
        if name == "chip" and tool.runout > 0.0:
            continue
        assert found[name] == pytest.approx(value[0], rel=0.03), name


def test_what_a_plan_promised_of_its_cut_is_held_and_what_was_changed_is_found():
    plan = limited_slot()
    points, file = plan.plan.trajectory.sample(2e-3), cut_arrays(cut_bytes(plan))
    promise = CutPromise("limits", SLOT.stock, SLOT.tools, {"": {"chip": SLOT.chip}}, {}, {}, 1e-3)
    judge = CutJudge(points, SLOT.toolpath(), promise)
    checks = {check.what: check for check in cut_checks(judge, file, 6, 6)}
    assert all(check.ok for check in checks.values()), list(checks.values())
    assert checks["chip of the cut"].ratio == pytest.approx(1.0, abs=2e-3)

    def failing(by=judge, **arrays):
        return {check.what for check in cut_checks(by, {**file, **arrays}, 6, 6) if not check.ok}

    arcs = "engagement exit"
    assert failing(**{arcs: file[arcs] - 0.3 * (file[arcs] - file["engagement entry"])}) == {"engagement of the cut"}
    assert failing(**{"station most": 0.9 * file["station most"]}) == {"speed by the cut"}
    assert failing(**{"station tip": file["station tip"] + np.array([0.0, 0.0, 1e-3])}) == {"engagement of the cut"}
    faster = CutJudge(dataclasses.replace(points, t=points.t / 1.05), SLOT.toolpath(), promise)
    assert failing(faster) >= {"chip of the cut", "speed by the cut"}
    judge.promise = dataclasses.replace(promise, limits={"": {"chip": 0.97 * SLOT.chip}})
    assert failing() == {"chip of the cut"}


def test_a_stock_that_is_larger_than_planned_is_found():
    plan = limited_slot()
    points, file = plan.plan.trajectory.sample(2e-3), cut_arrays(cut_bytes(plan))
    promise = CutPromise("air", box([0.0, -20e-3, -20e-3], [80e-3, 20e-3, 0.0]), SLOT.tools, {}, {}, {}, 1e-3)
    judge = CutJudge(points, SLOT.toolpath(), promise)
    assert "cut above the feed" in {check.what for check in cut_checks(judge, file, 8, 0) if not check.ok}


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
    promise = promise_of(cut_record(plan, rules, data), toolpath, setup, machine())
    judge = CutJudge(plan.plan.trajectory.sample(2e-3), toolpath, promise)
    in_shoulder = [judge.instant(row) for row in np.flatnonzero(judge.points.block == 9)[[300, 400]]]
    assert all(each.speed > 0.012 and each.loads["chip"] > 0.0 for each in in_shoulder)
    found = learned_check(judge, in_shoulder)
    assert found.ok and found.value > 0.95, found
    chip, area, edge = np.array(promise.teachers["1"]).max(axis=0)
    judge.promise = dataclasses.replace(promise, teachers={"1": [(0.9 * chip, area, edge)]})
    assert not learned_check(judge, in_shoulder).ok
