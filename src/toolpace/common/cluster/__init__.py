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

from toolpace.common.cluster.opening import open_pool
from toolpace.common.cluster.pool import Outcome, Pool

__all__ = ["Outcome", "Pool", "open_pool"]
