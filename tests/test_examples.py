"""Every numbered example runs, and comes to what it says."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import matplotlib.pyplot as plt
import numpy as np
import pytest

FOLDER = Path(__file__).parents[1] / "examples"
TESTED = {
    "01_plan_a_program",
    "02_your_own_machine",
    "03_exact_path",
    "04_any_joints",
    "05_read_the_result",
    "06_what_tolerance_buys",
    "07_choose_a_planner",
    "08_waypoints",
    "09_back_onto_the_path",
    "10_follow_a_disturbed_run",
    "11_limits_of_your_own",
    "12_torques_of_an_arm",
}


pytestmark = pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")


@pytest.fixture(autouse=True)
def no_windows() -> Iterator[None]:
    """Pictures are drawn without a screen, and closed after a test."""
    plt.switch_backend("agg")
    yield
    plt.close("all")


def load(name: str) -> ModuleType:
    """The example after it has run; it drew at least one picture."""
    spec = importlib.util.spec_from_file_location(f"example_{name}", FOLDER / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert plt.get_fignums()
    return module


def test_each_example_is_tested():
    assert {path.stem for path in FOLDER.glob("*.py")} == TESTED


def test_plan_a_program(capsys):
    example = load("01_plan_a_program")
    assert example.trajectory.usage().worst <= 1.0001
    assert {path.name for path in example.folder.iterdir()} == {"blade.ngc", "setpoints.npz", "report.html"}
    assert "limited by" in capsys.readouterr().out


def test_your_own_machine():
    machine = load("02_your_own_machine").machine
    assert machine.kind == "head-table" and machine.joints == ("X", "Y", "Z", "B", "C")
    q = np.array([[0.02, -0.03, 0.05, np.radians(30.0), np.radians(70.0)]])
    tip, axis = machine.forward(q)
    ways, _ = machine.rotary_solutions(axis)
    for way in ways[0]:
        again = machine.forward(machine.joints_at(tip, way[None]))
        assert np.allclose(again[0], tip) and np.allclose(again[1], axis)


def test_exact_path():
    example = load("03_exact_path")
    assert example.by_feed == pytest.approx(5.23599, abs=1e-5)
    # Speeding up and slowing down within the limits cannot be had for nothing.
    assert example.by_feed < example.trajectory.duration < 1.05 * example.by_feed
    # From some feed on the axes decide.
    assert all(quick < slow for slow, quick in pairwise(example.durations[:4]))
    assert example.durations[4] == pytest.approx(example.durations[3], rel=1e-3)


def test_any_joints():
    example = load("04_any_joints")
    assert example.trajectory.usage().worst <= 1.0001 and len(example.trajectory.joints) == 7
    s, h = np.linspace(0.1, 0.9, 9), 1e-6
    for order in range(3):
        slope = (example.joints(s + h, order) - example.joints(s - h, order)) / (2.0 * h)
        assert np.allclose(slope, example.joints(s, order + 1), rtol=1e-6, atol=1e-4)


def test_read_the_result(capsys):
    example = load("05_read_the_result")
    assert sum(example.limited_by.values()) == pytest.approx(1.0)
    assert "slowest at" in capsys.readouterr().out


@pytest.mark.sweep
def test_what_tolerance_buys():
    durations = load("06_what_tolerance_buys").durations
    assert all(wide < narrow for narrow, wide in pairwise(durations))


def test_choose_a_planner():
    optimal, genetic, second_order = load("07_choose_a_planner").plans.values()
    assert second_order.duration < optimal.duration < genetic.duration
    assert max(optimal.usage().worst, genetic.usage().worst) <= 1.0001
    assert np.isinf(second_order.usage().worst)


def test_waypoints():
    example = load("08_waypoints")
    for name, path in example.paths.items():
        run, plan = path.runs[0], example.plans[name]
        assert plan.usage().worst <= 1.0001
        assert np.allclose(run.evaluate(np.array([run.s0, run.s1]))[0], example.waypoints[[0, -1]])


def test_back_onto_the_path():
    example = load("09_back_onto_the_path")
    assert example.again.usage().worst <= 1.0001
    assert 0.0 < example.off[0] <= np.linalg.norm(example.measured - example.commanded)
    assert example.off[-1] < 1e-9


def test_limits_of_your_own(capsys):
    example = load("11_limits_of_your_own")
    assert capsys.readouterr().out.splitlines()[-1] == "True"
    durations = [each.duration for each in example.plans.values()]
    assert durations == sorted(durations)
    assert max(example.full.usage().rows.values()) <= 1.0001
    # the torques that were asked for are those that move the arm: their work is what its energy gains
    motion = example.full.at(np.linspace(0.0, example.full.duration, 20_001))
    torque = example.torques(np.stack([motion.q, motion.qd, motion.qdd, motion.qddd]))[:, :, 1]
    u, v = motion.qd.T
    cos = example.COUPLING * np.cos(motion.q[:, 1])
    energy = 0.5 * (example.INERTIA + 2.0 * cos) * u * u + (example.ELBOW + cos) * u * v + 0.5 * example.ELBOW * v * v
    power = (torque * motion.qd).sum(axis=1)
    work = np.cumsum((power[1:] + power[:-1]) / 2.0) * example.full.duration / 20_000
    assert np.allclose(work, energy[1:], atol=1e-6 * energy.max())


def test_torques_of_an_arm(capsys):
    example = load("12_torques_of_an_arm")
    assert capsys.readouterr().out.splitlines()[-1] == "True"
    assert 0.99 < example.shares.max() <= 1.0001
    # up against its weight, and down with it
    top = example.t[example.motion.q[:, 0].argmax()]
    assert top > 1.02 * (example.plan.duration - top)


@pytest.mark.sweep
def test_follow_a_disturbed_run():
    example = load("10_follow_a_disturbed_run")
    assert max(row[2].max() for row in example.used.values()) <= 1.0001
    size = [np.linalg.norm(error[700:2900], axis=1) for error in (example.with_correction, example.without)]
    # what is left is the runout, which no axis follows
    assert size[0].mean() < 20e-6 and size[1].mean() > 90e-6
    page = (example.folder / "followed.html").read_text(encoding="utf-8")
    assert "tool that bends" in page and "Content-Security-Policy" in page
