"""How the judge has a tool bend: against the integral of its moments, and the closed form of a bar."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.cutting.forces import tool_beam
from toolpace.judge.cut.beam import ToolBeam
from toolpace.programs.tool_figures import Frustum, ToolFigures

BEAMS = {
    "bar": ToolFigures("flat", 10e-3, stick_out=40e-3, flute_length=20e-3, material="carbide"),
    "cone": ToolFigures(
        "taper", 6e-3, taper=math.radians(5.0), stick_out=50e-3, flute_length=20e-3, material="HSS",
        shank=(Frustum(10e-3, 9e-3, 12e-3),),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BEAMS)
def test_a_tool_bends_as_the_integral_of_its_moments_says(name):
    tool = BEAMS[name]
    height = np.linspace(0.0, tool.stick_out, 23)
    found, wanted = ToolBeam(tool).compliance(height, height), tool_beam.ToolBeam.of(tool).compliance(height, height)
    assert found == pytest.approx(wanted, rel=1e-3, abs=1e-5 * wanted.max())


def test_an_even_bar_bends_by_the_cube_of_its_length():
    tool = ToolFigures("flat", 10e-3, stick_out=60e-3, flute_length=1e-12, material="steel")
    stiff = 207e9 * math.pi * 10e-3**4 / 64.0
    (bent,) = ToolBeam(tool).compliance(np.zeros(1), np.zeros(1))[0]
    assert bent == pytest.approx(60e-3**3 / (3.0 * stiff), rel=1e-6)
