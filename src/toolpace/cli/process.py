"""Standard output that may be closed early, and clean ends after Ctrl-C and other signals."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from types import FrameType
from typing import NoReturn, TextIO

from toolpace.common.files import finished
from toolpace.common.files.atomic import ENDING
from toolpace.common.workers import interrupted

GONE = (errno.EPIPE, errno.EBADF)
"""Nobody reads any more (head, less), or it was closed from the start: not a fault."""
_WORDS = {signal.SIGINT: "interrupted"}


class Output(io.TextIOBase):
    """Writes to a stream for as long as that takes it; characters that it cannot show become question marks."""

    def __init__(self, stream: TextIO | None) -> None:
        """`stream` is None where the process was started without standard output."""
        self.stream = stream
        self.failure = ""
        """Why not all of the output was taken; empty where it was, or nobody wants it."""

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Of the stream."""
        return getattr(self.stream, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        """Whether people look at it as it comes."""
        return self.stream is not None and self.stream.isatty()

    def fileno(self) -> int:
        """Of the stream, which a terminal's width is asked of."""
        if self.stream is None:
            raise io.UnsupportedOperation("standard output is closed")
        return self.stream.fileno()

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, text: str) -> int:
        """Write as much as is taken."""
        if self.stream is not None:
            try:
                self.stream.write(text.encode(self.encoding, "replace").decode(self.encoding))
            except OSError as error:
                self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Pass on what is in the buffer."""
        if self.stream is not None:
            try:
                self.stream.flush()
            except OSError as error:
                self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        if error.errno not in GONE:
            self.failure = (error.strerror or str(error)).lower()
        stream, self.stream = self.stream, None
        try:
            # What is still in the buffer must not raise again when the interpreter ends.
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno() if stream is not None else 1)
            os.close(nowhere)
        except (OSError, ValueError):
            return


@contextmanager
def guarded() -> Iterator[Output]:
    """Standard output that never raises while the block runs."""
    output = Output(sys.stdout)
    with redirect_stdout(output):
        yield output
        output.flush()


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
