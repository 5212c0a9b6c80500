"""The order of compilation: each kernel after those that it calls."""

from __future__ import annotations

import importlib
import pkgutil
import threading
from pathlib import Path

from toolpace.kernels.jit import KERNELS, called_by


class Work:
    """Kernels to be compiled: each after all that it calls, those that most of the work waits for first."""

    def __init__(self, signatures: dict[str, list[str | list[object]]]) -> None:
        """Take the signature of each kernel."""
        import_kernels()
        self.changed = threading.Condition()
        self._waits_for: dict[str, set[str]] = {}
        self._size: dict[str, int] = {}
        for name in signatures.keys() & KERNELS.keys():
            self._waits_for[name], parts = callees_and_parts(name, set(signatures))
            self._size[name] = sum(len(KERNELS[part].py_func.__code__.co_code) for part in parts)
        self._given: set[str] = set()
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
                rest = [name for name in self._waits_for if name not in self._given]
                ready = [name for name in rest if not self._waits_for[name]]
                if not rest:
                    return None
                # Kernels that seem to call each other wait for nothing when nobody is at work.
                if ready or len(rest) == len(self._waits_for):
                    name = max(ready or rest, key=self._weight.__getitem__)
                    self._given.add(name)
                    return name
                self.changed.wait()

    def give_back(self, name: str) -> None:
        """Say that a kernel was not compiled."""
        with self.changed:
            self._given.discard(name)
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
            self._given.update(self._waits_for)
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
