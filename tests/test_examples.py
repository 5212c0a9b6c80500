"""Every numbered example runs, and comes to what it says."""

from __future__ import annotations

import importlib.util
from itertools import pairwise
from pathlib import Path
from types import ModuleType

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
}


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{name}", FOLDER / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_example_is_tested():
    assert {path.stem for path in FOLDER.glob("*.py")} == TESTED


def test_plan_a_program(tmp_path, capsys):
    trajectory = load("01_plan_a_program").main(tmp_path)
    assert trajectory.usage().worst <= 1.0001
    assert {path.name for path in tmp_path.iterdir()} == {"blade.ngc", "setpoints.npz", "report.html"}
    assert "limited by" in capsys.readouterr().out


def test_your_own_machine():
    machine = load("02_your_own_machine").main()
    assert machine.kind == "head-table" and machine.joints == ("X", "Y", "Z", "B", "C")
    q = np.array([[0.02, -0.03, 0.05, np.radians(30.0), np.radians(70.0)]])
    tip, axis = machine.forward(q)
    ways, _ = machine.rotary_solutions(axis)
    for way in ways[0]:
        again = machine.forward(machine.joints_at(tip, way[None]))
        assert np.allclose(again[0], tip) and np.allclose(again[1], axis)


def test_exact_path():
    by_feed, duration = load("03_exact_path").main()
    assert by_feed == pytest.approx(5.23599, abs=1e-5)
    # Speeding up and slowing down within the limits cannot be had for nothing.
    assert by_feed < duration < 1.05 * by_feed


def test_any_joints():
    module = load("04_any_joints")
    trajectory = module.main()
    assert trajectory.usage().worst <= 1.0001 and len(trajectory.joints) == 7
    s, h = np.linspace(0.1, 0.9, 9), 1e-6
    for order in range(3):
        slope = (module.joints(s + h, order) - module.joints(s - h, order)) / (2.0 * h)
        assert np.allclose(slope, module.joints(s, order + 1), rtol=1e-6, atol=1e-4)


def test_read_the_result(capsys):
    trajectory = load("05_read_the_result").main()
    assert sum(trajectory.limited_by().values()) == pytest.approx(1.0)
    assert "slowest at" in capsys.readouterr().out


def test_what_tolerance_buys():
    durations = load("06_what_tolerance_buys").main()
    assert all(wide < narrow for narrow, wide in pairwise(durations))
