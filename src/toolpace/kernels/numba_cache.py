"""The interface through which numba loads and saves compiled kernels."""

from __future__ import annotations

import hashlib
import pickle
from typing import Any

from llvmlite import binding
from numba.core import compiler, serialize

from toolpace.kernels.kernel_cache import SUFFIX, store, warn


class KernelCache:
    """What numba asks for a kernel's code, and gives it to; in place of numba's own cache."""

    def __init__(self, name: str) -> None:
        """Take the kernel's name, unique among these sources."""
        self._name = name
        self.cache_path: str | None = None
        self._enabled = True

    def file(self, signature: Any) -> str:
        """Name of the file of one signature, a tuple of numba's types."""
        plain = "".join(c if c.isalnum() or c in "._" else "-" for c in self._name)
        return f"{plain}-{hashlib.sha256(f'{self._name} {signature}'.encode()).hexdigest()[:12]}{SUFFIX}"

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled function for a signature, or None."""
        target_context.refresh()
        if not self._enabled:
            return None
        data = store().load(self.file(signature))
        if data is None:
            return None
        try:
            return compiler.CompileResult._rebuild(target_context, *pickle.loads(data))
        except Exception as error:
            store().damaged(self.file(signature), f"unreadable, {type(error).__name__}")
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled function; whoever calls it is compiled with what is kept, like those that load it."""
        _as_loaded(compiled.library)
        if not self._enabled or compiled.lifted or compiled.library.has_dynamic_globals:
            return
        try:
            data = serialize.dumps(compiled._reduce())
        except Exception as error:
            warn(f"compiled kernels cannot be kept with this numba ({type(error).__name__}); every run compiles them")
            return
        store().save(self.file(signature), data)

    def enable(self) -> None:
        """Load and save."""
        self._enabled = True

    def disable(self) -> None:
        """Neither load nor save."""
        self._enabled = False

    def flush(self) -> None:
        """Forget nothing: what is kept is never stale."""


def _as_loaded(library: Any) -> None:
    """Give a library that was just compiled the form in which its callers would find it loaded.

    A caller's machine code holds that of its callees. From a module in memory the compiler made other code, by the last
    bit of its results, than from the same module written and read: uses of a value come in another order there.
    """
    if hasattr(library, "_shared_module") and hasattr(library, "_get_module_for_linking"):
        library._shared_module = binding.parse_bitcode(library._get_module_for_linking().as_bitcode())
