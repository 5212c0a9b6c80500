"""One change tried on some tests, in a copy of the tree and a process of its own."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

KILLED, SURVIVED, LATE = "killed", "survived", "timed out"


def tried(tests: list[str], seconds: float) -> str:
    """Whether a test fails: the child has the libraries at hand, and imports toolpace anew."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.alarm(int(seconds) + 1)
            nowhere = os.open(os.devnull, os.O_RDWR)
            for handle in (0, 1, 2):
                os.dup2(nowhere, handle)
            code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-p", "no:randomly", *tests]))
        finally:
            os._exit(code)
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        return LATE
    return SURVIVED if status == 0 else KILLED


class ChangedFile:
    """A file with other text for a while."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text

    def __enter__(self) -> None:
        self.before = self.path.read_text(encoding="utf-8")
        self.path.write_text(self.text, encoding="utf-8")

    def __exit__(self, *_: object) -> None:
        self.path.write_text(self.before, encoding="utf-8")
