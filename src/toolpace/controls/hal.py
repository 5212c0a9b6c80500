"""LinuxCNC's HAL: its Python module, a component's pins, the queue of a streamer, and the approach to its first row."""

from __future__ import annotations

import importlib
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import MILLIMETRE
from toolpace.machine.limits import Limits

PLACES = (Path("/usr/lib/python3/dist-packages"),)
"""Where Debian has it."""
JOINTS = 5
CONFIG = "f" * JOINTS
"""Of the streamer's rows."""
AXES = "xyz"
IN: dict[str, tuple[str, float]] = {
    "enable": ("BIT", 0),
    "hold": ("BIT", 0),
    "resume": ("BIT", 0),
    "feed-override": ("FLOAT", 1.0),
    **{f"deflection-{axis}": ("FLOAT", 0.0) for axis in AXES},
    "deflection-valid": ("BIT", 1),
    **{f"position-{j}": ("FLOAT", 0.0) for j in range(JOINTS)},
}
"""Kind and value of each pin that is read, until something is connected with it; in mm, degrees and seconds."""
OUT = {
    "playing": "BIT",
    "ended": "BIT",
    "status": "U32",
    "time": "FLOAT",
    "path-time": "FLOAT",
    "s": "FLOAT",
    "pace": "FLOAT",
    **{f"correction-{j}": "FLOAT" for j in range(JOINTS)},
    "backlog": "U32",
    "late": "U32",
}
"""Kind of each pin that is written."""
SHARE = 0.25
"""Of each limit that the approach uses at most: nobody gains by a fast one."""
PEAKS = (1.875, 10.0 / math.sqrt(3.0), 60.0)
"""Largest slope, second and third derivative of 10 u^3 - 15 u^4 + 6 u^5 on 0 to 1."""


def hal_module(places: tuple[Path, ...] = PLACES) -> Any:
    """The module `hal`, from Python's own path or from where LinuxCNC is installed. Raises UsageError with the cure."""
    if "hal" in sys.modules:
        return sys.modules["hal"]
    found = [str(place) for place in places if (place / "hal.py").is_file()]
    # last, and for this import alone: the packages beside it are of the system's Python
    sys.path.extend(found)
    try:
        return importlib.import_module("hal")
    except ImportError as error:
        if found:
            raise UsageError(
                f"{found[0]}: LinuxCNC's module hal does not load in Python {sys.version.split()[0]} ({error}); run"
                " toolpace with the Python that LinuxCNC was built for, /usr/bin/python3"
            ) from None
        raise UsageError(
            "LinuxCNC's Python module hal was not found; install LinuxCNC (Debian: apt-get install linuxcnc-uspace), or"
            " name the folder of hal.py in PYTHONPATH"
        ) from None
    finally:
        for place in found:
            sys.path.remove(place)


class Request(NamedTuple):
    """What the pins ask for."""

    feed: float
    """Override, 0 where the tool shall stand."""
    deflection: Floats | None
    """(3,) [m]; None where there is none."""
    resume: bool


def make_pins(hal: Any, component: Any) -> None:
    """Every pin of the component, with what it holds until something is connected."""
    for name, (kind, value) in IN.items():
        component.newpin(name, getattr(hal, f"HAL_{kind}"), hal.HAL_IN)
        component[name] = value
    for name, kind in OUT.items():
        component.newpin(name, getattr(hal, f"HAL_{kind}"), hal.HAL_OUT)


def read_request(pins: Any) -> Request:
    """What the pins ask for now."""
    feed = pins["feed-override"] if pins["enable"] and not pins["hold"] else 0.0
    deflection = None
    if pins["deflection-valid"]:
        deflection = MILLIMETRE * np.array([pins[f"deflection-{axis}"] for axis in AXES])
    return Request(0.0 if math.isnan(feed) else feed, deflection, bool(pins["resume"]))


def position(pins: Any) -> Floats:
    """(m,) where the joints stand [mm, deg]."""
    return np.array([pins[f"position-{j}"] for j in range(JOINTS)])


def approach(start: Floats, end: Floats, limits: Limits, period: float) -> Floats:
    """Rows (n, m) every `period` [s] from `start` (m,) to just before `end` (m,), all joints on one straight line; none
    where both are the same."""
    way = np.abs(end - start)
    if not way.any():
        return np.empty((0, len(start)))
    seconds = 0.0
    kinds = (limits.velocity, limits.acceleration, limits.jerk)
    for order, (limit, peak) in enumerate(zip(kinds, PEAKS), start=1):
        seconds = max(seconds, float(((peak * way / (SHARE * limit)) ** (1.0 / order)).max()))
    steps = max(math.ceil(seconds / period), 1)
    u = np.arange(steps) / steps
    rows: Floats = start + (u**3 * (10.0 - 15.0 * u + 6.0 * u**2))[:, None] * (end - start)
    return rows


class Rows:
    """Rows of joints [mm, deg] on their way to the realtime side."""

    def __init__(self, hal: Any, component: Any, key: int, ahead: int) -> None:
        """Attach to the streamer of a number, to be kept `ahead` rows full. Raises UsageError where there is none."""
        try:
            self._stream = hal.stream(component, hal.streamer_base + key, CONFIG)
        except Exception:  # of several kinds in hal
            raise UsageError(
                f"HAL has no streamer number {key} of {JOINTS} floats; before this, load it:"
                f" loadrt streamer depth=1000 cfg={CONFIG}"
            ) from None
        if self._stream.maxdepth <= ahead:
            raise UsageError(
                f"streamer number {key} holds {self._stream.maxdepth - 1} rows, the backlog is {ahead}; load it with"
                f" depth={2 * ahead}, or take a shorter --backlog"
            )
        self.ahead = ahead
        self.given = 0
        """Rows written so far."""
        self._dry = 0

    @property
    def depth(self) -> int:
        """Rows that wait."""
        return int(self._stream.depth)

    @property
    def room(self) -> int:
        """Rows that are missing."""
        return max(self.ahead - self.depth, 0)

    def write(self, row: list[float]) -> None:
        """Append a row."""
        self._stream.write(tuple(row))
        self.given += 1

    def count_from_here(self) -> None:
        """Periods without a row count from now on."""
        self._dry = int(self._stream.num_underruns)

    @property
    def late(self) -> int:
        """Servo periods that found no row."""
        return int(self._stream.num_underruns) - self._dry
