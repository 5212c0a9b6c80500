"""Clean ends after Ctrl-C and other signals."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from toolpace.common.files import finished
from toolpace.common.files.atomic import ENDING
from toolpace.common.workers import interrupted

_WORDS = {signal.SIGINT: "interrupted"}


class Ended(KeyboardInterrupt):
    """A signal that asks the process to end; whoever knows what to do at Ctrl-C does the same."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


@contextmanager
def heard() -> Iterator[None]:
    """Let the block meet signals that end a process as exceptions; what was written before is forgotten."""
    finished.clear()
    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in ENDING:
            # Who has set another way of dealing with it (nohup ignores SIGHUP) keeps it.
            if signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, _end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def ended_by(error: BaseException) -> int | None:
    """The signal behind an error, also one met by compiled code, which wraps it; None where there is none."""
    cause = error.__cause__ if interrupted(error) else error
    if not isinstance(cause, KeyboardInterrupt):
        return None
    return cause.number if isinstance(cause, Ended) else signal.SIGINT


def in_words(number: int) -> str:
    """What happened, and what there is of results."""
    word = _WORDS.get(signal.Signals(number), "ended from outside")
    if finished:
        return f"{word}; {', '.join(map(str, finished))} had been written, and is whole"
    return f"{word}; nothing was written"


def _end(number: int, frame: FrameType | None) -> NoReturn:
    raise Ended(number)
