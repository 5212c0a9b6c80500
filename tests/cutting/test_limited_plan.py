"""Plans whose speed is that which their cut allows: the profile of speed, and the motion that holds it."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

import toolpace as tp
from tests.support.limited_plans import SLOT, limited_slot, machine
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.cutting.feeds.limited_plan import BELOW, DEPARTURE, at_stations, few_places, same_path
from toolpace.judge import cut
from toolpace.programs.speed_profile import SpeedProfile


@pytest.mark.parametrize("seed", range(20))
def test_a_line_of_few_places_is_never_above_and_hardly_below(seed):
    rng = np.random.default_rng(seed)
    s = np.cumsum(rng.uniform(0.1, 1.0, 300))
    most = np.exp(np.cumsum(rng.normal(size=300)) * 10.0 ** rng.uniform(-4.0, -1.0))
    most[rng.random(300) < 0.1] *= 0.5
    kept = few_places(s, most)
    line = np.interp(s, s[kept], (1.0 - 0.5 * BELOW) * most[kept])
    assert kept[0] == 0 and kept[-1] == 299
    assert (line <= most * (1.0 + 1e-12)).all() and (line >= most * (1.0 - BELOW) - 1e-12).all()
    assert len(few_places(s, (1.0 + s) * (1.0 - 1e-9 * rng.random(300)))) == 2


EXITS = {
    "a slot": lambda x: 1.0 / np.sqrt(np.maximum(1.0 - (np.maximum(x, 0.0) / 5.0) ** 2, 0.04)),
    "a kink": lambda x: 1.0 + np.maximum(x - 0.7321, 0.0),
    "an entry": lambda x: np.where(x < 1.0377, 6.0, 1.0),
    "an exit": lambda x: np.where(x < 1.0377, 1.0, 6.0),
    "steps": lambda x: 1.0 + 0.3 * np.floor(x),
}
"""Most speed along a way of 5 mm."""


@pytest.mark.parametrize("name", EXITS)
@pytest.mark.parametrize("seed", range(5))
def test_a_line_between_stations_is_below_what_the_cut_allows(name, seed):
    """Stations at random ways from a twentieth to a tenth of a millimetre."""
    rng = np.random.default_rng(seed)
    place = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.1, 60))])
    most = EXITS[name](place)
    found = at_stations(place, most[1:])
    x = np.linspace(place[0], place[-1], 20_001)
    assert (np.interp(x, place, found) <= EXITS[name](x) * (1.0 + 2.0 * DEPARTURE)).all()
    if name == "a slot":
        bends = place < 4.0
        assert (found[bends] >= 0.99 * most[bends]).all()
    if name == "steps":
        assert (found == most).sum() >= 45


def test_a_speed_without_a_limit_stays_without_one():
    found = at_stations(np.arange(6.0), np.array([1.0, np.inf, np.inf, np.inf, 2.0]))
    assert found.tolist() == [1.0, 1.0, 1.0, np.inf, 2.0, 2.0]
    assert at_stations(np.array([0.0, 1.0]), np.array([3.0])).tolist() == [3.0, 3.0]


def test_a_profile_is_straight_between_its_places_and_jumps_at_doubled_ones():
    profile = SpeedProfile(
        np.array([0.0, 1.0, 1.0, 3.0, 4.0]), np.array([np.inf, np.inf, 2.0, 4.0, 1.0]), np.array([0, 0, 1, 0, 0]),
        ("feed", "chip"),
    )  # fmt: skip
    assert profile.at(np.array([0.5, 1.0, 2.0, 3.5, 4.0])).tolist() == [np.inf, 2.0, 3.0, 2.5, 1.0]
    assert profile.jumps.tolist() == [1.0]
    assert profile.limit_at(np.array([0.5, 1.0, 2.9, 3.0])).tolist() == [0, 1, 1, 0]
    assert profile.most_of_ways(5) == pytest.approx([np.inf, np.inf, 3.0, 4.0, 4.0])
    part = profile.along(np.array([2.0, 3.0, 4.0]), np.array([0.0, 10.0, 11.0]))
    assert part.place.tolist() == [0.0, 10.0, 11.0] and part.speed == pytest.approx([3.0, 4.0, 1.0])
    with pytest.raises(UsageError, match="must ascend"):
        SpeedProfile(np.array([1.0, 0.0]), np.ones(2), np.zeros(2, dtype=np.int64), ("feed",))


def test_a_part_of_a_tool_path_has_its_part_of_the_profile():
    whole = limited_slot().toolpath
    part = whole.part(1, 3)
    assert part.speed_profile.at(np.array([0.5, 1.25])) == pytest.approx(whole.speed_profile.at(np.array([1.5, 2.25])))


def test_the_load_that_holds_is_named_and_no_speed_is_above_the_profile():
    plan = limited_slot()
    trajectory = plan.plan.trajectory
    assert trajectory.usage().worst <= 1.0001
    assert trajectory.gap < 0.01
    shares = trajectory.limited_by()
    assert next(iter(shares)) == "chip" and shares["chip"] > 0.4
    points = trajectory.sample(1e-3)
    steps = np.linalg.norm(np.diff(points.tip, axis=0), axis=1) / 1e-3
    cutting = (points.tip[1:, 0] > 1e-3) & (points.tip[1:, 0] < 34e-3) & (points.block[1:] == 5)
    # a chip of 0.05 mm, three teeth, 100 turns per second
    assert steps[cutting].max() == pytest.approx(15e-3, rel=BELOW) and steps[cutting].max() <= 15e-3 * 1.0001
    assert steps[points.tip[1:, 0] < -8e-3].max() > 30e-3


def test_feeds_in_air_leave_the_feed_where_something_is_cut():
    program, air = (tp.plan_program(SLOT.toolpath(), machine(), effort="low").trajectory, limited_slot("air"))
    assert air.plan.trajectory.duration < 0.9 * program.duration
    points = air.plan.trajectory.sample(1e-3)
    steps = np.linalg.norm(np.diff(points.tip, axis=0), axis=1) / 1e-3
    cutting = (points.tip[1:, 0] > -4e-3) & (points.tip[1:, 0] < 40e-3) & (points.block[1:] == 5)
    assert steps[cutting].max() <= 10e-3 * 1.0001


def test_the_last_profile_is_of_the_path_that_is_moved():
    plan = limited_slot()
    low = tp.plan_program(plan.toolpath, machine(), effort="low")
    assert same_path(low.path, plan.plan.path)
    other = tp.plan_program(plan.toolpath, machine(), 5e-6, effort="low")
    assert not same_path(other.path, plan.plan.path)


def test_a_guessed_stock_raises_no_speed(tmp_path, capsys):
    sheet = tmp_path / "setup.toml"
    sheet.write_text(SLOT.sheet.split("[tools.1]")[1].join(["[tools.1]", ""]))
    program = tmp_path / "slot.ngc"
    program.write_text(SLOT.program)
    out = tmp_path / "plan"
    words = [str(program), "-m", "xyzac-trunnion", "--setup", str(sheet), "--controller", "linuxcnc", "--effort", "low"]
    words += ["--feeds", "air", "--resolution", "1mm", "--no-report", "--out", str(out)]
    assert main(["plan", *words]) == 0
    shown = capsys.readouterr().out
    assert "the stock is a guess" in " ".join(shown.split())
    assert json.loads((out / "plan.json").read_text())["cut_limits"]["stock_guessed"] is True


@pytest.mark.parametrize(
    "words, message",
    [
        (["--margin", "2mm"], "--margin goes with --feeds air"),
        (["--feeds", "limits"], "no limit is given"),
        (["--feeds", "limits", "--limit", "chip=-1mm"], "chip"),
        (["--feeds", "fast"], "'fast' are not known"),
    ],
)
def test_options_that_make_no_sense(tmp_path, capsys, words, message):
    program = tmp_path / "slot.ngc"
    program.write_text(SLOT.program)
    assert main(["plan", str(program), "-m", "xyzac-trunnion", "--out", str(tmp_path / "plan"), *words]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.sweep
def test_a_folder_tells_that_its_cut_was_changed(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cut, "INSTANTS", 6)
    monkeypatch.setattr(cut, "STATIONS", 2)
    sheet, program, out = tmp_path / "setup.toml", tmp_path / "slot.ngc", tmp_path / "plan"
    sheet.write_text(SLOT.sheet)
    program.write_text(SLOT.program)
    words = [str(program), "-m", "xyzac-trunnion", "--setup", str(sheet), "--controller", "linuxcnc", "--effort", "low"]
    words += ["--feeds", "limits", "--limit", "chip=0.05mm", "--finishing", "--air-feed", "6000mm/min"]
    assert main(["plan", *words, "--resolution", "1mm", "--no-report", "--out", str(out)]) == 0
    assert main(["verify", str(out)]) == 0
    assert "chip of the cut" in capsys.readouterr().out
    file = out / "cut_limits.npz"
    with np.load(file) as arrays:
        changed = {name: arrays[name] for name in arrays.files}
    changed["speed"] = 1.5 * changed["speed"]
    np.savez_compressed(file, **changed)
    assert main(["verify", str(out)]) == 2
    assert "cut_limits.npz: is not the file that the plan was made with" in capsys.readouterr().err
    file.unlink()
    assert main(["verify", str(out)]) == 2
    assert "do not belong together" in capsys.readouterr().err


def test_a_plan_by_the_feeds_of_the_program_knows_no_profile():
    toolpath = SLOT.toolpath()
    assert toolpath.speed_profile is None
    path = tp.Path.fit(toolpath, machine=machine())
    assert all(run.speed_profile is None for run in path.runs)
    same = dataclasses.replace(toolpath)
    assert same == toolpath and limited_slot().toolpath != toolpath
