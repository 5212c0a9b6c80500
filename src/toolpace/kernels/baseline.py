"""Processors that kernels are compiled for beforehand, and the one that they are compiled for here."""

from __future__ import annotations

import platform

from llvmlite import binding
from numba.core import config

V3 = (
    "avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2",
    "ssse3", "xsave",
)  # fmt: skip
"""What a processor of the level x86-64-v3 has (System V ABI, AMD64 supplement, 3.1.1), by LLVM's names."""
X86_64 = ("x86_64", "AMD64")
"""Names that systems give this kind of processor."""


def baselines() -> dict[str, str]:
    """Processors of this kind that a wheel has kernels for, the fastest first: LLVM's name and features."""
    fastest = {"x86-64-v3": ",".join(f"+{each}" for each in V3)} if platform.machine() in X86_64 else {}
    return {**fastest, "generic": ""}


def usable() -> list[str]:
    """Those of the baselines whose machine code may run here: one that numba's settings name, or all that fit."""
    named, features = config.CPU_NAME, config.CPU_FEATURES
    if named is not None:
        return [name for name, has in baselines().items() if (name, has) == (named, features)]
    if features is not None:
        return []
    here = binding.get_host_cpu_features()
    fits = all(here.get(each, False) for each in V3) and config.ENABLE_AVX
    return [name for name in baselines() if name == "generic" or fits]


def processor() -> str:
    """The processor that kernels are compiled for in this process: name and features."""
    name = binding.get_host_cpu_name() if config.CPU_NAME is None else config.CPU_NAME
    features = binding.get_host_cpu_features().flatten() if config.CPU_FEATURES is None else config.CPU_FEATURES
    return f"{name} {features}"
