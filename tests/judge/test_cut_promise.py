"""The promise of a cut: changed in plan.json, on the sheet or in the program, each is found; and what bends is judged.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import msgspec
import numpy as np
import pytest

import toolpace as tp
from testbed import deflection_on_a_wall
from tests.support.limited_plans import SLOT, limited_slot, machine
from toolpace.common.errors import UsageError
from toolpace.cutting.feeds.limited_plan import plan_within_cut
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.forces.engaged_deflection import with_engaged_deflection
from toolpace.cutting.forces.material import Material
from toolpace.cutting.simulation import simulate_cut
from toolpace.cutting.tool_file import tool_of_bytes
from toolpace.judge.cut import Bent, CutJudge, allowed_check, finishing_check, limit_checks, reached_checks, speed_check
from toolpace.judge.cut.stations import columns_check, covered_check, passed_again, passed_stations
from toolpace.judge.cut.stocks import box_stock
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.spindle_figures import SpeedCurve, SpindleFigures
from toolpace.programs.stock_figures import Solid
from toolpace.programs.tolerances import Tolerances
from toolpace.results.write.cut_limits import checked, cut_arrays, cut_bytes, cut_record, input_digests
from toolpace.results.write.cut_promise import NOTHING_STATED, StatedPromise, judged_cut, promise_of, told_checks

ALUMINIUM = Coefficients(800e6, 250e6, 100e6, 15e3, 20e3, 3e3)
SETUP = setup_of_text(SLOT.sheet)


@cache
def planned():
    """Set-points, the arrays of the file, and what plan.json says of a slot whose chips have a limit."""
    plan = limited_slot()
    data = cut_bytes(plan)
    record = cut_record(plan, FeedRules("limits", finishing=True, limits={"": CutLimits(chip=SLOT.chip)}), data, SETUP)
    return plan.plan.trajectory.sample(2e-3), cut_arrays(data), record


def judge_of(record, **changes):
    promise = promise_of(record, SLOT.toolpath(), SETUP, machine())
    return CutJudge(planned()[0], SLOT.toolpath(), dataclasses.replace(promise, **changes))


def changed(**changes):
    return msgspec.structs.replace(planned()[2], **changes)


def findings(checks):
    return [str(check) for check in checks if not check.ok]


def test_a_promise_that_was_not_changed_is_as_sheet_and_program_have_it():
    points, file, record = planned()
    assert not findings(judged_cut(record, file, points, SLOT.toolpath(), SETUP, machine()))
    right = StatedPromise({"": {"chip": SLOT.chip}})
    assert not findings(told_checks(record, SLOT.toolpath(), SETUP, right))


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"limits": {"": {"chip": 1.08 * SLOT.chip}}}, "0.9"),
        ({"limits": {"": {"force": 100.0}}}, "is none that was promised"),
        ({"limits": {}, "feeds": "learned", "teachers": {"1": [(1.0, 1.0, 1.0)]}}, "is none that was promised"),
    ],
)
def test_a_limit_that_was_raised_or_taken_out_is_not_reached(changes, words):
    """Whoever writes the seal anew still has the speeds of the plan."""
    (check,) = reached_checks(judge_of(changed(**changes)), planned()[1])
    assert not check.ok and words in str(check)


@pytest.mark.parametrize("part", [slice(0, 0), slice(0, 30), slice(0, None, 2)])
def test_stations_that_were_taken_out_are_found(part):
    file = dict(planned()[1])
    assert covered_check(judge_of(planned()[2]), file).ok
    arcs = np.split(np.arange(len(file["engagement entry"])), np.cumsum(file["engagement arcs"])[:-1])
    kept = np.concatenate([np.zeros(0, dtype=np.int64), *arcs[part]])
    for name in ("slice", "entry", "exit"):
        file[f"engagement {name}"] = file[f"engagement {name}"][kept]
    for name in [each for each in file if each.startswith(("station ", "engagement "))]:
        if name not in ("engagement slice", "engagement entry", "engagement exit"):
            file[name] = file[name][part]
    points, _, record = planned()
    found = findings(judged_cut(record, checked(file), points, SLOT.toolpath(), SETUP, machine()))
    assert found and all("stations" in each for each in found)


@pytest.mark.parametrize("times", [0.8, 1.3])
def test_another_size_of_the_cells_is_found(times):
    judge = judge_of(planned()[2], resolution=times * 1e-3 * planned()[2].resolution_mm)
    assert not covered_check(judge, planned()[1]).ok


def test_a_limit_that_was_lowered_is_not_held():
    judge = judge_of(changed(limits={"": {"chip": 0.97 * SLOT.chip}}))
    assert findings(limit_checks(judge, judge.instants(1)))


@cache
def held_by_force():
    """The file, were its speeds set by a force; that force [N], and the power at it [W]."""
    file = planned()[1]
    judge = judge_of(planned()[2], coefficients={"": ALUMINIUM})
    stations, rows = passed_stations(judge, file)
    k = len(stations) // 2
    at = judge.instant(int(rows[k]), float(file["station most"][stations[k]]))
    names = np.array([str(each) for each in file["names"]])
    return file, names, at.loads["force"], at.loads["power"]


@pytest.mark.parametrize(
    "name, scale, ok",
    [("force", 1.0, True), ("force", 0.9, False), ("power", 1.0, True), ("power", 0.9, False)],
)
def test_another_material_does_not_reach_the_force_and_the_power_of_the_spindle(name, scale, ok):
    file, names, force, power = held_by_force()
    source = np.where(file["station limit"] == names.tolist().index("chip"), names.tolist().index(name), 0)
    material = Coefficients(*(scale * each for each in dataclasses.astuple(ALUMINIUM)))
    limits = {"limits": {"": {"force": force}}} if name == "force" else {"limits": {}}
    spindle = {"power": [(50.0, 0.5 * power), (100.0, power)]} if name == "power" else {}
    judge = judge_of(changed(**limits), coefficients={"": material}, spindle=spindle)
    (check,) = reached_checks(judge, {**file, "station limit": source})
    assert check.ok is ok, check


def test_the_power_of_the_spindle_is_held_at_its_speed():
    _, _, _, power = held_by_force()
    curve = [(90.0, 0.9 * power), (110.0, 0.98 * power)]
    judge = judge_of(changed(limits={}), coefficients={"": ALUMINIUM}, spindle={"power": curve})
    (check,) = limit_checks(judge, judge.instants(3))
    assert not check.ok and check.what == "power of the cut" and check.limit == pytest.approx(0.94 * power)
    judge = judge_of(changed(limits={}), spindle={"power": curve})
    assert not limit_checks(judge, judge.instants(3)), "without a material no power is known"


@pytest.mark.parametrize("larger", [0.0, 0.4e-3])
@pytest.mark.parametrize("deep, wide, ok", [(2e-3, 5e-3, True), (3e-3, 5e-3, False), (2e-3, 8e-3, False)])
def test_speed_that_is_raised_beside_what_stays_is_found(deep, wide, ok, larger):
    """A slot of 10 mm, 2 mm deep: in a plate as thick and as wide as that nothing stays."""
    plate = box_stock(np.array([0.0, -wide, -deep]), np.array([40e-3, wide, 0.0]), larger)
    judge = judge_of(planned()[2], stock=plate, uncertainty=larger, finishing=False)
    middle = judge.moving[np.abs(judge.tip[judge.moving, 0] - 20e-3) < 12e-3]
    assert finishing_check(judge, middle).ok is ok


def with_tool(**figures):
    tool = SETUP.tools["1"]
    return dataclasses.replace(SETUP, tools={"1": dataclasses.replace(tool, figures=dataclasses.replace(
        tool.figures, **figures))})  # fmt: skip


def other_stock(**figures):
    stock = dataclasses.replace(SETUP.workpiece.stock, **figures)
    return dataclasses.replace(SETUP, workpiece=dataclasses.replace(SETUP.workpiece, stock=stock))


SHEETS = {
    "teeth": (with_tool(teeth=4), "tool 1"),
    "runout": (with_tool(runout=5e-6), "tool 1"),
    "material of the tool": (with_tool(material="HSS"), "tool 1"),
    "uncertainty": (other_stock(uncertainty=1e-3), "uncertainty"),
    "guess": (other_stock(guessed=True), "guess"),
    "box": (other_stock(solid=dataclasses.replace(SETUP.workpiece.stock.solid, origin=(0.0, 0.0, 1e-3))), "stock"),
    "spindle": (dataclasses.replace(SETUP, spindle=SpindleFigures(SpeedCurve((50.0,), (900.0,)))), "spindle"),
}


@pytest.mark.parametrize("name", SHEETS)
def test_another_sheet_than_that_of_the_plan_is_found(name):
    sheet, word = SHEETS[name]
    found = findings(told_checks(planned()[2], SLOT.toolpath(), sheet, NOTHING_STATED))
    assert found and word in " ".join(found)


def test_another_mesh_of_the_stock_is_found_wherever_it_is(tmp_path):
    def digest(name, data, unit="mm"):
        file = tmp_path / name
        file.write_bytes(data)
        solid = Solid(mesh=file, mesh_unit=unit)
        return input_digests(SLOT.toolpath(), other_stock(solid=solid))["stock"]

    first = digest("a.stl", b"solid")
    assert digest("b.stl", b"solid") == first
    assert first not in (digest("a.stl", b"other"), digest("b.stl", b"solid", "inch"))


@pytest.mark.parametrize(
    "changes",
    [{"spindle": {"power": [(50.0, 900.0)]}}, {"inputs": {}}, {"material": "Al7075-T6"}, {"material": "no such"}],
)
def test_another_record_of_the_inputs_is_found(changes):
    assert findings(told_checks(changed(**changes), SLOT.toolpath(), SETUP, NOTHING_STATED))


def test_coefficients_must_be_those_of_the_material_that_is_named():
    own = msgspec.to_builtins(Material.load("Al7075-T6").coefficients)
    right = changed(material="Al7075-T6", materials={"": own})
    assert not findings(told_checks(right, SLOT.toolpath(), SETUP, NOTHING_STATED))
    wrong = changed(material="Al7075-T6", materials={"": {**own, "radial": 1.001 * own["radial"]}})
    assert findings(told_checks(wrong, SLOT.toolpath(), SETUP, NOTHING_STATED))


@pytest.mark.parametrize(
    "stated",
    [
        StatedPromise({"": {"chip": 1.0001 * SLOT.chip}}),
        StatedPromise({"": {"chip": SLOT.chip}, "1": {"force": 100.0}}),
        StatedPromise({"": {"force": 100.0}}),
        StatedPromise(coefficients=ALUMINIUM),
    ],
)
def test_a_promise_that_is_stated_otherwise_is_found(stated):
    assert findings(told_checks(planned()[2], SLOT.toolpath(), SETUP, stated))


def test_what_is_stated_otherwise_is_told_in_units():
    stated = StatedPromise({"1": {"chip": 0.08e-3}})
    told = " ".join(findings(told_checks(planned()[2], SLOT.toolpath(), SETUP, stated)))
    assert "chip is 0.05 mm in the plan, and not limited as it was stated" in told
    assert "chip of tool 1 is not limited in the plan, and 0.08 mm as it was stated" in told


@pytest.mark.parametrize(
    "changes",
    [
        {"feeds": "as fast as can be"},
        {"limits": {"": {"speed": 1.0}}},
        {"limits": {"": {"chip": -1.0}}},
        {"limits": {"": {"chip": float("nan")}}},
        {"materials": {"": {"tangential": 1.0, "sideways": 1.0}}},
        {"spindle": {"power": []}},
        {"spindle": {"speed": [(1.0, 1.0)]}},
        {"resolution_mm": 0.0},
        {"teachers": {"1": [(1e-4, 0.0, 1e-3)]}},
    ],
)
def test_what_is_no_promise_is_refused_in_one_line(changes):
    points, file, _ = planned()
    with pytest.raises(UsageError, match="plan again"):
        judged_cut(changed(**changes), file, points, SLOT.toolpath(), SETUP, machine())


def test_the_cut_of_a_bent_tool_is_that_of_where_it_is_bent_to():
    """A path that is aimed off to the right by 30 micrometres, of a tool that bends back to the left."""
    points, file, record = planned()
    aimed = dataclasses.replace(points, tip=points.tip - np.array([0.0, 30e-6, 0.0]))
    promise = promise_of(record, SLOT.toolpath(), SETUP, machine())
    judge = CutJudge(aimed, SLOT.toolpath(), promise, points.tip, 20e-6)
    # times are those of another motion along the path
    again = passed_again(judge, {**file, "station time": 0.5 * file["station time"]})
    assert columns_check(judge, again).ok and speed_check(judge, again).ok and allowed_check(judge, again, 2).ok
    assert again["station time"] == pytest.approx(file["station time"], abs=0.03)
    assert not columns_check(CutJudge(aimed, SLOT.toolpath(), promise), file).ok


def test_what_is_left_of_a_deflection_that_is_compensated_counts():
    points, _, record = planned()
    promise = dataclasses.replace(
        promise_of(record, SLOT.toolpath(), SETUP, machine()), coefficients={"": ALUMINIUM}
    )
    row = int(judge_of(record).moving[len(judge_of(record).moving) // 2])
    none = CutJudge(points, SLOT.toolpath(), promise, points.tip).instant(row).loads
    assert none["compensated_deflection"] == pytest.approx(none["surface_deflection"]) and none["surface_mean"] != 0.0
    # a slot has a surface on both sides: what is gained on the one is lost on the other
    for side in (1.0, -1.0):
        moved = dataclasses.replace(points, tip=points.tip - side * np.array([0.0, 5e-6, 0.0]))
        found = CutJudge(moved, SLOT.toolpath(), promise, points.tip).instant(row).loads["compensated_deflection"]
        assert found >= none["compensated_deflection"] - 5e-6 - 1e-9
        assert abs(found - none["compensated_deflection"]) == pytest.approx(5e-6, rel=1e-3)


@pytest.mark.thorough
def test_a_wall_that_is_limited_and_compensated_is_within_what_may_be_left():
    """20 micrometres: twice as much, were it not for the compensation."""
    setup = setup_of_text(deflection_on_a_wall.SHEET)
    toolpath = tp.read_text(deflection_on_a_wall.PROGRAM, machine(), controller="linuxcnc", setup=setup)
    limits = {"": CutLimits(surface_deflection=deflection_on_a_wall.ALLOWED).compensated}
    rules = FeedRules(
        "limits", air_feed=0.1, finishing=True, limits=limits, materials={"": deflection_on_a_wall.COEFFICIENTS}
    )
    plan = plan_within_cut(toolpath, machine(), setup, rules, effort="low", resolution=0.2e-3)
    cut = simulate_cut(plan.plan.trajectory, plan.toolpath, setup, resolution=0.2e-3)
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    tool = with_engaged_deflection(
        tool_of_bytes(deflection_on_a_wall.TOOL.encode(), "wall"), cut, plan.toolpath, tools
    )
    points = tp.compensate_bending(plan.toolpath, machine(), tool).trajectory.sample(0.5e-3)
    data = cut_bytes(plan)
    record = cut_record(plan, rules, data, setup)
    bent = Bent(tool, machine(), plan.toolpath, Tolerances(10e-6), Tolerances(1e-3))
    found = judged_cut(record, cut_arrays(data), points, toolpath, setup, machine(), bent=bent)
    assert not findings(found)
    (left,) = [each for each in found if each.what == "compensated deflection of the cut"]
    assert left.ratio == pytest.approx(1.0, abs=0.01)
    promise = promise_of(record, toolpath, setup, machine())
    stiff = CutJudge(points, toolpath, promise)
    row = int(np.flatnonzero((points.block == 6) & (points.tip[:, 0] > 20e-3))[0])
    assert stiff.instant(row).loads["surface_deflection"] > 1.8 * deflection_on_a_wall.ALLOWED
