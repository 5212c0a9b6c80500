"""The report: true figures, every peak kept, no network, no errors in a browser."""

from __future__ import annotations

import base64
import json
import math
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support import motions
from tests.support.tool_paths import toolpath_through
from toolpace.judge import verify
from toolpace.machine.limits import Limits
from toolpace.motion import sampling
from toolpace.results.report import charts, report
from toolpace.results.report.charts import (
    NOTHING,
    Channel,
    Curves,
    FeedCaps,
    binding,
    deviations,
    extremes,
    limit_names,
    packed,
)
from toolpace.results.report.shell import checksum
from toolpace.results.report.words import at_most, colours, limit_words, percent

TRAJECTORY = motions.Trajectory()
PROGRAM = motions.program()


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    report(TRAJECTORY, path, PROGRAM, verify(TRAJECTORY, motions.machine(), PROGRAM))
    return path


def embedded(text):
    return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text)[1])


def test_is_one_file_that_asks_for_nothing(html):
    text = html.read_text(encoding="utf-8")
    own = text[: text.index("<script>")] + text[text.rindex("<script>") :]
    assert "plotly.js v" in text
    assert not re.search(r'(src|href)\s*=\s*"(?!data:)', own)
    assert "http" not in own.replace("http-equiv", "")
    assert html.stat().st_size < 7e6


def test_says_what_a_machinist_asks(html):
    text = html.read_text(encoding="utf-8")
    gap = "slower than the best possible on this path and mesh"
    for words in ("test", "xyzac-trunnion", "verified", "2.61 s", gap, "Programmed feed", "Jerk of A"):
        assert words in text, words
    assert "70.0 %" in text


def test_says_where_the_gap_lies(html):
    text = html.read_text(encoding="utf-8")
    assert "slower than the best possible: where" in text
    assert "<td>500 ms to 700 ms</td><td>3</td><td>100 ms</td>" in text
    assert "slower than any possible motion on this path" in text


def test_curves_are_the_set_points(html):
    data = embedded(html.read_text(encoding="utf-8"))
    points = TRAJECTORY.sample()
    names = [(c["panel"], c["name"]) for c in data["channels"]]
    assert names[0] == ("feed", "tip speed")
    assert len(names) == 2 + 15
    jerk = next(c for c in data["channels"] if (c["panel"], c["name"]) == ("jerk", "A"))
    values = np.frombuffer(base64.b64decode(jerk["data"]), dtype="<i2") * jerk["scale"]
    np.testing.assert_allclose(values, points.qddd[:, 3] / TRAJECTORY.limits.jerk[3], atol=1e-4)
    assert jerk["unit"] == "°/s³"
    assert jerk["peak"] == pytest.approx(np.degrees(TRAJECTORY.limits.jerk[3]))


def test_a_name_cannot_break_the_page(tmp_path):
    evil = replace(PROGRAM, source='</script><script>alert("x")</script>')
    report(TRAJECTORY, tmp_path / "r.html", evil)
    assert "<script>alert" not in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_thinning_keeps_every_peak():
    values = np.zeros(1_000_000)
    values[123_457], values[876_543] = 1.0, -2.0
    small = extremes(values)
    assert len(small) <= 40_000
    assert (small.max(), small.min()) == (1.0, -2.0)
    ramp = extremes(np.arange(500_000.0))
    assert (np.diff(ramp) > 0.0).all()


def test_a_million_set_points_stay_light():
    values = np.random.default_rng(1).normal(size=1_000_000)
    assert len(packed(Channel("X", "jerk", 0, values))["data"]) < 140_000


def test_feed_cap_knows_least_times():
    least = PROGRAM.least_time.copy()
    least[30] = 0.02
    timed = replace(PROGRAM, least_time=least, feed=np.full(len(PROGRAM), np.inf))
    points = TRAJECTORY.sample()
    cap = FeedCaps(timed).at(points.block)
    assert np.isinf(cap[points.block != 40]).all()
    np.testing.assert_allclose(cap[points.block == 40], 5e-4 / 0.02, rtol=1e-6)


def test_binding_is_the_feed_where_the_motion_cruises_and_nothing_where_it_pauses():
    """The limits are its own peaks: raised, they leave the cruise to the feed alone."""
    fast = motions.Trajectory()
    fast.limits = fast.limits.scaled(2.0, 2.0, 2.0)
    cruise, pause = 0.5 * fast.laws[0].duration, fast.starts[1] - 0.1
    assert [limit_names(fast.joints)[k] for k in binding(fast, np.array([cruise]))] == ["feed"]
    assert binding(fast, np.array([pause])).tolist() == [NOTHING]


def test_binding_is_the_joint_whose_limit_is_lowered():
    slow = motions.Trajectory()
    cruise = np.array([0.5 * slow.laws[0].duration])
    speed = np.abs(slow.at(cruise).qd[0])
    assert (speed > 0.0).all()
    for k, joint in enumerate(slow.joints):
        velocity = np.full(len(slow.joints), np.inf)
        velocity[k] = 0.9 * speed[k]
        slow.limits = Limits(velocity, np.inf, np.inf, slow.joints)
        assert limit_names(slow.joints)[binding(slow, cruise)[0]] == f"velocity {joint}"


def test_words():
    for share, words in ((0.00132, "0.14 %"), (0.0013, "0.13 %"), (2.3141, "232 %"), (3e-8, "3e-06 %")):
        assert at_most(share) == words
    assert (at_most(-1e-12), at_most(0.0), at_most(math.inf), at_most(0.9999)) == ("0 %", "0 %", "unbounded", "100 %")
    assert [percent(x) for x in (1.00004, 0.5, 0.0004)] == ["100.00 %", "50.0 %", "0.040 %"]
    assert limit_words("jerk A") == "Jerk of A"
    assert len(set(colours(("X", "Y")).values())) == 7


@pytest.mark.browser
@pytest.mark.parametrize("width", [1400, pytest.param(390, marks=pytest.mark.sweep)])
def test_draws_without_errors_and_without_network(html, tmp_path, width):
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("Chromium is not installed (apt-get install chromium)")
    probe = (
        "<script>window.problems=[];window.addEventListener('error',e=>problems.push(e.message));"
        "window.addEventListener('unhandledrejection',e=>problems.push(String(e.reason)));"
        "const told=console.error;console.error=(...a)=>{problems.push(a.join(' '));told(...a)};</script>"
    )
    after = (
        "<script>setTimeout(()=>Plotly.relayout('time',{'xaxis.range':[0.5,0.6]}),2000);"
        "setTimeout(()=>{const d=document,x=d.getElementById('time').data[5].x;"
        "d.title='probe:'+JSON.stringify({problems,ready:window.toolpaceReady,from:x[0],to:x.at(-1),"
        "lines:d.querySelectorAll('#time .scatterlayer .trace').length,"
        "canvas:d.querySelectorAll('#space canvas').length,"
        "wide:d.documentElement.scrollWidth})},4000)</script>"
    )
    page = tmp_path / "page.html"
    text = html.read_text(encoding="utf-8").replace("<head>", "<head>" + probe, 1) + after
    # The policy of the page would keep the probes out; it is held for all else.
    added = " ".join(checksum(script[len("<script>") : -len("</script>")]) for script in (probe, after))
    page.write_text(text.replace("script-src ", f"script-src {added} ", 1), encoding="utf-8")
    command = [
        browser,
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
        *("--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader"),
        # Any request would fail, and be seen.
        *("--enable-unsafe-swiftshader", "--host-resolver-rules=MAP * ~NOTFOUND", f"--window-size={width},900"),
        *(f"--user-data-dir={tmp_path / 'profile'}", "--virtual-time-budget=15000", "--dump-dom"),
        page.as_uri(),
    ]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False).stdout
    found = re.search(r"<title>probe:(.*?)</title>", shown)
    assert found, shown[:500]
    state = json.loads(found[1].replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">"))
    assert state["problems"] == []
    assert state["ready"] == 2
    assert state["lines"] == 17
    assert state["canvas"] >= 1
    # Zooming in draws the curves anew, from the set-points in view.
    assert 0.49 < state["from"] <= 0.5
    assert 0.6 <= state["to"] < 0.61
    assert state["wide"] <= max(width, 500) + 1


def test_deviations_are_those_of_the_run_that_is_passed():
    """The parameter of each run begins at 0, so that it does not tell which one."""
    toolpath = toolpath_through([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]], 4 * [[0, 0, 1]], stops=(2,))
    machine = tp.Machine.load("xyzac-trunnion")
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine, bound=False)
    t = np.linspace(0.0, trajectory.duration, 300)
    tip, _ = deviations(trajectory, t, 0.01, math.degrees(1e-3))
    for k, run in enumerate(trajectory.axis_path.runs):
        breaks, off, _ = run.deviations()
        of_run = trajectory.run_at(t) == k
        assert run.s0 == 0.0 and 0 < of_run.sum() < len(t)
        cell = np.searchsorted(breaks[1:-1], trajectory.parameter(t[of_run]), side="right")
        np.testing.assert_allclose(tip.values[of_run], off[cell] / 10e-6)


@pytest.mark.parametrize("points", [40_000, 100])
def test_curves_are_the_same_in_blocks_of_any_length(monkeypatch, points):
    """Also where blocks begin and end within the stretches of which the extremes are shown."""
    monkeypatch.setattr(charts, "POINTS", points)
    found = []
    for rows in (1 << 15, 77):
        monkeypatch.setattr(sampling, "ROWS", rows)
        found.append(Curves.of(TRAJECTORY.sample(), TRAJECTORY.limits, ["m"] * len(TRAJECTORY.joints), PROGRAM))
    whole, blocks = (curves.extremes() for curves in found)
    assert len(whole) > 2 and [each.name for each in whole] == [each.name for each in blocks]
    for one, other in zip(whole, blocks, strict=True):
        np.testing.assert_array_equal(one.values, other.values)
        assert one.top == other.top
    np.testing.assert_array_equal(found[0].tip_steps, found[1].tip_steps)
