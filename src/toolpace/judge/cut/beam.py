"""The bending of a tool that is clamped at its holder, by finite elements.

Elements of a beam of Euler and Bernoulli with cubic displacements (Przemieniecki, Theory of Matrix Structural Analysis,
1968): what they tell at their nodes is exact, but for the cones, whose elements have the diameter of their middle.
Flutes bend as a bar of FLUTES of their diameter.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.tool_figures import ToolFigures

FLUTES = 0.8
"""Diameter of the bar that bends as flutes do, over theirs (Kops and Vo 1990)."""
MODULI = {"carbide": 580e9, "hss": 207e9, "steel": 207e9, "ceramic": 310e9, "cermet": 450e9}
"""Young's modulus of the material of a tool [Pa]; of any other it is that of carbide."""
ELEMENTS = 40
"""Of a tool, about."""
SHORT = 1e-3
"""Share of the tool's length below which a part of it is left out: an element as short as that is too stiff beside the
others to be told in the digits of a number."""


class ToolBeam:
    """A tool from its tip to its holder. Young's modulus [Pa] is that of its material where none is told."""

    def __init__(self, tool: ToolFigures, youngs_modulus: float | None = None) -> None:
        assert tool.stick_out is not None
        self.length = tool.stick_out
        named = (value for name, value in MODULI.items() if name in tool.material.lower())
        modulus = youngs_modulus or next(named, MODULI["carbide"])
        flutes = min(tool.flute_length or tool.stick_out, tool.stick_out)
        ends = [0.0]
        for end in (*np.cumsum([flutes, *(part.length for part in tool.shank)]).tolist(), self.length):
            if end - ends[-1] > SHORT * self.length and end <= self.length:
                ends.append(end)
        ends[-1] = self.length
        parts = [np.linspace(a, b, 1 + math.ceil(ELEMENTS * (b - a) / self.length)) for a, b in pairwise(ends)]
        nodes: Floats = np.unique(np.concatenate(parts))
        self.nodes = nodes
        self.holder_diameter = float(_diameter(tool, flutes, nodes[-1:])[0])
        diameter = _diameter(tool, flutes, 0.5 * (nodes[1:] + nodes[:-1]))
        clamped = np.zeros((2 * len(nodes), 2 * len(nodes)))
        clamped[:-2, :-2] = np.linalg.inv(_stiffness(np.diff(nodes), modulus * math.pi * diameter**4 / 64.0))
        self.flexibility: Floats = clamped
        """(2 n, 2 n) displacement and slope of n nodes per force and moment there; none at the holder."""

    def compliance(self, at: Floats, force: Floats) -> Floats:
        """(n, m) deflection at heights (n,) per force at heights (m,) [m/N]; none from the holder on."""
        (row, share), (column, part) = self._shapes(at), self._shapes(force)
        found: Floats = np.einsum("na,namb,mb->nm", share, self.flexibility[row[:, :, None, None], column], part)
        return found

    def _shapes(self, height: Floats) -> tuple[Ints, Floats]:
        """(n, 4) which displacements and slopes of the nodes tell the deflection at heights (n,), and by how much."""
        k = np.clip(np.searchsorted(self.nodes, height, side="right") - 1, 0, len(self.nodes) - 2)
        h = self.nodes[k + 1] - self.nodes[k]
        u = np.clip((height - self.nodes[k]) / h, 0.0, 1.0)
        shapes = [1.0 - 3.0 * u**2 + 2.0 * u**3, h * (u - 2.0 * u**2 + u**3), u**2 * (3.0 - 2.0 * u), h * (u**3 - u**2)]
        return 2 * k[:, None] + np.arange(4), np.stack(shapes, axis=1)


def _diameter(tool: ToolFigures, flutes: float, height: Floats) -> Floats:
    """(n,) of the bar that bends like the tool at heights (n,) [m]."""
    found = np.where(
        height < flutes, FLUTES * (tool.diameter + 2.0 * height * math.tan(tool.taper)),
        tool.shank_diameter or tool.diameter,
    )  # fmt: skip
    begin = flutes
    for part in tool.shank:
        share = (height - begin) / part.length
        inside = (share >= 0.0) & (share < 1.0)
        found[inside] = part.lower_diameter + share[inside] * (part.upper_diameter - part.lower_diameter)
        found[share >= 1.0] = part.upper_diameter
        begin += part.length
    return found


def _stiffness(length: Floats, rigidity: Floats) -> Floats:
    """(2 n, 2 n) of n elements of some lengths (n,) [m] and E I (n,) [N m2], clamped at the end of the last."""
    n = len(length)
    found = np.zeros((2 * n + 2, 2 * n + 2))
    for k, (h, stiff) in enumerate(zip(length.tolist(), rigidity.tolist())):
        of_element = np.array([
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, 4.0 * h**2, -6.0 * h, 2.0 * h**2],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, 2.0 * h**2, -6.0 * h, 4.0 * h**2],
        ])  # fmt: skip
        found[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += stiff / h**3 * of_element
    return found[:-2, :-2]
