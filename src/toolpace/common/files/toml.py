"""TOML text from tables of numbers and strings, exact to the last digit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(table: Mapping[str, Any], above: str = "") -> str:
    """The text of a table: numbers, words and lists of them first, then the tables in it under their headings.

    above: heading of the table itself, where it stands in another.
    """
    text = "\n".join(_lines(table, above)).strip("\n")
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def _lines(table: Mapping[str, Any], above: str) -> list[str]:
    inner = {key: value for key, value in table.items() if _is_table(value) or _is_tables(value)}
    lines = [f"{toml_key(key)} = {toml_value(value)}" for key, value in table.items() if key not in inner]
    if above and (lines or not inner):
        lines = [f"[{above}]", *lines]
    for key, value in inner.items():
        heading = f"{above}.{toml_key(key)}" if above else toml_key(key)
        if _is_table(value):
            lines += ["", *_lines(value, heading)]
            continue
        for each in value:
            lines += ["", f"[[{heading}]]", *_lines(each, "")]
    return lines


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def _is_tables(value: object) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(_is_table(each) for each in value)


def toml_key(key: str) -> str:
    """A key as it is written: in quotes where it must be."""
    return key if _BARE.fullmatch(key) else toml_value(key)


def toml_value(value: bool | str | float | Sequence[Any]) -> str:
    """A word in quotes, a number, or a list of them; what cannot be printed is written as its number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
    if isinstance(value, (int, float)):
        return repr(value)
    return "[" + ", ".join(map(toml_value, value)) + "]"
