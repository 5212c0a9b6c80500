"""Times that a commercial control took, measured by others, beside those of its model.

Ströbel, Kader, Mau, Deucker, Bless, Oexle (2025), Part series dataset of milling processes for time series prediction,
KIT, doi 10.35097/ctvuj6dgzepzmk0g: positions that a Sinumerik on a DMC 60 H commanded, 500 Hz, resampled to 20 ms. Its
limits are those that the log itself shows in other moves: rapids of 118 mm in Z and 22 mm in X, and an approach in Y.
"""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import MODELS
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.programs.reading import Source, read_commanded

HALF_RAMP = 0.0139
"""Measured between places at full feed: what a rest at either end of the model's motion takes more [s]."""
SWITCHED = 0.045
"""How long the control waits where the program says F, S and M3 anew [s], from the log: no model knows it."""
NOTCH = "".join(
    f"G0 Z{z}\nG1 X30 F350\nG2 X60 Y30 I0 J-30\nG1 Y10\nG1 X40\nG1 X-10 Y60\nF350 S1000 M3\n" for z in (30, 24, 18)
)
"""Three passes of 197.8 mm, each 6 mm deeper: corners of 90 and 45 degrees, and an arc."""
STARTS = [(37.5, -5), (37.5, 10), (25, 10), (10, 25), (10, 40), (15, 50), (15, 60), (10, 70), (10, 89.023)]
ENDS = [(65, 92.711), (65, 70), (60, 60), (60, 50), (65, 40), (65, 25), (50, 10), (37.5, 10), (37.5, -5)]
"""Of the contour of a plate: corners of 90, 45 and 27 degrees."""


def machine() -> Machine:
    """The axes of the log: 3.0 and 3.2 m/s^2, 50 m/s^3."""
    plain = Machine.load("xyzac-trunnion")
    limits = np.stack([plain.limits.velocity, plain.limits.acceleration, plain.limits.jerk])
    limits[:, :3] = [[0.5] * 3, [3.0, 3.0, 3.2], [50.0] * 3]
    return plain.with_limits(Limits(*limits, plain.joints))


def lines(points: list[tuple[float, float]]) -> str:
    """Lines through points [mm] at F576."""
    first, *others = points
    return f"G0 X{first[0]} Y{first[1]} Z50\n" + "".join(f"G1 X{x} Y{y} F576\n" for x, y in others)


def times(body: str, mode: str) -> np.ndarray:
    """Of each move [s], in a mode of corners; the program says none, and the control's own is not known."""
    text = f"G90 G94 G710\n{mode}\nSOFT\nG0 X-10 Y60 Z50\n{body}M30\n"
    moves = read_commanded(Source.from_text(text, "part.mpf"), machine())
    return MODELS["sinumerik"](moves, machine(), figures_of({}, "", "sinumerik")).times


@pytest.mark.parametrize("body, count, measured", [
    (NOTCH, 6, 34.190 - SWITCHED),
    (lines(STARTS), 8, 12.1426 + 2.0 * HALF_RAMP),
    (lines(ENDS), 8, 12.5267 + 2.0 * HALF_RAMP),
], ids=["notch", "plate, its start", "plate, its end"])  # fmt: skip
def test_a_sinumerik_took_a_time_between_rounded_corners_and_stops(body: str, count: int, measured: float):
    """Feeds are low: corners are all that a model can be wrong in, and cost 0.4 to 1.5 percent here."""
    rounded, smooth, stops = (float(times(body, mode)[-count:].sum()) for mode in ("G642", "G64", "G60"))
    assert rounded < smooth < measured < stops
    assert smooth > 0.993 * measured and stops < 1.003 * measured
