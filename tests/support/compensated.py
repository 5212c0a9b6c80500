"""Programs with a compensated tool of 4 mm, for four controls."""

from __future__ import annotations

from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

R = 4.0
"""Of the tool [mm]."""
SHEET = SetUp(tools={"1": Tool(0.1, R * 1e-3), "2": Tool(0.1), "3": Tool(0.1, 3e-3)})
HEADS = {
    "fanuc": "G21 G90 G17 G94\nT1 M6\n",
    "haas": "G21 G90 G17 G94\nT1 M6\n",
    "sinumerik": "G71 G90 G17 G94\nT1 M6\n",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n",
}


def read(text: str, control: str, sheet: SetUp = SHEET):
    return read_text(HEADS[control] + text, None, controller=control, setup=sheet, name="part.nc")
