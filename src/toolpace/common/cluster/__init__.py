"""Pools of workers: a dask.distributed cluster, the cores of this computer, or this process.

    with open_pool("tcp://10.0.0.5:8786") as pool:
        for outcome in pool.each(work, common, items):
            ...

Outcomes come as they are made, in any order, one for each item: its value, or its error in one line. Only so many items
are with the cluster at once as it works on and has next, and no outcome is kept: neither scheduler nor caller grow with
their number. Kernels are compiled once on each computer, whatever the number of its workers.

dask is imported where a cluster is opened, not before: it is the extra `toolpace[cluster]`.
"""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from toolpace.common.cluster.pool import Outcome, Pool, ThisProcess
from toolpace.common.errors import ClusterError, UsageError, in_short
from toolpace.common.value_objects import counted

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Outcome", "Pool", "open_pool"]

CURE = "pip install 'toolpace[cluster]'"
CONNECT = 10.0
"""How long a scheduler is knocked at [s]."""


@contextmanager
def open_pool(where: Client | str | int | None = None, memory: str | None = None) -> Iterator[Pool]:
    """Yield what does the work, and close what was opened for it.

    where: a Client of dask, which stays open; the address of a scheduler, like tcp://10.0.0.5:8786; a number of
    workers on this computer, 0 for this process, one item after the other; None: a worker a core, and this process
    where dask.distributed is not installed.
    memory: what each of the workers that are started here may take, like "4GB"; by default an equal share of all.

    Raises ClusterError where a scheduler does not answer, UsageError where dask.distributed is needed and missing.
    """
    if where == 0 or (where is None and not installed()):
        yield ThisProcess("" if where == 0 else f"dask.distributed is not installed: {CURE} for all cores")
        return
    if not installed():
        raise UsageError(f"clusters need dask.distributed, which is not installed: {CURE}")
    from toolpace.common.cluster.dask_pool import DaskPool

    with contextlib.ExitStack() as stack:
        if where is None or isinstance(where, int):
            stack.enter_context(_quiet())
            client, words = stack.enter_context(_local(where, memory)), "on this computer"
        elif isinstance(where, str):
            stack.enter_context(_quiet())
            client, words = stack.enter_context(_joined(where)), f"of {where}"
        elif where.asynchronous:
            raise UsageError("the client is asynchronous; give one that was made with asynchronous=False")
        else:
            client, words = where, f"of {where.scheduler.address}"
        pool = DaskPool(client)
        pool.where = f"{counted(pool.workers(), 'worker')} {words}"
        yield pool


def installed() -> bool:
    """Whether dask.distributed is."""
    from importlib.util import find_spec

    return find_spec("distributed") is not None


@contextmanager
def _local(workers: int | None, memory: str | None) -> Iterator[Client]:
    """A client of a cluster on this computer; each worker is a process that works on one item at a time."""
    import dask
    from distributed import Client, LocalCluster
    from distributed.worker_memory import parse_memory_limit

    count = workers if workers is not None else os.cpu_count() or 1
    if count < 1:
        raise UsageError(f"{count} workers do nothing; give one or more, or 0 for this process")
    try:
        limit = parse_memory_limit(memory or "auto", 1, count, logger=logging.getLogger("distributed"))
    except ValueError as error:
        raise UsageError(f"--memory {memory}: {in_short(error)}; give a size like 4GB") from None
    options: dict[str, Any] = {
        "n_workers": count,
        "threads_per_worker": 1,
        "memory_limit": limit,
        "resources": {"memory": limit} if limit else None,
        "dashboard_address": "127.0.0.1:0",
        "silence_logs": logging.CRITICAL,
    }
    # An item whose worker dies comes back at once: it is tried again when it can harm no other.
    # Samples of what goes on in each worker, a hundred a second, take cores from the work.
    config = dask.config.set({"distributed.scheduler.allowed-failures": 0, "distributed.worker.profile.enabled": False})
    with config, LocalCluster(**options) as cluster, Client(cluster) as client:
        yield client


@contextmanager
def _joined(address: str) -> Iterator[Client]:
    """A client of a scheduler elsewhere."""
    from distributed import Client

    try:
        client = Client(address, timeout=CONNECT)
    except (OSError, ValueError, TimeoutError) as error:
        raise ClusterError(
            f"--cluster {address}: no scheduler answers ({in_short(error)}); start one with `dask scheduler`, or check "
            "the address, like tcp://10.0.0.5:8786"
        ) from None
    with client:
        yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """What dask logs of workers and schedulers that go is told in our words."""
    import distributed  # it sets the levels of its logs when it is imported

    named = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == distributed.__name__]
    before = {name: logging.getLogger(name).level for name in named}
    for name in named:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)
