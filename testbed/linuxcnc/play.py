"""Play rows of set-points through HAL's streamer and limit3: an independent referee, without a planner."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from testbed.linuxcnc.instance import SPEED, LinuxCNCError, execute, folder, last_words
from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits

DEPTH = 20_000
"""Of the queues from and to the servo thread, in cycles."""


@dataclass(frozen=True)
class Played:
    """What the servo thread saw, one row a cycle, from the first row that was given to the last."""

    commanded: Floats
    """(n, m) as the streamer handed them out, in the unit of the rows given."""
    limited: Floats
    """(n, m) what limit3 made of them."""

    @property
    def deviation(self) -> Floats:
        """(m,) most that limit3 had to change."""
        return np.abs(self.limited - self.commanded).max(axis=0)


def play(
    rows: Floats, limits: Limits | None = None, *, cycle: float = 1e-3, seconds: float = 600.0, speed: int = SPEED
) -> Played:
    """The rows (n, m), one a servo cycle, through limit3 with `limits` in their units (None: without).

    Raises LinuxCNCError where LinuxCNC is missing, takes longer than `seconds` of real time, or a cycle was lost or
    found no row.
    """
    rows = np.ascontiguousarray(rows, dtype=float)
    count, width = rows.shape
    if count < 2:
        raise LinuxCNCError(f"{count} rows to play; give two or more")
    with folder() as place:
        (place / "play.hal").write_text(_hal(width, limits, cycle), encoding="utf-8")
        (place / "played.json").write_text(json.dumps({"width": width, "cycle": cycle}), encoding="utf-8")
        rows.tofile(place / "rows.bin")
        player = shutil.copy(Path(__file__).with_name("player.py"), place / "player.py")
        player.chmod(0o755)
        printed = execute(["halrun", "-f", "play.hal"], place, seconds, speed)
        try:
            ended = json.loads((place / "ended.json").read_text())
            seen = np.fromfile(place / "out.bin", dtype=float).reshape(-1, 1 + 2 * width)
        except (OSError, ValueError):
            raise LinuxCNCError(f"HAL did not play the rows: {last_words(printed)}") from None
    if ended["lost"] or ended["left"] or ended["sent"] < count:
        raise LinuxCNCError(f"HAL played {ended['sent'] - ended['left']} of {count} rows, lost {ended['lost']} samples")
    return _from_first_to_last(rows, seen)


def _from_first_to_last(rows: Floats, seen: Floats) -> Played:
    """Those cycles that had a row; one in which the streamer found none repeats the row before it."""
    count, width = rows.shape
    leading = np.flatnonzero(seen[:, 0] != 0.0)
    if not len(leading):
        raise LinuxCNCError("HAL played no row")
    first = int(leading[-1]) + 1
    found = seen[first : first + count]
    if len(found) < count or not np.array_equal(found[:, 1 : 1 + width], rows):
        wrong = int(np.argmax(np.any(found[:, 1 : 1 + width] != rows[: len(found)], axis=1)))
        raise LinuxCNCError(f"HAL's streamer found no row in cycle {wrong}: the player was too slow; lower the speed")
    return Played(found[:, 1 : 1 + width], found[:, 1 + width :])


def _hal(width: int, limits: Limits | None, cycle: float) -> str:
    lines = [
        f"loadrt threads name1=servo-thread period1={round(cycle * 1e9)}",
        f"loadrt streamer depth={DEPTH} cfg=b{'f' * width}", f"loadrt sampler depth={DEPTH} cfg=b{'f' * (2 * width)}",
        f"loadrt limit3 count={width}", "setp streamer.0.enable 0", "setp sampler.0.enable 0",
        "addf streamer.0 servo-thread", *(f"addf limit3.{k} servo-thread" for k in range(width)),
        "addf sampler.0 servo-thread",
        "net begin streamer.0.pin.0 => sampler.0.pin.0 " + " ".join(f"limit3.{k}.load" for k in range(width)),
    ]  # fmt: skip
    for k in range(width):
        if limits is not None:
            lines.append(f"setp limit3.{k}.maxv {float(limits.velocity[k])!r}")
            lines.append(f"setp limit3.{k}.maxa {float(limits.acceleration[k])!r}")
        lines.append(f"net in{k} streamer.0.pin.{k + 1} => limit3.{k}.in sampler.0.pin.{k + 1}")
        lines.append(f"net out{k} limit3.{k}.out => sampler.0.pin.{k + 1 + width}")
    return "\n".join([*lines, "start", "loadusr -w ./player.py"]) + "\n"
