"""The step as control code calls it: from C, compiled here, on a piece read from its file."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.arrays import Floats
from toolpace.deflection.following.law import read_law, write_law
from toolpace.kernels.follow import layout

PAGE = Path(__file__).parents[3] / "docs" / "design" / "follower.md"


@pytest.fixture(scope="module")
def follower() -> tp.Follower:
    machine = tp.Machine.load("paper-ab")
    return tp.Follower(tp.plan(tp.Path.paper_arc(), machine.reserved(0.1), bound=False), machine)


def test_lengths_of_the_page_are_those_of_the_kernel():
    text = PAGE.read_text(encoding="utf-8")
    assert f"`STATE` = {layout.STATE} " in text and (layout.INPUTS, layout.OVERRIDE, layout.OUTPUTS) == (14, 13, 45)


def test_places_of_the_page_are_those_of_the_kernel():
    """Of every constant that the page defines, and it defines all bits of the status, inputs and outputs."""
    text = PAGE.read_text(encoding="utf-8")
    told = {name: int(value) for name, value in re.findall(r"^#define (\w+) (\d+)", text, re.MULTILINE)}
    assert told == {name: getattr(layout, name) for name in told}
    bits = text.split("/* bits of the status */")[1].split("/*")[0]
    assert [int(value) for value in re.findall(r"#define \w+ (\d+)", bits)] == [each.value for each in tp.Status]
    assert {"TIP", "AXIS", "FORCE", "DEFLECTION", "OVERRIDE", "MEASURED_AT", "Q", "OUT_CORRECTION"} <= set(told)
    assert f"/* {layout.MAGIC:.0f} */" in text and f"/* {layout.VERSION:.0f} */" in text
    assert "step_for_c()" in text


def test_a_law_is_the_same_from_its_file(follower: tp.Follower, tmp_path: Path):
    follower.save(tmp_path / "arc.law")
    assert np.array_equal(read_law(tmp_path / "arc.law"), follower.piece)
    assert np.array_equal(tp.Follower.load(tmp_path / "arc.law").step().q, follower.step().q)
    with (tmp_path / "arc.law").open("ab") as file:
        file.write(b"more")
    with pytest.raises(tp.ToolpaceError, match="bytes where the law needs"):
        read_law(tmp_path / "arc.law")


def test_no_changed_byte_of_a_law_gets_to_the_kernel(follower: tp.Follower, tmp_path: Path):
    """Of counts and indices as of figures: a place in memory that is not the law's would be read."""
    follower.save(tmp_path / "arc.law")
    content, random = (tmp_path / "arc.law").read_bytes(), np.random.default_rng(2)
    places = [*range(0, 8 * layout.PATH, 3), *random.integers(0, len(content), 200)]
    for at in places:
        changed = bytearray(content)
        changed[at] ^= 1 << int(random.integers(8))
        (tmp_path / "changed.law").write_bytes(changed)
        with pytest.raises(tp.ToolpaceError, match=r"(no law|version|bytes where|was changed).*; write"):
            tp.Follower.load(tmp_path / "changed.law")
    old = follower.piece.copy()
    old[layout.HAS_VERSION] = 3.0
    (tmp_path / "old.law").write_bytes(old.tobytes())
    with pytest.raises(tp.ToolpaceError, match="a law of version 3, read is 4; write it anew"):
        tp.Follower.load(tmp_path / "old.law")


@pytest.mark.parametrize(
    "at, figure, words",
    [
        (layout.DELAY, np.nan, "figure 8 is no number"),
        (layout.PATH + 100, np.nan, f"figure {layout.PATH + 100} is no number"),
        (layout.PATH + 100, np.inf, "its path leads to infinity"),
        (-layout.TOOL_COLUMNS, np.inf, "a tool of it has no length"),
        (-1, -np.inf, "a tool of it has no length"),
        (layout.USED, 6.0, "its joints or its dead time make no sense"),
        (layout.USED, 2.5, "its joints or its dead time make no sense"),
        (layout.DEAD_TIME, -1.0, "its joints or its dead time make no sense"),
        (layout.PERIOD, 0.0, "its period is 0 s"),
        (layout.STEP, np.inf, "its step is inf s"),
        (layout.DURATION, np.inf, "it has no path"),
        (layout.PLACE, 77.0, "its joints are not five"),
        (layout.GROUP + 2, 1e300, "its joints are not five"),
    ],
)
def test_a_law_that_others_wrote_is_not_played_where_it_makes_no_sense(
    follower: tp.Follower, tmp_path: Path, at: int, figure: float, words: str
):
    piece = follower.piece.copy()
    piece[at] = figure
    write_law(tmp_path / "odd.law", piece)
    with pytest.raises(tp.ToolpaceError, match=f"{words}.*; write one with"):
        tp.Follower.load(tmp_path / "odd.law")


@pytest.mark.parametrize("back", range(1, 4 * layout.COLUMNS + 1))
def test_no_control_point_of_a_law_is_infinite(follower: tp.Follower, tmp_path: Path, back: int):
    """Of none of the last four, which the end of the path is made of."""
    piece = follower.piece.copy()
    last = layout.PATH + (int(piece[layout.SAMPLES]) + 3) * layout.COLUMNS
    piece[last - back] = np.inf if back % 2 else -np.inf
    write_law(tmp_path / "odd.law", piece)
    with pytest.raises(tp.ToolpaceError, match="its path leads to infinity"):
        tp.Follower.load(tmp_path / "odd.law")


@pytest.mark.sweep
@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_the_example_in_c_goes_where_python_goes(follower: tp.Follower, tmp_path: Path):
    from toolpace.kernels.follow.step import step_for_c

    follower.save(tmp_path / "arc.law")
    piece: Floats = np.fromfile(tmp_path / "arc.law", dtype="<f8")
    code = "#include <math.h>\n#include <stdint.h>\n" + "\n".join(
        re.findall(r"```c\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    )
    (tmp_path / "run.c").write_text(code)
    library = tmp_path / "run.so"
    command = ["gcc", "-Wall", "-Werror", "-O2", "-shared", "-fPIC", str(tmp_path / "run.c"), "-o", str(library)]
    subprocess.run(command, check=True, timeout=120)
    door, last, steps = step_for_c(), np.empty(5), 700
    follower.reset()
    state = follower.state.copy()
    run = ctypes.CDLL(str(library)).run
    run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]
    run(door.address, piece.ctypes.data, len(piece), state.ctypes.data, last.ctypes.data, steps)
    q = [follower.step().q for _ in range(steps)][-1]
    assert last == pytest.approx(q, abs=1e-15)
    assert not np.allclose(q, follower.piece[layout.PATH : layout.PATH + 5], atol=1e-3)
