"""Plans side by side, from their folders alone."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from toolpace.cli import demo_programs, main
from toolpace.results.compare import MotionAlong, compared, later, thinned


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    """One program at two tolerances, and the first without set-points."""
    folder = tmp_path_factory.mktemp("compare")
    (folder / "part.ngc").write_text(demo_programs.spiral_program(120))
    words = ["plan", str(folder / "part.ngc"), "-m", "xyzac-trunnion", "--no-report", "-o"]
    assert main([*words, str(folder / "wide"), "--tip-tolerance", "20um"]) == 0
    assert main([*words, str(folder / "tight"), "--tip-tolerance", "1um"]) == 0
    assert main([*words, str(folder / "bare"), "--npz", "none"]) == 0
    return folder


def test_times_add_up_by_operation_and_by_limit(plans):
    found = compared([plans / "wide", plans / "tight"])
    assert found.names == ("wide", "tight") and not found.programs_differ
    assert found.durations[1] > found.durations[0]
    for k, time in enumerate(found.durations):
        assert sum(row[1][k] for row in found.operations) == pytest.approx(time, rel=1e-9)
        assert sum(row[1][k] for row in found.limits) == pytest.approx(time, rel=1e-6)
        said = json.loads((found.folders[k] / "plan.json").read_text())["limited_by"]
        assert {name: times[k] for name, times in found.limits}["feed"] == pytest.approx(said["feed"] * time)


def test_the_terminal_and_the_page(plans, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["compare", *(str(plans / name) for name in ("wide", "tight", "bare")), "--page", str(page)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"tight .*\+\d+\.\d+ %.* verified", output) and "tool 1" in output and "jerk of C" in output
    text = page.read_text()
    data = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text).group(1))
    assert [plan["name"] for plan in data] == ["wide", "tight", "bare"]
    assert "Content-Security-Policy" in text and "no set-points of a tool: bare" in text
    assert set(data[0]) == {"name", "colour", "speed"} and "speed" not in data[2]
    way, speed = data[0]["speed"]
    assert way == sorted(way) and max(speed) == pytest.approx(2500.0, rel=2e-3)
    found = compared([plans / "wide", plans / "tight"])
    assert data[1]["later"][1][-1] == pytest.approx(found.durations[1] - found.durations[0], abs=2e-3)
    assert main(["compare", str(plans / "wide"), str(plans / "tight"), "--page", str(page)]) == 2
    assert "is there already" in capsys.readouterr().err


def test_how_much_later_is_that_of_times_at_equal_shares_of_the_way():
    t = np.linspace(0.0, 10.0, 1001)
    even = MotionAlong(t * 0.1, np.full(1001, 0.1), t)
    waited = np.concatenate((np.arange(500), np.full(200, 499), np.arange(500, 1001)))
    paused = MotionAlong(even.way[waited], even.speed[waited], np.arange(len(waited)) * 0.01)
    way, behind = later(paused, even)
    assert behind[way < 0.49] == pytest.approx(0.0, abs=0.011)
    assert behind[way > 0.51] == pytest.approx(2.0, abs=0.011)
    assert later(MotionAlong(2.0 * even.way, even.speed, even.t), even) is None


def test_thinning_keeps_the_slowest_and_the_fastest():
    n = 100_000
    speed = np.ones(n)
    speed[12_345], speed[77_777] = 5.0, 0.1
    way, kept = thinned(MotionAlong(np.linspace(0.0, 1.0, n), speed, np.linspace(0.0, 1.0, n)))
    assert len(kept) <= 6000 and kept.max() == 5.0 and kept.min() == 0.1 and (np.diff(way) >= 0.0).all()


@pytest.mark.parametrize("names, message", [(["wide"], "1 plans: give 2 to 8"), (["wide", "nowhere"], "no such file")])
def test_what_is_no_plan_is_refused(plans, names, message, capsys):
    assert main(["compare", *(str(plans / name) for name in names)]) == 2
    assert message in capsys.readouterr().err


def test_plans_of_one_name_are_told_apart(plans, tmp_path):
    for place in ("first", "second"):
        (tmp_path / place).mkdir()
        (tmp_path / place / "part-plan").symlink_to(plans / "wide")
    folders = [tmp_path / place / "part-plan" for place in ("first", "second")]
    assert len(set(compared(folders).names)) == 2
