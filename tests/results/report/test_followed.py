"""The page of a followed run: figures, what was not measured, and what a browser makes of it."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from tests.support.report_pages import embedded, opened
from toolpace.deflection.following import SetPoint, Status
from toolpace.results.report import follow_report
from toolpace.results.report.shell import THEME_BUTTON, framed

ERROR = "<b>bent</b></script>"
COUNT = 2001


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A run of two seconds along X with an error that grows to 20 µm, and is not measured at the end."""
    machine = tp.Machine.load("xyzac-trunnion")
    points, t = [], np.linspace(0.0, 2.0, COUNT)
    for k in range(COUNT):
        q, speed, none = np.zeros(5), np.zeros(5), np.zeros(5)
        q[0], speed[0] = 0.02 * t[k], 0.02
        points.append(SetPoint(t[k], q, speed, none, none, t[k], t[k], 1.0, np.zeros((4, 5)), Status(0)))
    error = np.zeros((COUNT, 3))
    error[:, 1] = 1e-5 * t
    error[-10:] = np.nan
    file = tmp_path_factory.mktemp("followed") / "run.html"
    follow_report(file, points, machine, {ERROR: error}, "<i>run</i>")
    return file


def test_curves_are_those_of_the_run(page):
    text = page.read_text(encoding="utf-8")
    data = embedded(text)
    curve = data["errors"][ERROR]
    assert curve[1000] == pytest.approx(10.0) and curve[-1] is None
    speed = float(tp.Machine.load("xyzac-trunnion").limits.velocity[0])
    assert data["used"]["velocity"][0][5] == pytest.approx(100.0 * 0.02 / speed, rel=1e-4)
    assert "<i>run</i>" not in text and len(text) < 600_000


@pytest.mark.browser
@pytest.mark.sweep
def test_it_plays_and_names_are_text(page, tmp_path):
    """And its colours are changed by a button, as are those of a page without any script of its own."""
    plain = tmp_path / "plain.html"
    plain.write_text(framed("plain", THEME_BUTTON), encoding="utf-8")
    colours = "getComputedStyle(document.documentElement).colorScheme"
    with opened(page, width=700, scheme="dark") as found:
        state = found.run("(toolpace.seek(1), toolpace.state())")
        assert state["t"] == 1.0 and state["errors"][ERROR] == pytest.approx(10.0) and state["pace"] == 1.0
        found.page.keyboard.press("Home")
        found.page.keyboard.press("Space")
        found.wait("toolpace.state().t > 0.05")
        found.run("toolpace.pause()")
        assert found.page.locator("main b:has-text('bent')").count() == 0
        assert found.page.locator("#names").inner_text().strip() == ERROR
        assert found.run("document.documentElement.scrollWidth") <= 701
        for address in (page, plain):
            found.page.goto(address.as_uri())
            assert found.run(colours) == "dark"
            found.page.locator('[data-do="theme"]').click()
            assert found.run(colours) == "light"
        assert found.problems == []
        assert [url for url in found.requests if not url.startswith(("file:", "data:"))] == []
