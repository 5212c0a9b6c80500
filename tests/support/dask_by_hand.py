"""A scheduler and workers as processes of their own, as one starts them from a shell."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator

DASK = [sys.executable, "-m", "dask"]
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


class ByHand:
    """What was started, and its address; each process leads a group of its own, so that all of it can be ended."""

    def __init__(self, port: int = 0) -> None:
        self.port = port or free_port()
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.processes: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--dashboard-address", "127.0.0.1:0"
        )

    def worker(self, *words: str, largest_file: int | None = None) -> subprocess.Popen[bytes]:
        """Start one, with a nanny that starts it anew where it dies."""
        words = ("worker", self.address, "--nthreads", "1", "--no-dashboard", *words)
        return self._start(*words, largest_file=largest_file)

    def _start(self, *words: str, largest_file: int | None = None) -> subprocess.Popen[bytes]:
        def limited() -> None:
            if largest_file is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

        process = subprocess.Popen([*DASK, *words], start_new_session=True, preexec_fn=limited, **QUIET)
        self.processes.append(process)
        return process

    def wait(self, workers: int) -> None:
        """Until so many workers are there."""
        from distributed import Client

        with Client(self.address, timeout=60) as client:
            client.wait_for_workers(workers, timeout=60)

    def end(self) -> None:
        """All of it, at once."""
        for process in reversed(self.processes):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@contextlib.contextmanager
def by_hand(workers: int, *words: str) -> Iterator[ByHand]:
    """A scheduler with workers that are there."""
    cluster = ByHand()
    try:
        for _ in range(workers):
            cluster.worker(*words)
        if workers:
            cluster.wait(workers)
        yield cluster
    finally:
        cluster.end()


def free_port() -> int:
    """One that nobody listens on."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        port: int = server.getsockname()[1]
        return port
