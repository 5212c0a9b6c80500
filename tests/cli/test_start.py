"""What a command does not need is not imported: `--help` answers at once, a short plan soon."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("numpy", "numba", "scipy", "toolpace.judge", "toolpace.planning", "toolpace.programs.reading")
NOT_FOR_A_PLAN = (
    "scipy.interpolate", "scipy.optimize", "scipy.sparse", "scipy.spatial", "scipy.special", "scipy.stats",
    "matplotlib", "pandas", "pyarrow", "toolpace.setup_search", "toolpace.study",
)  # fmt: skip
PROGRAM = "G21 G90 G54\nG43.4 H1\nG1 X10 Y0 Z10 A0 C0 F1000\nX20 Y5\nX30 Y5 A5\nX40 Y0\nM30\n"


def imported_by(arguments: list[str]) -> set[str]:
    """Names of the modules that a command has imported when it ends."""
    text = (
        "import sys, toolpace.cli\n"
        "try:\n    toolpace.cli.main(sys.argv[1:])\nexcept SystemExit as end:\n    assert not end.code, end.code\n"
        "print('IMPORTED', *sorted(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", text, *arguments], capture_output=True, text=True, check=True)
    return set(run.stdout.rpartition("IMPORTED")[2].split())


@pytest.mark.parametrize("arguments", [["--help"], ["plan", "--help"], ["--version"]])
def test_help_imports_no_numbers(arguments: list[str]):
    imported = imported_by(arguments)
    assert "toolpace.cli.app" in imported
    assert not imported.intersection(HEAVY)


def test_a_plan_imports_no_more_than_it_uses(tmp_path: Path):
    program, out = tmp_path / "part.ngc", tmp_path / "out"
    program.write_text(PROGRAM)
    imported = imported_by(["plan", str(program), "-m", "xyzac-trunnion", "--out", str(out)])
    assert (out / "report.html").is_file() and "toolpace.planning.bound.continuous" in imported
    assert not imported.intersection(NOT_FOR_A_PLAN)
