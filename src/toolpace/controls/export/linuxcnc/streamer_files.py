"""Target `linuxcnc-hal`: rows for HAL's streamer, one a servo period, and the HAL file that plays them.

No interpreter and no planner lie between these rows and the joints: what is written is what they are told. limit3 is
set just above what the plan uses, so that it never acts, but holds the joints back where rows are missing.
Sources: manual pages streamer(9), halstreamer(1), limit3(9) of LinuxCNC 2.9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError
from toolpace.common.units import format_time
from toolpace.controls.export.rows import CHUNK, refuse_no_cycle, refuse_tool_changes, rows_every
from toolpace.controls.export.target import PlannedMotion, ReadBack, Written, provenance, start_in_words
from toolpace.controls.hal import approach

ROWS, HAL = "rows.txt", "play.hal"
REST = 1.0
"""Time at rest before, between and behind approach and motion [s]: the FIFO is full by then, and the end is seen."""
ABOVE = (1.0005, 1.003)
"""limit3's velocity and acceleration, as shares of what the rows use: measured as the least that leave them alone."""
STILL = 1e-6
"""Share of a joint's limits that limit3 allows a joint that does not move."""
MOST_PINS = 20
"""Pins of one streamer (streamer(9))."""
DEPTH = 20_000
"""Rows in the FIFO."""


@dataclass(frozen=True, kw_only=True)
class Streamer:
    """Streamer rows in mm and degrees, and play.hal."""

    name: ClassVar[str] = "linuxcnc-hal"
    period: float | None = None
    """Servo period [s]; None: the plan's time step."""
    resample: bool = False
    """Whether rows may lie between set-points."""

    def __post_init__(self) -> None:
        refuse_no_cycle("--period", self.period)

    def write(self, motion: PlannedMotion, folder: Path) -> Written:
        """Write rows.txt and play.hal. Raises UsageError where they cannot hold the plan."""
        self._refuse(motion)
        rows, lead = self._rows(motion)
        period = self.period or motion.dt
        units = motion.shop_units[0]
        head = [
            *provenance(motion, "Joint positions for HAL's streamer"),
            f"columns {', '.join(f'{j} [{u}]' for j, u in zip(motion.joints, units))}; a row every {period:.9g} s",
            f"rows 1 to {lead} lead from zero to the start, row {lead + 1} is the first of the plan; play.hal "
            "plays them",
        ]
        form = " ".join(["%.17g"] * rows.shape[1]) + "\n"
        with (folder / ROWS).open("w", encoding="utf-8", newline="\n") as stream:
            stream.writelines(f"# {line}\n" for line in head)
            for start in range(0, len(rows), CHUNK):
                part = rows[start : start + CHUNK]
                stream.write((form * len(part)) % tuple(part.ravel().tolist()))
        (folder / HAL).write_text(self._hal(motion, rows, lead), encoding="utf-8")
        return Written(
            [HAL, ROWS],
            [
                f"{len(rows)} rows every {format_time(period)}: {format_time(lead * period)} from every joint "
                "at zero to "
                f"the start ({start_in_words(motion)}), then the plan",
                "limit3 stands 0.05 % above the plan's velocities and 0.3 % above its accelerations",
            ],
        )

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Every row must be there to the last bit."""
        right = self._rows(motion)[0]
        try:
            rows = np.loadtxt(folder / ROWS, comments="#", ndmin=2)
        except ValueError:
            raise VerificationError(f"{ROWS}: read back it holds what is no number; nothing was written") from None
        worst = float(np.abs(rows - right).max()) if rows.shape == right.shape else math.inf
        return [ReadBack("largest difference of a position [mm, deg]", worst, 0.0).raise_if_failed(folder / ROWS)]

    def _refuse(self, motion: PlannedMotion) -> None:
        refuse_tool_changes(motion, self.name)
        if len(motion.joints) > MOST_PINS:
            raise UsageError(
                f"--to {self.name}: {len(motion.joints)} joints, and a streamer has {MOST_PINS} pins at most"
            )
        for joint, (low, high) in zip(motion.joints, motion.machine.travel):
            if not low <= 0.0 <= high:
                raise UsageError(
                    f"--to {self.name}: joint {joint} cannot stand at zero, where limit3 starts (its travel is "
                    f"{low:g} to {high:g}, in m or rad); take --to linuxcnc-g93"
                )

    def _rows(self, motion: PlannedMotion) -> tuple[Floats, int]:
        """All rows (n, m) in mm and deg, and how many lie before the first of the plan."""
        period = self.period or motion.dt
        points = rows_every(motion, period, self.resample).points
        rest = math.ceil(REST / period)
        start = np.zeros(len(motion.joints))
        way = approach(start, points.q[0], motion.machine.limits, period)
        before = np.concatenate([np.tile(start, (rest, 1)), way, np.tile(points.q[0], (rest, 1))])
        rows: Floats = np.concatenate([before, points.q, np.tile(points.q[-1], (rest, 1))]) * motion.shop_units[1]
        return rows + 0.0, len(before)  # zero has no sign

    def _hal(self, motion: PlannedMotion, rows: Floats, lead: int) -> str:
        period, joints = self.period or motion.dt, motion.joints
        velocity, acceleration = self._presets(motion, rows)
        config = "f" * len(joints)
        lines = [
            *(f"# {line}" for line in provenance(motion, "Plays rows.txt into the joints, through limit3")),
            "#",
            "# How to use it:",
            "#  1. Try it as it is, in a simulation: halrun -I -f play.hal, in this folder.",
            "#  2. On a machine: connect toolpace-"
            + joints[0]
            + " and its like with the position commands of the joints",
            "#     (where the file says so), and let the servo thread be that of the machine, with this very period.",
            "#  3. Before it is loaded every joint must stand at zero: limit3 starts there, whatever the drives say.",
            f"#     It moves to the start first ({start_in_words(motion)}), then plays the plan.",
            "#  4. Nothing may smooth or limit the commands again: no jerk limit, no filter, no stepgen limit below",
            "#     those of limit3. Following errors of the drives are theirs.",
            "#  5. First without a workpiece and with the spindle off, and a hand on the emergency stop.",
            "# streamer.0.underruns must stay at zero from the first row on: each one is a row that came too late.",
            "",
            f"loadrt threads name1=servo-thread period1={round(period * 1e9)}",
            f"loadrt streamer depth={DEPTH} cfg={config}",
            f"loadrt limit3 count={len(joints)}",
            "setp streamer.0.enable 0",
            "addf streamer.0 servo-thread",
        ]
        for j, joint in enumerate(joints):
            lines += [
                "",
                f"setp limit3.{j}.maxv {velocity[j]:.9g}",
                f"setp limit3.{j}.maxa {acceleration[j]:.9g}",
                f"addf limit3.{j} servo-thread",
                f"net toolpace-{joint}-row streamer.0.pin.{j} => limit3.{j}.in",
                f"net toolpace-{joint} limit3.{j}.out",
                f"# connect here: net toolpace-{joint} => (position command of joint {joint})",
            ]
        lines += [
            "",
            "start",
            "# The FIFO is filled, then its rows are played.",
            f"loadusr halstreamer {ROWS}",
            "loadusr -w sleep 1",
            "setp streamer.0.enable 1",
        ]
        return "\n".join(lines) + "\n"

    def _presets(self, motion: PlannedMotion, rows: Floats) -> tuple[Floats, Floats]:
        """Velocity and acceleration (m,) of limit3, in mm and deg."""
        period, limits = self.period or motion.dt, motion.machine.limits
        found = []
        for order, (limit, above) in enumerate(zip((limits.velocity, limits.acceleration), ABOVE), start=1):
            used = np.abs(np.diff(rows, n=order, axis=0)).max(axis=0) / period**order
            least = STILL * np.where(np.isfinite(limit), limit, 1.0) * motion.shop_units[1]
            found.append(np.maximum(used * above, least))
        return found[0], found[1]
