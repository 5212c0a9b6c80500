"""The paper's simulation study by one call."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from toolpace import study
from toolpace.planning.guarantee import PROMISED


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study")
    told: list[float] = []
    study.write_study(out, told.append)
    assert told == sorted(told) and told[-1] == 1.0
    return out


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
    for number in range(4, 11):
        assert f"Figure {number}." in text and f'id="figure-{number}"' in text
    for words in ("Errata", "What the paper does not say", "Time in each interval", "lead angle", "(7b)", "5.23599"):
        assert words in text, words
    assert 'src="http' not in text and '<link rel="stylesheet' not in text


def test_pictures(folder: Path, facts: dict) -> None:
    pytest.importorskip("matplotlib")
    assert facts["png"] == [f"figure_{n}.png" for n in range(4, 11)]
    for name in facts["png"]:
        assert (folder / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert (folder / name).stat().st_size > 20_000


def test_errata_are_worked_out_anew() -> None:
    from toolpace.study.errata import all_errata, comparison
    from toolpace.study.simulation import simulate

    done = simulate(lambda share: None)
    lines = {line.where: line.check for line in all_errata(done)}
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
    ) in comparison(done)
