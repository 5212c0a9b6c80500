"""Order of compilation of a first run's kernels, from their signatures (`signatures.json`).

The signatures tell what to compile before anything is called, so that many processes can share the work.
`python tools/first_run.py --record` writes them anew after a kernel's arguments have changed.

A type is `int64`, `float64[2]` for an array of two dimensions in C order, `float64[2, read-only]`, or a list: the class
of a record, or `tuple`, and the types within.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import re
import threading
from pathlib import Path
from typing import Any

import numba

from toolpace.kernels.jit import KERNELS, called_by

FILE = Path(__file__).with_name("signatures.json")
FURTHER = Path(__file__).with_name("further_signatures.json")
"""Those that other usual commands compile besides: a wheel brings them, a first run does not wait for them."""
ARRAY = re.compile(r"(\w+)\[(\d+)(?:, layout ([AF]))?(, read-only)?\]")

types: Any = numba.types
Text = str | list[Any]
"""A type as it is written."""


def read_signatures(file: Path = FILE) -> dict[str, list[Text]]:
    """Signature of each kernel, by its name."""
    found: dict[str, list[Text]] = json.loads(file.read_text("utf-8"))
    return found


def write_signatures(signatures: dict[str, list[Text]], file: Path = FILE) -> None:
    """Write them, one kernel a line."""
    rows = [f"{json.dumps(name)}: {json.dumps(kinds)}" for name, kinds in sorted(signatures.items())]
    file.write_text("{\n" + ",\n".join(rows) + "\n}\n", "utf-8")


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


class Work:
    """Kernels to be compiled: each after all that it calls, those that most of the work waits for first."""

    def __init__(self, signatures: dict[str, list[Text]]) -> None:
        """Take the signature of each kernel."""
        import_kernels()
        self.changed = threading.Condition()
        self._waits_for: dict[str, set[str]] = {}
        self._size: dict[str, int] = {}
        for name in signatures.keys() & KERNELS.keys():
            self._waits_for[name], parts = callees_and_parts(name, set(signatures))
            self._size[name] = sum(len(KERNELS[part].py_func.__code__.co_code) for part in parts)
        self._handed_out: set[str] = set()
        self.total = len(self._waits_for)
        self._weight: dict[str, int] = {}
        for name in self._waits_for:
            self._weight[name] = self._way_to_end(name)

    def _way_to_end(self, name: str) -> int:
        """Size of a kernel and of the longest chain of its callers [bytes of code]."""
        if name not in self._weight:
            callers = [each for each, callees in self._waits_for.items() if name in callees]
            self._weight[name] = self._size[name] + max((self._way_to_end(each) for each in callers), default=0)
        return self._weight[name]

    @property
    def left(self) -> int:
        """How many kernels are not done."""
        return len(self._waits_for)

    def take(self) -> str | None:
        """A kernel that is ready, waited for; None when all are given out."""
        with self.changed:
            while True:
                rest = [name for name in self._waits_for if name not in self._handed_out]
                ready = [name for name in rest if not self._waits_for[name]]
                if not rest:
                    return None
                # Kernels that seem to call each other wait for nothing when nobody is at work.
                if ready or len(rest) == len(self._waits_for):
                    name = max(ready or rest, key=self._weight.__getitem__)
                    self._handed_out.add(name)
                    return name
                self.changed.wait()

    def give_back(self, name: str) -> None:
        """Say that a kernel was not compiled."""
        with self.changed:
            self._handed_out.discard(name)
            self.changed.notify_all()

    def finish(self, name: str) -> None:
        """Say that a kernel is compiled."""
        with self.changed:
            self._waits_for.pop(name, None)
            for callees in self._waits_for.values():
                callees.discard(name)
            self.changed.notify_all()

    def drop(self) -> None:
        """Give nothing out any more."""
        with self.changed:
            self._handed_out.update(self._waits_for)
            self.changed.notify_all()


def callees_and_parts(name: str, compiled: set[str]) -> tuple[set[str], set[str]]:
    """Kernels that one calls: those `compiled` by themselves; and those compiled as parts of it, itself among them."""
    callees: set[str] = set()
    parts, ahead = {name}, called_by(name)
    while ahead:
        each = ahead.pop()
        if each in compiled:
            callees.add(each)
        elif each not in parts:
            parts.add(each)
            ahead |= called_by(each)
    return callees, parts


def import_kernels() -> None:
    """Import all modules of kernels, so that every kernel is known."""
    package = __package__ or ""
    for module in pkgutil.walk_packages([str(Path(__file__).parent)], f"{package}."):
        if not module.ispkg:
            importlib.import_module(module.name)
