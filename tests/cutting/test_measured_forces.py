"""Forces that were measured on a dynamometer and published, beside those of the model.

Jianhui Li, ForceCalculation, github.com/leekunhwee/ForceCalculation (of 24 October 2019): slots with mills of two
teeth, 10 000 samples at 10 kHz each. The figures below are of the mean over both teeth (which takes the runout out):
`20170822.mat` over the first 13 turns at 800 rpm, `General/Flat end milling/*.csv` over 100 turns at 6000 rpm.
Of the author's comparison there are pictures only, so no deviation of his can be quoted: ours are stated.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.engagements import shoulder
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.cutting.forces.material import Material
from toolpace.programs.tool_figures import ToolFigures

MEASURED = {
    # depth [mm]: mean along feed, normal and axis, largest across the axis [N]
    "bull": {
        1: (-26.9, 72.2, 46.1, 146.0),
        2: (-60.8, 137.9, 57.5, 287.0),
        3: (-93.4, 199.8, 47.5, 417.0),
        4: (-107.3, 253.4, 28.4, 510.0),
        5: (-123.4, 310.3, 11.1, 608.0),
    },
    "ball": {
        1: (-24.9, 93.5, 90.3, 182.0),
        2: (-57.7, 169.0, 136.9, 335.0),
        3: (-94.0, 243.7, 183.0, 473.0),
        4: (-142.0, 318.6, 215.9, 619.0),
        5: (-194.6, 382.1, 235.5, 750.0),
    },
}
FLAT = {
    # feed [mm/min]: mean along feed, normal and axis [N]
    300: (-39.8, 63.0, -55.7),
    600: (-60.1, 107.1, -70.9),
    900: (-71.6, 137.7, -82.6),
    1200: (-76.8, 171.3, -85.2),
    1500: (-78.5, 210.7, -83.5),
}


@pytest.mark.parametrize("kind, corner", [("bull", 3e-3), ("ball", 8e-3)])
def test_slots_with_round_mills(kind, corner):
    """With the coefficients that the author states: nothing here is fitted to these figures."""
    material = Material.load("aluminium-unnamed", "ball")
    tool = ToolFigures(kind, 16e-3, corner_radius=corner, teeth=2, helix=np.radians(25.0))
    for depth, (feed, normal, axis, across) in MEASURED[kind].items():
        forces = EngagedForces(shoulder(depth * 1e-3, 0.0, np.pi), tool, material.coefficients, 800.0 / 60.0)
        speed = 160e-3 / 60.0
        slope, constant = forces.over_turn([0], speed)
        turn = (slope + constant)[0]
        largest = np.hypot(turn[:, 0], turn[:, 1]).max()
        assert largest == pytest.approx(across, rel=0.11 if depth == 1 else 0.05)
        mean = forces.loads(speed).mean[0]
        assert mean[1] == pytest.approx(normal, rel=0.19 if depth == 1 else 0.08)
        assert mean[0] == pytest.approx(feed, abs=0.07 * across)
        assert mean[2] == pytest.approx(axis, abs=0.19 * across)


def test_means_of_slots_with_a_flat_mill():
    """The coefficients are the author's, fitted to these five means: this tests that they are linear in the feed.

    Only means: the largest forces of these files are of vibration (most of their spectrum is at 600 to 1000 Hz).
    """
    tool = ToolFigures("flat", 25e-3, teeth=2, helix=np.radians(45.0))
    material = Material.load("aluminium-unnamed", "helix 45")
    for feed, measured in FLAT.items():
        forces = EngagedForces(shoulder(3e-3, 0.0, np.pi), tool, material.coefficients, 100.0)
        mean = forces.loads(feed / 60e3).mean[0]
        np.testing.assert_allclose(mean, measured, rtol=0.18 if feed == 300 else 0.10)
