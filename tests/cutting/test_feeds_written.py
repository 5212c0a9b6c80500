"""Programs written with new feeds: the same path, none faster than planned, in every dialect and mode of feed."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import toolpace as tp
from tests.support.feed_programs import EXTRAS, MODES, SHEET, TWO_SLOTS, feed_program
from tests.support.feed_read_back import check_new_feeds, random_plan
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.controls.export.cut_feeds import rounded_down, with_cut_feeds
from toolpace.cutting.feeds.feed_plan import FeedPlan, plan_feeds
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places, Steps
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.setup_file import setup_of_text

KLARTEXT = (
    "BEGIN PGM A MM\nTOOL CALL 1 Z S6000\nL X-30 Y0 Z20 FMAX M3\nL Z-2 FMAX\nL X-20 F600\nL X90\nL Z20 FMAX\n"
    "END PGM A MM\n"
)


@pytest.mark.parametrize("name, text", [("linuxcnc", TWO_SLOTS), ("heidenhain", KLARTEXT)])
def test_the_feeds_of_a_cut_are_written_and_read_back(name, text):
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(SHEET)
    options = ReadOptions(controller=tp.Controller.load(name), setup=setup)
    toolpath = tp.read_text(text, machine, controller=name, setup=setup)
    plan = tp.plan_program(toolpath, machine, effort="low")
    simulation = tp.simulate_cut(plan.trajectory, toolpath, setup, resolution=1e-3)
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    feeds = plan_feeds(simulation, toolpath, tools, FeedRules(air_feed=0.1, steps=Steps(ratio=1.05)))
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a"), machine, None, options, toolpath, feeds)
    again = written.toolpath
    if name == "heidenhain":
        # its blocks are not divided: the feed of the cut holds in the whole block
        assert (written.changed, written.divided) == (1, 0)
        assert [round(60e3 * each) for each in again.feed[~again.rapid]] == [6000, 600]
        return
    assert written.divided >= 1
    feeding = ~again.rapid
    assert {round(60e3 * each) for each in again.feed[feeding][1:]} >= {600}
    assert again.feed[feeding].max() > 0.09
    assert np.allclose(again.tip[-1], toolpath.tip[-1])


CASES = [(dialect, mode) for dialect, modes in MODES.items() for mode in (*modes, "mixed")]


def read_back(dialect, mode, inch, five, seed):
    """Lines of a random program with another feed, and how many should have one, after all was compared."""
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(SHEET)
    controller = None if dialect == "cldata" else tp.Controller.load(dialect)
    options = ReadOptions(controller=controller, setup=setup)
    text = feed_program(dialect, mode, inch, five, EXTRAS, seed)
    source = Source.from_bytes(text.encode(), "part.apt" if dialect == "cldata" else "part.nc")
    toolpath = read_source(source, machine, None, options)
    plan = random_plan(toolpath, seed)
    written = with_cut_feeds(source, machine, None, options, toolpath, plan)
    return written.changed, check_new_feeds(toolpath, plan, written)


@pytest.mark.parametrize("dialect, mode", CASES)
def test_every_mode_of_feed_reads_back_to_the_same_path_with_the_new_feeds(dialect, mode):
    case = CASES.index((dialect, mode))
    changed, wanted = read_back(dialect, mode, case % 2 == 0, case % 4 < 2, case)
    assert 0.6 * wanted < changed


@pytest.mark.thorough
@pytest.mark.parametrize("dialect, mode", CASES)
def test_every_mode_of_feed_reads_back_in_many_programs(dialect, mode):
    pairs = [read_back(dialect, mode, seed % 2 == 0, seed % 4 < 2, seed) for seed in range(1000, 1016)]
    changed, wanted = (sum(each) for each in zip(*pairs))
    assert 0.7 * wanted < changed


def changed(text, controller, wanted, machine="xyzac-trunnion", times=None):
    """A program with `wanted` feeds by line [m/s], others as they are: the path before, and what is written."""
    machine = tp.Machine.load(machine)
    source = Source.from_bytes(text.encode(), "part.nc")
    options = ReadOptions(controller=tp.Controller.load(controller), setup=setup_of_text(SHEET))
    toolpath = tp.read_text(text, machine, controller=controller, setup=options.setup)
    own = toolpath.most_speed
    feeds = np.array([wanted.get(line, feed) for line, feed in zip(toolpath.block.tolist(), own.tolist())])
    feeds[~np.isfinite(feeds)] = 0.0
    at = Places(np.arange(len(toolpath), dtype=float), np.cumsum(toolpath.way_length))
    plan = FeedPlan((at,), (feeds,), ())
    return toolpath, with_cut_feeds(source, machine, None, options, toolpath, plan, times=times)


IN_TOOL_CALL = "BEGIN PGM A MM\nTOOL CALL 1 Z S6000 F500\nL X-30 Y0 Z20 FMAX M3\nL X-20\nL X90\nEND PGM A MM\n"
IN_SUBPROGRAM = """G21 G90 G54 G17
G0 X0 Y0 Z0
G1 X10 F900
M98 P100
G1 X30
M98 P100
M30
O100
G91 G1 Y5
G1 Y5 F200
G90
M99
"""


@pytest.mark.parametrize(
    "text, controller, wanted",
    [(IN_TOOL_CALL, "heidenhain", {4: 0.1}), (IN_SUBPROGRAM, "fanuc", {5: 0.1}), (IN_SUBPROGRAM, "fanuc", {3: 0.1})],
)
def test_blocks_that_keep_their_text_keep_their_feed(text, controller, wanted):
    before, written = changed(text, controller, wanted)
    old, new = before.most_speed, written.toolpath.most_speed
    other = ~np.isin(before.block, list(wanted))
    assert np.allclose(new[other], old[other])


def test_a_block_behind_a_skip_sign_finds_the_old_feed_in_force():
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X30 F600\n/G1 X60\nG0 Z20\nM30\n"
    before, written = changed(text, "linuxcnc", {3: 0.1})
    assert 4 not in before.block
    assert "G1 X30 F6000\nF600\n/G1 X60\n" in written.data.decode()


def test_pieces_of_a_block_end_where_its_feeds_change_though_increments_led_to_its_beginning():
    text = "G21 G90 G54\nG0 X20 Y0 Z0\nG91 G1 X10 Y0 F600\nG90\nG1 X100\nM30\n"
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions(controller=tp.Controller.load("linuxcnc"))
    toolpath = tp.read_text(text, machine, controller="linuxcnc")
    way, last = np.cumsum(toolpath.way_length), len(toolpath) - 1
    own = np.where(np.isfinite(toolpath.most_speed), toolpath.most_speed, 0.0)
    # air on the first third of the last block
    at = Places(np.append(np.arange(last), [last - 2 / 3, last]), np.append(way[:-1], [0.0, way[-1]]))
    plan = FeedPlan((at,), (np.append(own[:-1], [0.1, 0.01]),), ())
    new = with_cut_feeds(Source.from_bytes(text.encode(), "a.ngc"), machine, None, options, toolpath, plan).toolpath
    border = (2.0 * toolpath.tip[-2] + toolpath.tip[-1]) / 3.0
    beyond = (new.tip - border) @ toolpath.way[-1] > 1e-8
    assert beyond.any() and np.allclose(new.most_speed[beyond], 0.01)


def test_a_block_too_short_for_a_station_keeps_its_feed_or_is_lowered_with_the_next():
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X30 F600\nG1 X30.1 F300\nG1 X30.2 F3000\nG1 X60 F600\nM30\n"
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions(controller=tp.Controller.load("linuxcnc"))
    toolpath = tp.read_text(text, machine, controller="linuxcnc")
    last = len(toolpath) - 1
    at = Places(np.array([last - 4.0, last - 3.0, last]), np.array([0.0, 30e-3, 60e-3]))
    for feed, new in ((0.01, (600, 300, 3000, 600)), (0.05, (600, 300, 3000, 3000)), (0.008, (600, 300, 480, 480))):
        plan = FeedPlan((at,), (np.array([0.01, 0.01, feed]),), ())
        written = with_cut_feeds(Source.from_bytes(text.encode(), "a.ngc"), machine, None, options, toolpath, plan)
        assert [round(60e3 * each) for each in written.toolpath.most_speed[-4:]] == list(new)
        assert (written.data.decode() == text) == (feed == 0.01)


def test_one_feed_of_a_block_whose_tip_changes_its_speed_is_nowhere_above_the_plan():
    text = "G21 G90 G54 G94\nG0 X20 Y0 Z5 A0 C0\nG1 X80 Y30 A40 C90 F500\nM30\n"
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(text, machine, controller="linuxcnc")
    own, block = toolpath.most_speed, toolpath.block == 3
    assert own[block].max() > 1.5 * own[block].min()
    # where the tip is slow it is in air, else the program's feed is the most
    feeds = np.where(block & (own < np.quantile(own[block], 0.9)), 10.0 * own, np.where(np.isfinite(own), own, 0.0))
    plan = FeedPlan((Places(np.arange(len(own)) * 1.0, np.cumsum(toolpath.way_length)),), (feeds,), ())
    options = ReadOptions(controller=tp.Controller.load("linuxcnc"))
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a.ngc"), machine, None, options, toolpath, plan)
    assert (written.toolpath.most_speed[block] <= feeds[block] * (1.0 + 1e-6)).all()


def test_no_feed_is_above_what_the_rotary_joints_can_do():
    # A turns by 150 degrees a second at most, C by 240; on its own F of a rotary word is in degrees
    text = "G21 G90 G94\nG0 X20 Y0 Z5 A0 C0\nG1 A30 F100\nG1 C90 F100\nG1 X80 F100\nM30\n"
    _, written = changed(text, "linuxcnc", {3: 10.0, 4: 10.0, 5: 0.1})
    feeds = [float(each) for each in re.findall(r"F(\d+)", written.data.decode())]
    assert feeds == [9000.0, 14400.0, 6000.0]


def test_a_feed_that_is_lowered_by_little_is_written_and_what_cannot_be_is_told():
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X30 F1000\nG1 X60\nM30\n"
    _, written = changed(text, "linuxcnc", {3: 0.97 / 60.0})
    assert "G1 X30 F970\nF1000" in written.data.decode() and written.above == ()
    text = "G21 G90\nG0 X0 Y0 Z0\n#1=0\nO1 WHILE [#1 LT 2]\nG1 X30 F1000\nG1 X0\n#1=[#1+1]\nO1 ENDWHILE\nM30\n"
    _, written = changed(text, "linuxcnc", {5: 0.01})
    assert (written.data.decode(), written.changed, written.above) == (text, 0, (5,))
    _, written = changed(text, "linuxcnc", {5: 1000.0 / 30e3})
    assert (written.data.decode(), written.above, written.below) == (text, (), (5,))
    # twice 30 mm in 1.8 s, at twice the feed
    assert written.missed == pytest.approx(1.8) and "1.80 s slower" in written.told(3)[0]


def test_a_higher_feed_that_gains_nothing_on_the_control_is_left_out():
    """Its model never goes faster than 20 mm/s: the second block is as fast as that already."""
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X30 F600\nG0 X0\nG1 X30 F1200\nG0 X0\nG1 X30 F1800\nM30\n"

    def times(toolpath):
        return toolpath.way_length / np.minimum(toolpath.most_speed, 0.02)

    _, written = changed(text, "linuxcnc", {3: 0.1, 5: 0.1, 7: 0.015}, times=times)
    assert written.data.decode() == text.replace("F600", "F6000").replace("F1800", "F900")


def test_a_block_that_cannot_be_divided_keeps_its_text():
    """Its pieces would lead elsewhere: its axis turns on a circle, and its rotary words are at no place halfway."""
    text = "G21 G90 G54 G43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X200 A5 C0 F600\nM30\n"
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions(controller=tp.Controller.load("fanuc"))
    toolpath = tp.read_text(text, machine, controller="fanuc")
    last = len(toolpath) - 1
    at = Places(np.array([last - 1.0, last - 0.5, last]), np.array([0.0, 0.1, 0.2]))
    plan = FeedPlan((at,), (np.array([0.01, 0.1, 0.01]),), ())
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a.nc"), machine, None, options, toolpath, plan)
    assert (written.data.decode(), written.changed, written.divided) == (text, 0, 0)


@pytest.mark.parametrize("seed", range(3))
def test_places_of_a_program_are_found_in_the_one_with_divided_blocks(seed):
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions(controller=tp.Controller.load("linuxcnc"))
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X80 F600\nG2 X90 Y10 I0 J10\nG1 A20\nG1 X10\nM30\n"
    toolpath = tp.read_text(text, machine, controller="linuxcnc")
    plan = random_plan(toolpath, seed)
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a.ngc"), machine, None, options, toolpath, plan)
    x = np.sort(np.random.default_rng(seed).uniform(0.0, len(toolpath) - 1.0, 200))
    point, new = written.points_at(toolpath, x), written.toolpath
    k, share = np.floor(x).astype(int), (x % 1.0)[:, None]
    tip = (1.0 - share) * toolpath.tip[k] + share * toolpath.tip[k + 1]
    way = new.tip[point] - new.tip[point - 1]
    length = np.maximum(np.linalg.norm(way, axis=1), 1e-12)
    along = np.einsum("nc,nc->n", tip - new.tip[point - 1], way) / length
    assert (along >= -1e-6).all() and (along <= length + 1e-6).all()
    off = np.linalg.norm(tip - new.tip[point - 1] - (along / length)[:, None] * way, axis=1)
    assert off.max() < 1e-8


def test_blocks_with_one_feed_have_one_word():
    text = "G21 G90\nG0 X0 Y0 Z0\nG1 X30 F1000\nX60\nX90\nG95 X95 F0.1\nG94 X99 F1000\nM30\n"
    _, written = changed("S6000 M3\n" + text, "linuxcnc", {4: 0.01, 5: 0.01, 6: 0.005})
    assert "G1 X30 F600\nX60\nX90 F300\nG95 X95 F0.1\n" in written.data.decode()
    assert written.changed == 3


def test_cutter_location_data_keep_the_unit_of_their_feeds():
    text = (
        "PARTNO/A\nUNITS/INCHES\nLOADTL/1\nSPINDL/6000,RPM,CLW\nRAPID\nGOTO/0,0,1\nFEDRAT/20,IPM\nGOTO/1,0,1\n"
        "GOTO/2,0,1\nFEDRAT/IPR,0.005\nGOTO/3,0,1\nFEDRAT/20,IPM\nGOTO/4,0,1\nFINI\n"
    )
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions()
    toolpath = tp.read_text(text, machine, dialect="apt")
    own = np.where(np.isfinite(toolpath.most_speed), toolpath.most_speed, 0.0)
    feeds = np.where(toolpath.block < 13, 2.0 * own, own)
    plan = FeedPlan((Places(np.arange(len(own)) * 1.0, np.cumsum(toolpath.way_length)),), (feeds,), ())
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a.apt"), machine, "apt", options, toolpath, plan)
    new = written.data.decode()
    assert "FEDRAT/40,IPM\nGOTO/1,0,1\nGOTO/2,0,1\n" in new and "FEDRAT/IPR,0.01\nGOTO/3,0,1\n" in new
    assert np.allclose(written.toolpath.most_speed[1:][~toolpath.rapid[1:]], feeds[1:][~toolpath.rapid[1:]])


@pytest.mark.parametrize("share", [0.5, 0.6180339887])
def test_pieces_have_points_and_digits_that_controls_take(share):
    text = "%\nO1234\nG21 G90 G54\nG0 X-100. Y0. Z5.\nG1 X300. Y40. F600.\nM30\n%\n"
    machine, options = tp.Machine.load("xyzac-trunnion"), ReadOptions(controller=tp.Controller.load("fanuc"))
    toolpath = tp.read_text(text, machine, controller="fanuc")
    last = len(toolpath) - 1
    way = toolpath.way_length[last]
    at = Places(np.array([last - 1.0, last - 1.0 + share, last]), np.array([0.0, share, 1.0]) * way)
    plan = FeedPlan((at,), (np.array([0.01, 0.1, 0.01]),), ())
    written = with_cut_feeds(Source.from_bytes(text.encode(), "a.nc"), machine, None, options, toolpath, plan)
    lines = [line for line in written.data.decode().splitlines() if line.startswith("G1")]
    assert len(lines) == 2 and lines[0].endswith(" F6000.") and lines[1] == "G1 X300. Y40. F600."
    for word in lines[0].split()[1:]:
        assert "." in word and sum(letter.isdigit() for letter in word) <= 8


def test_a_table_of_points_is_refused_in_its_own_words():
    text = "x [mm],y [mm],z [mm],i,j,k,feed [mm/min]\n0,0,0,0,0,1,600\n50,0,0,0,0,1,600\n90,0,0,0,0,1,600\n"
    machine = tp.Machine.load("xyzac-trunnion")
    source = Source.from_bytes(text.encode(), "a.csv")
    with pytest.raises(UsageError, match="feeds: a table of points"):
        toolpath = read_source(source, machine, None, ReadOptions())
        with_cut_feeds(source, machine, None, ReadOptions(), toolpath, FeedPlan((), (), ()))


def test_feeds_are_rounded_down():
    values = (1234.9, 600.0, 599.9999999999, 0.123456, 98765.0)
    assert [rounded_down(each) for each in values] == ["1230", "600", "600", "0.123", "98700"]


def test_the_command_writes_the_program_and_tells_times(tmp_path, capsys):
    program, sheet, new = tmp_path / "part.ngc", tmp_path / "sheet.toml", tmp_path / "new.ngc"
    program.write_text(TWO_SLOTS)
    sheet.write_text(SHEET)
    words = [str(program), "-m", "xyzac-trunnion", "--setup", str(sheet), "--resolution", "1mm", "--effort", "low"]
    assert main(["feeds", *words, "--air-feed", "6000mm/min", "--out", str(new), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"controller", "before_s", "after_s", "operations", "blocks_changed", "largest"} <= set(found)
    assert found["after_s"] < 0.8 * found["before_s"]
    assert found["largest"]["1"]["chip_mm"]["after"] <= found["largest"]["1"]["chip_mm"]["before"] * (1.0 + 1e-9)
    assert "F600" in new.read_text() and new.read_text() != TWO_SLOTS
    assert main(["feeds", *words, "--out", str(program)]) == 2
    assert main(["feeds", *words, "--out", str(sheet)]) == 2
    assert main(["feeds", *words, "--out", str(tmp_path / "none" / "new.ngc")]) == 2
    assert (program.read_text(), sheet.read_text()) == (TWO_SLOTS, SHEET)
    twice = ["--feeds", "limits", "--limit", "chip=0.1mm", "--limit", "chip=0.2mm"]
    assert main(["feeds", *words, *twice]) == 2
    assert main(["feeds", *words, "--limit", "chip=0.1mm"]) == 2
    assert main(["feeds", *words, "--feeds", "limits", "--limit", "chips=0.1mm"]) == 2
    assert "did you mean 'chip'" in capsys.readouterr().err
