"""The errors and warnings that a user can cause: one line with what, where, the figures and the cure."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST_FAULT = 300
"""Characters that a message quotes of what a library says."""


def printable(text: str) -> str:
    """The text with what cannot be printed written out, as \\x1b: names come from files and callers, and a message
    that holds one is still one line that moves no terminal's cursor."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "surrogatepass").decode() for c in text)


class ToolpaceError(Exception):
    """Base of all errors that toolpace raises on purpose; a command ends with `exit_code` and the message alone."""

    exit_code = 2

    def __init__(self, message: str = "") -> None:
        super().__init__(printable(message))


class UsageError(ToolpaceError):
    """An argument that makes no sense, whatever the program and the machine."""


class ProgramError(ToolpaceError):
    """A program that cannot be read, or asks for what cannot be done."""

    def __init__(self, message: str, *, source: str = "", line: int = 0, text: str = "") -> None:
        place = f"{source}:{line}: " if line else f"{source}: " if source else ""
        shown = f" in '{text.strip()[:60]}'" if text.strip() else ""
        super().__init__(f"{place}{message}{shown}")
        self.source, self.line, self.text = source, line, text


class FeedMissingError(ProgramError):
    """A program that tells no feed: it is read with one that is given."""


class MachineError(ToolpaceError):
    """A machine file that is missing, misspelt or contradicts itself."""


class ReachError(ToolpaceError):
    """A pose that the machine cannot take: a tilt out of reach, or travel exceeded."""


class PathError(ToolpaceError):
    """A path that cannot be followed smoothly."""


class InfeasibleError(ToolpaceError):
    """A state or a path that no motion within the limits can start from, end in or follow."""


class ClusterError(ToolpaceError):
    """A cluster that is not there, or went away."""


class VerificationError(ToolpaceError):
    """Set-points that break a limit, a feed or a tolerance."""

    exit_code = 1


class UnitWarning(UserWarning):
    """A question: a figure that can hardly be meant as it stands, and the unit that it is likely in."""


def in_short(error: Exception) -> str:
    """What an error says, as far as fits on a few lines: names in a file may be as long as one likes."""
    return text if len(text := str(error)) <= LONGEST_FAULT else f"{text[:LONGEST_FAULT]}..."


def did_you_mean(word: str, names: Iterable[str]) -> str:
    """A hint that ends a message: the nearest known word, or all of them."""
    choices = list(names)
    close = difflib.get_close_matches(word, choices, n=1, cutoff=0.6)
    return f"did you mean '{close[0]}'?" if close else f"known: {', '.join(choices)}"
