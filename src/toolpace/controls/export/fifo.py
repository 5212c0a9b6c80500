"""Target `beckhoff-fifo`: positions for TwinCAT's NC FIFO axes.

The FIFO of a channel has Z rows of N axes. The PLC hands it arrays of LREAL, row by row, with FiFoWrite, and keeps it
filled; the NC takes a row each FIFO cycle time T_f, goes straight between rows where its own cycle T_saf is shorter,
and leaves rows out where it is longer. Where the FIFO runs dry the axes stand at once.
Source: Beckhoff Information System, TS5060 and TF5060 (TwinCAT NC FIFO Axes): FIFO Parameters and the FIFO; Sequence
and the Generation of Set Values; FiFoGetDimension, FiFoGroupIntegrate, FiFoWrite, FiFoStart. These name no largest Z
or N: what a channel has is what FiFoGetDimension tells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time
from toolpace.controls.export.rows import WHOLE, Rows, Scale, refuse_no_cycle, refuse_tool_changes, rows_every, scale_of
from toolpace.controls.export.target import PlannedMotion, ReadBack, Written, provenance, start_in_words

ROWS, HOW_TO = "rows.lreal", "how_to_use.txt"
REST = 0.1
"""Time at rest behind the motion [s]: a stationary interval is how positioning ends (Sequence, End Phase)."""
CYCLES = 2
"""PLC cycles that a full FIFO must last at least."""


@dataclass(frozen=True, kw_only=True)
class Fifo:
    """Rows of LREAL, and how to feed them."""

    name: ClassVar[str] = "beckhoff-fifo"
    period: float | None = None
    """FIFO cycle time T_f [s]; None: the plan's time step."""
    resample: bool = False
    """Whether rows may lie between set-points."""
    scale: str = "mm,deg"
    fifo_rows: int | None = None
    """Rows of the channel's FIFO; None: not known, and what is needed is said."""
    fifo_axes: int | None = None
    """Axes of the channel's FIFO; None: taken to be those of the machine."""
    nc_cycle: float | None = None
    """Cycle time of the SAF task [s]; None: that of the rows."""
    plc_cycle: float = 10e-3
    """Cycle time of the PLC that fills the FIFO [s]."""

    def __post_init__(self) -> None:
        refuse_no_cycle("--period", self.period)
        refuse_no_cycle("--nc-cycle", self.nc_cycle)
        refuse_no_cycle("--plc-cycle", self.plc_cycle)

    def write(self, motion: PlannedMotion, folder: Path) -> Written:
        """Write rows.lreal and how_to_use.txt. Raises UsageError where the FIFO cannot hold the plan."""
        rows, scale = self._rows(motion)
        self._refuse(motion, rows)
        (folder / ROWS).write_bytes(self._table(rows, scale).astype("<f8").tobytes())
        notes = self._notes(motion, rows)
        text = [
            *provenance(motion, "Rows for TwinCAT NC FIFO axes"),
            "",
            *self._how_to_use(motion, rows, scale),
            "",
            *notes,
        ]
        (folder / HOW_TO).write_text("\n".join(text) + "\n", encoding="utf-8")
        return Written([ROWS, HOW_TO], notes)

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Every position must be there to the last bit."""
        right = self._table(*self._rows(motion))
        data = (folder / ROWS).read_bytes()
        same = len(data) == 8 * right.size
        worst = float(np.abs(np.frombuffer(data, dtype="<f8") - right.ravel()).max()) if same else math.inf
        return [ReadBack("largest difference of a position [mm, deg]", worst, 0.0).raise_if_failed(folder / ROWS)]

    def _rows(self, motion: PlannedMotion) -> tuple[Rows, Scale]:
        return rows_every(motion, self.period or motion.dt, self.resample), scale_of(motion, self.scale, {})

    def _rest(self, rows: Rows) -> int:
        return math.ceil(REST / rows.period)

    def _table(self, rows: Rows, scale: Scale) -> Floats:
        q = rows.points.q
        table: Floats = np.concatenate([q, np.tile(q[-1], (self._rest(rows), 1))]) * scale.factors
        return table

    def _refuse(self, motion: PlannedMotion, rows: Rows) -> None:
        refuse_tool_changes(motion, self.name)
        joints = motion.joints
        if self.fifo_axes is not None and self.fifo_axes != len(joints):
            raise UsageError(
                f"--fifo-axes {self.fifo_axes}: the plan has {len(joints)} columns ({', '.join(joints)}), and each row "
                f"fills the FIFO's axes; parameterise the FIFO group for {len(joints)} axes"
            )
        ratio = rows.period / (self.nc_cycle or rows.period)
        if ratio < 1.0 - WHOLE:
            raise UsageError(
                f"--period {format_time(rows.period)} is shorter than the NC's cycle "
                f"({format_time(self.nc_cycle or 0.0)}), "
                f"which would leave rows out; give --period {(self.nc_cycle or 0.0) * 1e3:.6g}ms or a multiple of it"
            )
        if abs(ratio - round(ratio)) > WHOLE * ratio:
            raise UsageError(
                f"--period {format_time(rows.period)} is {ratio:.6g} cycles of the NC, not a whole number of "
                "them: speeds "
                f"would swing; give a multiple of {(self.nc_cycle or 0.0) * 1e3:.6g}ms"
            )
        needed = self._least(rows)
        if self.fifo_rows is not None and self.fifo_rows < needed:
            raise UsageError(
                f"--fifo-rows {self.fifo_rows}: they last {format_time(self.fifo_rows * rows.period)}, and a "
                "PLC that comes "
                f"every {format_time(self.plc_cycle)} needs {needed} rows ({CYCLES} cycles) not to let them run dry; "
                "parameterise a longer FIFO, or take a longer --period or a shorter --plc-cycle"
            )

    def _least(self, rows: Rows) -> int:
        """Fewest rows of the FIFO."""
        return max(math.ceil(CYCLES * self.plc_cycle / rows.period), 2)

    def _how_to_use(self, motion: PlannedMotion, rows: Rows, scale: Scale) -> list[str]:
        count, columns = len(rows.points) + self._rest(rows), len(motion.joints)
        length = self.fifo_rows or self._least(rows)
        named = ", ".join(
            f"{k + 1} {joint} [{unit}]" for k, (joint, unit) in enumerate(zip(motion.joints, scale.units))
        )
        return [
            f"{ROWS}: {count} rows of {columns} LREAL (8 bytes each, lowest byte first), row after row, no header",
            f"columns, which are the group positions of the axes (FiFoGroupIntegrate): {named}",
            f"FIFO cycle time T_f {rows.period:.9g} s; FIFO dimension {columns}; FIFO length at least "
            f"{self._least(rows)}",
            "",
            "1. Move every axis in PTP mode to the first row: " + start_in_words(motion) + ".",
            "2. Put the axes into the FIFO group, in the order of the columns (FiFoGroupIntegrate), and compare",
            "   FiFoGetDimension with the figures above.",
            f"3. Fill the FIFO with FiFoWrite, iColDim {columns}, in pieces of at most {max(length // 2, 1)} "
            "rows (a piece that",
            "   does not fit is refused as a whole, and is offered again), then FiFoStart.",
            f"4. Every PLC cycle ({format_time(self.plc_cycle)}) top it up: where it runs dry the axes stand at once.",
            "5. Behind the last row the axes rest; then FiFoStop and FiFoGroupDisintegrate.",
            "",
            "Leave the channel override at 100 %, and set no filter of set values in drives or axes: each would change",
            "the motion. Check first in simulation (axes with simulation encoders), then in the air.",
        ]

    def _notes(self, motion: PlannedMotion, rows: Rows) -> list[str]:
        notes = [
            f"{len(rows.points) + self._rest(rows)} rows every {format_time(rows.period)}; the FIFO needs at least "
            f"{self._least(rows)} rows for a PLC cycle of {format_time(self.plc_cycle)}"
        ]
        if rows.error.any():
            worst = motion.by_joint(rows.error)
            notes.append(f"rows lie between set-points of the plan: interpolated, off by at most {worst}")
        if round(rows.period / (self.nc_cycle or rows.period)) > 1:
            notes.append(
                "the NC moves straight between rows: it deviates from the motion by at most "
                f"{motion.by_joint(rows.sag)}, and speeds change in steps"
            )
        return notes
