"""A random contour, read for a control, and held against its sampled way."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from testbed.compensation.contours import Contour, R, contour
from testbed.compensation.sampled import NoFitError, Rule, apart, way
from testbed.compensation.written import Form, klartext, word_address
from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

MOST_APART = 2e-3
"""Beyond which two ways are not the same [mm]; points lie within half a micrometre of arcs, chords within 0.1."""
SHEET = SetUp(tools={"1": Tool(0.1, R * 1e-3)})
SLIGHT, MOST_MET = math.radians(10.0), math.radians(100.0)
"""MD20230 and MD20210 as they are delivered."""
RULES = {
    "fanuc": Rule("lines"),
    "type B": Rule("lines", around=True),
    "haas": Rule("lines"),
    "mazak": Rule("lines"),
    "heidenhain": Rule("arcs"),
    "G450": Rule("arcs", SLIGHT, MOST_MET),
    "G451": Rule("met", SLIGHT, MOST_MET),
}
SAME, REFUSED_BY_BOTH, REFUSED, ACCEPTED, ELSEWHERE = "same", "refused by both", "refused here", "accepted here", "off"
Plane = Callable[[np.ndarray], np.ndarray]


class Held(NamedTuple):
    """What came of it."""

    outcome: str
    apart: float
    """[mm]; 0 where one of them refuses."""
    said: str
    """By whom it was refused, and why."""


def in_plane(tip: np.ndarray) -> np.ndarray:
    """Places (n,) in XY [mm] of tips (n, 3) [m]."""
    found: np.ndarray = (tip[:, 0] + 1j * tip[:, 1]) * 1e3
    return found


def held(
    seed: int, rule: str, form: Form, *, places: Plane = in_plane, controller: str | Controller | None = None
) -> Held:
    """Read the contour of a seed by a rule of RULES.

    places: from tips (n, 3) [m] to places in the contour's own plane (n,) [mm]. controller: by whose file it is read.
    """
    drawn = contour(seed)
    wanted: np.ndarray | str
    try:
        wanted = way(drawn, RULES[rule])
    except NoFitError as error:
        wanted = str(error)
    control = {"type B": "fanuc", "G450": "sinumerik", "G451": "sinumerik"}.get(rule, rule)
    try:
        text = _text(drawn, rule, control, form)
        found = read_text(text, None, controller=controller or control, setup=SHEET, name="part.nc")
    except ProgramError as error:
        outcome = REFUSED_BY_BOTH if isinstance(wanted, str) else REFUSED
        return Held(outcome, 0.0, str(error))
    if isinstance(wanted, str):
        return Held(ACCEPTED, 0.0, wanted)
    off = apart(places(found.tip), wanted)
    return Held(SAME if off <= MOST_APART else ELSEWHERE, off, "")


def _text(drawn: Contour, rule: str, control: str, form: Form) -> str:
    if control == "heidenhain":
        return klartext(drawn, form)
    if control == "sinumerik":
        form = Form(**{**vars(form), "head": f"{rule}\n{form.head}"})
    return word_address(drawn, control, form)
