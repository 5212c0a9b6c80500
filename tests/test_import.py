"""`import toolpace` is light, and its functions survive the import of the folders of the same name."""

from __future__ import annotations

import subprocess
import sys

import pytest

import toolpace as tp

HEAVY = ("numba", "scipy", "plotly", "matplotlib", "rich", "cyclopts", "msgspec", "numpy")


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_import_loads_no_heavy_library():
    loaded = python(f"import sys, toolpace; print([m for m in {HEAVY} if m in sys.modules])")
    assert loaded == "[]"


def test_import_takes_less_than_300_ms():
    times = python(
        "import subprocess, sys, time\n"
        "def best(code):\n"
        "    times = []\n"
        "    for _ in range(5):\n"
        "        began = time.perf_counter()\n"
        "        subprocess.run([sys.executable, '-c', code], check=True)\n"
        "        times.append(time.perf_counter() - began)\n"
        "    return min(times)\n"
        "print(best('import toolpace') - best('pass'))"
    )
    assert float(times) < 0.3


def test_reading_and_machines_need_neither_scipy_nor_plotly():
    code = (
        "import sys, toolpace as tp; tp.Machine.load('paper-ab'); tp.read; "
        "print([m for m in ('scipy', 'plotly') if m in sys.modules])"
    )
    assert python(code) == "[]"


def test_deflect_is_reached_as_an_attribute():
    assert python("import toolpace as tp; print(tp.deflect.replan.__name__)") == "replan"


@pytest.mark.parametrize(
    "first, second", [("plan", "read"), ("read", "verify"), ("verify", "report"), ("report", "plan")]
)
def test_functions_win_over_folders_in_any_order(first, second):
    code = (
        f"import toolpace.{first}\n"
        "import toolpace as tp\n"
        f"tp.{second}\n"
        f"import toolpace.{second}, toolpace.plan.optimal, toolpace.report.words\n"
        f"from toolpace import {first}\n"
        f"assert {first} is tp.{first} and callable(tp.{first}) and callable(tp.{second})\n"
        f"from toolpace.{first} import {first} as direct\n"
        f"assert direct is {first}\n"
        "import sys\n"
        f"assert sys.modules['toolpace.{first}'].{first} is direct"
    )
    python(code)


def test_every_public_name_is_there():
    for name in tp.__all__:
        assert getattr(tp, name) is not None
    assert set(dir(tp)) == set(tp.__all__)


def test_unknown_name_lists_the_known_ones():
    with pytest.raises(AttributeError, match=r"it has .*Machine.*plan"):
        tp.planner  # noqa: B018
