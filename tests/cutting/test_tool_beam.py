"""The tool as a cantilever of pieces, against textbooks and against a chain of finite elements made here."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.common.errors import UsageError
from toolpace.cutting.compliance import Bending
from toolpace.cutting.forces.tool_beam import ToolBeam
from toolpace.programs.tool_figures import Frustum, ToolFigures


def finite_elements(beam, nodes=400):
    """Compliance of all nodes (Hermite elements of constant diameter), and their heights; the last node is clamped."""
    x = np.linspace(0.0, beam.length, nodes + 1)
    stiffness = np.zeros((2 * nodes + 2, 2 * nodes + 2))
    for k in range(nodes):
        middle, length = 0.5 * (x[k] + x[k + 1]), x[k + 1] - x[k]
        piece = np.searchsorted(beam.breaks, middle) - 1
        share = (middle - beam.breaks[piece]) / (beam.breaks[piece + 1] - beam.breaks[piece])
        diameter = beam.diameter[piece] @ [1.0 - share, share]
        bend = beam.youngs_modulus * np.pi * diameter**4 / 64.0 / length**3
        h = length
        stiffness[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += bend * np.array(
            [
                [12, 6 * h, -12, 6 * h],
                [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, 2 * h * h, -6 * h, 4 * h * h],
            ]
        )
    return np.linalg.inv(stiffness[:-2, :-2])[::2, ::2], x[:-1]


def test_a_bar_of_one_diameter_is_the_cantilever_of_textbooks():
    tool = ToolFigures("flat", 8e-3, flute_length=40e-3, stick_out=40e-3, material="carbide")
    found = ToolBeam.of(tool).compliance(np.array([0.0]), np.array([0.0]))[0, 0]
    right = Bending.cantilever(0.8 * 8e-3, 40e-3, 580e9).compliance[0, 0]
    assert found == pytest.approx(right, rel=1e-12)


@pytest.mark.parametrize(
    "figures",
    [
        {"flute_length": 15e-3, "shank_diameter": 10e-3},
        {"flute_length": 12e-3, "shank": (Frustum(10e-3, 6e-3, 9e-3), Frustum(5e-3, 12e-3, 12e-3))},
        {"kind": "taper", "corner_radius": 1e-3, "taper": np.radians(4.0), "flute_length": 30e-3},
    ],
)
def test_pieces_bend_as_a_chain_of_finite_elements(figures):
    tool = ToolFigures(**{"kind": "flat", "diameter": 8e-3, "stick_out": 45e-3, "material": "HSS", **figures})
    beam = ToolBeam.of(tool)
    right, x = finite_elements(beam)
    found = beam.compliance(x[::20], x[::25])
    np.testing.assert_allclose(found, right[::20, ::25], rtol=2e-3, atol=1e-4 * right.max())


def test_what_is_missing_is_asked_for():
    with pytest.raises(UsageError, match="stick_out"):
        ToolBeam.of(ToolFigures("flat", 8e-3, material="carbide"))
    with pytest.raises(UsageError, match="one of carbide"):
        ToolBeam.of(ToolFigures("flat", 8e-3, stick_out=30e-3))
    assert ToolBeam.of(ToolFigures("flat", 8e-3, stick_out=30e-3), 200e9).youngs_modulus == 200e9
