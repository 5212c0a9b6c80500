"""One-line descriptions of objects: the `repr` of all public classes."""

from __future__ import annotations

from collections.abc import Sequence

LONGEST = 120
"""Most characters of a line."""
LONGEST_NAMES = 40
"""Most characters of a list of names in it."""


def one_line(thing: object, *parts: str) -> str:
    """`<Class part, part, ...>`, no longer than a line; parts that are empty are left out.

    Names come from files and callers: what cannot be printed is shown as `?`, and never moves a terminal's cursor.
    """
    text = ", ".join(part for part in parts if part)
    line = f"{type(thing).__name__} {text}" if text else type(thing).__name__
    printed = "".join(c if c.isprintable() else "?" for c in line)
    return f"<{shortened(printed, LONGEST - 2)}>"


def named(joints: Sequence[str]) -> str:
    """How many joints, and which: "5 joints X Y Z A C"."""
    return f"{counted(len(joints), 'joint')} {shortened(' '.join(joints), LONGEST_NAMES)}"


def counted(count: int, noun: str) -> str:
    """ "1 run", "3 runs"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def shortened(text: str, most: int) -> str:
    """The text, or as much of it as fits, and three dots."""
    return text if len(text) <= most else text[: most - 3] + "..."
