"""A first run: what it compiles is known beforehand, and shared among processes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from toolpace.kernels import compile_order
from toolpace.kernels.jit import KERNELS, called_by
from toolpace.kernels.kernel_cache import SUFFIX
from toolpace.kernels.lock import FileLock

LISTED = compile_order.read_signatures()
FURTHER = compile_order.read_signatures(compile_order.FURTHER)
EVERY = {**FURTHER, **LISTED}

SOME = """
import json, sys
from toolpace.kernels import ahead_of_time as warm
names = json.loads(sys.argv[1])
listed = warm.read_signatures()
warm.read_signatures = lambda: {name: listed[name] for name in names}
shared = []
share_out = warm._share_out
warm._share_out = lambda *given: shared.append(1) or share_out(*given)
told = []
warm.warm_up(told.append)
print(len(shared), warm.is_warm(), told == sorted(told))
"""
"""Compiles some kernels; prints whether it shared them out, whether all are there, whether progress only rose."""


@pytest.fixture(scope="module", autouse=True)
def kernels() -> None:
    compile_order.import_kernels()


@pytest.fixture(scope="module")
def smallest() -> list[str]:
    """A few kernels that are compiled in no time, and call no other."""
    alone = [name for name in LISTED if not called_by(name)]
    return sorted(alone, key=lambda name: len(KERNELS[name].py_func.__code__.co_code))[:4]


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "TOOLPACE_CACHE": str(folder)}
    return subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )


def test_every_listed_kernel_is_there_with_as_many_arguments():
    for name, kinds in EVERY.items():
        assert len(kinds) == KERNELS[name].py_func.__code__.co_argcount, name


def test_no_kernel_takes_constants_or_arrays_in_another_order():
    assert all("layout" not in kind for kinds in EVERY.values() for kind in kinds if isinstance(kind, str))


def test_a_type_is_read_as_it_was_written():
    for kinds in EVERY.values():
        for kind in kinds:
            assert compile_order.to_text(compile_order.from_text(kind)) == kind


def test_a_wheel_has_kernels_that_a_first_run_does_not_wait_for():
    assert FURTHER and not FURTHER.keys() & LISTED.keys()
    for name in ("planners.genetic.select", "follow.step.step"):
        assert name in FURTHER


@pytest.mark.parametrize("listed", [LISTED, EVERY])
def test_a_kernel_is_given_out_after_all_that_it_calls(listed):
    work = compile_order.Work(listed)
    order: list[str] = []
    while (name := work.take()) is not None:
        assert compile_order.callees_and_parts(name, set(listed))[0] <= set(order)
        order.append(name)
        work.finish(name)
    assert sorted(order) == sorted(listed) and not work.left


def test_a_kernel_that_a_worker_gave_back_is_given_out_again(smallest):
    work = compile_order.Work({name: LISTED[name] for name in smallest[:1]})
    assert work.take() == smallest[0]
    work.give_back(smallest[0])
    assert work.take() == smallest[0]
    work.finish(smallest[0])
    assert work.take() is None


@pytest.mark.sweep
def test_one_of_two_processes_compiles_and_both_find_all(tmp_path, smallest):
    both = [start(tmp_path, "-c", SOME, json.dumps(smallest)) for _ in range(2)]
    said = sorted(each.communicate(timeout=600) for each in both)
    assert said == [("0 True True\n", ""), ("1 True True\n", "")]
    names = sorted(file.name.rpartition("-")[0] for file in tmp_path.rglob(f"*{SUFFIX}"))
    assert names == sorted(smallest)
    assert start(tmp_path, "-c", SOME, json.dumps(smallest)).communicate(timeout=600) == ("0 True True\n", "")


@pytest.mark.sweep
def test_a_cut_cache_is_told_and_compiled_again(tmp_path, smallest):
    start(tmp_path, "-c", SOME, json.dumps(smallest)).communicate(timeout=600)
    for file in tmp_path.rglob(f"*{SUFFIX}"):
        file.write_bytes(file.read_bytes()[:500])
    out, said = start(tmp_path, "-c", SOME, json.dumps(smallest)).communicate(timeout=600)
    assert out == "1 True True\n"
    assert said.count("\n") == 1 and said.startswith("warning: ") and "damaged" in said


@pytest.mark.sweep
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_one_that_is_stopped_while_it_compiles_leaves_nothing_locked(tmp_path, how):
    compiling = start(tmp_path, "-m", "toolpace.kernels.ahead_of_time")
    while not list(tmp_path.rglob(f"*{SUFFIX}")):
        assert compiling.poll() is None
        time.sleep(0.05)
    (lock,) = tmp_path.rglob("lock")
    with FileLock(lock) as other:
        assert not other.take()
        compiling.send_signal(how)
        compiling.communicate(timeout=60)
        assert compiling.returncode != 0
        assert other.take()


JOB = """
import toolpace as tp
from toolpace.cli import demo_programs as demo
from toolpace.kernels.jit import KERNELS
from toolpace.kernels.compile_order import from_text, read_signatures

machine = tp.Machine.load(demo.MACHINE)
toolpath = tp.read_text(demo.spiral_program(60, machine), machine)
trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine)
trajectory.usage()
tp.verify(trajectory, machine, toolpath)
listed = {name: [tuple(map(from_text, kinds))] for name, kinds in read_signatures().items()}
called = {name: kernel.signatures for name, kernel in KERNELS.items() if kernel.signatures}
print(len(called))
for name in called:
    if called[name] != listed.get(name):
        print(name, called[name])
"""


def test_a_job_calls_each_kernel_with_the_one_signature_that_is_listed():
    done = subprocess.run([sys.executable, "-c", JOB], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    count, *others = done.stdout.splitlines()
    assert int(count) > 30 and others == []
