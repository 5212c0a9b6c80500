"""Plans side by side, from their folders alone: figures, places, and the page that plays them."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from tests.support.report_pages import Arrays, embedded, opened
from toolpace.cli import demo_programs, main
from toolpace.motion.trajectory import Trajectory
from toolpace.results.compare.motions import PlannedMotion, same_places
from toolpace.results.compare.page import comparison_page
from toolpace.results.compare.plans import compared
from toolpace.results.report.passages import Passages


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    """One program at two tolerances, the first without set-points, and with half the feed and a hostile name."""
    folder = tmp_path_factory.mktemp("compare")
    text = demo_programs.spiral_program(120)
    (folder / "part.ngc").write_text(text)
    words = ["plan", str(folder / "part.ngc"), "-m", "xyzac-trunnion", "--no-report", "--effort", "low", "-o"]
    assert main([*words, str(folder / "wide"), "--tip-tolerance", "20um"]) == 0
    assert main([*words, str(folder / "tight"), "--tip-tolerance", "1um"]) == 0
    assert main([*words, str(folder / "bare"), "--npz", "none"]) == 0
    lines = text.splitlines()
    changed = "\n".join([*lines[:2], "(</script><b>slow</b>)", *lines[2:]]).replace("F2500", "F1250")
    (folder / "slow.ngc").write_text(changed)
    (folder / "corner.ngc").write_text("G21 G90 G94\nG1 X0 Y0 Z50 A0 C0 F2000\nX9\nY9 C20\nM30\n")
    assert main(["plan", str(folder / "corner.ngc"), *words[2:], str(folder / "corner")]) == 0
    slow = ["plan", str(folder / "slow.ngc"), *words[2:]]
    assert main([*slow, str(folder / "<b>slow")]) == 0
    return folder


@pytest.fixture(scope="module")
def page(plans):
    """That of the two tolerances."""
    target = plans / "page.html"
    target.write_text(comparison_page(compared([plans / "wide", plans / "tight"])), encoding="utf-8")
    return target


def loaded(plans, name):
    found = compared([plans / name, plans / "wide"])
    return PlannedMotion.load(found.folders[0], found.records[0])


@pytest.mark.sweep
def test_times_add_up_by_operation_and_by_limit(plans):
    found = compared([plans / "wide", plans / "tight"])
    assert found.names == ("wide", "tight") and not found.programs_differ
    assert found.durations[1] > found.durations[0]
    for k, time in enumerate(found.durations):
        assert sum(row[1][k] for row in found.operations) == pytest.approx(time, rel=1e-9)
        assert sum(row[1][k] for row in found.limits) == pytest.approx(time, rel=1e-6)
        said = json.loads((found.folders[k] / "plan.json").read_text())["limited_by"]
        assert {name: times[k] for name, times in found.limits}["feed"] == pytest.approx(said["feed"] * time)


def test_prices_stand_side_by_side_where_a_plan_has_them(plans):
    found = compared([plans / "wide", plans / "tight"])
    assert "1 % more" not in comparison_page(found)
    priced = msgspec.structs.replace(found.records[1], prices_s={"jerk C": 0.02})
    shown = comparison_page(dataclasses.replace(found, records=(found.records[0], priced)))
    assert re.search(r"1 % more of a limit.*Jerk of C</td><td class=n>-?</td><td class=n>20 ms<", shown, re.DOTALL)


def test_the_terminal_and_the_page(plans, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["compare", *(str(plans / name) for name in ("wide", "tight", "bare")), "--page", str(page)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"tight .*\+\d+\.\d+ %.* verified", output) and "tool 1" in output and "jerk of C" in output
    text = page.read_text(encoding="utf-8")
    data = embedded(text)
    arrays, (wide, tight) = Arrays(data), data["plans"]
    assert (wide["name"], tight["name"]) == ("wide", "tight")
    assert "Content-Security-Policy" in text and "no set-points of a tool: bare" in text
    assert arrays.numbers(wide["channels"][0]["data"]).max() == pytest.approx(2500.0, rel=2e-3)
    assert arrays.numbers(tight["places"])[-1] == pytest.approx(tight["duration"], abs=1e-4)
    # the text that both have stands there once
    assert wide["program"] and tight["program"] is None and tight["text_of"] == 0
    way = arrays.numbers(data["way"])
    length = compared([plans / "wide", plans / "tight"]).records[0].path_length_mm
    assert (np.diff(way) >= 0.0).all() and way[-1] == pytest.approx(length, abs=1e-3)
    assert main(["compare", str(plans / "wide"), str(plans / "tight"), "--page", str(page)]) == 2
    assert "is there already" in capsys.readouterr().err


@pytest.mark.parametrize("names, apart", [(("wide", "tight"), 21e-6), (("wide", "<b>slow"), 30e-6)])
def test_at_the_times_of_the_same_places_both_tips_are_there(plans, names, apart):
    """Within the tolerances of both, also where the lines of the programs are other ones."""
    first, other = (loaded(plans, name) for name in names)
    t = np.sort(np.random.default_rng(3).uniform(0.0, first.duration, 2000))
    found = same_places(first, other, t)
    off = first.trajectory.tip(t)[0] - other.trajectory.tip(found)[0]
    assert np.linalg.norm(off, axis=1).max() < apart
    assert (np.diff(found) >= 0.0).all()


def motion(t, way, passed=None):
    """One along a line."""
    none = np.zeros(1, dtype=np.int64)
    passed = passed or Passages(np.zeros(1), none, none, none)
    return PlannedMotion(SimpleNamespace(duration=t[-1]), SimpleNamespace(t=t), None, None, passed, way)


def test_a_pause_is_lost_where_it_is():
    t = np.linspace(0.0, 10.0, 1001)
    even = motion(t, 0.1 * t)
    paused = motion(np.array([0.0, 5.0, 7.0, 12.0]), np.array([0.0, 0.5, 0.5, 1.0]))
    found = same_places(even, paused, t)
    assert found[t < 4.99] - t[t < 4.99] == pytest.approx(0.0, abs=1e-9)
    assert found[t > 5.01] - t[t > 5.01] == pytest.approx(2.0, abs=1e-9)
    assert same_places(even, motion(t, 0.2 * t), t) is None


def test_while_the_tip_stands_lines_are_matched_by_time():
    """A rotary joint turns for 4 s in the first and 2 s in the other, between two ways."""
    lines, way = (np.array([1, 2, 3]), *np.zeros((2, 3), dtype=np.int64)), np.array([0.0, 1.0, 1.0, 2.0])
    times = np.array([[0.0, 1.0, 5.0, 6.0], [0.0, 2.0, 4.0, 5.0]])
    first, other = (motion(t, way, Passages(t[:3], *lines)) for t in times)
    assert same_places(first, other, np.array([0.5, 2.0, 3.0, 5.5])) == pytest.approx([1.0, 2.5, 3.0, 4.5])


def test_mean_feeds_are_way_over_time(plans):
    """Of the operation's moves at feed, counted by set-points."""
    found = loaded(plans, "wide")
    [(key, feed)] = found.feeds().items()
    points = found.setpoints
    at_feed = ~np.isin(points.block[1:], found.toolpath.block[found.toolpath.rapid])
    expected = points.tip_steps[at_feed].sum() / np.diff(points.t)[at_feed].sum()
    assert key == ("", "1", 1) and feed == pytest.approx(expected, rel=2e-3)


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


@pytest.mark.sweep
@pytest.mark.browser
def test_both_tools_run_and_every_place_leads_to_both(plans, page):
    wide, tight = (Trajectory.load(plans / name, exact=True) for name in ("wide", "tight"))
    with opened(page) as found:
        for t in (0.0, 0.3 * wide.duration, wide.duration, tight.duration):
            state = found.run(f"(toolpace.seek({t!r}), toolpace.state())")
            for said, trajectory in zip(state["plans"], (wide, tight)):
                at = min(t, trajectory.duration)
                scale = np.where(trajectory.axis_path.machine.is_rotary, 180.0 / math.pi, 1e3)
                np.testing.assert_allclose(said["q"], trajectory.at(at).q * scale, atol=1e-2)
                np.testing.assert_allclose(said["tip"], trajectory.tip(at)[0] * 1e3, atol=1e-2)
        assert state["plans"][1]["gained"] == pytest.approx(wide.duration - tight.duration, abs=1e-3)
        # a place of the path: the first is there
        box = found.page.locator("#timeline").bounding_box()
        middle = {"x": 52 + 0.5 * (box["width"] - 62), "y": 60}
        found.page.locator("#timeline .cursors").click(position=middle)
        points = wide.sample(1e-3)
        way = np.concatenate(([0.0], np.cumsum(points.tip_steps)))
        there = found.run("toolpace.state().t")
        assert np.interp(there, points.t, way) == pytest.approx(0.5 * way[-1], rel=2e-3)
        # over time the middle is that of the longer one
        found.page.locator('[data-axis="time"]').click()
        found.page.locator("#timeline .cursors").click(position=middle)
        assert found.run("toolpace.state().t") == pytest.approx(0.5 * tight.duration, rel=2e-3)
        # a line of the program, and the block that differs most
        line = found.run(f"(toolpace.seek({0.4 * wide.duration!r}), toolpace.state().plans[0].line)") + 2
        found.page.locator(f"#listing .row:has(.number:text-is('{line}'))").click()
        first, other = found.run("toolpace.state().plans")
        lit = found.page.locator("#listing .row.lit .number")
        assert int(lit.inner_text()) == first["line"] == line
        assert other["line"] < line
        assert int(found.page.locator("#listing .row.pale .number").inner_text()) == other["line"]
        found.page.locator('[data-tab="blocks"]').click()
        leading = found.page.locator('[data-panel="blocks"] button').first
        leading.click()
        assert f"line {found.run('toolpace.state().plans[0].line')}" == leading.inner_text()
        assert found.problems == []
        assert [url for url in found.requests if not url.startswith(("file:", "data:", "blob:"))] == []
    assert page.stat().st_size < 1.2e6


@pytest.mark.browser
@pytest.mark.sweep
def test_it_is_played_by_keys_and_names_are_text(plans, tmp_path):
    """And a plan of another path runs beside, and gains nothing."""
    page, apart = tmp_path / "page.html", tmp_path / "apart.html"
    apart.write_text(comparison_page(compared([plans / "wide", plans / "corner"])), encoding="utf-8")
    page.write_text(comparison_page(compared([plans / "wide", plans / "<b>slow", plans / "tight"])), encoding="utf-8")
    with opened(page, width=700, scheme="dark") as found:
        press = found.page.keyboard.press
        press("ArrowRight")
        assert found.run("toolpace.state().t") > 0.0
        press("End")
        state = found.run("toolpace.state()")
        assert state["t"] == pytest.approx(max(plan["t"] for plan in state["plans"]))
        press("Home")
        # so slow that a busy computer does not come to the end
        for _ in range(3):
            press("-")
        press("Space")
        found.wait("toolpace.state().t > 0.05")
        press("Space")
        assert found.run("toolpace.state().playing") is False
        press("Home")
        press("p")
        assert found.page.locator('[data-axis="time"]').get_attribute("aria-pressed") == "true"
        # the other program, with its own lines
        found.page.locator('[data-tab="other-program"]').click()
        assert found.page.locator("#other-listing .row", has_text="</script><b>slow</b>").count() == 1
        found.page.locator("#ghosts").click()
        # the third plan instead: of one program
        found.page.locator("#plans button", has_text="tight").click()
        assert found.page.locator('[data-tab="other-program"]').is_hidden()
        assert found.page.locator("main b:has-text('slow')").count() == 0
        assert found.run("document.documentElement.scrollWidth") <= 701
        assert found.problems == []
        found.page.goto(apart.as_uri())
        found.wait("window.toolpaceReady")
        state = found.run("(toolpace.seek(0.2), toolpace.state())")
        assert state["plans"][1]["gained"] is None and state["plans"][1]["t"] == 0.2
        assert found.page.locator("#ghosts").is_visible() and found.page.locator("[data-axis]").first.is_hidden()
        assert found.page.locator('[data-tab="blocks"]').is_hidden() and found.problems == []
