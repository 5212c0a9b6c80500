"""The report: true figures, every peak kept, no network, no errors in a browser."""

from __future__ import annotations

import hashlib
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import toolpace as tp
from tests.support import motions
from tests.support.report_pages import Arrays, embedded
from tests.support.tool_paths import toolpath_through
from toolpace.judge import verify
from toolpace.machine.limits import Limits
from toolpace.motion import sampling
from toolpace.results.report import charts, page, report
from toolpace.results.report.charts import (
    NOTHING,
    Curves,
    FeedCaps,
    binding,
    deviations,
    extremes,
    limit_names,
)
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.words import at_most, colours, limit_words, percent

TRAJECTORY = motions.Trajectory()
PROGRAM = motions.program()


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    report(TRAJECTORY, path, PROGRAM, verify(TRAJECTORY, motions.machine(), PROGRAM))
    return path


def test_is_one_file_that_asks_for_nothing(html):
    text = html.read_text(encoding="utf-8")
    own = text[: text.index("<script>")] + text[text.rindex("<script>") :]
    assert "three.js" in text
    assert not re.search(r'(src|href)\s*=\s*"(?!data:)', own)
    assert "http" not in own.replace("http-equiv", "")
    assert html.stat().st_size < 1e6


def test_says_what_a_machinist_asks(html):
    text = html.read_text(encoding="utf-8")
    gap = "slower at most than the best on this path and mesh"
    for words in ("test", "xyzac-trunnion", "verified", "2.61 s", gap, "Programmed feed", "Jerk of A"):
        assert words in text, words
    assert "70.0 %" in text


def test_says_where_the_gap_lies(html):
    text = html.read_text(encoding="utf-8")
    assert "slower than the best possible: where" in text
    assert "<td>500 ms to 700 ms</td><td>3</td><td>100 ms</td>" in text
    assert "than any motion on this path" in text


def test_curves_are_the_set_points(html):
    data = embedded(html.read_text(encoding="utf-8"))
    points = TRAJECTORY.sample()
    names = [(c["panel"], c["name"]) for c in data["channels"]]
    assert names[0] == ("feed", "tip speed")
    assert len(names) == 2 + 15
    jerk = next(c for c in data["channels"] if (c["panel"], c["name"]) == ("jerk", "A"))
    values = Arrays(data).numbers(jerk["data"])
    np.testing.assert_allclose(values, points.qddd[:, 3] / TRAJECTORY.limits.jerk[3], atol=2e-4)
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


def test_what_is_packed_is_read_back_to_its_unit():
    arrays, random = PackedArrays(), np.random.default_rng(1)
    sets = [
        (np.cumsum(random.normal(size=2000)), 1e-3), (random.normal(size=500) * 1e9, 1.0), (np.zeros(0), 1.0),
        (np.array([np.nan, 0.0, -5.0, np.inf, 7.25]), 0.25), (np.arange(1000.0), 1.0), (np.full(3, np.nan), 1.0),
    ]  # fmt: skip
    entries = [arrays.add(values, unit) for values, unit in sets]
    data = arrays.add_bytes("Ü <b>".encode())
    read = Arrays({"arrays": arrays.text})
    for (values, unit), entry in zip(sets, entries, strict=True):
        back, there = read.numbers(entry), np.isfinite(values)
        assert entry["unit"] == unit or np.abs(values[there]).max() > 2**30 * unit
        assert (np.isnan(back) == ~there).all()
        np.testing.assert_allclose(back[there], values[there], rtol=0.0, atol=0.5 * entry["unit"])
    assert read.text(data) == "Ü <b>"


def test_the_script_library_is_the_one_that_was_built():
    folder = Path(charts.__file__).parent / "vendor"
    for name, about in json.loads((folder / "vendored.json").read_text()).items():
        text = (folder / name).read_bytes()
        assert hashlib.sha256(text).hexdigest() == about["sha256"]
        assert about["licence"] == "MIT" and b"The MIT License" in text[:400]
        assert about["version"].encode() in text[:100]


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
    # feed; of each joint three of its own, its motor, and the motor's continuous rating
    assert len(set(colours(("X", "Y")).values())) == 11


def test_deviations_are_those_of_the_run_that_is_passed():
    """The parameter of each run begins at 0, so that it does not tell which one."""
    toolpath = toolpath_through([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]], 4 * [[0, 0, 1]], stops=(2,))
    machine = tp.Machine.load("xyzac-trunnion")
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine, bound=False)
    t = np.linspace(0.0, trajectory.duration, 300)
    tip, _ = deviations(trajectory, trajectory.sample(t[1]), 0.01, math.degrees(1e-3))
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
    assert found[0].length == pytest.approx(found[1].length, rel=1e-12) and found[0].length > 0.0


def test_prices_are_a_table_of_what_is_worth_a_row():
    """Ten percent more of a limit that holds all of the motion: the time goes with its power."""
    machine = tp.Machine.load("xyzac-trunnion")
    prices = {"jerk C": 0.1, "feed": 0.05, "velocity X": 1e-7}
    shown = page._prices(SimpleNamespace(prices_s=prices), 30.0, machine)
    assert shown.index("Jerk of C") < shown.index("Programmed feed") and "Velocity of X" not in shown
    assert f"{3e4 * (1.0 - 1.1 ** (-0.1 / 0.3)):.0f} ms" in shown and "of the program" in shown
    assert page._prices(SimpleNamespace(prices_s={}), 30.0, machine) == ""


def test_a_wider_tolerance_is_asked_for_by_a_command_that_runs_beside_the_page():
    reading = SimpleNamespace(controller_file="controller.toml", setup_file="")
    figures = SimpleNamespace(program_file="program.<b>", reading=reading, tip_tolerance_mm=0.01)
    shown = page.wider_tolerance(figures)
    assert "program.&lt;b&gt; -m machine.toml --controller controller.toml --tips 10um,20um,40um" in shown
    assert "--setup" not in shown
    assert page.wider_tolerance(None) == ""
