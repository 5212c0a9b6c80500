"""Spindle speeds by what is cut: as fast as range, cutting speed and spindle allow, with the same chip."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
import pytest

import toolpace as tp
from tests.support.feed_programs import TWO_SLOTS
from tests.support.set_up_sheets import milling_sheet
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.controls.export.spindle_words import SpindleWords
from toolpace.cutting.feeds.feed_moves import FeedMoves
from toolpace.cutting.feeds.feed_plan import plan_feeds
from toolpace.cutting.feeds.largest_loads import largest_loads
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.spindle_speeds import spindle_speeds
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.reading import ReadOptions, Source
from toolpace.programs.reading.setup_file import load_setup, setup_of_text, setup_text
from toolpace.programs.spindle_figures import SpeedCurve, SpindleFigures

BOX = [(0, -20, -20), (60, 20, 0)]
FIGURES = {"spindle_range": [4000, 12000]}
ALUMINIUM = Coefficients(800e6, 250e6, 100e6, 15e3, 20e3, 3e3)
CURVES = "[spindle]\npower = [[1000, 2], [10000, 8]]\ntorque = [[1000, 40], [20000, 5]]\n"


@cache
def cut_slots(sheet):
    """The motion of two slots, what it cuts, and the figures of its tools."""
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(sheet)
    toolpath = tp.read_text(TWO_SLOTS, machine, controller="linuxcnc", setup=setup)
    trajectory = tp.plan_program(toolpath, machine, effort="low").trajectory
    simulation = tp.simulate_cut(trajectory, toolpath, setup, resolution=1e-3)
    return toolpath, simulation, [setup.figures_of(each.tool) for each in toolpath.operations]


def chosen(rules, kind="flat", **figures):
    """The speed of the operation that mills both slots, and what was cut."""
    sheet = milling_sheet(BOX, 10, 20, 40, **FIGURES, **figures).replace('"flat"', f'"{kind}"')
    toolpath, simulation, tools = cut_slots(sheet)
    speeds = spindle_speeds(simulation, toolpath, tools, rules, [range(len(toolpath.operations))])
    return next(each for each in speeds if not math.isnan(each.before)), (simulation, toolpath, tools)


def largest_at(ratio, simulation, toolpath, tools, rules):
    """The largest loads as the program is written, and at new feeds with other spindle speeds."""
    ratios = [ratio] * len(toolpath.operations)
    plan = plan_feeds(simulation, toolpath, tools, rules, ratio=ratios)
    old = FeedMoves.of(simulation, toolpath, tools, rules, None)
    new = FeedMoves.of(simulation, toolpath, tools, rules, None, ratios)
    return largest_loads(old, new, old.before, plan.feeds)


def test_a_sheet_with_speeds_and_charts_reads_as_it_was_written():
    figures = FIGURES | {"cutting_speed": 250, "stability": "[[4000, 1.5], [9000, 3]]"}
    setup = setup_of_text(milling_sheet(BOX, 10, 20, 40, **figures) + CURVES)
    tool = setup.figures_of("1")
    assert tool.spindle_range == (4000.0 / 60.0, 200.0) and tool.cutting_speed == pytest.approx(250.0 / 60.0)
    assert tool.stability.at(6500.0 / 60.0) == pytest.approx(2.25e-3)
    assert setup.spindle.power.at(5500.0 / 60.0) == pytest.approx(5000.0)
    again = setup_of_text(setup_text(setup))
    assert again.figures_of("1") == tool and again.spindle == setup.spindle


@pytest.mark.parametrize(
    "line, message",
    [
        ("spindle_range = [12000, 4000]", "give the least speed first"),
        ("spindle_range = 4000", "two speeds"),
        ("cutting_speed = 0", "cutting_speed"),
        ("stability = [[4000, 1], [4000, 2]]", "must ascend"),
        ('stability = "nowhere.csv"', "cannot be read"),
    ],
)
def test_figures_that_make_no_sense(line, message):
    with pytest.raises(UsageError, match=message):
        setup_of_text(milling_sheet(BOX, 10, 20, 40) + line + "\n")


def test_a_stability_chart_is_read_from_a_file(tmp_path):
    (tmp_path / "chart.csv").write_text("rpm;mm\n4000; 1.5\n9000; 3\n")
    sheet = tmp_path / "setup.toml"
    sheet.write_text(milling_sheet(BOX, 10, 20, 40) + 'stability = "chart.csv"\n')
    found = load_setup(sheet).figures_of("1").stability
    assert found.speed == pytest.approx((4000.0 / 60.0, 150.0)) and found.value == pytest.approx((1.5e-3, 3e-3))
    assert math.isnan(found.least(60.0, 100.0))
    (tmp_path / "chart.csv").write_text("4000 1.5 2\n")
    with pytest.raises(UsageError, match=r"line 1 of chart\.csv"):
        load_setup(sheet)


def test_the_speed_is_the_most_of_its_range_and_feeds_keep_their_chip():
    rules = FeedRules("air", air_feed=0.1, finishing=True)
    speed, (simulation, toolpath, tools) = chosen(rules)
    assert 60.0 * speed.after == pytest.approx(12000.0) and speed.reason == "spindle_range"
    found = largest_at(speed.ratio, simulation, toolpath, tools, rules)
    before, after = ({each.kind: getattr(each, when) for each in found} for when in ("before", "after"))
    assert after["chip"] == pytest.approx(before["chip"])
    assert after["removal_rate"] == pytest.approx(2.0 * before["removal_rate"])


def test_a_surface_that_stays_keeps_its_speed():
    speed, _ = chosen(FeedRules("air", air_feed=0.1))
    assert speed.ratio == 1.0 and "--finishing" in speed.reason


def test_the_cutting_speed_holds_at_the_diameter_of_the_cut():
    speed, _ = chosen(FeedRules("air", air_feed=0.1, finishing=True), cutting_speed=250)
    assert speed.diameter == pytest.approx(10e-3)
    assert 60.0 * speed.after == pytest.approx(250e3 / (math.pi * 10.0), abs=10.0)
    ball, _ = chosen(FeedRules("air", air_feed=0.1, finishing=True), cutting_speed=250, kind="ball")
    # 2 mm deep, told to a slice
    assert 8e-3 <= ball.diameter <= 9.3e-3
    assert math.pi * ball.diameter * ball.after <= 250.0 / 60.0 < math.pi * ball.diameter * (ball.after + 0.2)


@pytest.mark.sweep
def test_what_the_spindle_does_not_give_is_not_asked_of_it():
    """Power grows with the speed: where its chip is free, fewer turns with thicker chips remove more."""
    limits, materials = {"": CutLimits(chip=0.2e-3)}, {"": ALUMINIUM}
    free, _ = chosen(FeedRules("limits", air_feed=0.2, finishing=True, limits=limits, materials=materials))
    assert 60.0 * free.after == pytest.approx(12000.0)
    weak = SpindleFigures(power=SpeedCurve((10.0, 300.0), (300.0, 300.0)))
    rules = FeedRules("limits", air_feed=0.2, finishing=True, limits=limits, materials=materials, spindle=weak)
    slow, (simulation, toolpath, tools) = chosen(rules)
    assert slow.after < 0.7 * slow.before
    found = largest_at(slow.ratio, simulation, toolpath, tools, rules)
    assert max(each.after for each in found if each.kind == "power") <= 300.0 * (1.0 + 1e-6)


def test_a_cut_above_its_stability_chart_is_told_and_not_chosen():
    rules = FeedRules("air", air_feed=0.1, finishing=True)
    deep, _ = chosen(rules, stability="[[3000, 5], [8000, 5], [11000, 0.5], [12000, 0.5]]")
    # cells of 1 mm tell the entry into the stock to half a cell
    assert deep.depth == pytest.approx(2e-3, abs=0.5e-3)
    assert deep.ratio == 1.0 and not deep.chatters and deep.stable_depth == pytest.approx(5e-3)
    shallow, _ = chosen(rules, stability="[[3000, 0.5], [12000, 0.5]]")
    assert shallow.chatters and shallow.line > 0


PROGRAMS = {
    "linuxcnc": ("G21 G90 G54\nT1 M6\n(S99) S6000 M3\nG0 X0 Y0 Z5\nG1 X9 F600\nT2 M6\nS8000 M3\nG1 X1\nM30\n", 2),
    "sinumerik": ("T1 M6\nS6000 M3 ;S12\nG0 X0 Y0 Z5\nG1 X9 F600\nT2 M6\nS1=8000 M1=3 S2=60\nG1 X1\nM30\n", 2),
    "heidenhain": (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S6000\nL X0 Y0 Z5 FMAX M3\nL X9 F600\nTOOL CALL 2 Z S8000\nL X1 F600 M3\n"
        "END PGM A MM\n", 2,
    ),
    "": (
        "PARTNO/PART\nUNITS/MM\nLOADTL/1\nSPINDL/6000,RPM,CLW\nRAPID\nGOTO/0,0,5\nFEDRAT/600,MMPM\nGOTO/9,0,5\n"
        "LOADTL/2\nSPINDL/8000,RPM,CLW\nGOTO/1,0,5\nFINI\n", 2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PROGRAMS)
def test_s_words_are_those_that_govern_an_operation_and_read_back(name):
    text, count = PROGRAMS[name]
    machine = tp.Machine.load("xyzac-trunnion")
    options = ReadOptions(controller=tp.Controller.load(name) if name else None)
    source = Source.from_bytes(text.encode(), "part.nc" if name else "part.apt")
    toolpath = tp.read_text(text, machine, controller=name or None, dialect=None if name else "apt")
    words = SpindleWords.of(source, machine, None, options, toolpath)
    groups = words.together()
    assert len(groups) == count
    ratio = np.ones(len(toolpath.operations))
    ratio[groups[1]] = 1.5
    new, again = words.with_ratios(ratio.tolist())
    turned = again.spindle[1:] / toolpath.spindle[1:]
    fed = ~toolpath.rapid[1:]
    assert turned[fed] == pytest.approx(ratio[toolpath.operation[1:]][fed])
    changed = [b for a, b in zip(text.splitlines(), new.data.decode().splitlines()) if a != b]
    assert len(changed) == 1 and "12000" in changed[0]


def test_a_computed_speed_and_a_cycle_keep_theirs():
    text = "#5=7000\nG21 G90 G54\nT1 M6\nS#5 M3\nG0 X0 Y0 Z5\nG1 X9 F600\nT2 M6\nS8000 M3\nG81 X5 Y5 Z-2 R3 F200\nM2\n"
    machine = tp.Machine.load("xyzac-trunnion")
    options = ReadOptions(controller=tp.Controller.load("linuxcnc"))
    toolpath = tp.read_text(text, machine, controller="linuxcnc")
    words = SpindleWords.of(Source.from_bytes(text.encode(), "a.ngc"), machine, None, options, toolpath)
    assert words.together() == []


def test_the_command_writes_speeds_and_feeds(tmp_path, capsys):
    sheet, program, out = tmp_path / "setup.toml", tmp_path / "slots.ngc", tmp_path / "new.ngc"
    sheet.write_text(milling_sheet(BOX, 10, 20, 40, **FIGURES, stability="[[3000, 0.5], [9000, 5], [20000, 5]]"))
    program.write_text(TWO_SLOTS)
    words = ["feeds", str(program), "-m", "xyzac-trunnion", "--setup", str(sheet), "--controller", "linuxcnc"]
    words += ["--effort", "low", "--resolution", "1mm", "--spindle", "range", "--finishing", "--air-feed", "3000mm/min"]
    assert main([*words, "--out", str(out)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "6000 rpm 12000 rpm 10 mm 377 m/min" in shown and "may chatter" not in shown
    text = out.read_text()
    assert "S12000 M3" in text and "F1200" in text
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["spindle"][-1]["after_rpm"] == pytest.approx(12000.0)
    assert told["after_s"] < 0.7 * told["before_s"]
    assert main([each if each != "range" else "fast" for each in words]) == 2
    assert "--spindle fast is not known" in capsys.readouterr().err
