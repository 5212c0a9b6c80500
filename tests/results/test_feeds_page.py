"""The page of new feeds: feed and loads before and after, beside formulas of a slot."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.support.report_pages import Arrays, calculated, embedded
from tests.support.set_up_sheets import milling_sheet
from toolpace.cli import main

PROGRAM = """(<b>slot</b>)
G21 G90 G94
T1 M6
S6000 M3
G0 X-20 Y10 Z2
G1 Z-3 F1200
G1 X50 F1200
G0 Z30
M30
"""
SHEET = milling_sheet([(0, 0, -10), (30, 20, 0)], 8, 12, 30)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The page and its data; the chip is limited to half of what the program takes."""
    place = tmp_path_factory.mktemp("feeds")
    (place / "slot.ngc").write_text(PROGRAM)
    (place / "sheet.toml").write_text(SHEET)
    words = ["feeds", str(place / "slot.ngc"), "-m", "xyzac-trunnion", "--setup", str(place / "sheet.toml")]
    words += ["--effort", "low", "--resolution", "0.5mm", "--feeds", "limits", "--limit", "chip=0.03333mm"]
    words += ["--air-feed", "3000mm/min", "--finishing", "-o", str(place / "new.ngc"), "--report"]
    assert main([*words, str(place / "feeds.html")]) == 0
    text = (place / "feeds.html").read_text(encoding="utf-8")
    return text, embedded(text), (place / "new.ngc").read_text()


def test_before_and_after_are_those_of_the_slot(made):
    _, data, program = made
    arrays = Arrays(data)
    rows = {(each["panel"], each["role"]): arrays.numbers(each["data"]) for each in data["tracks"]}
    feed = rows["program_feed", "before"]
    assert feed.max() == pytest.approx(1200.0, rel=1e-3)
    after = rows["program_feed", "after"]
    in_cut = rows["chip", "before"] > 60.0
    assert in_cut.sum() > 20
    # a chip of F / (n z) in a full slot, of 0.0333 mm in place of 0.0667
    assert np.median(rows["chip", "before"][in_cut]) == pytest.approx(1200.0 / 6000.0 / 3.0 * 1e3, rel=0.01)
    assert rows["chip", "after"].max() <= 33.33 * 1.001
    assert np.nanmax(rows["chip", "limit"]) == pytest.approx(33.33, rel=1e-3)
    assert np.median(rows["removal", "before"][in_cut]) == pytest.approx(8 * 3 * 1200e-3, rel=0.05)
    halved = np.median(after[in_cut])
    assert 0.9 * 600.0 < halved <= 600.0
    assert after.max() == pytest.approx(3000.0, rel=1e-3)
    written = [float(each) for each in re.findall(r"F([\d.]+)", program)]
    assert min(written) == pytest.approx(halved, rel=0.01)
    assert np.isnan(rows["chip", "limit"]).any()


def test_the_path_is_coloured_by_load_before_and_after(made):
    text, data, _ = made
    assert [each["name"] for each in data["loads"]] == ["Chip before", "Chip after"]
    shares = calculated(
        text,
        """const out = {}, t = 0.5 * player.duration;
        for (const { name } of player.loads) {
            player.colouring = name;
            out[name] = player.loadShare(player.load(), t);
        }
        player.colouring = "speed";
        return [out, player.load()];""",
    )
    assert shares[0]["Chip before"] == pytest.approx(1.0, abs=0.02)
    assert shares[0]["Chip after"] == pytest.approx(0.48, abs=0.03)
    assert shares[1] is None


def test_the_page_tells_times_by_operation_and_names_are_text(made):
    text, *_ = made
    body = text[: text.index('<script id="data"')]
    assert "<b>slot</b>" not in body and "more time" in body
    assert body.count("<td>") >= 4 and "thickest chip" in body


def test_a_report_that_cannot_be_written_is_refused_before_the_work(tmp_path, capsys):
    (tmp_path / "p.ngc").write_text(PROGRAM)
    for name, word in (("x.txt", "it is a page"), ("no/x.html", "folder does not exist")):
        words = ["feeds", str(tmp_path / "p.ngc"), "-m", "xyzac-trunnion", "--report", str(tmp_path / name)]
        assert main(words) == 2
        error = capsys.readouterr().err.strip()
        assert word in error and "\n" not in error


def test_chips_after_are_those_at_the_spindle_speed_after(tmp_path):
    (tmp_path / "slot.ngc").write_text(PROGRAM)
    sheet = milling_sheet([(0, 0, -10), (30, 20, 0)], 8, 12, 30, spindle_range=[6000, 12000])
    (tmp_path / "sheet.toml").write_text(sheet)
    words = ["feeds", str(tmp_path / "slot.ngc"), "-m", "xyzac-trunnion", "--setup", str(tmp_path / "sheet.toml")]
    words += ["--effort", "low", "--resolution", "1mm", "--finishing", "--spindle", "range", "--report"]
    assert main([*words, str(tmp_path / "feeds.html")]) == 0
    text = (tmp_path / "feeds.html").read_text(encoding="utf-8")
    data = embedded(text)
    rows = {(each["panel"], each["role"]): Arrays(data).numbers(each["data"]) for each in data["tracks"]}
    in_cut = rows["chip", "before"] > 60.0
    feeds, chips = (
        [np.median(rows[panel, role][in_cut]) for role in ("before", "after")] for panel in ("program_feed", "chip")
    )
    assert feeds[1] == pytest.approx(2.0 * feeds[0], rel=0.01) and chips[1] == pytest.approx(chips[0], rel=0.01)
    assert "6000 rpm, 12000 rpm after: spindle_range" in text
