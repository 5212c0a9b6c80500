"""Compiled kernels that a wheel brings: taken where they fit, compiled anew where they do not, never written to."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from llvmlite.binding.targets import FeatureMap

from toolpace.kernels import baseline
from toolpace.kernels import kernel_cache as kept
from toolpace.kernels.kernel_cache import SUFFIX, VERSIONS, Store, built_store

BASELINES = {"x86-64-v3": "+avx2,+fma", "generic": ""}


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder as in a wheel, with one kernel for each of two processors, and an empty cache of the user's own."""
    monkeypatch.setattr(kept, "_warned", functools.cache(list))
    monkeypatch.setattr(kept, "BUILT", tmp_path / "built")
    for module in (kept, baseline):
        monkeypatch.setattr(module, "baselines", lambda: BASELINES)
    monkeypatch.setattr(baseline, "V3", ("avx2", "fma"))
    processor_has(monkeypatch, avx2=True, fma=True, sse3=True)
    monkeypatch.setenv("TOOLPACE_CACHE", str(tmp_path / "own"))
    for name, features in BASELINES.items():
        made = Store(tmp_path / "built" / name)
        made.save(f"a{SUFFIX}", name.encode())
        made.mark_complete()
        (tmp_path / "built" / name / VERSIONS).write_text(f"{kept.versions()}\n{kept.key(f'{name} {features}')}\n")
    kept.store.cache_clear()
    yield tmp_path / "built"
    kept.store.cache_clear()


def processor_has(monkeypatch: pytest.MonkeyPatch, **features: bool) -> None:
    monkeypatch.setattr(baseline.binding, "get_host_cpu_features", lambda: FeatureMap(features))


def test_the_fastest_that_the_processor_can_run_is_taken(built, monkeypatch, capsys):
    store = kept.store()
    assert store.load(f"a{SUFFIX}") == b"x86-64-v3" and store.complete()
    store.save(f"b{SUFFIX}", b"mine")
    assert store.load(f"b{SUFFIX}") == b"mine" and sorted(store.files()) == [f"b{SUFFIX}"]
    assert not list(built.rglob(f"b{SUFFIX}"))
    processor_has(monkeypatch, avx2=True, fma=False)
    assert built_store().load(f"a{SUFFIX}") == b"generic"
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("name", "features", "taken"),
    [("generic", "", b"generic"), ("x86-64-v3", "+avx2,+fma", b"x86-64-v3"), ("skylake", None, None)],
)
def test_a_processor_named_in_the_settings_of_numba_is_the_one(built, monkeypatch, capsys, name, features, taken):
    monkeypatch.setattr(baseline.config, "CPU_NAME", name)
    monkeypatch.setattr(baseline.config, "CPU_FEATURES", features)
    found = built_store()
    assert (found.load(f"a{SUFFIX}") if found else None) == taken
    assert ("compiled anew" in capsys.readouterr().err) == (taken is None)


def test_other_versions_are_told_once_and_compiled_anew(built, capsys):
    for each in built.iterdir():
        (each / VERSIONS).write_text("numba 0.61.0, llvmlite 0.44.0, NumPy 2.0.0, CPython 3.11.0\n0123456789abcdef\n")
    store = kept.store()
    assert store.load(f"a{SUFFIX}") is None and not store.complete()
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "for numba 0.61.0" in said and f"here is {kept.versions()}; compiled anew" in said


def test_a_damaged_kernel_of_a_wheel_is_not_run(built, capsys):
    (built / "x86-64-v3" / f"a{SUFFIX}").write_bytes(bytes(32) + b"x86-64-v3")
    assert kept.store().load(f"a{SUFFIX}") is None
    assert "damaged; compiled again" in capsys.readouterr().err


CALL = "import toolpace as tp; print(tp.Machine.load('xyzac-trunnion').forward([[0.1, 0.2, 0.3, 0.4, 0.5]])[0])"
WRITE = """
from pathlib import Path
from toolpace.kernels.kernel_cache import store, write_built
store().mark_complete()
write_built(Path({folder!r}))
"""
READ = """
from pathlib import Path
from toolpace.kernels import kernel_cache
kernel_cache.BUILT = Path({folder!r})
"""


def printed(program: str, **environment: str) -> str:
    """What a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=600, env={**os.environ, **environment}
    )
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return done.stdout


@pytest.mark.sweep
def test_machine_code_for_a_baseline_runs_in_another_process(tmp_path):
    """Compiled for a named processor, read by a process that would compile for its own, or for the same by name."""
    results = []
    for name, features in baseline.baselines().items():
        named = {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features}
        write = CALL + WRITE.format(folder=str(tmp_path / "built" / name))
        results.append(printed(write, TOOLPACE_CACHE=str(tmp_path / name), **named))
        read = READ.format(folder=str(tmp_path / "built")) + CALL
        results.append(printed(read, TOOLPACE_CACHE=str(tmp_path / "own"), **named))
    results.append(printed(read, TOOLPACE_CACHE=str(tmp_path / "own")))
    assert len(set(results)) == 1 and "[[" in results[0]
    assert list((tmp_path / "built").rglob(f"*{SUFFIX}")) and not list((tmp_path / "own").rglob(f"*{SUFFIX}"))
