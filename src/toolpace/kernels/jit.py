"""The decorator of all compiled functions, from numba's: cached, for one signature, under stable names.

Each kernel is compiled once, for one signature: arrays in C order, int64, float64. Where a kernel calls another with
a constant, numba would compile a version for each value; here a constant is an int64 like any other.

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
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

import numba
import numpy as np
from numba.core import bytecode, cpu_options

from toolpace.kernels.kernel_cache import KernelCache

F = TypeVar("F", bound=Callable[..., Any])
TYPES: Any = numba.types

KERNELS: dict[str, Any] = {}
"""Every compiled function of the modules imported so far, by the name that `name_of` gives."""
HOME = f"{__package__}."
Identity: Any = bytecode.FunctionIdentity
Flags: Any = cpu_options.FastMathOptions
PLAIN = (int, float, complex, str, bytes, bool, type(None))


def jit(*, reorder: bool = False, inline: bool = False) -> Callable[[F], F]:
    """Compile to machine code, cached on disk, free of the interpreter lock.

    `reorder` lets sums be reassociated and products fused, for loops that shall use vector instructions.
    A nan or an infinity is always seen: the flags that assume their absence are never set.
    `inline` is for the parts of a longer function: they are compiled as part of it only. A caller's machine code holds
    that of all it calls, so that otherwise each level of calls would compile what lies below it once more.
    """
    flags: Any = {"reassoc", "contract", "nsz", "arcp"} if reorder else False

    def decorate(function: F) -> F:
        compiled: Any = numba.njit(
            nogil=True,
            fastmath=flags,
            error_model="numpy",
            inline="always" if inline else "never",
            no_cfunc_wrapper=True,  # for calls from C: never called, and costs time to compile
        )(function)
        if compiled is not function:  # with NUMBA_DISABLE_JIT it is the function itself
            _take_constants_as_values(compiled)
            _compile_with_stable_names(compiled)
            # A function that is none of ours (a test's, a user's) is not known to the cache's key.
            if function.__module__.startswith(HOME):
                name = name_of(function)
                compiled._cache = KernelCache(name)
                KERNELS[name] = compiled
        kernel: F = compiled
        return kernel

    return decorate


def name_of(function: Any) -> str:
    """Name of a kernel below this package: `optimal.solver.maximise_speed`, or `fit.band.solve_of_width.run(w=6)`."""
    name = f"{function.__module__.removeprefix(HOME)}.{function.__qualname__.replace('<locals>.', '')}"
    cells = zip(function.__code__.co_freevars, function.__closure__ or ())
    closed_over = ", ".join(f"{variable}={cell.cell_contents!r}" for variable, cell in cells)
    return f"{name}({closed_over})" if closed_over else name


def called_by(name: str) -> set[str]:
    """Names of the kernels that a kernel names in its body."""
    function: FunctionType = KERNELS[name].py_func
    code: CodeType = function.__code__
    named = [function.__globals__.get(each) for each in code.co_names]
    # A kernel of another module may be named as an attribute of the module.
    modules = [each for each in named if isinstance(each, ModuleType)]
    named += [getattr(module, attribute, None) for module in modules for attribute in code.co_names]
    names = {id(kernel): each for each, kernel in KERNELS.items()}
    return {names[id(each)] for each in named if id(each) in names} - {name}


def _take_constants_as_values(compiled: Any) -> None:
    """Have calls with constants, made by other kernels, compiled for the type of the constant, not for its value."""
    resolve = compiled.get_call_template

    def by_type(args: Any, keywords: Any) -> Any:
        plain = {each: TYPES.unliteral(kind) for each, kind in keywords.items()}
        return resolve(tuple(TYPES.unliteral(each) for each in args), plain)

    compiled.get_call_template = by_type


def _compile_with_stable_names(compiled: Any) -> None:
    """Have the machine code not depend on what this process has compiled before: numba's lock is held meanwhile."""
    compile_now = compiled._compiler.compile

    def with_names(args: Any, return_type: Any) -> Any:
        with stable_names():
            return compile_now(args, return_type)

    compiled._compiler.compile = with_names


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
