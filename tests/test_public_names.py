"""`import toolpace` is light, and its functions survive the import of the folders of the same name."""

from __future__ import annotations

import subprocess
import sys

import pytest

import toolpace as tp

HEAVY = ("numba", "scipy", "matplotlib", "rich", "cyclopts", "msgspec", "numpy")


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_import_loads_no_heavy_library():
    loaded = python(f"import sys, toolpace; print([m for m in {HEAVY} if m in sys.modules])")
    assert loaded == "[]"


def test_import_loads_next_to_nothing():
    """What keeps it short: few modules, all of them Python's, and of its own the package and its version alone."""
    loaded = python(
        "import sys; before = set(sys.modules); import toolpace; print(*sorted(set(sys.modules) - before))"
    ).split()
    own = {name for name in loaded if name.partition(".")[0] == "toolpace"}
    assert own == {"toolpace", "toolpace.common"}
    assert {name.partition(".")[0] for name in set(loaded) - own} <= sys.stdlib_module_names
    assert len(loaded) < 60


def test_reading_and_machines_need_no_scipy():
    code = (
        "import sys, toolpace as tp; tp.Machine.load('paper-ab'); tp.read; "
        "print([m for m in ('scipy',) if m in sys.modules])"
    )
    assert python(code) == "[]"


def test_deflection_is_reached_as_an_attribute():
    assert python("import toolpace as tp; print(tp.deflection.replan.__name__)") == "replan"


def test_no_public_function_is_named_like_a_module():
    code = (
        "import importlib, pkgutil, toolpace as tp\n"
        "rooms = {m.name for m in pkgutil.iter_modules(tp.__path__)}\n"
        "for room in sorted(rooms - {'__main__'}):\n"
        "    importlib.import_module('toolpace.' + room)\n"
        "print(sorted(rooms & set(tp.__all__)), callable(tp.plan), callable(tp.read), callable(tp.verify))"
    )
    assert python(code) == "['deflection'] True True True"


def test_every_public_name_is_there():
    for name in tp.__all__:
        assert getattr(tp, name) is not None
    assert set(dir(tp)) == set(tp.__all__)


def test_unknown_name_lists_the_known_ones():
    with pytest.raises(AttributeError, match=r"it has .*Machine.*plan"):
        tp.planner  # noqa: B018
