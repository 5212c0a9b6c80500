"""The options of where work runs, shared by `batch` and `setup`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from toolpace.common.errors import UsageError


@Parameter(name="*")
@dataclass(frozen=True)
class Where:
    """A cluster, or processes of this computer."""

    cluster: Annotated[
        str | None,
        Parameter(
            help="Address of a dask scheduler, like tcp://10.0.0.5:8786; by default workers are started on this"
            " computer."
        ),
    ] = None
    workers: Annotated[
        int | None,
        Parameter(help="Workers to start on this computer; by default one for each core; 0: this process alone."),
    ] = None

    def client(self) -> str | int | None:
        """The one that was given, as `open_pool` takes it. Raises UsageError."""
        if self.cluster is not None and self.workers is not None:
            raise UsageError("--cluster and --workers: one of them; a cluster has the workers that it has")
        if self.workers is not None and self.workers < 0:
            raise UsageError(f"--workers {self.workers}: give 1 or more, or 0 for this process")
        return self.cluster if self.cluster is not None else self.workers


HERE = Where()
