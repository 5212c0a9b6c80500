"""A pass once round a blade, and the machine that it is planned on."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from tests.support.tool_paths import toolpath_through
from toolpace.cli import demo_programs


@pytest.fixture(scope="package")
def machine():
    return tp.Machine.load(demo_programs.MACHINE)


@pytest.fixture(scope="package")
def blade():
    """Once round a blade, as fast as the machine can."""
    return toolpath_through(*demo_programs.blade_flank(120), feed=np.inf)
