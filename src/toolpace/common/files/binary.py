"""A binary file, read by a function; one error that names it where it is missing, damaged or another thing."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeVar

from toolpace.common.errors import UsageError
from toolpace.common.files.atomic import reason

Content = TypeVar("Content")
AGAIN = "plan again, into a new folder"


def read_binary(
    path: str | os.PathLike[str], read: Callable[[BinaryIO], Content], missing: str, what: str
) -> Content:
    """What `read` makes of the open file.

    `missing` says where such a file comes from, `what` what it ought to be ("a trajectory"). Whatever a reader of
    damaged bytes may raise, and a UsageError of it, becomes a UsageError that begins with the file.
    """
    source = Path(path)
    try:
        with source.open("rb") as stream:
            return read(stream)
    except FileNotFoundError:
        raise UsageError(f"{source}: no such file; {missing}") from None
    except OSError as error:
        raise UsageError(f"{source}: cannot read: {reason(error)}") from None
    except UsageError as error:
        raise UsageError(f"{source}: {error}; {AGAIN}") from None
    except (ValueError, LookupError, TypeError, ArithmeticError, RecursionError):
        raise UsageError(f"{source}: damaged or not {what}; {AGAIN}") from None
