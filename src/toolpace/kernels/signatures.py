"""The signatures of the kernels of a first run, as text (`signatures.json`).

It tells what to compile before anything is called, so that many processes can share the work.
`python tools/first_run.py --record` writes it anew after a kernel's arguments have changed.

A type is `int64`, `float64[2]` for an array of two dimensions in C order, `float64[2, read-only]`, or a list: the class
of a record, or `tuple`, and the types within.
"""

from __future__ import annotations

import importlib
import json
import re
from pathlib import Path
from typing import Any

import numba

FILE = Path(__file__).with_name("signatures.json")
ARRAY = re.compile(r"(\w+)\[(\d+)(?:, layout ([AF]))?(, read-only)?\]")

types: Any = numba.types
Text = str | list[Any]
"""A type as it is written."""


def read_signatures() -> dict[str, list[Text]]:
    """Signature of each kernel, by its name."""
    found: dict[str, list[Text]] = json.loads(FILE.read_text("utf-8"))
    return found


def write_signatures(signatures: dict[str, list[Text]]) -> None:
    """Write them, one kernel a line."""
    rows = [f"{json.dumps(name)}: {json.dumps(kinds)}" for name, kinds in sorted(signatures.items())]
    FILE.write_text("{\n" + ",\n".join(rows) + "\n}\n", "utf-8")


def to_text(kind: Any) -> Text:
    """A type of numba's, written; raises ValueError for one that a kernel should not take."""
    kind = types.unliteral(kind)
    if isinstance(kind, types.Array) and kind.aligned:
        layout = "" if kind.layout == "C" else f", layout {kind.layout}"
        return f"{kind.dtype}[{kind.ndim}{layout}{'' if kind.mutable else ', read-only'}]"
    if isinstance(kind, types.BaseTuple):
        record = getattr(kind, "instance_class", None)
        name = "tuple" if record in (None, tuple) else f"{record.__module__}:{record.__qualname__}"
        return [name, *(to_text(each) for each in kind.types)]
    if isinstance(kind, types.Number | types.Boolean | types.NoneType):
        return str(kind)
    raise ValueError(f"{kind}: no type for a kernel's argument")


def from_text(text: Text) -> Any:
    """The type of numba's that was written; raises ValueError, AttributeError or ImportError where there is none."""
    if isinstance(text, list):
        within = tuple(from_text(each) for each in text[1:])
        if text[0] == "tuple":
            return types.BaseTuple.from_types(within)
        module, _, name = text[0].partition(":")
        return types.BaseTuple.from_types(within, getattr(importlib.import_module(module), name))
    found = ARRAY.fullmatch(text)
    if found is None:
        return _scalar(text)
    dtype, dimensions, layout, frozen = found.groups()
    return types.Array(_scalar(dtype), int(dimensions), layout or "C", readonly=bool(frozen))


def _scalar(text: str) -> Any:
    return types.boolean if text == "bool" else getattr(types, text)
