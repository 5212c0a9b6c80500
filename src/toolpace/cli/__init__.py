"""The command `toolpace`: arguments in, exit code out, every error one line."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

__all__ = ["main"]

INTERRUPTED = 130
"""Exit code after Ctrl-C: 128 and the number of the signal, as shells have it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0 when all is well, 1 when a verification failed, 2 when the input is at fault.

    Errors are one line on standard error. Where toolpace itself is at fault, TOOLPACE_DEBUG=1 shows where.
    """
    from cyclopts import CycloptsError

    from toolpace.cli.app import app
    from toolpace.errors import ToolpaceError

    tokens = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except ToolpaceError as error:
        return _fail(str(error), error.exit_code)
    except CycloptsError as error:
        from toolpace.cli.arguments import explain

        return _fail(explain(error, tokens), 2)
    except KeyboardInterrupt:
        return _fail("interrupted; nothing was written", INTERRUPTED)
    except BrokenPipeError:
        # The reader (head, less) has gone; what is still in the buffer must not raise again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except MemoryError:
        return _fail("out of memory; split the program, or take a longer --dt", 2)
    except Exception as error:
        from toolpace.workers import interrupted

        if interrupted(error):
            return _fail("interrupted; nothing was written", INTERRUPTED)
        if os.environ.get("TOOLPACE_DEBUG"):
            raise
        return _fail(f"a fault in toolpace itself, {type(error).__name__}: {error}; TOOLPACE_DEBUG=1 shows where", 2)


def _fail(message: str, code: int) -> int:
    print("error: " + " ".join(message.split()), file=sys.stderr)
    return code
