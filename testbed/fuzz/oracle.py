"""What reading may do with any input: a sound result, or one of the library's own errors in one printable line."""

from __future__ import annotations

import signal
import time
import traceback
import tracemalloc
import warnings
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np

from toolpace.common.errors import ToolpaceError
from toolpace.programs.toolpath import ToolPath

SECONDS = 2.0
"""CPU time that an input of some kilobytes may take."""
SECONDS_A_POINT = 20e-6
"""More for every point of its path: few words may ask for many."""
LONGEST_MESSAGE, LONGEST_LIST = 2000, 10_000
"""Characters of a message, and of one that lists many kinds of refused words."""
MEMORY_A_BYTE, MEMORY, MEMORY_A_POINT = 10.0, 64e6, 1500.0
"""Bytes that reading may take for a byte of input, for any input, and for a point of its path."""


SLOW = ("slow", "no end")
"""Kinds of what goes wrong that take long to be tried again."""


class Wrong(Exception):
    """What must not be; `kind` is the same for what goes wrong in the same way."""

    def __init__(self, kind: str, told: str = "") -> None:
        super().__init__(kind if not told else f"{kind}\n{told}")
        self.kind = kind


class _OverdueError(BaseException):
    """Not caught by what is tried."""


def tried(read: Callable[[], ToolPath | None], *, weighed: int = 0) -> ToolpaceError | None:
    """Read, and judge what comes of it: None, or the error it ended with. Raises Wrong.

    weighed: bytes of the input, where the memory is to be measured too (which takes several times as long).
    """
    began = time.process_time()
    limit = SECONDS * (5 if weighed else 1)
    signal.signal(signal.SIGVTALRM, _overdue)
    signal.setitimer(signal.ITIMER_VIRTUAL, 3.0 * limit)
    if weighed:
        tracemalloc.start()
    path, error = None, None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            path = read()
    except ToolpaceError as raised:
        error = raised
        _judge_message(str(raised))
    except _OverdueError:
        raise Wrong("no end", f"after {3 * limit:g} s") from None
    except Wrong:
        raise
    except BaseException as raised:
        raise Wrong(_kind(raised), traceback.format_exc(limit=-8)) from None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        peak = tracemalloc.get_traced_memory()[1] if weighed else 0
        tracemalloc.stop()
    points = 0 if path is None else len(path)
    if path is not None:
        _judge_path(path)
    if (taken := time.process_time() - began) > limit + SECONDS_A_POINT * points:
        raise Wrong("slow", f"{taken:.3g} s for {points} points")
    if peak > MEMORY_A_BYTE * weighed + MEMORY + MEMORY_A_POINT * points:
        raise Wrong("memory", f"{peak / 1e6:.4g} MB for {weighed} bytes and {points} points")
    return error


def _overdue(signal_number: int, frame: FrameType | None) -> None:
    raise _OverdueError


def _kind(error: BaseException) -> str:
    """The error and the innermost place in toolpace that it went through."""
    places = [frame for frame in traceback.extract_tb(error.__traceback__) if "toolpace" in frame.filename]
    place = f" in {Path(places[-1].filename).name}:{places[-1].name}:{places[-1].lineno}" if places else ""
    return f"{type(error).__name__}{place}"


def _judge_message(message: str) -> None:
    if not message.strip() or not message.isprintable():
        raise Wrong("message that is no printable line", repr(message)[:500])
    if len(message) > (LONGEST_LIST if "kinds of words" in message else LONGEST_MESSAGE):
        raise Wrong("long message", f"{len(message)} characters: {message[:300]}")


def _judge_path(path: ToolPath) -> None:
    n = len(path)
    shapes = n >= 2 and path.tip.shape == (n, 3) == path.axis.shape
    finite = [path.tip, path.axis, path.least_time, path.dwell, *([path.rotary] if path.rotary is not None else [])]
    sound = {
        "shapes": shapes,
        "finite": all(bool(np.isfinite(values).all()) for values in finite),
        "feed": bool((path.feed > 0).all()),
        "times": bool((path.least_time >= 0).all() and (path.dwell >= 0).all()),
        "unit axes": shapes and bool(np.abs(np.linalg.norm(path.axis, axis=1) - 1.0).max() < 1e-9),
        "rests at both ends": shapes and bool(path.stop[0] and path.stop[-1]),
        "blocks": bool((path.block >= 1).all()),
        "operations": len(path.operation) in (0, n) and bool((path.operation < len(path.operations)).all()),
        "printable": all(text.isprintable() for text in (*path.assumed, *path.skipped)),
    }
    for what, holds in sound.items():
        if not holds:
            raise Wrong(f"a path that is not sound: {what}")
