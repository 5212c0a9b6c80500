"""The pins of the component, in mm, degrees and seconds."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import MILLIMETRE

JOINTS = 5
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
"""Kind and value of each pin that is read, until something is connected with it."""
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


class Asked(NamedTuple):
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


def asked(pins: Any) -> Asked:
    """What the pins ask for now."""
    feed = pins["feed-override"] if pins["enable"] and not pins["hold"] else 0.0
    deflection = None
    if pins["deflection-valid"]:
        deflection = MILLIMETRE * np.array([pins[f"deflection-{axis}"] for axis in AXES])
    return Asked(0.0 if math.isnan(feed) else feed, deflection, bool(pins["resume"]))


def position(pins: Any) -> Floats:
    """(m,) where the joints stand [mm, deg]."""
    return np.array([pins[f"position-{j}"] for j in range(JOINTS)])
