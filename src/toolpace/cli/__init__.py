"""The command `toolpace`: arguments in, exit code out, every error one line."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import TextIO

__all__ = ["main"]

LONGEST = 1000
"""Most characters of an error: names may have thousands."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when all is well, 1 when a verification failed, 2 when the input is at fault,
    and 128 and the number of the signal, as shells have it, where one ended it.

    Errors are one line on standard error. Where toolpace itself is at fault, TOOLPACE_DEBUG=1 shows where.
    """
    from toolpace.cli.process import ended_by, ending_signals, guarded, in_words
    from toolpace.common.errors import UnitWarning

    words = sys.argv[1:] if arguments is None else arguments
    # A hyphen alone would be taken for an option without a name.
    tokens = ["/dev/stdin" if token == "-" else token for token in words]
    with guarded() as output, ending_signals(), warnings.catch_warnings():
        if not sys.warnoptions:
            # What overflows in a damaged file is found wanting in one line; warnings would stand beside it.
            warnings.simplefilter("ignore", RuntimeWarning)
            warnings.simplefilter("default", UnitWarning)
        warnings.showwarning = _in_one_line
        try:
            code = _run(tokens)
            output.flush()
        except BaseException as error:
            signal = ended_by(error)
            if signal is None:
                raise
            code = _fail(in_words(signal), 128 + signal)
    if output.failure:
        return _fail(f"standard output: cannot write: {output.failure}", 2)
    return code


def _in_one_line(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning: a question about a figure as one, any other with the place in the code that gave it."""
    from toolpace.common.errors import UnitWarning, printable

    text = printable(" ".join(str(message).split()))
    is_question = issubclass(category, UnitWarning)
    shown = f"question: {text}" if is_question else f"warning: {text} ({category.__name__}, {filename}:{lineno})"
    with contextlib.suppress(OSError, UnicodeError, ValueError, AttributeError):
        print(shown, file=sys.stderr, flush=True)


def _run(tokens: list[str]) -> int:
    """The command's exit code, with every error that is none of a signal in one line."""
    from cyclopts import CycloptsError

    from toolpace.cli.app import app
    from toolpace.cli.process import ended_by
    from toolpace.common.errors import ToolpaceError

    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        return code if isinstance(code, int) else 0
    except ToolpaceError as error:
        return _fail(str(error), error.exit_code)
    except CycloptsError as error:
        from toolpace.cli.arguments import explain

        return _fail(explain(error, tokens), 2)
    except MemoryError:
        return _fail("out of memory; split the program, or take a longer --dt", 2)
    except Exception as error:
        if ended_by(error) is not None or os.environ.get("TOOLPACE_DEBUG"):
            raise
        return _fail(f"a fault in toolpace itself, {type(error).__name__}: {error}; TOOLPACE_DEBUG=1 shows where", 2)


def _fail(message: str, code: int) -> int:
    from toolpace.common.errors import printable

    line = "error: " + printable(" ".join(message.split()))
    if len(line) > LONGEST:
        # The beginning says where, the end how to cure it.
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    try:
        print(line, file=sys.stderr, flush=True)
    except (OSError, UnicodeError, ValueError, AttributeError):
        # Standard error is closed, full, or knows no such letters: the exit code tells.
        return code
    return code
