"""Arcs whose radii differ: how far they may, by control and unit of the program, and where the tool then goes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.controllers import read_for
from tests.support.heidenhain import read as klartext
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.controllers.controller import Controller

HEAD = {"mm": "G21 G90 G94 G17 F600\n", "inch": "G20 G90 G94 G17 F20\n"}
SAID = "it changes evenly with the angle"


def arc(controller, unit, radius, off):
    """Half a circle about the origin whose end is so much farther out."""
    text = f"{HEAD[unit]}G0 X{radius} Y0 Z0\nG3 X{-radius - off:.6f} Y0 I{-radius} J0\nM30\n"
    return read_for(controller, text)


@pytest.mark.parametrize(
    ("controller", "unit", "radius", "most"),
    [
        # LinuxCNC: 2 sqrt(2) hundredths of a millimetre, or thousandths of an inch; a tenth of a percent of the larger
        # radius, but a hundred times the former at most
        ("linuxcnc", "mm", 1.0, 0.028284), ("linuxcnc", "inch", 1.0, 0.0028284), ("linuxcnc", "mm", 100.0, 0.1001),
        ("linuxcnc", "inch", 10.0, 0.01001), ("linuxcnc", "mm", 9000.0, 2.8284),
        ("fanuc", "mm", 1.0, 0.01), ("fanuc", "inch", 1.0, 0.001001), ("haas", "mm", 50.0, 0.05005),
    ],
)  # fmt: skip
def test_radii_may_differ_by_what_the_control_allows(controller, unit, radius, most):
    path = arc(controller, unit, radius, 0.98 * most)
    assert any(SAID in said for said in path.assumed)
    with pytest.raises(ProgramError, match=r"mm off its circle .*at most"):
        arc(controller, unit, radius, 1.02 * most)


def test_the_radius_changes_evenly_with_the_angle():
    """LinuxCNC's spiral, and Fanuc's (B-63324EN, 4.4: "the arc radius changes linearly with the center angle")."""
    tip = arc("linuxcnc", "mm", 100.0, 0.08).tip * 1e3
    angle, radius = np.arctan2(tip[:, 1], tip[:, 0]), np.hypot(tip[:, 0], tip[:, 1])
    angle[-1] = math.pi
    assert len(tip) > 100
    assert radius == pytest.approx(100.0 + 0.08 * angle / math.pi, abs=1e-9)


def test_what_decimals_explain_is_not_said():
    assert not any(SAID in said for said in arc("linuxcnc", "mm", 10.0, 0.002).assumed)


@pytest.mark.parametrize(("short", "read"), [(0.0012, True), (0.0014, False)])
def test_r_of_linuxcnc_may_be_shorter_than_half_the_chord_by_a_rounding(short, read):
    """0.00005 inch; the arc is then half a circle about the middle of the chord."""
    text = f"{HEAD['mm']}G0 X0 Y0 Z0\nG2 X20 Y0 R{10 - short}\nM2\n"
    if not read:
        with pytest.raises(ProgramError, match="is too small"):
            read_for("linuxcnc", text)
        return
    tip = read_for("linuxcnc", text).tip * 1e3
    assert np.hypot(tip[:, 0] - 10.0, tip[:, 1]) == pytest.approx(10.0, abs=1e-9) and tip[:, 1].max() > 9.99


def test_a_file_of_a_controller_tells_another_tolerance():
    """As parameter 3410 of Fanuc does, or CENTER_ARC_RADIUS_TOLERANCE_MM in the INI file of a LinuxCNC."""
    own = Controller.from_toml('name = "own"\nlike = "fanuc"\nnote = "ours"\n[options]\narc_radii_mm = 0.5\n')
    assert len(read_for(own, f"{HEAD['mm']}G0 X10 Y0 Z0\nG3 X-10.4 Y0 I-10 J0\nM30\n")) > 10


@pytest.mark.parametrize(("unit", "most"), [("MM", 0.016), ("INCH", 0.016 / 25.4)])
@pytest.mark.parametrize("radius", [1.0, 100.0])
def test_radii_of_klartext_may_differ_by_sixteen_micrometres(unit, most, radius):
    """"Input tolerance: up to 0.016 mm (selected through the circleDeviation machine parameter)" (TNC 320
    Conversational, "Circular path C"; MP7431 of iTNC 530): at any radius, in millimetres."""
    text = f"CC X+0 Y+0\nL X+{radius} F100\nC X-{{:.7f}} Y+0 DR+"
    path = klartext(text.format(radius + 0.98 * most), unit=unit)
    assert any(SAID in said for said in path.assumed)
    assert not any(SAID in said for said in klartext(text.format(radius + 0.1 * most), unit=unit).assumed)
    for words in (text, text.replace("C X-", "CP PA+180 DR+\nC X-").replace("Y+0 DR+", "Y+0.5 DR+")):
        with pytest.raises(ProgramError, match=r"off its circle .*at most 0\.016 mm"):
            klartext(words.format(radius + 1.02 * most), unit=unit)
