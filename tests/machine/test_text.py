"""The text of a machine file: exact, short, in the order of the chain, and explained."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import msgspec
import numpy as np
import pytest

from tests.support.machines import CLASSES, oracle, random_machine
from toolpace.common.files.toml import toml_value
from toolpace.machine.file_writer import units_of
from toolpace.machine.machine import Machine

LONGEST_FIGURE = 6
"""Most characters of a figure in a built-in machine that a person would write."""


def assert_same(machine: Machine, again: Machine) -> None:
    """To the last bit, and with the same columns."""
    assert again == machine and again.joints == machine.joints and again.file.note == machine.file.note
    for key in ("frame", "group", "place"):
        np.testing.assert_array_equal(getattr(machine.geometry, key), getattr(again.geometry, key))
    np.testing.assert_array_equal(machine.travel, again.travel)
    np.testing.assert_array_equal(machine.wrap, again.wrap)
    for key in ("velocity", "acceleration", "jerk"):
        np.testing.assert_array_equal(getattr(machine.limits, key), getattr(again.limits, key))
    assert (machine.name, machine.kind) == (again.name, again.kind)


def code(text: str) -> list[str]:
    """The lines without what explains them."""
    return [line.split("  # ")[0].rstrip() for line in text.splitlines() if line]


@pytest.mark.parametrize("name", Machine.names())
def test_built_in_round_trip_is_exact(name: str, tmp_path: Path) -> None:
    machine = Machine.load(name)
    file = tmp_path / "mine.toml"
    file.write_text(machine.to_toml())
    assert_same(machine, Machine.load(file))
    assert Machine.load(file).to_toml() == machine.to_toml()


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=() if kind == "head-table" else pytest.mark.sweep) for kind in CLASSES]
)
def test_random_round_trip_is_exact(kind: str) -> None:
    """Figures of all digits, joints in any order, skew directions; other tools, mountings and limits."""
    rng = np.random.default_rng(11)
    for _ in range(100):
        machine = random_machine(rng, kind)
        assert_same(machine, Machine.from_toml(machine.to_toml()))
    for name in Machine.names():
        machine = Machine.load(name)
        others = (
            machine.with_tool(float(rng.random())),
            machine.with_limits(machine.limits.scaled(*rng.uniform(0.1, 2.0, 3))),
            machine.mounted(origin=rng.normal(size=3).tolist(), x=(0.6, 0.8, 0.0)),
        )
        for other in others:
            assert_same(other, Machine.from_toml(other.to_toml()))


@pytest.mark.parametrize("name", Machine.names())
def test_built_in_figures_are_as_a_person_writes_them(name: str) -> None:
    for line in code(Machine.load(name).to_toml()):
        if not line.startswith(("name", "note", "columns", "workpiece = ", "tool = ")):
            figures = re.findall(r"[-+]?[0-9][-+.eE0-9]*", line.partition("=")[2])
            assert all(len(figure.lstrip("-")) <= LONGEST_FIGURE and "e" not in figure for figure in figures), line


@pytest.mark.parametrize("name", Machine.names())
def test_tables_are_in_the_order_of_the_chain_and_each_line_is_explained(name: str) -> None:
    machine = Machine.load(name)
    text = machine.to_toml()
    chain = machine.file.chain
    assert re.findall(r"^\[joints\.(\w+)\]", text, re.M) == [*chain.workpiece, *chain.tool]
    assert all("  # " in line for line in text.splitlines() if line)
    assert len({line.index("  # ") for line in text.splitlines() if line and not line.startswith("note")}) == 1


def test_units_are_those_of_the_shortest_figures() -> None:
    units = {name: units_of(Machine.load(name).file) for name in Machine.names()}
    assert units.pop("xyzab-trunnion-inch") == ("in", "deg")
    assert units.pop("paper-ab") == ("mm", "rad")
    assert set(units.values()) == {("mm", "deg")}
    assert units_of(random_machine(np.random.default_rng(1), "head-head").file)[1] == "rad"


def test_limits_and_travel_without_end_are_written() -> None:
    machine = Machine.load("xyzac-trunnion")
    free = machine.with_limits(machine.limits.scaled(jerk=math.inf))
    assert "jerk = inf" in free.to_toml()
    assert_same(free, Machine.from_toml(free.to_toml()))


def test_comments_say_what_the_oracle_finds() -> None:
    """Where 30 degrees take the tool axis, for every rotary joint of every built-in machine."""
    compared = 0
    for name in Machine.names():
        machine = Machine.load(name)
        for joint, says in re.findall(r"(\w+) \+30 deg leans the tool axis to \((.*?)\)", machine.to_toml()):
            q = np.where(np.array(machine.joints) == joint, math.radians(30.0), 0.0)
            np.testing.assert_allclose([float(x) for x in says.split(",")], oracle(machine, q)[1], atol=6e-4)
            compared += 1
        turns = r"(\w+) \+30 deg turns the tool axis that (\w+) \+30 leans to \((.*?)\) on to \((.*?)\)"
        for joint, other, before, after in re.findall(turns, machine.to_toml()):
            for moved, says in (((other,), before), ((joint, other), after)):
                q = np.where([each in moved for each in machine.joints], math.radians(30.0), 0.0)
                np.testing.assert_allclose([float(x) for x in says.split(",")], oracle(machine, q)[1], atol=6e-4)
            compared += 1
    assert compared == 2 * len(Machine.names())


def test_odd_names_are_escaped_where_they_are_written() -> None:
    """Machines made by a program are not read from a file; what they write can be."""
    file = Machine.load("xyzac-trunnion").file
    for name in ("a\x1b[31m", 'a"b\\', "a\nb = 1", "\u202e", "\x7f\x9b", "µ° text"):
        written = f"name = {toml_value(name)}"
        assert written.isprintable() and tomllib.loads(written) == {"name": name}
        joints = {name if each == "C" else each: joint for each, joint in file.joints.items()}
        chain = msgspec.structs.replace(file.chain, workpiece=("A", name))
        text = Machine(msgspec.structs.replace(file, name=name, joints=joints, chain=chain)).to_toml()
        read = tomllib.loads(text)
        assert read["name"] == name and name in read["joints"] and all(map(str.isprintable, text.splitlines()))
