"""Which tests run: long sweeps only where asked for; in CI none that needs a browser or LinuxCNC is left out."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Generator

import pytest

INSTALLED_IN_CI = {"browser": "Chromium", "linuxcnc": "LinuxCNC"}
"""What tests of a marker need."""
IN_CI = os.environ.get("CI", "").lower() in ("1", "true", "yes")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--sweep", action="store_true", help="run the long sweeps too (CI=true does so as well)")
    parser.addoption("--thorough", action="store_true", help="run those that take hours too")


def pytest_configure(config: pytest.Config) -> None:
    """Before many processes run the tests, compile the kernels once, on all cores."""
    # What was started in the background ignores these signals, and so do its children.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        from toolpace.kernels import ahead_of_time

        ahead_of_time.warm_up()


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What the collection makes lives to the end: the collector of garbage need not look through it again and again.

    Nor need it look after every 700 objects, where a test makes millions.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(10_000, 10, 10)
        gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    left_out = [] if config.getoption("--thorough") else ["thorough"]
    if not (IN_CI or config.getoption("--sweep") or config.getoption("--thorough")):
        left_out.append("sweep")
    dropped = [item for item in items if any(map(item.get_closest_marker, left_out))]
    if dropped:
        config.hook.pytest_deselected(items=dropped)
        items[:] = [item for item in items if not any(map(item.get_closest_marker, left_out))]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """CI has what these tests need; one that is skipped there has silently stopped testing."""
    report = yield
    missing = next((name for marker, name in INSTALLED_IN_CI.items() if item.get_closest_marker(marker)), "")
    if IN_CI and report.skipped and missing:
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid} was skipped in CI, where {missing} is installed: {report.longrepr}"
    return report
