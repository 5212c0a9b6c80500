"""The branch of the inverse kinematics is decided once a path, and carried on to all points put in later."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest

from tests.support.tool_paths import spiral, tilted, toolpath_through
from toolpace.cli import main
from toolpace.jobs import plan_steps
from toolpace.kernels.kinematics import branches
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import refined
from toolpace.path.path import Path
from toolpace.planning.planner import plan

MACHINE = Machine.load("xyzac-trunnion")
PROGRAM = "UNITS/MM\nFEDRAT/3000,MMPM\n" + "".join(
    f"GOTO/{20 * np.cos(u):.4f},{20 * np.sin(u):.4f},0,{a[0]:.6f},{a[1]:.6f},{a[2]:.6f}\n"
    for u, a in zip(np.linspace(0, 2, 40), tilted(0.5 + 0.3 * np.sin(np.linspace(0, 6, 40)), np.linspace(0, 4, 40)))
)


@pytest.fixture
def choices(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """How many points each dynamic programme over a path went through, in order."""
    seen: list[int] = []
    choose = branches.choose

    def counted(frame: object, points: branches.Points, *rest: object) -> bool:
        seen.append(len(points.axis))
        return choose(frame, points, *rest)

    monkeypatch.setattr(branches, "choose", counted)
    return seen


def test_a_plan_from_the_command_line_decides_at_most_once_a_fit(choices, tmp_path, monkeypatch):
    monkeypatch.setattr(plan_steps, "warm_up", lambda steps: None)
    program = tmp_path / "part.cls"
    program.write_text(PROGRAM)
    out = tmp_path / "out"
    assert main(["plan", str(program), "--machine", "xyzac-trunnion", "--out", str(out), "--no-report"]) == 0
    rounds = json.loads((out / "plan.json").read_text())["rounds"]
    # fits within the same tolerances share what they begin with
    assert 1 <= len(choices) <= max(len(rounds), 1)


def test_a_plan_of_a_program_decides_once(choices):
    toolpath = spiral(300)
    path = Path.fit(toolpath, machine=MACHINE)
    plan(path, MACHINE)
    assert len(choices) == 1


def test_a_plan_of_an_exact_path_decides_once(choices):
    plan(Path.paper_arc(), Machine.load("paper-ab"))
    assert len(choices) == 1


@pytest.mark.parametrize("offset", [0.0, 1e-6, 1e-3, 1e-2], ids=lambda d: f"{d:g} rad beside the pole")
def test_past_the_pole_decides_once(choices, offset):
    """The points around the pole are put in before the choice; those put in later follow it."""
    tilt = np.linspace(-0.3, 0.3, 8)
    axis = np.stack([np.sin(tilt), np.full(8, offset), np.cos(tilt)], axis=1)
    toolpath = toolpath_through(np.stack([0.1 * tilt, 0 * tilt, 0 * tilt], axis=1), axis)
    dense, _ = refined(toolpath, 1e-3, MACHINE)
    assert len(choices) == 1
    np.testing.assert_allclose(MACHINE.axis_at(dense.rotary), dense.axis, atol=1.1e-4)
    # straight over the pole the tilt changes sign; beside it the table turns by half a turn
    turned = abs(dense.rotary[-1, 0] - dense.rotary[0, 0])
    assert turned == pytest.approx(0.0 if offset < 1e-4 else np.pi - 2 * np.arctan(offset / np.sin(0.3)), abs=1e-3)


def test_points_put_in_stay_on_the_branch_of_their_neighbours():
    """Against the choice over all points at once, on a program whose axis winds about its pole."""
    toolpath = spiral(200)
    whole = MACHINE.choose_rotary(toolpath)
    known = np.unique(np.append(np.arange(0, 200, 7), 199))
    np.testing.assert_allclose(MACHINE.rotary_between(toolpath, known, whole[known]), whole, atol=1e-12)
