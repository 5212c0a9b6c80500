"""Machine code of kernels that Python calls, and LLVM's intermediate code of those that other kernels call.

A kernel's machine code holds that of all it calls, and is made from their intermediate code. numba makes machine code
of each function besides, and a wrapper that takes Python's objects apart. For a function that only kernels call, one of
numba's library too, neither is ever run.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import Any

from llvmlite import binding
from numba.core import codegen, compiler
from numba.core.runtime import rtsys

Library: Any = codegen.CPUCodeLibrary
Codegen: Any = codegen.JITCPUCodegen
FINALIZE = Library._finalize_final_module
SET_ENVIRONMENT = Codegen.set_env
WRAPPER = "_ZN7cpython"
"""What the names of wrappers for Python begin with (`PythonFunctionDescriptor.llvm_cpython_wrapper_name`)."""


@contextlib.contextmanager
def machine_code_where_python_calls() -> Iterator[None]:
    """Within, functions without a wrapper for Python get no machine code; to be used under numba's compiler lock."""

    def finalize(library: Any) -> None:
        is_loaded = getattr(library, "_compiled_object", None) is not None
        if is_loaded or any(each.name.startswith(WRAPPER) for each in library._final_module.functions):
            if not is_loaded:
                set_intermediate_code(library)  # making machine code changes it
            FINALIZE(library)
            return
        library._finalize_dynamic_globals()
        library._verify_declare_only_symbols()
        library._finalized = True

    def set_environment(generator: Any, name: str, environment: Any) -> None:
        # the function's own variable for it is in the machine code of its callers
        if generator._engine.is_symbol_defined(name):
            SET_ENVIRONMENT(generator, name, environment)

    outer = Library._finalize_final_module, Codegen.set_env
    Library._finalize_final_module, Codegen.set_env = finalize, set_environment
    try:
        yield
    finally:
        Library._finalize_final_module, Codegen.set_env = outer


def set_intermediate_code(library: Any) -> None:
    """Set what callers are compiled with, as they would find it loaded, without the wrapper; for all callers the same.

    A caller's machine code holds that of its callees. From a module in memory the compiler made other code, by the last
    bit of its results, than from the same module written and read: uses of a value come in another order there.
    """
    module = library._final_module.clone()
    for each in module.functions:
        if each.name.startswith(WRAPPER) and not each.is_declaration:
            each.linkage = "internal"
    unused = binding.create_new_module_pass_manager()
    unused.add_global_dead_code_eliminate_pass()
    unused.run(module, library._codegen._pass_builder())
    for each in module.functions:
        if each.linkage == binding.Linkage.external and not each.is_declaration:
            each.linkage = "linkonce_odr"  # as in numba's `_get_module_for_linking`: several callers may bring it
    library._shared_module = binding.parse_bitcode(module.as_bitcode())


class Uncalled:
    """In place of the function that Python would call; numba's compiler finds a callee's code by it."""


def without_entry(compiled: Any) -> Any:
    """A result of the compiler that kernels find by an entry point that cannot be called."""
    found = compiled._replace(entry_point=Uncalled())
    found.target_context.insert_user_function(found.entry_point, found.fndesc, [found.library])
    return found


def set_environments(compiled: Any) -> None:
    """Give machine code the environments of all whose code it holds, as numba does for code that it loads."""
    for environment in compiled._find_referenced_environments():
        compiled.library.codegen.set_env(environment.env_name, environment)


def reduced(compiled: Any) -> tuple[Any, ...]:
    """What is kept of a result without machine code, in the form of `CompileResult._reduce`."""
    library, description = compiled.library, compiled.fndesc
    code = (library.name, "object", (b"", library._get_module_for_linking().as_bitcode()))
    description.typemap = description.calltypes = None
    return code, description, compiled.environment, compiled.signature, False, (), "", compiled.reload_init, ()


def rebuilt(context: Any, kept: tuple[Any, ...], from_python: bool) -> Any:
    """A result for Python that calls, of what was kept with machine code; or for kernels that call, of either form.

    Intermediate code is read when a caller is compiled: no sooner, since most processes compile nothing.
    """
    (name, _, (machine, code)), description, environment, signature, _, _, _, reload_init, environments = kept
    for initialise in reload_init:
        initialise()
    library = context.codegen().create_library(name)
    library._get_module_for_linking = functools.cache(lambda: binding.parse_bitcode(code))
    entry: Any = Uncalled()
    if from_python:
        # Machine code calls numba's functions for memory. What numba compiles with takes a quarter of a second to
        # set up and is not needed to load it; where something is to be compiled, numba's compiler sets it up.
        rtsys.initialize(context)
        library.enable_object_caching()
        library._set_compiled_object(machine)
        FINALIZE(library)
        symbols = {description.llvm_cpython_wrapper_name, *(each.env_name for each in (environment, *environments))}
        library._codegen._engine._defined_symbols |= symbols
        entry = context.get_executable(library, description, environment)
    library._finalized = True
    found = compiler.CompileResult(
        typing_context=context.typing_context,
        target_context=context,
        entry_point=entry,
        typing_error=None,
        type_annotation="",
        signature=signature,
        objectmode=False,
        lifted=(),
        fndesc=description,
        library=library,
        call_helper=None,
        environment=environment,
        metadata=None,
        reload_init=reload_init,
        referenced_envs=environments,
    )
    if from_python:
        for each in environments:
            library.codegen.set_env(each.env_name, each)
    return found
