"""Machine code is the same, whatever a process has compiled or loaded before, and in whatever order it hashes."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from toolpace.kernels import jit
from toolpace.kernels.kernel_cache import DIGEST

KERNELS = tuple(f"optimal.multipliers.{name}" for name in ("set_bounds", "set_shift", "tiled", "start"))
"""The last one calls the first two."""
COMPILE = """
import sys
from toolpace.kernels import compile_order
from toolpace.kernels.jit import KERNELS
compile_order.import_kernels()
for name in sys.argv[1:]:
    KERNELS[name].compile(tuple(compile_order.from_text(each) for each in compile_order.read_signatures()[name]))
"""
PLAN = """
import numpy as np
from toolpace import AxisPath, Limits, plan
rate = np.array([3.0, 7.0, 11.0])
f = lambda s, order: rate**order * np.sin(s[:, None] * rate + order * np.pi / 2)
trajectory = plan(AxisPath.from_callable(f), Limits(*(np.ones(3) * 10**k for k in range(3))), mesh=300)
motion = trajectory.sample(1e-3)
print(trajectory.duration.hex(), trajectory.lower_bound.hex(), motion.q.tobytes().hex()[-64:], motion.qddd.sum().hex())
"""


def run(program: str, folder: Path, seed: int, *arguments: str) -> str:
    environment = {**os.environ, "TOOLPACE_CACHE": str(folder), "PYTHONHASHSEED": str(seed)}
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


def code(folder: Path) -> dict[str, tuple[bytes, bytes]]:
    """Machine code and the form that callers are compiled with, by file."""
    files = sorted(folder.rglob("*.kernel"))
    return {file.name: pickle.loads(file.read_bytes()[DIGEST:])[0][2] for file in files}


@pytest.mark.sweep
def test_code_does_not_depend_on_what_was_compiled_before(tmp_path):
    run(COMPILE, tmp_path / "together", 1, *KERNELS)
    for seed, name in enumerate(KERNELS):
        run(COMPILE, tmp_path / "apart", 2 + seed, name)
    together, apart = code(tmp_path / "together"), code(tmp_path / "apart")
    assert {file.rpartition("-")[0] for file in together} == set(KERNELS) and together.keys() == apart.keys()
    for file, (machine, intermediate) in together.items():
        assert machine == apart[file][0], file
        assert intermediate == apart[file][1], file


@pytest.mark.thorough
def test_two_caches_filled_apart_give_the_same_bits(tmp_path):
    just_compiled = run(PLAN, tmp_path / "one", 1)
    loaded = run(PLAN, tmp_path / "one", 2)
    elsewhere = run(PLAN, tmp_path / "other", 3)
    assert just_compiled == loaded == elsewhere
    assert code(tmp_path / "one").keys() == code(tmp_path / "other").keys()


def closing_over(value):
    def inner(x):
        return x + value

    return inner


def test_numbers_tell_functions_apart():
    one, two = closing_over(1), closing_over(2)
    assert jit.number_of(one) == jit.number_of(closing_over(1)) != jit.number_of(two)
    assert jit.number_of(closing_over(1.0)) != jit.number_of(one)
    assert jit.number_of(closing_over(np.add)) != jit.number_of(closing_over(np.multiply))
    assert jit.number_of(closing_over(closing_over)) != jit.number_of(closing_over(run))
    with pytest.raises(jit.Unstable):
        jit.number_of(closing_over(object()))
    made_elsewhere = {}
    exec("def f(x): return x", made_elsewhere)
    with pytest.raises(jit.Unstable):
        jit.number_of(made_elsewhere["f"])
