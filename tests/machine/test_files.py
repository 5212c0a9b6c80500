"""Machine files: what is built in, what goes through, and one line of error for everything that does not."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.limits import Limits
from toolpace.machine.machine import FOLDER, Machine

TEXT = (FOLDER / "xyzac-trunnion.toml").read_text()


def test_built_in_names_and_classes() -> None:
    classes = {name: Machine.load(name).kind for name in Machine.names()}
    assert classes == {
        "linuxcnc-xyzac-trt": "table-table",
        "linuxcnc-xyzbc-bridgemill": "head-head",
        "paper-ab": "head-table",
        "xyzab-table": "table-table",
        "xyzab-trunnion-inch": "table-table",
        "xyzac-head": "head-head",
        "xyzac-trunnion": "table-table",
        "xyzbc-head": "head-head",
        "xyzbc-millturn": "head-table",
        "xyzbc-nutating": "head-table",
        "xyzbc-nutating-large": "head-table",
        "xyzbc-table": "table-table",
        "xyzbc-trunnion": "table-table",
    }


def test_units() -> None:
    machine = Machine.load("linuxcnc-xyzac-trt")
    np.testing.assert_allclose(machine.limits.velocity, [0.02, 0.02, 0.02, math.radians(30), math.radians(30)])
    np.testing.assert_allclose(machine.limits.jerk, [3, 3, 3, math.radians(3000), math.radians(3000)])
    np.testing.assert_allclose(machine.travel[:, 1], [0.2, 0.1, 0.12, math.radians(50), math.radians(36000)])
    wrap = Machine.load("xyzac-trunnion")
    assert wrap.wrap.tolist() == [False, False, False, False, True] and np.isinf(wrap.travel[4]).all()
    inch = Machine.from_toml(TEXT.replace('length = "mm"', 'length = "in"'))
    np.testing.assert_allclose(inch.limits.velocity[:3], 25.4 * wrap.limits.velocity[:3])


def test_description() -> None:
    machine = Machine.load("paper-ab")
    assert "head-table, workpiece < Y < X < B < bed > Z > A > tool" in repr(machine)
    row = machine.summary()[3]
    assert row["joint"] == "A" and row["carries"] == "tool" and row["velocity"] == "28.6479 deg/s"
    assert Machine.load("xyzac-trunnion").summary()[4]["travel"] == "endless"


def test_arrays_are_locked() -> None:
    machine = Machine.load("paper-ab")
    for array in (machine.travel, machine.geometry.frame, machine.limits.jerk):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_other_limits() -> None:
    machine = Machine.load("paper-ab")
    faster = machine.with_limits(machine.limits.scaled(jerk=2.0))
    assert faster.limits.jerk.tolist() == [400.0] * 5 and faster.limits.velocity.tolist() == [0.5] * 5
    with pytest.raises(UsageError, match="limits of 2 joints given, machine paper-ab has 5"):
        machine.with_limits(Limits([1, 1], [1, 1], [1, 1]))


def swap(old: str, new: str, count: int = 1) -> str:
    assert old in TEXT
    return TEXT.replace(old, new, count)


def columns(value: str) -> str:
    return swap("[units]", f"columns = {value}\n[units]")


BAD = {
    "misspelt limit": (
        swap("acceleration", "accelleration"),
        r"m.toml: \[joints.X\] unknown key 'accelleration'; did you mean 'acceleration'",
    ),
    "misspelt chain": (swap("spindle_nose", "nose"), r"\[chain\] unknown key 'nose'; known: workpiece, tool,"),
    "misspelt table": (swap("[units]", "[unit]"), r"unknown key 'unit'; did you mean 'units'"),
    "missing limit": (swap("jerk = 50000\n", ""), r"\[joints.X\] 'jerk' is missing"),
    "zero limit": (swap("jerk = 50000\n", "jerk = 0\n"), r"joint X: jerk = 0 mm/s\^3; give a number above zero"),
    "negative limit": (swap("jerk = 50000\n", "jerk = -1\n"), r"joint X: jerk = -1 mm/s\^3"),
    "nan limit": (swap("jerk = 50000\n", "jerk = nan\n"), r"joint X: jerk = nan mm/s\^3"),
    "text limit": (swap("jerk = 50000\n", 'jerk = "50"\n'), "joint X: jerk: .* '50' has no unit"),
    "wrong unit": (swap('length = "mm"', 'length = "cm"'), r"\[units\] length = 'cm' is not known; did"),
    "no travel": (swap("travel = [-500, 500]\n", ""), r"joint X: travel is missing; give travel ="),
    "reversed travel": (swap("travel = [-500, 500]", "travel = [500, -500]"), r"travel = \[500.0, -500.0\] mm is"),
    "travel and wrap": (swap("wrap = true", "wrap = true\ntravel = [-1, 1]"), r"joint C: has both travel and wrap"),
    "linear wrap": (swap("travel = [-500, 500]", "wrap = true"), r"joint X: wrap = true is for rotary joints"),
    "no direction": (swap("direction = [1, 0, 0]", "direction = [0, 0, 0]"), r"joint X: .* is no direction"),
    "plane": (swap("direction = [0, 1, 0]", "direction = [1, 0, 0]"), r"linear joints X, Y, Z lie in one plane"),
    "parallel": (swap("direction = [-1, 0, 0]", "direction = [0, 0, 1]"), r"rotary joints C and A are parallel"),
    "no tilt": (swap('workpiece = ["A", "C"]', 'workpiece = ["C", "A"]'), r"rotary joint C turns about the tool axis"),
    "unknown joint": (swap('"A", "C"', '"A", "D"'), r"\[chain\] workpiece names joint 'D', which has no table"),
    "idle joint": (swap('"A", "C"', '"A"'), r"joint C is in neither"),
    "twice": (swap('"A", "C"', '"A", "C", "X"'), r"joint X appears twice"),
    "four linear": (swap('kind = "rotary"', 'kind = "linear"'), r"4 linear and 1 rotary joints; .* need exactly"),
    "no point": (swap("point = [0, 0, 0]\n", ""), r"joint A: point is missing; .* like point = \[0, 0, 0\]"),
    "some columns": (columns('["X"]'), r'columns must name each joint once, .*\["X", "Y", "Z", "A", "C"\]'),
    "a column twice": (columns('["X", "X", "Y", "Z", "A", "C"]'), "columns must name each joint once"),
    "columns of what": (columns("3"), "columns must name each joint once"),
    "odd columns": (columns("[1, [2], {}, 4, 5]"), "columns must name each joint once"),
    "no chain": (swap("[chain]", "[chains]"), r"unknown key 'chains'; did you mean 'chain'"),
    "not toml": ("name = ", r"m.toml: not a TOML file"),
    "skew part": (swap("[chain]", "[chain]\nworkpiece_x = [1, 0, 1]"), r"not at a right angle"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_file(case: str) -> None:
    text, message = BAD[case]
    with pytest.raises(MachineError, match=message) as caught:
        Machine.from_toml(text, "m.toml")
    assert str(caught.value).startswith("m.toml: ") and "\n" not in str(caught.value)


def test_unknown_machine_lists_the_known() -> None:
    with pytest.raises(
        MachineError, match=r"unknown machine 'xyzac-trunion'; did you mean 'xyzac-trunnion'\? built-in: "
    ):
        Machine.load("xyzac-trunion")
    with pytest.raises(MachineError, match=r"unknown machine 'foo'; built-in: linuxcnc-xyzac-trt, linuxcnc-"):
        Machine.load("foo")
    with pytest.raises(MachineError, match=r"machine file gone.toml: No such file"):
        Machine.load("gone.toml")


def test_binary_file(tmp_path: Path) -> None:
    file = tmp_path / "m.toml"
    file.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(MachineError, match="not a text file"):
        Machine.load(file)


def test_limits() -> None:
    limits = Limits(1.0, [2.0, 3.0], math.inf)
    assert limits.joints == ("q1", "q2") and limits.velocity.tolist() == [1.0, 1.0] and len(limits) == 2
    with pytest.raises(UsageError, match="acceleration of joint q2 is nan"):
        Limits(1.0, [2.0, math.nan], 1.0)
    with pytest.raises(UsageError, match="velocity of joint X is 0"):
        Limits(0.0, 1.0, 1.0, ("X",))
    with pytest.raises(UsageError, match=r"jerk has shape \(3,\) for 2 joints"):
        Limits([1, 1], [1, 1], [1, 1, 1], ("X", "Y"))


BEYOND = {
    "deep": ("velocity = 500", "velocity = " + "[" * 5000 + "]" * 5000, "too deep"),
    "a far point": ("point = [0, 0, 0]", "point = [1e300, 0, 0]", r"joint A: point = \[1e\+297.*beyond 1000 m"),
    "no point": ("point = [0, 0, 0]", "point = [nan, 0, 0]", "joint A: point = .*finite"),
    "too fast": ("velocity = 500", "velocity = 1e300", r"velocity = 1e\+300 mm/s is beyond any joint; give"),
    "too slow": ("velocity = 500", "velocity = 1e-300", "velocity = 1e-300 mm/s is beyond any joint; give"),
    "a long integer": ("velocity = 500", "velocity = " + "9" * 5000, "4300 digits"),
    "a large integer": ("velocity = 500", "velocity = " + "9" * 400, "out of range"),
    "no double": ("velocity = 500", "velocity = 1e400", "1e400 is too large"),
    "minus zero": ("velocity = 500", "velocity = -0.0", "above zero"),
    "tool": ("tool_length = 150", "tool_length = 1e300", "tool_length is 1e.297 m"),
    "nose": ("spindle_nose = [0, 0, 220]", "spindle_nose = [0, 0, -inf]", "spindle_nose"),
    "direction": ("direction = [1, 0, 0]", "direction = [1e300, 0, 0]", "no direction"),
    "travel": ("travel = [-500, 500]", "travel = [-1e300, 1e300]", "give ends within"),
    "no travel": ("travel = [-500, 500]", "travel = [nan, 500]", "lower end first"),
    "cursor": ('name = "xyzac-trunnion"', 'name = "\\u001b[31m"', r"name '\\x1b\[31m' has characters that cannot"),
    "direction of writing": ('name = "xyzac-trunnion"', 'name = "\\u202ered"', "cannot be printed"),
    "no name": ('name = "xyzac-trunnion"', 'name = " "', "name is empty"),
    "a long name": ('name = "xyzac-trunnion"', 'name = "' + "x" * 5000 + '"', "5000 characters; give at most 64"),
    "note": ('note = "cradle', 'note = "\\u009b31m', r"note '\\x9b31m"),
    "joint": ("[joints.X]", '[joints."X\\u001b"]', r"joint 'X\\x1b' has"),
    "no joint": ("[joints.X]", '[joints.""]', "joint is empty"),
    "a long key": ("jerk = 50000", "j" * 50_000 + " = 5", "unknown key 'j{40}'"),
    "a large file": ("[units]", "#" + "x" * 200_000 + "\n[units]", "more than 100000 characters"),
}


@pytest.mark.parametrize("case", BEYOND)
def test_figures_and_names_beyond_all_bounds_are_one_line(case, tmp_path):
    old, new, says = BEYOND[case]
    text = (FOLDER / "xyzac-trunnion.toml").read_text()
    assert old in text
    file = tmp_path / "mill.toml"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(MachineError, match=says) as caught:
        Machine.load(file)
    message = str(caught.value)
    assert str(file) in message and message.isprintable() and len(message) < 500


@pytest.mark.parametrize("name", ["nul\0", "x" * 5000, "\udcff.toml", "/dev/zero", "/dev/null", "."])
def test_what_is_no_machine_file_is_one_line(name):
    with pytest.raises(MachineError) as caught:
        Machine.load(name)
    assert str(caught.value).isprintable()


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    (tmp_path / "mill.toml").write_bytes(b"\xef\xbb\xbf" + (FOLDER / "xyzac-trunnion.toml").read_bytes())
    assert Machine.load(tmp_path / "mill.toml").name == "xyzac-trunnion"
