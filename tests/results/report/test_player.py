"""The report in a browser: the tool is where the motion says, everything leads everywhere, nothing is asked for."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import toolpace as tp
from tests.support.report_pages import Arrays, embedded, opened
from toolpace.results.report import write_report
from toolpace.results.report.keyframes import keyframes
from toolpace.results.report.passages import FEED, RAPID, WAITING, passages

PROGRAM = """(<b>corner</b> & "tilt")
G21 G90 G54
G43.4 H1
G0 X0 Y0 Z40 A0 C0
G1 Z5 F2000
X30 F1200
X30 Y20 A15 C30
G4 P0.5
X0 Y20 A0 C0
G0 Z40
T2 M6
G43.4 H2
G1 X10 F3000
M30
"""


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A program, its motion, and its report."""
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(PROGRAM, machine)
    plan = tp.plan_program(toolpath, machine, effort="low")
    page = tmp_path_factory.mktemp("player") / "report.html"
    write_report(page, plan.trajectory, plan.trajectory.sample(1e-3), toolpath, program=PROGRAM.encode())
    return SimpleNamespace(machine=machine, toolpath=toolpath, trajectory=plan.trajectory, page=page)


def test_keyframes_show_the_motion(planned):
    found = keyframes(planned.trajectory)
    assert found.t[0] == 0.0 and found.t[-1] == planned.trajectory.duration
    t = np.random.default_rng(2).uniform(0.0, found.t[-1], 3000)
    k = np.clip(np.searchsorted(found.t, t, side="right") - 1, 0, len(found.t) - 2)
    h = (found.t[k + 1] - found.t[k])[:, None]
    u = (t - found.t[k])[:, None] / h
    shown = (
        (1 + 2 * u) * (1 - u) ** 2 * found.q[k] + u * (1 - u) ** 2 * h * found.qd[k]
        + u * u * (3 - 2 * u) * found.q[k + 1] + u * u * (u - 1) * h * found.qd[k + 1]
    )  # fmt: skip
    assert np.abs(shown - planned.trajectory.at(t).q).max() < 3e-6


def test_few_keyframes_are_coarser_and_no_more_than_asked_for(planned):
    few = keyframes(planned.trajectory, most=60)
    assert len(few.t) <= 60 and few.tolerance > keyframes(planned.trajectory).tolerance


def test_lines_are_passed_when_the_motion_is_there(planned):
    found = passages(planned.trajectory, planned.trajectory.sample(1e-3), planned.toolpath)
    assert set(found.kind) == {FEED, RAPID, WAITING}
    assert (np.diff(found.t) > 0.0).all() and found.t[0] == 0.0
    points = planned.trajectory.sample(1e-3)
    line = found.line[np.clip(np.searchsorted(found.t, points.t, side="right") - 1, 0, None)]
    # at a border one set-point may be on either side
    assert (line != points.block).sum() <= len(found.t)


def test_the_page_holds_program_and_motion(planned):
    data = embedded(planned.page.read_text(encoding="utf-8"))
    arrays = Arrays(data)
    assert arrays.text(data["program"]).split("\n")[5] == "X30 F1200"
    assert arrays.numbers(data["keyframes"]["t"])[-1] == pytest.approx(planned.trajectory.duration, abs=1e-5)
    assert [each["tool"] for each in data["operations"]][-1] == "2"
    assert planned.page.stat().st_size < 1e6


@pytest.mark.browser
def test_the_tool_is_where_the_motion_says_and_everything_leads_there(planned):
    duration = planned.trajectory.duration
    with opened(planned.page) as page:
        for t in np.linspace(0.0, duration, 23).tolist():
            state = page.run(f"(toolpace.seek({t!r}), toolpace.state())")
            motion = planned.trajectory.at(t)
            tip, axis = planned.trajectory.tip(t)
            scale = np.where(planned.machine.is_rotary, 180.0 / math.pi, 1e3)
            np.testing.assert_allclose(state["q"], motion.q * scale, atol=5e-3)
            np.testing.assert_allclose(state["tip"], tip * 1e3, atol=5e-3)
            np.testing.assert_allclose(state["axis"], axis, atol=1e-4)
        # a line of the program, and the one that is lit
        page.page.locator("#listing .row", has_text="X30 F1200").click()
        assert page.run("toolpace.state().line") == 6
        assert page.page.locator("#listing .row.lit").inner_text().startswith("6")
        # the way of the tip: what is clicked on is where the tool goes
        target = page.run(f"(toolpace.seek({0.4 * duration!r}), toolpace.state())")
        place = page.run(f"toolpace.onScreen({target['tip']!r})")
        page.run("toolpace.seek(0)")
        page.page.locator("#space canvas").click(position={"x": place[0], "y": place[1]})
        reached = page.run("toolpace.state()")
        assert np.linalg.norm(np.subtract(page.run(f"toolpace.onScreen({reached['tip']!r})")[:2], place[:2])) < 2.0
        # the time line
        box = page.page.locator("#timeline").bounding_box()
        page.page.locator("#timeline .cursors").click(position={"x": 52 + 0.5 * (box["width"] - 62), "y": 90})
        assert page.run("toolpace.state().t") == pytest.approx(0.5 * duration, rel=0.01)
        # the lists
        page.page.locator("[data-tab=blocks]").click()
        page.page.locator('[data-panel="blocks"] button').first.click()
        assert page.run("toolpace.state().line") in (5, 6, 7, 9)
        # hostile words are text
        assert page.page.locator("#listing b").count() == 0
        assert page.problems == []
        assert [url for url in page.requests if not url.startswith(("file:", "data:", "blob:"))] == []


@pytest.mark.browser
@pytest.mark.sweep
def test_it_plays_and_is_played_by_keys(planned):
    with opened(planned.page, width=700, scheme="dark") as page:
        page.run("toolpace.play()")
        page.wait("toolpace.state().t > 0.05")
        page.run("toolpace.pause()")
        assert 0.05 < page.run("toolpace.state().t") <= planned.trajectory.duration
        press = page.page.keyboard.press
        press("Home")
        assert page.run("toolpace.state().t") == 0.0
        first = page.run("toolpace.state().line")
        press("ArrowRight")
        assert page.run("toolpace.state().line") > first
        press("ArrowLeft")
        assert page.run("toolpace.state().line") == first
        press("End")
        assert page.run("toolpace.state().t") == planned.trajectory.duration
        press("Space")
        assert page.run("toolpace.state().playing") is True
        press("Space")
        assert page.run("toolpace.state().playing") is False
        # the clock takes a time or a line, and says what is neither
        at = page.page.locator("#at")
        for words, line, t in (("0.25", None, 0.25), ("line 6", 6, None), ("0:00.5", None, 0.5)):
            press("g")
            at.fill(words)
            press("Enter")
            assert line in (None, page.run("toolpace.state().line"))
            assert t in (None, page.run("toolpace.state().t"))
        for words in ("line 2000", "1:02:03", "soon"):
            press("g")
            at.fill(words)
            press("Enter")
            assert at.get_attribute("class") == "bad" and page.run("toolpace.state().t") == 0.5
            press("Escape")
        assert at.input_value() == "0.500 s" and at.get_attribute("class") == ""
        # the view in space has keys of its own, and what is folded opens by space
        page.page.locator("#space canvas").focus()
        before, t = page.run("toolpace.onScreen([0, 0, 0])"), page.run("toolpace.state().t")
        press("ArrowUp")
        page.page.wait_for_timeout(50)
        assert page.run("toolpace.onScreen([0, 0, 0])") != before and page.run("toolpace.state().t") == t
        page.page.locator("summary").last.press("Space")
        assert page.page.locator("details[open]").count() == 1 and page.run("toolpace.state().playing") is False
        # paper is light, and the page is dark again behind it
        page.run("dispatchEvent(new Event('beforeprint'))")
        assert page.run("getComputedStyle(document.documentElement).colorScheme") == "light"
        page.run("dispatchEvent(new Event('afterprint'))")
        assert page.run("getComputedStyle(document.documentElement).colorScheme") == "dark"
        assert page.run("document.documentElement.scrollWidth") <= 701
        assert page.problems == []
