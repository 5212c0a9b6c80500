"""The app: a page on this computer for those who never open a terminal.

    browser --guard--> server --> service --> project (on disk)
                                     |
                                     +--> line of tasks --> worker process --> what the commands do too
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Serving", "serving"]


@dataclass(frozen=True)
class Serving:
    """An app that is ready."""

    folder: Path
    address: str
    """What to open in a browser: it has the key."""
    until_signal: Callable[[], None]
    """Answers requests until Ctrl-C or another signal, which it then raises as KeyboardInterrupt."""


@contextmanager
def serving(folder: str | Path, port: int = 0) -> Iterator[Serving]:
    """The app of a folder, ready to be served.

    folder: where programs, jobs and results are kept; made where it is missing. One process has it at a time.
    port: of the loopback; 0: any that is free.
    Raises UsageError where the folder or the port is not fit, or the libraries of the server are missing.
    """
    from toolpace.app import server
    from toolpace.app.project import Project
    from toolpace.app.service import Service
    from toolpace.app.worker import WorkerProcess
    from toolpace.jobs.batch.folder import batch_folder

    server.refuse_without_extra()
    root = Path(folder).expanduser().absolute()
    project = Project(root)
    with project.held(), batch_folder(project.plans), server.loopback(port) as listening:
        token = server.new_token()
        service = Service(project, WorkerProcess(root), WorkerProcess(root))
        try:
            bound = listening.getsockname()[1]
            http = server.http_server(service, bound, token)
            yield Serving(root, f"http://127.0.0.1:{bound}/?token={token}", lambda: http.run(sockets=[listening]))
        finally:
            service.stop()

