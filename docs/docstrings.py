"""Docstrings are plain prose; this makes reStructuredText of them.

    `name`                       code
    |q'|, a*b, *q                 as they stand: no markup is meant
    an indented block            as it stands, in a frame
    lines of "name: what it is"  a list
"""

from __future__ import annotations

import re
from dataclasses import is_dataclass
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.inspect import signature, stringify_signature

ALIAS = re.compile(r"TypeAliasForwardRef\('([^']*)'\)")
MARKUP = re.compile(r"[*|\\]|_(?=\W|$)")
ENTRY = re.compile(r"\w+: ")


def as_markup(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Rewrite the lines of one docstring in place, as autodoc asks for it."""
    paragraphs = re.split(r"\n\s*\n", "\n".join(lines).strip("\n"))
    lines[:] = [*"\n\n".join(map(_paragraph, paragraphs)).split("\n"), ""]


def with_short_types(
    app: Any, what: str, name: str, thing: Any, options: Any, arguments: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """A signature with the names of array types as they stand in the code, in nested types too.

    What a dataclass makes anew for each object shows as `...`: "<factory>" is no Python. A dataclass that looks at its
    options before they are taken (`__new__`) shows the options themselves.
    """
    if what == "class" and is_dataclass(thing) and thing.__new__ is not object.__new__:
        arguments = stringify_signature(signature(thing.__init__, bound_method=True), unqualified_typehints=True)
    texts = (None if text is None else text.replace("<factory>", "...") for text in (arguments, result))
    short = [None if text is None else ALIAS.sub(r"\1", text) for text in texts]
    return short[0], short[1]


def _paragraph(text: str) -> str:
    rows = text.split("\n")
    if rows[0].startswith(" "):
        return ".. code-block:: text\n\n" + "\n".join(f"   {row}" for row in rows)
    if any(row.startswith(" ") for row in rows) and all(ENTRY.match(row) for row in rows if not row.startswith(" ")):
        return "\n".join("  " + _escaped(row.strip()) if row.startswith(" ") else _entry(row) for row in rows)
    return "\n".join(_escaped(row.strip()) for row in rows)


def _entry(row: str) -> str:
    name, _, rest = row.partition(": ")
    return f"* `{name}`: {_escaped(rest)}"


def _escaped(row: str) -> str:
    """The row with what would be markup outside backquotes made harmless."""
    parts = row.split("`")
    parts[::2] = [MARKUP.sub(lambda found: "\\" + found.group(), part) for part in parts[::2]]
    return "`".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", as_markup)
    app.connect("autodoc-process-signature", with_short_types)
    return {"parallel_read_safe": True}
