"""Names of compiled functions that do not depend on what a process compiled before.

A kernel's machine code holds that of all it calls, parts of the library among them, such as numpy.empty. numba numbers
the functions in the order in which a process meets them, and writes flags in the order of a set, which changes from
process to process; both are part of a symbol's name. So a part could be there once or several times, under other names,
and the compiler made other code of it: plans differed in their last digits from one cache to the next. While a kernel
is compiled, a function's number is a hash of what it is, and flags come in alphabetical order.
"""

from __future__ import annotations

import contextlib
import hashlib
import sys
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType
from typing import Any

import numpy as np
from numba.core import bytecode, cpu_options

Identity: Any = bytecode.FunctionIdentity
Flags: Any = cpu_options.FastMathOptions
PLAIN = (int, float, complex, str, bytes, bool, type(None))


class Unstable(Exception):
    """What cannot be told by a name that is the same in every process."""


@contextlib.contextmanager
def stable_names() -> Iterator[None]:
    """Within, functions are named by what they are; to be used under numba's lock of the compiler."""
    made, derived, encode = Identity.__dict__["from_function"], Identity.derive, Flags.encode
    original: Callable[..., Any] = made.__func__

    def from_function(cls: Any, function: Any) -> Any:
        identity = original(cls, function)
        with contextlib.suppress(Unstable):
            identity.unique_id = number_of(identity.func)
            identity.unique_name = f"{identity.func_qualname}${identity.unique_id}"
        return identity

    # what is derived from a function is another one of the same source: it is numbered as ever
    Identity.from_function = classmethod(from_function)
    Identity.derive = lambda self: original(type(self), self.func)
    Flags.encode = lambda self: str(sorted(self.flags))
    try:
        yield
    finally:
        Identity.from_function, Identity.derive, Flags.encode = made, derived, encode


def number_of(function: FunctionType) -> int:
    """A number that belongs to a function, its code and what it closes over. Raises Unstable where there is none."""
    digest = hashlib.sha256()
    for part in parts_of(function):
        digest.update(part.encode("utf-8", "backslashreplace") + b"\n")
    return int.from_bytes(digest.digest()[:7], "big")


def parts_of(value: Any) -> Iterator[str]:
    """What a function, or a value that one closes over, is told by. Raises Unstable for what no text tells."""
    inner = getattr(value, "py_func", value)
    if isinstance(inner, FunctionType):
        home = sys.modules.get(inner.__module__)
        if home is None or vars(home) is not inner.__globals__:
            raise Unstable(inner.__qualname__)
        yield f"{inner.__module__}.{inner.__qualname__}"
        yield from parts_of_code(inner.__code__)
        for default in (*(inner.__defaults__ or ()), *(inner.__kwdefaults__ or {}).values()):
            yield from parts_of(default)
        for cell in inner.__closure__ or ():
            yield from parts_of(cell.cell_contents)
    elif isinstance(value, tuple | list):
        yield f"{type(value).__name__} {len(value)}"
        for each in value:
            yield from parts_of(each)
    elif isinstance(value, PLAIN):
        yield f"{type(value).__name__} {value!r}"
    elif isinstance(value, np.ufunc):
        yield f"ufunc {value.__name__}"
    elif isinstance(value, type):
        yield f"class {value.__module__}.{value.__qualname__}"
    elif type(value).__module__.startswith("numba.core.types"):
        yield f"type {type(value).__qualname__} {value}"
    else:
        raise Unstable(repr(type(value)))


def parts_of_code(code: CodeType) -> Iterator[str]:
    """What a piece of code is told by."""
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars))
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from parts_of_code(each)
        else:
            yield repr(sorted(each, key=repr) if isinstance(each, frozenset) else each)
