"""No test leans on another test, and none on the benchmarks."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SUPPORT = ("tests.support", "testbed", "toolpace")


def imports(file: Path) -> set[str]:
    """Names of the modules that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: write where it comes from in full"
            found.add(node.module or "")
    return found


def among(name: str, packages: tuple[str, ...]) -> bool:
    return any(name == package or name.startswith(f"{package}.") for package in packages)


@pytest.mark.parametrize("file", sorted((ROOT / "tests").rglob("*.py")), ids=lambda file: str(file.relative_to(ROOT)))
def test_what_is_shared_comes_from_support_or_testbed(file):
    own = {name for name in imports(file) if among(name, ("tests", "testbed", "toolpace", "benchmarks", "examples"))}
    assert all(among(name, SUPPORT) for name in own)


@pytest.mark.parametrize("file", sorted((ROOT / "testbed").rglob("*.py")), ids=lambda file: str(file.relative_to(ROOT)))
def test_testbed_knows_neither_tests_nor_benchmarks(file):
    assert not {name for name in imports(file) if among(name, ("tests", "benchmarks"))}
