"""What toolpace needs: bounded above, and in step with the versions that are tested together."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NEEDED = [Requirement(text) for text in PROJECT["dependencies"]]
EXTRAS = [Requirement(text) for texts in PROJECT["optional-dependencies"].values() for text in texts]
LOCKED = {
    name: Version(number)
    for name, number in re.findall(r"^([a-z0-9-]+)==(\S+)$", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
}


@pytest.mark.parametrize("needed", NEEDED, ids=str)
def test_what_users_install_has_an_upper_bound_and_is_tested_within_it(needed):
    kinds = {each.operator for each in needed.specifier}
    assert kinds == {">=", "<"}
    assert version(needed.name) in needed.specifier


def test_the_kernels_store_meets_no_numba_that_it_was_not_tested_with():
    """It uses parts of numba that no promise covers: the bound is the next minor version after the one tested."""
    numba = next(each for each in NEEDED if each.name == "numba")
    tested = LOCKED["numba"]
    assert f"<{tested.major}.{tested.minor + 1}" in {str(each) for each in numba.specifier}


@pytest.mark.parametrize("needed", [*NEEDED, *EXTRAS], ids=str)
def test_the_lock_holds_a_version_that_is_allowed(needed):
    name = re.sub(r"[-_.]+", "-", needed.name).lower()
    assert LOCKED[name] in needed.specifier


def test_every_line_of_the_lock_is_one_version():
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    assert len(LOCKED) == len([line for line in lines if line and not line.startswith("#")]) > 50
    assert "toolpace" not in LOCKED
