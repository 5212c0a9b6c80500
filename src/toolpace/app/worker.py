"""A process for tasks, and a line of tasks that wait for it.

The process ends with the server, however that ends: its standard input is then at its end. It tells what goes on in
lines of JSON, a task's last line being its result or its error.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import msgspec

from toolpace.app.work import Task, Tell, carry_out
from toolpace.common.errors import ToolpaceError

ENDED = "the process that worked on it has ended, for want of memory perhaps; start it again, or split the program"
SLOWEST_END = 5.0
"""How long an end is waited for [s]."""


class Worker(Protocol):
    """Carries out one task after the other."""

    def carry_out(self, task: Task, tell: Tell) -> dict[str, Any]:
        """What comes of a task. Raises ToolpaceError."""

    def stop(self) -> None:
        """End the task under way, which then raises; the next one begins anew."""


class ThisProcess:
    """Tasks in the thread that brings them; they cannot be ended."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def carry_out(self, task: Task, tell: Tell) -> dict[str, Any]:
        """See `Worker`."""
        return carry_out(self.root, task, tell)

    def stop(self) -> None:
        """See `Worker`."""


class WorkerProcess:
    """Tasks in a process of its own, which is started with the first of them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._process: subprocess.Popen[bytes] | None = None

    def carry_out(self, task: Task, tell: Tell) -> dict[str, Any]:
        """See `Worker`."""
        process = self._process
        if process is None or process.poll() is not None:
            process = self._process = self._started()
        assert process.stdin is not None and process.stdout is not None
        with contextlib.suppress(OSError):  # it has ended: there is no answer either
            process.stdin.write(msgspec.json.encode(task) + b"\n")
            process.stdin.flush()
        for line in process.stdout:
            told = json.loads(line)
            if "done" in told:
                done: dict[str, Any] = told["done"]
                return done
            if "error" in told:
                raise ToolpaceError(told["error"])
            tell(told)
        raise ToolpaceError(ENDED)

    def stop(self) -> None:
        """See `Worker`."""
        if self._process is not None:
            self._process.kill()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(SLOWEST_END)

    def _started(self) -> subprocess.Popen[bytes]:
        # -P: modules are not looked for in the folder that one happens to be in. In a session of its own Ctrl-C at the
        # terminal does not reach it, but the server, which ends it.
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "toolpace.app.worker", str(self.root)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=None if os.environ.get("TOOLPACE_DEBUG") else subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip


@dataclass
class Entry:
    """A task that waits or is carried out."""

    key: str
    task: Task
    ended: Callable[[dict[str, Any] | None, str], None]
    """Takes its result, or None and the error: one line, empty where it was cancelled."""
    steps: list[dict[str, Any]] = field(default_factory=list)
    """What was told of it, a step each: `step`, `note`, and `share` or `seconds`."""
    began: float = 0.0
    """Where it is under way [s since the epoch]."""
    cancelled: bool = False

    def tell(self, told: dict[str, Any]) -> None:
        """Note what goes on."""
        if "say" in told:
            self.steps.append({"step": "", "note": told["say"], "seconds": 0.0})
        elif self.steps and self.steps[-1]["step"] == told["step"] and "seconds" not in self.steps[-1]:
            self.steps[-1] = {**self.steps[-1], **told}
        else:
            self.steps.append(told)


class Line:
    """Tasks in the order in which they came, one at a time."""

    def __init__(self, worker: Worker) -> None:
        self._worker = worker
        self._entries: list[Entry] = []
        self._change = threading.Condition()
        self._stopped = False
        self._thread = threading.Thread(target=self._go, daemon=True)
        self._thread.start()

    def submit(self, key: str, task: Task, ended: Callable[[dict[str, Any] | None, str], None]) -> None:
        """Put a task at the end; one of the same key that waits already stays in its place, and is enough."""
        with self._change:
            if not any(each.key == key and not each.began for each in self._entries):
                self._entries.append(Entry(key, task, ended))
                self._change.notify()

    def entries(self) -> list[Entry]:
        """Those that are not done, the one under way first."""
        with self._change:
            return list(self._entries)

    def cancel(self, key: str) -> None:
        """Take a task out of the line; one that is under way is ended."""
        with self._change:
            found = [each for each in self._entries if each.key == key]
            for each in found:
                each.cancelled = True
                if each.began:
                    self._worker.stop()
                else:
                    self._entries.remove(each)
        # Who is told may ask for more of the line.
        for each in found:
            if not each.began:
                each.ended(None, "")

    def stop(self) -> None:
        """End what is under way, and begin nothing more; nobody is told of tasks that are left."""
        with self._change:
            self._stopped = True
            self._change.notify()
        self._worker.stop()
        self._thread.join(SLOWEST_END)

    def _go(self) -> None:
        while True:
            with self._change:
                while not self._entries and not self._stopped:
                    self._change.wait()
                if self._stopped:
                    return
                entry = self._entries[0]
                entry.began = time.time()
            done, error = self._carried_out(entry)
            with self._change:
                if self._stopped:
                    return
                self._entries.remove(entry)
            entry.ended(*((None, "") if entry.cancelled else (done, error)))

    def _carried_out(self, entry: Entry) -> tuple[dict[str, Any] | None, str]:
        from toolpace.common.cluster.pool import error_in_words

        def tell(told: dict[str, Any]) -> None:
            entry.tell(told)
            if entry.cancelled:  # before its process was there
                self._worker.stop()

        try:
            return self._worker.carry_out(entry.task, tell), ""
        except Exception as error:
            return None, error_in_words(error)


def main(root: Path) -> None:
    """Carry out tasks from standard input until that ends."""
    from toolpace.common.cluster.pool import attempt

    # What libraries print must not stand between the lines of JSON.
    with os.fdopen(os.dup(1), "wb", buffering=0) as out:
        os.dup2(2, 1)
        lock = threading.Lock()

        def tell(told: dict[str, Any]) -> None:
            with lock, contextlib.suppress(OSError):
                out.write(msgspec.json.encode(told) + b"\n")

        for line in _until_its_end():
            task = msgspec.json.decode(line, type=Task)
            done, error, _ = attempt(lambda told, task: carry_out(root, task, told), tell, task)
            tell({"done": done} if done is not None else {"error": error})


def _until_its_end() -> Any:
    """The lines of standard input; at its end, which is that of the server, the process ends whatever it is at."""
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def read() -> None:
        for line in sys.stdin.buffer:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
