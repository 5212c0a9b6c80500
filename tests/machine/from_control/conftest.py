"""Tests that run the real LinuxCNC are skipped where it is missing, but in CI (tests/conftest.py)."""

from __future__ import annotations

import pytest

from testbed.linuxcnc.instance import missing


@pytest.fixture(autouse=True)
def _installed(request):
    if request.node.get_closest_marker("linuxcnc") and missing():
        pytest.skip(missing())
