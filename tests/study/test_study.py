"""The paper's simulation study by one call."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from toolpace import deflection, study
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.study import simulation
from toolpace.study.simulation import DEFLECTION, Study
from toolpace.study.tables import all_errata, comparison

pytestmark = pytest.mark.sweep


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Study]:
    """The folder, and the study that was written into it."""
    out = tmp_path_factory.mktemp("study")
    told: list[float] = []
    kept: list[Study] = []

    def simulate(progress: Callable[[float], None]) -> Study:
        kept.append(real(progress))
        return kept[0]

    with pytest.MonkeyPatch.context() as patch:
        real = simulation.simulate
        patch.setattr(simulation, "simulate", simulate)
        study.write_study(out, told.append)
    assert told == sorted(told) and told[-1] == 1.0
    return out, kept[0]


@pytest.fixture(scope="module")
def folder(written: tuple[Path, Study]) -> Path:
    return written[0]


@pytest.fixture(scope="module")
def done(written: tuple[Path, Study]) -> Study:
    return written[1]


@pytest.fixture(scope="module")
def facts(folder: Path) -> dict:
    return json.loads((folder / "study.json").read_text(encoding="utf-8"))


def test_projections(facts: dict) -> None:
    printed = facts["projection_interval20_m"]
    assert [round(v, 3) for v in printed[:2]] == [0.058, 0.058] and round(printed[2], 4) == 0.0571
    angle = np.arctan2((0.059 + 0.0568) / np.sqrt(2.0), 0.0589)
    closed = 0.1 * np.array([np.sin(angle) / np.sqrt(2.0), np.sin(angle) / np.sqrt(2.0), np.cos(angle)])
    np.testing.assert_allclose(facts["projection_path_m"], closed, atol=1e-9)


def test_durations(facts: dict) -> None:
    genetic = facts["duration_genetic_s"]
    assert facts["duration_optimal_s"] == pytest.approx(5.3112, rel=5e-4)
    assert genetic["1"] > genetic["10"] > genetic["100"] > facts["duration_optimal_s"]
    assert genetic["1"] < 1.06 * facts["duration_optimal_s"]
    assert facts["lower_bound_feed_s"] == pytest.approx(5.23599, abs=1e-5)
    for name, total in (("genetic_1", genetic["1"]), ("optimal", facts["duration_optimal_s"])):
        periods = facts["periods_s"][name]
        assert len(periods) == 31 and sum(periods) == pytest.approx(total, abs=1e-9)


def test_all_limits_are_held_without_and_with_deflection(facts: dict) -> None:
    assert set(facts["peak_usage"]) == {"genetic", "optimal"}
    for both in facts["peak_usage"].values():
        assert set(both) == {"without_deflection", "with_deflection"}
        for peak in both.values():
            kinds = [peak["feed"], *peak["velocity"].values(), *peak["acceleration"].values(), *peak["jerk"].values()]
            assert peak["worst"] == max(kinds) <= PROMISED


def test_page_opens_offline_and_says_all(folder: Path) -> None:
    text = (folder / "study.html").read_text(encoding="utf-8")
    for number in range(1, 11):
        assert f"Figure {number}." in text
    for number in range(4, 11):
        assert f'id="figure-{number}"' in text
    for words in (
        "Errata",
        "What the paper does not say",
        "Time in each interval",
        "lead angle",
        "(7b)",
        "5.23599",
        "to the letter",
        "displaced",
        "bending",
        "Hills of preset speeds",
        "Taylor",
        "seeds 2009 to 2018",
    ):
        assert words in text, words
    assert 'src="http' not in text and '<link rel="stylesheet' not in text


def test_sketches_are_whole_drawings(folder: Path) -> None:
    """Parsed as XML, with every word and every point inside the frame."""
    for number in range(1, 4):
        root = ElementTree.fromstring((folder / f"figure_{number}.svg").read_text(encoding="utf-8"))
        width, height = float(root.get("width", "")), float(root.get("height", ""))
        texts = list(root.iter("{http://www.w3.org/2000/svg}text"))
        assert len(texts) > 10
        for text in texts:
            assert text.text and 0 < float(text.get("x", "")) < width and 0 < float(text.get("y", "")) < height
        lines = list(root.iter("{http://www.w3.org/2000/svg}polyline"))
        points = [float(v) for line in lines for pair in line.get("points", "").split() for v in pair.split(",")]
        assert len(lines) > 5 and min(points) >= 0 and max(points) <= max(width, height)


def test_seeds_find_what_the_planner_finds(facts: dict) -> None:
    """The first seed is that of the plans; more generations are no slower, seed by seed."""
    assert facts["genetic"] == {"population": 20, "seed": 2009, "seeds": list(range(2009, 2019))}
    found = facts["duration_by_seed_s"]
    for count in ("1", "10", "100"):
        assert found[count][0] == pytest.approx(facts["duration_genetic_s"][count], rel=1e-12)
        assert len(set(found[count])) == 10
    assert all(a > b > c for a, b, c in zip(found["1"], found["10"], found["100"]))


def test_pictures(folder: Path, facts: dict) -> None:
    pytest.importorskip("matplotlib")
    assert facts["png"] == [f"figure_{n}.png" for n in range(4, 11)]
    for name in facts["png"]:
        assert (folder / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert (folder / name).stat().st_size > 20_000


def coordinates(done: Study, way: simulation.Trajectory, t: np.ndarray) -> np.ndarray:
    """(n, 5) tip in the workpiece frame, by forward kinematics, and rotary joints."""
    return np.concatenate([way.tip(t)[0], way.at(t).q[:, done.machine.rotary]], axis=1)


@pytest.mark.parametrize("reading", ["acceleration", "jerk"])
def test_way_to_the_letter_is_that_of_step_2(done: Study, reading: str) -> None:
    """Quintics in the workpiece frame, with the reference's velocity at both ends, and what else can be the same."""
    way = done.literal[reading]
    first, second = way.periods
    law = done.genetic[1].laws[0]
    instant = law.passing_time(done.interval.s)
    t = first * (0.5 - 0.5 * np.cos(np.pi * np.arange(13) / 12.0))
    values = coordinates(done, way.trajectory, t)
    quintics = [Polynomial.fit(t, value, 5) for value in values.T]
    for quintic, value in zip(quintics, values.T):
        np.testing.assert_allclose(quintic(t), value, atol=1e-14)
    rates = np.array([[[q.deriv(k)(end) for q in quintics] for end in (0.0, first)] for k in (1, 2, 3)])
    np.testing.assert_allclose(rates, way.rates, rtol=1e-6, atol=1e-6)
    # of the reference from its right side: its third derivative jumps at the point
    later = instant + 0.03 * (0.5 - 0.5 * np.cos(np.pi * np.arange(13) / 12.0))
    reference = [Polynomial.fit(later, value, 6) for value in coordinates(done, done.genetic[1], later).T]
    velocity, acceleration = (np.array([p.deriv(k)(instant) for p in reference]) for k in (1, 2))
    np.testing.assert_allclose(rates[0], [velocity, velocity], rtol=1e-5)
    wanted = acceleration if reading == "acceleration" else np.zeros(5)
    np.testing.assert_allclose(rates[1], [wanted, wanted], atol=1e-6)
    # both jerks are the same where nothing accelerates, and only there
    np.testing.assert_allclose(rates[2, 1] - rates[2, 0], 12.0 * wanted / first, atol=1e-4)
    assert (np.abs(rates[2, 1] - rates[2, 0]).max() > 0.2) == (reading == "acceleration")
    ends = coordinates(done, way.trajectory, np.array([0.0, first, first + second]))[:, :3]
    following = done.path.runs[0].evaluate(done.points[20:21]).tip[0, 0]
    np.testing.assert_allclose(ends, [DEFLECTION, done.interval.tip, following], atol=1e-12)


@pytest.mark.parametrize("reading", ["acceleration", "jerk"])
def test_way_to_the_letter_keeps_to_the_limits_but_for_its_jump(done: Study, reading: str) -> None:
    way, known = done.literal[reading], done.genetic[1]
    assert way.trajectory.usage().worst <= PROMISED
    instant, h = known.laws[0].passing_time(done.interval.s), 1e-5
    after = (way.trajectory.at(np.array([0.0, h])).q[1] - way.trajectory.at(np.zeros(1)).q[0]) / h
    before = np.diff(known.at(np.array([instant - h, instant])).q, axis=0)[0] / h
    np.testing.assert_allclose(after - before, way.jump[0], atol=2e-5)
    assert np.abs(way.jump[0]).max() > 1e-4 and not np.abs(way.jump[0][done.machine.rotary]).max() > 1e-9


def test_what_is_gone_backwards_is_so_by_the_nearest_points_of_the_path(done: Study, facts: dict) -> None:
    """The page says it; here every place is projected on the path."""
    for name, (way, duration) in done.ways().items():
        tips = way.tip(np.linspace(0.0, duration, 150))[0]
        s = np.array([deflection.project(done.path, tip).s for tip in tips])
        assert (np.maximum.accumulate(s) - s).max() == pytest.approx(facts["gone_back"][name]["tip_m"], abs=2e-6)
    back = facts["gone_back"]
    assert back["genetic"]["tip_m"] > 5e-4 and back["literal_acceleration"]["tip_m"] > 5e-4
    assert back["genetic"]["joints"][done.machine.joints.index("B")] > np.radians(0.5)


def test_page_says_what_is_gone_backwards(folder: Path, facts: dict) -> None:
    text = (folder / "study.html").read_text(encoding="utf-8")
    assert (
        f"The genetic way goes back {1e3 * facts['gone_back']['genetic']['tip_m']:.2f} mm along the arc, and B" in text
    )


def test_errata_are_worked_out_anew(done: Study) -> None:
    lines = {where: check for where, _, _, check in all_errata(done).rows}
    assert len(lines) == 10
    assert "100 mm" in lines["II.B, point P_t"]
    assert "68.3 mm" in lines["Eq. (6), third line"]
    assert "0.09994 m from the origin" in lines["III, the circle"]
    assert "2.367 mm" in lines["III, “20th interval”"]
    assert "1.781 mm" in lines["III, the projection"]
    assert (
        "Projection on the 20th interval",
        "(0.058, 0.058, 0.0571) m",
        "(0.05804, 0.05804, 0.05713) m",
    ) in comparison(done).rows
