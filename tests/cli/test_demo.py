"""The programs that toolpace writes itself, and `toolpace demo`."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.report_pages import opened
from toolpace.cli import demo_programs, main
from toolpace.machine.machine import Machine
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.programs.reading import read_text


@pytest.fixture(scope="module")
def machine():
    return Machine.load(demo_programs.MACHINE)


@pytest.fixture(scope="module")
def impeller(machine):
    return read_text(demo_programs.impeller_program(machine), machine)


def test_impeller_has_its_blocks(impeller):
    turning = np.abs(np.diff(impeller.axis, axis=0)).max(axis=1) > 1e-6
    assert len(np.unique(impeller.block[1:][turning])) >= 2000


def test_impeller_returns_the_points_it_was_made_of(machine, impeller):
    tip, axis = demo_programs.blade_flank(400)
    first = np.argmin(np.linalg.norm(impeller.tip - tip[0], axis=1))
    part = slice(first, first + 600)
    distance = np.linalg.norm(impeller.tip[part, None] - tip[None], axis=2)
    nearest = distance.argmin(axis=0)
    assert distance.min(axis=0).max() < 1e-7
    turned = np.arccos(np.clip(np.sum(impeller.axis[part][nearest] * axis, axis=1), -1.0, 1.0))
    assert np.degrees(turned).max() < 1e-3


def test_impeller_blade_keeps_its_distance():
    """The tool lies along the ruling: its centre line keeps the tool radius and half the thickness from the blade."""
    tip, _ = demo_programs.blade_flank(401)
    hub, _ = demo_programs._hub(np.linspace(0.0, 1.0, 4001))
    away = np.linalg.norm(tip[:, None] - hub[None], axis=2).min(axis=1)
    meant = demo_programs.TOOL_RADIUS + demo_programs.HALF_THICKNESS
    assert away.min() > meant - 3e-5
    assert np.allclose(away[20:180], meant, atol=3e-5) and np.allclose(away[220:380], meant, atol=3e-5)


def test_flank_is_smooth_round_the_rim():
    tip, axis = demo_programs.blade_flank(2001)
    step = np.diff(tip, axis=0)
    turn = np.linalg.norm(np.diff(step, axis=0), axis=1) / np.linalg.norm(step[:-1], axis=1)
    assert turn.max() < 0.1
    assert np.linalg.norm(np.diff(axis, axis=0), axis=1).max() < 0.01


@pytest.mark.parametrize("blocks", [1, 100, 3000])
def test_spiral_has_as_many_blocks_as_asked(machine, blocks):
    toolpath = read_text(demo_programs.spiral_program(blocks, machine), machine)
    moving = np.unique(toolpath.block[1:])
    assert len(moving) == blocks
    tip, _ = demo_programs.sampled_spiral(blocks + 1, 0.5e-3)
    assert np.allclose(np.linalg.norm(np.diff(tip, axis=0), axis=1), 0.5e-3, rtol=2e-3)


def test_spiral_is_rounded_as_asked(machine):
    lines = demo_programs.spiral_program(50, machine, decimals=3).splitlines()
    assert sum("G1 X" in line for line in lines) == 50
    assert all(len(word.partition(".")[2]) == 3 for line in lines if "G1 X" in line for word in line.split()[1:5])


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    out = tmp_path_factory.mktemp("demo") / "out"
    return out, main(["demo", "--out", str(out)])


@pytest.mark.sweep
def test_demo_plans_within_every_limit(planned):
    planned, code = planned
    assert code == 0
    plan = json.loads((planned / "plan.json").read_text())
    assert plan["blocks"] >= 2000 and plan["verified"] is True
    peaks = [
        plan["usage"]["feed"],
        *(r for k in ("velocity", "acceleration", "jerk") for r in plan["usage"][k].values()),
    ]
    assert max(peaks) <= PROMISED
    assert main(["verify", str(planned)]) == 0


@pytest.mark.browser
@pytest.mark.sweep
def test_demo_report_draws_itself(planned):
    planned, _ = planned
    with opened(planned / "report.html") as page:
        assert "impeller.ngc" in page.page.title()
        assert page.run("toolpace.state().t") == 0.0
        assert page.problems == []
