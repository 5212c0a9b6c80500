"""The simulation of a cut on a stock of points: times, sums, and what is wrong."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.point_stock import PointStock
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.simulate import CutSimulation, Surroundings, ToolInUse, cut_stations
from toolpace.cutting.simulation.stock_range import StockRange
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import Frustum, ToolFigures
from toolpace.programs.toolpath import Operation

MM = 1e-3
HOLDER = (Frustum(20 * MM, 30 * MM, 30 * MM),)
FLAT = ToolFigures("flat", 6 * MM, flute_length=10 * MM, teeth=2, stick_out=20 * MM, holder=HOLDER)
CELL = 0.5 * MM
LOW, HIGH = np.array([0.0, 0.0, -12.0]) * MM, np.array([20.0, 10.0, 0.0]) * MM


def box(off: float = 0.0) -> PointStock:
    return PointStock.box(LOW - off, HIGH + off, CELL)


def guess() -> StockRange:
    one = box()
    return StockRange(one, one, one, guessed=True)


def way(points: list[Any], rapid: list[bool], speed: float = 10 * MM, operation: int = 0) -> Stations:
    """Stations a cell apart along straight ways [mm]; block k + 1 leads to point k."""
    corners = np.array(points, dtype=float) * MM
    tip, block, fast = [corners[:1]], [0], [False]
    for k in range(1, len(corners)):
        count = max(int(np.ceil(np.linalg.norm(corners[k] - corners[k - 1]) / CELL)), 1)
        share = np.arange(1, count + 1)[:, None] / count
        tip.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        block += [k + 1] * count
        fast += [rapid[k]] * count
    tips = np.concatenate(tip)
    time = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tips, axis=0), axis=1))]) / speed
    block[0], fast[0] = block[1], fast[1]
    return Stations(
        tips, np.tile([0.0, 0.0, 1.0], (len(tips), 1)), time, np.array(block), np.full(len(tips), operation),
        np.array(fast), np.array(block) - 1,
    )  # fmt: skip


def cut(
    *parts: Stations, tool: ToolFigures = FLAT, stock: StockRange | None = None, around: Surroundings | None = None,
    **more: Any,
) -> CutSimulation:
    one = box()
    names = [Operation(f"operation {k}", "1") for k in range(1 + max(int(part.operation[-1]) for part in parts))]
    return cut_stations(
        parts, names, [ToolInUse(tool, ToolProfile.of(tool))] * len(names), stock or StockRange(one, one, one),
        around or Surroundings(), resolution=CELL, **more,
    )  # fmt: skip


SLOT = way([[-10, 5, 5], [-10, 5, -2], [30, 5, -2], [30, 5, 5]], [True, True, False, True])


def test_a_slot_has_its_times_its_volume_and_its_size():
    (each,) = cut(SLOT).operations
    assert each.feed_time == pytest.approx(4.0)
    assert each.rapid == pytest.approx(1.4)
    # the tool is in material from where its edge reaches the stock to where its axis leaves it
    assert each.cutting == pytest.approx(2.3, abs=0.11)
    assert each.air == pytest.approx(1.7, abs=0.11)
    assert each.uncertain == 0.0
    assert each.removed == pytest.approx(20 * 6 * 2 * MM**3, rel=0.02)
    assert each.width == pytest.approx(6 * MM, abs=CELL) and each.depth == pytest.approx(2 * MM, abs=CELL)
    assert each.mean_rate == pytest.approx(each.removed / each.cutting)
    assert 1.0 < each.peak_rate / (10 * 6 * 2 * MM**3) < 1.2


def test_what_is_removed_and_what_is_left_are_the_stock():
    found = cut(SLOT)
    assert found.removed_volume + found.left_volume == pytest.approx(found.stock_volume)
    assert found.stock_volume == pytest.approx(20 * 10 * 12 * MM**3)


def test_a_cut_that_depends_on_where_the_stock_ends_is_neither_air_nor_cutting():
    """Half a millimetre above the stock as it is told: the largest stock may be touched, the smallest is not."""
    stock = StockRange(box(-MM), box(), box(MM), MM)
    skim = way([[-10, 5, 0.6], [30, 5, 0.6]], [False, False])
    (each,) = cut(skim, stock=stock).operations
    assert each.cutting == 0.0 and each.removed == 0.0
    assert each.uncertain == pytest.approx(2.5, abs=0.11)
    assert each.removed_range[0] == 0.0 < each.removed_range[1]


def test_stock_left_by_one_program_is_the_stock_of_the_next():
    first = cut(SLOT)
    again = cut(SLOT, stock=first.left)
    assert again.stock_volume == first.left_volume
    assert again.removed_volume == 0.0
    assert [each.kind for each in again.findings] == ["air"]


def test_a_feed_move_that_cuts_nothing_is_found():
    found = cut(way([[-10, 5, 5], [30, 5, 5], [30, 5, 8], [30, 20, 8]], [False] * 4))
    (air,) = found.findings
    assert (air.kind, air.line, air.last_line, air.seconds) == ("air", 2, 4, pytest.approx(5.8))
    assert not found.collisions


def test_a_block_that_rapids_part_cuts_where_one_of_its_parts_does():
    """The first peck of a drilling cycle may end above the stock."""
    pecks = [[10, 5, 4], [10, 5, 2], [10, 5, 4], [10, 5, 2], [10, 5, -2], [10, 5, 4]]
    rapid = [True, False, True, True, False, True]
    peck = way(pecks, rapid)
    cycle = replace(peck, block=np.full(len(peck), 7))
    assert [each.line for each in cut(peck).findings] == [2]
    assert not cut(cycle).findings
    above = replace(cycle, tip=cycle.tip + np.array([0.0, 0.0, 5 * MM]))
    assert [(each.kind, each.line) for each in cut(above).findings] == [("air", 7)]


def test_a_rapid_through_material_is_found_with_its_depth_and_place():
    found = cut(way([[-10, 5, 5], [-10, 5, -1.5], [30, 5, -1.5], [30, 5, 5]], [True] * 4))
    (hit,) = found.findings
    assert (hit.kind, hit.line, hit.body, hit.certain) == ("rapid", 3, "stock", True)
    assert hit.depth == pytest.approx(1.5 * MM, abs=CELL)
    assert 0.0 < hit.place[0] < 20 * MM and hit.place[2] == pytest.approx(-1.5 * MM)


def test_what_a_rapid_takes_is_no_removal_rate_width_or_depth_of_a_cut():
    crash = way([[-10, 5, -2], [30, 5, -2], [30, 5, 20]], [False, True, True])
    (each,) = cut(crash).operations
    assert each.removed == pytest.approx(20 * 6 * 2 * MM**3, rel=0.02)
    assert each.mean_rate == each.peak_rate == each.width == each.depth == 0.0


def test_a_rapid_does_not_meet_what_the_rapid_before_has_gone_through():
    back_and_forth = way([[-10, 5, -1], [30, 5, -1], [-10, 5, -1]], [True] * 3)
    assert [each.line for each in cut(back_and_forth).findings] == [2]


def test_a_rapid_in_the_stock_that_may_be_there_is_told_as_such():
    stock = StockRange(box(-MM), box(), box(MM), MM)
    (hit,) = cut(way([[-10, 5, 0.2], [30, 5, 0.2]], [True] * 2), stock=stock).findings
    assert (hit.kind, hit.certain) == ("rapid", False)
    assert hit.depth == pytest.approx(0.8 * MM, abs=CELL)


def test_a_rapid_over_the_stock_meets_nothing():
    assert not cut(way([[-10, 5, 0.1], [30, 5, 0.1]], [True] * 2)).findings


def test_a_wide_holder_in_a_wall_is_found():
    """The tool stands out 20 mm; the stock beside the slot is higher than that."""
    short = ToolFigures("flat", 6 * MM, flute_length=6 * MM, teeth=2, stick_out=8 * MM, holder=HOLDER)
    found = cut(way([[-4, 5, -10], [10, 5, -10]], [False] * 2), tool=short)
    kinds = {each.kind: each for each in found.findings}
    assert kinds["holder"].line == 2 and kinds["holder"].depth == pytest.approx(2 * MM, abs=CELL)
    assert "flute" in kinds and "shank" not in kinds


def test_a_shank_that_is_wider_than_the_edge_is_found_as_a_shank():
    wide = ToolFigures("flat", 4 * MM, flute_length=3 * MM, teeth=2, stick_out=20 * MM, shank_diameter=8 * MM)
    found = cut(way([[-20, 5, -5], [30, 5, -5]], [False] * 2), tool=wide)
    assert {each.kind for each in found.findings} == {"shank"}
    assert found.findings[0].depth == pytest.approx(2 * MM, abs=CELL)
    assert found.removed_volume + found.left_volume == pytest.approx(found.stock_volume)


def test_a_collision_is_told_once_not_at_each_later_pass():
    wide = ToolFigures("flat", 4 * MM, flute_length=3 * MM, teeth=2, stick_out=20 * MM, shank_diameter=8 * MM)
    there = way([[-20, 5, -5], [30, 5, -5]], [False] * 2)
    back = way([[30, 5, -5], [-20, 5, -5]], [False] * 2, operation=1)
    found = cut(there, back, tool=wide)
    assert [(each.kind, each.operation) for each in found.findings] == [
        ("shank", "operation 0"), ("air", "operation 1"),
    ]  # fmt: skip


def test_a_gouge_below_the_finished_part_is_found_where_it_is_deeper_than_the_tolerance():
    part = PointStock.box(LOW, HIGH - [0.0, 0.0, 3 * MM], CELL)
    around = Surroundings(part, 0.3 * MM)
    dip = way([[-10, 5, -2], [5, 5, -2.9], [10, 5, -4.5], [15, 5, -3.1], [30, 5, -2]], [False] * 5)
    found = cut(dip, around=around)
    assert {(each.kind, each.line, each.body) for each in found.findings} == {
        ("gouge", 3, "finished part"), ("gouge", 4, "finished part"),
    }  # fmt: skip
    assert found.findings[0].depth == pytest.approx(1.5 * MM, abs=CELL)


def test_a_fixture_is_not_cut_and_whatever_meets_it_is_named():
    clamp = PointStock.box([22 * MM, 0.0, -12 * MM], [26 * MM, 10 * MM, 2 * MM], CELL)
    before = clamp.volume()
    over = cut(
        way([[-10, 5, -2], [30, 5, -2]], [False] * 2), around=Surroundings(fixtures={"clamp": clamp}), stock=guess()
    )
    (hit,) = over.findings
    assert (hit.kind, hit.body) == ("gouge", "fixture clamp")
    fast = cut(way([[24, 5, 20], [24, 5, 0]], [True] * 2), around=Surroundings(fixtures={"clamp": clamp}))
    assert [(each.kind, each.body) for each in fast.findings] == [("rapid", "fixture clamp")]
    assert clamp.volume() == before


def test_nothing_is_concluded_from_a_guessed_stock():
    through = way([[-10, 5, -1.5], [30, 5, -1.5], [30, 20, 5], [-10, 20, 5]], [True, True, False, False])
    found = cut(through, stock=guess())
    assert found.guessed and not found.findings and found.removed_volume > 0.0


def test_findings_stand_worst_first():
    deep = way([[-10, 5, 5], [-10, 5, -1], [30, 5, -1], [30, 5, 9], [-10, 5, 9], [-10, 5, -4], [30, 5, -4]],
               [True, True, True, True, False, True, True])  # fmt: skip
    found = cut(deep).findings
    assert [each.kind for each in found] == ["rapid", "rapid", "air"]
    assert found[0].depth > found[1].depth > 0.0 and found[0].line == 7


def test_an_operation_without_a_tool_is_passed_over():
    idle = way([[-10, 5, 5], [30, 5, 5]], [True] * 2)
    work = way([[30, 5, 5], [-10, 5, -1]], [False] * 2, operation=1)
    one = box()
    tools = [None, ToolInUse(FLAT, ToolProfile.of(FLAT))]
    ended: list[int] = []
    found = cut_stations(
        [idle, work], [Operation(), Operation("work")], tools, StockRange(one, one, one), Surroundings(),
        resolution=CELL, after_operation=lambda k, stock: ended.append(k),
    )  # fmt: skip
    assert [each.name for each in found.operations] == ["work"]
    assert ended == [0]
