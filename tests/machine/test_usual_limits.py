"""Limits that no machine tool has are asked about, with the unit that was likely meant; those of no joint refused."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
from toolpace.cli import main
from toolpace.machine.machine import FOLDER

TEXT = (FOLDER / "xyzac-trunnion.toml").read_text()


def questions(old: str, new: str) -> list[str]:
    """What is asked about the built-in machine with a line of its file written otherwise."""
    assert old in TEXT
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        tp.Machine.from_toml(TEXT.replace(old, new, 1), "mill.toml")
    assert all(issubclass(each.category, tp.UnitWarning) for each in told)
    return [str(each.message) for each in told]


@pytest.mark.parametrize("name", tp.Machine.names())
def test_nothing_is_asked_about_built_in_machines(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        machine = tp.Machine.load(name)
        assert tp.Machine.from_toml(machine.to_toml()) == machine
        machine.with_limits(machine.limits.scaled(0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("old", "new", "asked"),
    [
        ('angle = "deg"', 'angle = "rad"', "joint A: velocity = 150 rad/s is more .* is it 150 deg/s?"),
        ("velocity = 500", "velocity = 42000", "X: velocity = 42000 mm/s is more .*1 to 5000 mm/s.* 42000 mm/min?"),
        ("acceleration = 5000", "acceleration = 6", "X: acceleration = 6 mm/s.2 is less .* is it 6 m/s2?"),
        ("jerk = 50000", "jerk = 50", "X: jerk = 50 mm/s.3 is less .* is it 50 m/s3?"),
        ("velocity = 500", "velocity = 0.5", "X: velocity = 0.5 mm/s is less .* is it 0.5 m/s?"),
        ("velocity = 150", "velocity = 0.2", "A: velocity = 0.2 deg/s is less .* is it 0.2 rad/s?"),
        ("velocity = 150", "velocity = 9000", "A: velocity = 9000 deg/s is more .*; is it right?"),
    ],
)  # fmt: skip
def test_a_figure_in_another_unit_is_asked_about(old: str, new: str, asked: str) -> None:
    told = questions(old, new)
    assert told and re.search(f"^mill.toml: .*{asked.replace('?', '[?]')}", told[0])
    assert all("\n" not in each and len(each) < 250 for each in told)


def test_what_is_asked_may_be_written_as_it_says() -> None:
    """The cure in a question is one: it is read, and asks no more."""
    told = questions("velocity = 500", "velocity = 42000")
    cure = told[0].partition("Then write ")[2]
    assert cure == 'velocity = "42000 mm/min"'
    assert questions("velocity = 500", cure) == []
    machine = tp.Machine.from_toml(TEXT.replace("velocity = 500", cure, 1))
    assert machine.limits.velocity[0] == pytest.approx(0.7, rel=1e-15)


@pytest.mark.parametrize(
    ("joint", "key", "text", "value"),
    [
        ("X", "velocity", "42 m/min", 0.7),
        ("X", "velocity", "0.5 m/s", 0.5),
        ("X", "velocity", "1200 in/min", 0.508),
        ("X", "acceleration", "6 m/s2", 6.0),
        ("X", "acceleration", "6000 mm/s^2", 6.0),
        ("X", "acceleration", "0.5 g", 4.903325),
        ("X", "jerk", "60m/s3", 60.0),
        ("A", "velocity", "90 deg/s", math.pi / 2),
        ("A", "velocity", "10 rpm", math.pi / 3),
        ("A", "velocity", "1.5 rad/s", 1.5),
        ("A", "acceleration", "600 deg/s2", 600.0 * math.pi / 180.0),
        ("A", "acceleration", "1 rev/s²", 2.0 * math.pi),
        ("A", "jerk", "6000 deg/s^3", 6000.0 * math.pi / 180.0),
    ],
)
@pytest.mark.parametrize("name", ["xyzac-trunnion", "paper-ab", "xyzab-trunnion-inch"])
def test_limits_may_be_written_with_their_unit(joint: str, key: str, text: str, value: float, name: str) -> None:
    """Files in mm, m and in, in deg and rad: the unit of a figure is its own."""
    head, heading, tail = (FOLDER / f"{name}.toml").read_text().partition(f"[joints.{joint}]")
    line = next(each for each in tail.splitlines() if each.startswith(f"{key} ="))
    changed = head + heading + tail.replace(line, f'{key} = "{text}"', 1)
    limits = tp.Machine.from_toml(changed).limits
    assert getattr(limits, key)[limits.joints.index(joint)] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("velocity = 500", "velocity = 4200000", r"velocity = 4.2e\+06 mm/s is beyond any joint; give"),
        ('length = "mm"', 'length = "m"', r"velocity = 500 m/s is beyond any joint; is it 500 mm/s\?"),
        ("velocity = 500", 'velocity = "42 m/mn"', "'m/mn' is not a unit of velocity of a linear joint: use"),
        ("velocity = 150", 'velocity = "42 m/min"', "'m/min' is not a unit of velocity of a rotary joint"),
        ("velocity = 500", 'velocity = "-5 m/min"', "'-5 m/min' is negative, and must be above zero"),
        ("velocity = 500", 'velocity = "fast"', "'fast' is not a velocity of a linear joint: write"),
        ('angle = "deg"', 'angle = "rpm"', r'angle = .rpm. is not known; known: rad, deg; .* velocity = "10 rpm"'),
        ('kind = "rotary"', 'kind = "rotry"', "kind = 'rotry' is not known; did you mean 'rotary'?"),
    ],
)  # fmt: skip
def test_what_no_joint_has_is_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(tp.ToolpaceError, match=message) as caught:
        tp.Machine.from_toml(TEXT.replace(old, new, 1), "mill.toml")
    assert "\n" not in str(caught.value)


def test_limits_that_are_given_in_python_are_asked_about_once() -> None:
    machine = tp.Machine.load("xyzac-trunnion")
    limits = machine.limits
    with pytest.warns(tp.UnitWarning, match=r"with_limits: joint A: velocity = 150 rad/s .* is it 150 deg/s\?"):
        fast = np.where(machine.is_rotary, 150.0, limits.velocity)
        odd = machine.with_limits(tp.Limits(fast, limits.acceleration, 50.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        odd.with_limits(odd.limits.scaled(0.9))
        machine.with_limits(limits.scaled(np.inf, np.inf, np.inf))


def test_the_command_line_asks_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mill.toml"
    file.write_text(TEXT.replace("velocity = 500", "velocity = 42000", 1))
    assert main(["machines", str(file)]) == 0
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1 and told[0].startswith("question: ") and told[0].endswith('velocity = "42000 mm/min"')
