"""Slips of programs that a control would not notice, or would tell of elsewhere: each is named, with its cure."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import heidenhain, sinumerik
from tests.support.controllers import read_for
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

START = "G90 G21 G94 G17 F600\nG0 X0. Y0. Z10.\n"
WORD_ADDRESS = ("fanuc", "haas", "linuxcnc", "iso", "mazak", "millplus")


@pytest.mark.parametrize("controller", WORD_ADDRESS)
@pytest.mark.parametrize(
    ("word", "right"), [("X10,5", "X10.5"), ("X-10,5", "X-10.5"), ("X,5", "X.5"), ("R=1,25", "=1.25")]
)
def test_a_decimal_comma_is_named(controller, word, right):
    with pytest.raises(ProgramError, match=f"has a decimal comma: write {right}"):
        read_for(controller, START + f"G1 {word} Y2.\nM30")


def test_a_comma_that_is_of_the_language_is_none():
    """,R5 rounds the corner, and Klartext may write either."""
    assert len(read_for("fanuc", START + "G1 X10.,R2. F500\nY10.\nM30")) > 3
    assert heidenhain.read("L X+10,5 F300").tip[-1, 0] == pytest.approx(0.0105)


def test_a_decimal_comma_of_sinumerik_is_named():
    with pytest.raises(ProgramError, match=r"numbers have a decimal point, like X10\.5"):
        sinumerik.read("G1 X10,5 Y2")


@pytest.mark.parametrize("controller", WORD_ADDRESS)
def test_forgotten_units_are_said(controller):
    body = "G90 G94 G17\nG0 X0. Y0. Z10.\nG1 X1. F600\nM30"
    assert any("does not say its unit of lengths (G20, G21)" in said for said in read_for(controller, body).assumed)


def test_forgotten_units_of_sinumerik_are_said():
    said = "does not say its unit of lengths (G70, G71, G700, G710)"
    begin = "G54 G64 G90 F1000\nG0 X0 Y0 Z0\n"
    assert any(said in sentence for sentence in sinumerik.read("G1 X10", start=begin).assumed)
    for unit in ("G70", "G71", "G700", "G710"):
        assert not any(said in sentence for sentence in sinumerik.read("G1 X10", start=f"{unit}\n{begin}").assumed)


@pytest.mark.parametrize(
    ("before", "said"),
    [
        ("T1 M6\nG43.4", "G43.4 without H: the length is that of tool 1"),
        ("T1 M6\nG43 H2\nG43.4", "G43.4 without H: the length is that of H2 before"),
        ("G43.4", "G43.4 without H: the length is that of the machine's own tool, since no T or H names one"),
    ],
)
def test_a_length_without_h_is_said(before, said):
    body = f"G90 G21 G94 G17 F600\nG54\n{before}\nG0 X0. Y0. Z10.\nG1 X1.\nM30"
    head = Machine.load("xyzbc-head")
    assert said in read_for("fanuc", body, head).assumed
    assert not any("without H" in each for each in read_for("fanuc", body.replace("G43.4", "G43.4 H1"), head).assumed)


SECONDS = {"3": 2000.0, "19": 100 / 19 * 60}


@pytest.mark.parametrize(("feed", "doubted"), [("3", True), ("19", True), ("20", False), ("600", False)])
def test_a_feed_in_metres_is_doubted(feed, doubted):
    """100 mm at 3 mm/min are 33 min 20 s; a hundred at 19 mm/min are more than five minutes too."""
    path = read_text(f"G90 G21 G94 G17 F{feed}\nG0 X0 Y0 Z0\nG1 X100\nM2\n", None, controller="linuxcnc", name="a.ngc")
    found = [said for said in path.assumed if "is F in metres" in said]
    assert bool(found) == doubted
    if doubted:
        assert f"feeds of {feed} mm/min" in found[0] and "first line 3" in found[0]
        assert np.sum(path.way_length[1:] / path.feed[1:]) == pytest.approx(SECONDS[feed])
    if feed == "3":
        assert "33 min 20" in found[0]


def test_a_short_way_at_a_low_feed_is_not_doubted():
    text = "G90 G21 G94 G17 F3\nG0 X0 Y0 Z0\nG1 X10\nM2\n"
    assumed = read_text(text, None, controller="linuxcnc", name="a.ngc").assumed
    assert not any("is F in metres" in said for said in assumed)


def test_the_length_of_tools_without_a_sheet_is_said():
    """In tool-centre-point mode and with a length that counts: Fanuc, Sinumerik, Heidenhain, and tables of points."""
    head = Machine.load("xyzbc-head")
    said = f"each is as long as the machine's own, {head.tool_length * 1e3:g} mm"
    body = "G90 G21 G94 G17 F600\nG54\nT1 M6\nG43{} H1\nG0 X0. Y0. Z10.\nG1 X1.\nM30"
    sheet = SetUp(tools={"1": Tool(0.1)})
    for mode in ("", ".4"):
        assert said in " ".join(read_for("fanuc", body.format(mode), head).assumed)
        assert said not in " ".join(read_for("fanuc", body.format(mode), head, setup=sheet).assumed)
    assert said in " ".join(sinumerik.read("TRAORI\nG1 X10", "xyzbc-head").assumed)
    assert said in " ".join(heidenhain.read("L X+1 FMAX\nL M128\nL X+3 F300", head).assumed)
    table = "x [mm],y [mm],z [mm],feed [mm/min]\n0,0,0,600\n1,0,0,600\n"
    assert said in " ".join(read_text(table, head, dialect="csv", name="a.csv").assumed)
    assert said not in " ".join(read_text(table, None, dialect="csv", name="a.csv").assumed)
    assert said not in " ".join(read_for("fanuc", START + "G1 X1.\nM30", head).assumed)


def test_the_preset_without_a_sheet_is_said():
    said = "the origin of the part stands for every work offset (preset)"
    assert said in " ".join(heidenhain.read("L X+3 F300").assumed)
    assert said in " ".join(sinumerik.read("G1 X3").assumed)
    sheet = SetUp(offsets={"1": {"X": 0.1}})
    assert said not in " ".join(heidenhain.read("L X+3 F300", setup=sheet).assumed)
