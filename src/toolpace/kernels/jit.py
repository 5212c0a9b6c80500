"""The decorator of all compiled functions.

Each kernel is compiled once, for one signature: arrays in C order, int64, float64. Where a kernel calls another with
a constant, numba would compile a version for each value; here a constant is an int64 like any other.
"""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

import numba

from toolpace.kernels.names import stable_names
from toolpace.kernels.numba_cache import KernelCache

F = TypeVar("F", bound=Callable[..., Any])
TYPES: Any = numba.types

KERNELS: dict[str, Any] = {}
"""Every compiled function of the modules imported so far, by the name that `name_of` gives."""
HOME = f"{__package__}."


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
    known = {id(kernel): each for each, kernel in KERNELS.items()}
    return {known[id(each)] for each in named if id(each) in known} - {name}


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
