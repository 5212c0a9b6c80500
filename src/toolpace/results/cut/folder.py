"""The folder of a cut: figures, engagement, the stock after each operation, and a page.

| file | what is in it |
|---|---|
| cut.json | what `cut --json` prints |
| engagement.parquet | a row a station: place, time, what is removed, and the arcs of each slice in material |
| stock-1-2.stl | the stock of the first program after its second operation, in mm |
| cut-1.html | the page of the first program |
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from toolpace.common import __version__
from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import whole_folder
from toolpace.common.units import MILLIMETRE
from toolpace.results.cut.page import cut_page
from toolpace.results.cut.record import MM3, cut_record
from toolpace.results.workpiece.stock_stages import Cut
from toolpace.results.workpiece.view import WorkpieceView, cuts_of, view_of_cut

if TYPE_CHECKING:
    from toolpace.cutting.engagement.table import EngagementTable
    from toolpace.cutting.simulation.operation_cut import CutStretch
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import Stock
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.toolpath import ToolPath

RECORD, ENGAGEMENT = "cut.json", "engagement.parquet"
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""Of binary STL."""


class ProgramCut(Protocol):
    """One program, planned and cut."""

    @property
    def program(self) -> str: ...
    @property
    def toolpath(self) -> ToolPath: ...
    @property
    def trajectory(self) -> Trajectory: ...
    @property
    def simulation(self) -> CutSimulation: ...
    @property
    def setup(self) -> SetUp: ...
    @property
    def text(self) -> bytes:
        """What its file holds."""


@contextmanager
def written_in(directory: Path) -> Iterator[Path]:
    """A folder that takes the place of `directory` when the block ends well. Raises UsageError without pyarrow."""
    arrow()
    with whole_folder(directory, seal=RECORD) as folder:
        yield folder


def arrow() -> Any:
    """The library of Parquet. Raises UsageError, naming the extra, where it is missing."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise UsageError(
            "--out writes engagement as Parquet, which needs pyarrow: pip install 'toolpace[parquet]', or leave --out"
        ) from None
    return pyarrow


class CutFolder:
    """Takes the stock after each operation while programs are cut, and what was found at the end."""

    def __init__(self, folder: Path, programs: Sequence[str], machine: str) -> None:
        self.folder, self.programs, self.machine = folder, programs, machine
        self.files: list[str] = []

    def after_operation(self, program: int, operation: int, stock: Stock) -> None:
        """Write the stock."""
        name = f"stock-{program + 1}-{operation + 1}.stl"
        write_stl(self.folder / name, stock.triangles())
        self.files.append(name)

    def finish(self, found: Sequence[ProgramCut]) -> list[str]:
        """Write all else; return the names of the files, the page of the first program last."""
        records = [cut_record(each.simulation, each.program, self.machine) for each in found]
        text = json.dumps({"programs": records, "toolpace_version": __version__}, indent=2, allow_nan=False)
        (self.folder / RECORD).write_text(text + "\n", encoding="utf-8")
        write_engagement(self.folder / ENGAGEMENT, [each.simulation for each in found])
        pages = [f"cut-{k + 1}.html" for k in range(len(found))]
        for name, each, view in zip(pages, found, views_in_turn(found)):
            page = cut_page(
                each.simulation, each.trajectory, each.toolpath, view, each.program, self.machine, each.text
            )
            (self.folder / name).write_text(page, encoding="utf-8")
        return [RECORD, ENGAGEMENT, *self.files, *reversed(pages)]


def views_in_turn(found: Sequence[ProgramCut]) -> Iterator[WorkpieceView]:
    """What is to be seen of programs of which each cuts what the one before left."""
    from toolpace.cutting.simulation import set_up

    stock: Floats | None = None
    before: list[Cut] = []
    for each in found:
        machine = each.trajectory.axis_path.machine
        assert machine is not None
        tools, _ = set_up.tools_in_use(each.toolpath, each.setup)
        if stock is None:
            stock = set_up.stock_body(each.toolpath, each.setup, machine, tools)[1].triangles()
        yield view_of_cut(each.simulation, each.trajectory, each.toolpath, each.setup, stock, before)
        before = before + cuts_of(each.simulation, tools)


def write_stl(file: Path, triangles: Floats) -> None:
    """Write triangles (n, 3, 3) [m] as binary STL in mm."""
    rows = np.zeros(len(triangles), dtype=TRIANGLE)
    rows["corners"] = triangles / MILLIMETRE
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = np.divide(normal, length, where=length > 0.0, out=np.zeros_like(normal))
    head = f"toolpace {__version__}, mm".encode().ljust(80)
    with file.open("wb") as stream:
        stream.write(head + np.uint32(len(rows)).tobytes())
        rows.tofile(stream)


def write_engagement(file: Path, simulations: Sequence[CutSimulation]) -> None:
    """Write the engagement of all programs: lengths in mm, volumes in mm3, times in s, angles in rad.

    slice, entry and exit are lists, one entry for each arc: slice j is from j to j + 1 of slice_height_mm above the
    tip. What begins with `certain` and `possible` is of the smallest and of the largest stock.
    """
    pa = arrow()
    writer = None
    try:
        for program, simulation in enumerate(simulations):
            for stretch in simulation.stretches:
                table = pa.table(_columns(pa, program, stretch))
                if writer is None:
                    writer = pa.parquet.ParquetWriter(file, table.schema, compression="zstd")
                writer.write_table(table)
        if writer is None:
            pa.parquet.write_table(pa.table({"program": pa.array([], pa.int32())}), file)
    finally:
        if writer is not None:
            writer.close()


def _columns(pa: Any, program: int, stretch: CutStretch) -> dict[str, Any]:
    """The rows of a stretch, by name; its first station is where the one before ends."""
    stations, found = stretch.stations, stretch.engagement
    count = len(stations)
    columns: dict[str, Any] = {
        "program": np.full(count, program, dtype=np.int32),
        "operation": stations.operation.astype(np.int32),
        "line": stations.block.astype(np.int32),
        "rapid": stations.rapid,
        "time_s": stations.time,
    }
    columns |= {f"tip_{axis}_mm": stations.tip[:, k] / MILLIMETRE for k, axis in enumerate("xyz")}
    columns |= {f"axis_{axis}": stations.axis[:, k] for k, axis in enumerate("xyz")}
    columns |= {f"feed_{axis}": found.feed_direction[:, k] for k, axis in enumerate("xyz")}
    columns |= {"across": found.across, "along": found.along, "bottom": found.bottom}
    for name, each in (("", found), ("certain_", stretch.certain), ("possible_", stretch.possible)):
        columns |= _sums(name, each)
    columns["slice_height_mm"] = np.full(count, found.slice_height / MILLIMETRE)
    offsets = pa.array(found.first_arc.astype(np.int32))
    arcs = {"slice": found.slice.astype(np.int32), "entry": found.entry, "exit": found.exit}
    return columns | {
        name: pa.ListArray.from_arrays(offsets, pa.array(np.ascontiguousarray(values))) for name, values in arcs.items()
    }


def _sums(name: str, found: EngagementTable) -> dict[str, Floats]:
    return {
        f"{name}removed_mm3": found.removed / MM3,
        f"{name}width_mm": found.width / MILLIMETRE,
        f"{name}depth_mm": found.depth / MILLIMETRE,
    }
