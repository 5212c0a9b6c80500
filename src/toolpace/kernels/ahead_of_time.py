"""Ahead-of-time compilation of the kernels of a first run, in parallel processes.

Which kernels, and for which signatures, is known beforehand (`signatures.json`). A kernel is handed out when all that
it calls is compiled, so that no process compiles what another is at: callees are loaded from the folder that all
share. What lies on the longest way to the end goes first. One process at a time has a folder's lock and shares the
work out; others that come meanwhile wait, and then load. Nothing depends on it having been done: a kernel that is not
found is compiled where it is first called.

`python -m toolpace.kernels.ahead_of_time` does it ahead, for instance once for all users of a machine, with
TOOLPACE_CACHE.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable

from numba.core import config

from toolpace.kernels.compile_order import FURTHER, Work, from_text, import_kernels, read_signatures
from toolpace.kernels.jit import KERNELS
from toolpace.kernels.kernel_cache import COMPLETE, Store, store, warn
from toolpace.kernels.lock import FileLock

MOST_WORKERS = 8
"""More find nothing to do: kernels that call each other are compiled one after the other."""
BREATH = 0.05
"""Time between two looks at the work of others [s]."""
STALLED = 300.0
"""Time without a new kernel after which another process's work is no longer waited for [s]."""

Tell = Callable[[float], None]
"""Takes the share of the work that is done, from 0 to 1."""


def is_warm() -> bool:
    """Whether all that a first run needs is compiled, or no compiled kernel can be kept at all."""
    return store().folder is None or store().complete()


@functools.cache
def ensure_warm() -> None:
    """Compile what is missing, once a process and without a word: for those who use the library, not the command."""
    warm_up()


def warm_up(tell: Tell = lambda share: None, further: bool = False) -> None:
    """Compile what is missing of a first run's kernels; return when it is there, whoever did it.

    `further` takes the kernels of other usual commands with them, where nothing is compiled yet: for a wheel.
    """
    kept = store()
    if config.DISABLE_JIT or is_warm() or kept.folder is None or not sys.executable or getattr(sys, "frozen", False):
        return
    if (kept.folder / COMPLETE).exists():
        warn(f"compiled kernels in {kept.folder} are damaged; compiled again")
    signatures = {**(read_signatures(FURTHER) if further else {}), **read_signatures()}
    needed = len(signatures)
    with FileLock(kept.folder / "lock") as lock:
        found, since = 0, time.monotonic()
        while not _taken(lock):
            if kept.complete():
                return
            now = len(kept.files())
            if now != found:
                found, since = now, time.monotonic()
            if time.monotonic() - since > STALLED:
                break
            tell(now / needed)
            time.sleep(BREATH)
        if kept.complete():
            return
        work = Work(signatures)
        if _share_out(work, kept, tell):
            kept.mark_complete()


def _taken(lock: FileLock) -> bool:
    """Whether the lock is ours; so too where there are no locks: the work may be done twice then, but not wrongly."""
    try:
        return lock.take()
    except OSError:
        return True


def _share_out(work: Work, kept: Store, tell: Tell) -> bool:
    """Have workers compile all; whether they did and kept it. Where they cannot be started, nothing is compiled."""
    workers: list[subprocess.Popen[str]] = []
    threads: list[threading.Thread] = []
    try:
        for _ in range(min(cores(), MOST_WORKERS)):
            workers.append(_start(kept))
            threads.append(threading.Thread(target=_hand_out, args=(work, workers[-1]), daemon=True))
            threads[-1].start()
        while work.left and any(thread.is_alive() for thread in threads):
            tell(1.0 - work.left / work.total)
            with work.changed:
                work.changed.wait(BREATH)
    except OSError:
        return False
    finally:
        work.drop()
        for worker in workers:
            worker.kill()
            worker.wait()
        for thread in threads:
            thread.join()
        for worker in workers:
            for pipe in (worker.stdin, worker.stdout):
                with contextlib.suppress(OSError):  # what could not be written to a worker that is gone
                    if pipe is not None:
                        pipe.close()
    return not work.left


def cores() -> int:
    """How many cores this process may use."""
    allowed: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)  # Linux
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def _start(kept: Store) -> subprocess.Popen[str]:
    """A process that compiles what it is told to, with the modules and the folder of this one."""
    assert kept.folder is not None
    program = (
        f"import sys; sys.path[:] = {sys.path!r}; "
        "from toolpace.kernels.ahead_of_time import compile_on_order as go; go()"
    )
    return subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "TOOLPACE_CACHE": str(kept.folder.parent.parent)},
    )


def _hand_out(work: Work, worker: subprocess.Popen[str]) -> None:
    """Give kernels to a worker one by one, until none is left or the worker is gone."""
    assert worker.stdin is not None and worker.stdout is not None
    while (name := work.take()) is not None:
        try:
            worker.stdin.write(name + "\n")
            worker.stdin.flush()
            answer = worker.stdout.readline()
        except (OSError, ValueError):
            answer = ""
        if answer.strip() != name:
            work.give_back(name)  # it died, or cannot keep what it compiles
            return
        work.finish(name)


def compile_on_order() -> None:
    """The life of a worker: names of kernels come in, and go out when they are compiled; ends with its input."""
    with contextlib.suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # who gives the orders ends this too
    gc.disable()  # looking for garbage among what is kept would take a tenth of the time
    answers = sys.stdout
    sys.stdout = sys.stderr  # what the compiler may print is no answer
    signatures = {**read_signatures(FURTHER), **read_signatures()}
    import_kernels()
    for line in sys.stdin:
        name = line.strip()
        # A signature that is out of date compiles nothing; the caller will compile the right one.
        with contextlib.suppress(Exception):
            KERNELS[name].compile(tuple(from_text(each) for each in signatures[name]))
        if not store().writable:
            return
        print(name, file=answers, flush=True)


if __name__ == "__main__":
    began = time.perf_counter()
    warm_up()
    print(json.dumps({"kernels": len(read_signatures()), "seconds": round(time.perf_counter() - began, 1)}))
