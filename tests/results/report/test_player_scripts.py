"""What the scripts of the report calculate, without a browser: lists, steps from block to block, playing."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.report_pages import calculated
from toolpace.machine.machine import Machine
from toolpace.results.report import report
from toolpace.results.report.keyframes import TICK, keyframes
from toolpace.results.report.machine_view import machine_view
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.player_data import page_json, program_text

TRAJECTORY, PROGRAM = motions.Trajectory(), motions.program()
LISTS = "const found = costTables(player); return found;"


def page_of(tmp_path, toolpath=None):
    """The text of a report."""
    report(TRAJECTORY, tmp_path / "report.html", toolpath)
    return (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    return page_of(tmp_path_factory.mktemp("scripts"), PROGRAM)


def test_a_motion_without_a_tool_path_has_no_operations_and_its_blocks(tmp_path):
    found = calculated(page_of(tmp_path), LISTS)
    assert found["operations"] == [] and found["slow"] == []
    assert found["blocks"][0]["cells"][0].startswith("line ")


def test_lists_are_made_of_more_lines_than_a_call_takes_arguments(text):
    many = """
        const n = 400000;
        const count = (from, by) => Float64Array.from({ length: n }, (_, k) => from + k * by);
        const none = count(0, 0);
        player.passages = { t: count(0, player.duration / n), line: count(1, 1), operation: none, kind: none };
        player.lineTimes.clear(); player.account();
        return [largest(player.lineTimes.values()) * n / player.duration, costTables(player).blocks.length];
    """
    assert calculated(text, many) == [pytest.approx(1.0), 60]


def test_a_line_of_megabytes_is_short_in_lists(text):
    script = """
        player.text = Array(900).fill("G1 X" + "1".repeat(5e6));
        return costTables(player).blocks[0].cells[1].length;
    """
    assert calculated(text, script) <= 500


def test_steps_lead_through_blocks_that_begin_at_the_same_moment(text):
    script = """
        player.passages.t = Float64Array.from([0, 0.5, 0.5, 0.5, 1]);
        player.passages.line = Int32Array.from([1, 2, 3, 4, 5]);
        const times = [];
        player.seek(player.duration);
        for (let k = 0; k < 4; k++) { player.step(-1); times.push(player.t); }
        for (let k = 0; k < 2; k++) { player.step(1); times.push(player.t); }
        return times;
    """
    assert calculated(text, script) == [1.0, 0.5, 0.0, 0.0, 0.5, 1.0]


def test_the_line_at_the_moment_at_which_a_block_ends_is_the_next(text, tmp_path):
    """Whatever the moments are rounded to; of the last block itself at the end."""
    begins = calculated(text, "return Array.from(player.passages.t);")
    points = TRAJECTORY.sample()
    exact = points.t[np.flatnonzero(np.diff(points.block)) + 1]
    assert begins[0] == 0.0 and max(begins) <= TRAJECTORY.duration
    assert all(min(abs(np.array(begins) - t)) <= 2e-3 for t in exact.tolist())
    found = calculated(text, "return Array.from(player.passages.t, (t) => player.lineAt(t - 2e-10));")
    assert found == calculated(text, "return Array.from(player.passages.line);")
    assert calculated(text, "return player.lineAt(player.duration);") == points.block[-1]


@pytest.mark.parametrize("name", ["xyzac-trunnion", "xyzbc-nutating", "xyzbc-head", "xyzab-table"])
def test_the_chain_of_the_page_is_that_of_the_machine(text, name):
    """With a workpiece that is clamped askew, and a tool of any length, also none."""
    as_text = Machine.load(name).to_toml()
    askew = "workpiece_x = [0.6, 0.8, 0.0]\nworkpiece_z = [0.48, -0.36, 0.8]\n"
    machine = Machine.from_toml(as_text.replace("workpiece_origin", askew + "workpiece_origin", 1))
    random = np.random.default_rng(3)
    q = random.normal(size=(8, len(machine.joints))) * np.where(machine.is_rotary, 2.0, 0.2)
    length = np.append(random.uniform(-0.05, 0.3, 7), 0.0)
    shown = (q * np.where(machine.is_rotary, 1.0, 1e3)).tolist(), (1e3 * length).tolist()
    chain = f"const [q, length] = {json.dumps(shown)}, machine = new Machine({json.dumps(machine_view(machine))});"
    found = calculated(text, f"{chain} return q.map((each, k) => machine.tool(each, length[k]));")
    tip, axis = machine.forward(q, length)
    np.testing.assert_allclose([each["tip"] for each in found], 1e3 * tip, atol=1e-9)
    np.testing.assert_allclose([each["axis"] for each in found], axis, atol=1e-12)


def test_playing_on_at_once_plays_no_faster(text):
    script = "player.play(); player.pause(); player.play(); return frames.filter(Boolean).length;"
    assert calculated(text, script) == 1


def test_the_way_of_whole_turns_between_keyframes_is_seen(text):
    """Two turns between two keyframes end where they began, and so does their middle: a circle of 40 mm, twice."""
    script = """
        const { motion } = player, c = player.joints.findIndex((joint) => joint.name === "C");
        motion.t = Float64Array.from([0, 1]);
        motion.q = motion.q.map((_, j) => Float64Array.from(j === c ? [0, 4 * Math.PI] : j ? [0, 0] : [40, 40]));
        motion.v = motion.v.map((_, j) => Float64Array.from(j === c ? [4 * Math.PI, 4 * Math.PI] : [0, 0]));
        const { tips } = motion.samples(0.01, 10000), far = (a, b) => Math.hypot(...a.map((v, k) => v - b[k]));
        return tips.slice(1).reduce((sum, tip, k) => sum + far(tip, tips[k]), 0);
    """
    assert calculated(text, script) == pytest.approx(2 * 2 * np.pi * 40.0, rel=2e-3)


def test_a_time_that_is_rounded_to_a_minute_is_one(text):
    script = 'return [clock(59.99996), clock(119.9999), clock(3599.9999), clock(61.5), clock(0.00021, 1e-4)];'
    assert calculated(text, script) == ["1:00.000", "2:00.000", "1:00:00.000", "1:01.500", "0.0002 s"]


def test_keyframes_are_few_where_stops_alone_would_be_too_many():
    many = motions.Trajectory()
    many.starts = np.linspace(0.0, 0.9 * many.duration, 300)
    found = keyframes(many, most=100)
    assert len(found.t) <= 100 and found.t[-1] == many.duration


@pytest.mark.parametrize("duration", [0.4 * TICK, 0.6 * TICK, 7.3 * TICK])
def test_keyframes_of_a_moment_reach_to_its_end(duration):
    short = motions.Trajectory()
    short.starts, short.duration = np.zeros(1), duration
    found = keyframes(short)
    assert found.t[0] == 0.0 and found.t[-1] == duration and (np.diff(found.t) > 0.0).all()


def test_a_name_that_is_no_text_is_written_out(tmp_path):
    """As the system hands over a file's name in another encoding."""
    text = page_of(tmp_path, replace(PROGRAM, source="part\udcff\u202e.nc"))
    assert "part\\udcff\\u202e.nc" in text


def test_lines_of_a_program_are_those_that_its_reader_counts():
    text = program_text("A\fB\u2028C\r\nD\rE\n".encode())
    assert text is not None and text.decode().split("\n") == ["A\\x0cB\\u2028C", "D", "E", ""]


def test_names_in_the_data_cannot_end_it():
    text = page_json({"name": "</script><b>"}, PackedArrays())
    assert "<" not in text and json.loads(text)["name"] == "</script><b>"
