"""What a command does not need is not imported: `--help` answers at once."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numpy", "numba", "scipy", "toolpace.judge", "toolpace.planning", "toolpace.programs.reading")


@pytest.mark.parametrize("asked", [["--help"], ["plan", "--help"], ["--version"]])
def test_help_imports_no_numbers(asked: list[str]):
    text = (
        "import sys, toolpace.cli\n"
        "try:\n    toolpace.cli.main(sys.argv[1:])\nexcept SystemExit:\n    pass\n"
        "print('IMPORTED', *sorted(sys.modules))"
    )
    said = subprocess.run([sys.executable, "-c", text, *asked], capture_output=True, text=True, check=True).stdout
    imported = set(said.rpartition("IMPORTED")[2].split())
    assert "toolpace.cli.app" in imported
    assert not imported.intersection(HEAVY)
