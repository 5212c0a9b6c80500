"""The bending of a tool as a cantilever of pieces: its flutes, its shank, up to the holder.

    deflection at w by a force at z    integral from max(z, w) to L of (x - z) (x - w) / (E I(x)) dx

with x from the tip to the holder at L (Euler and Bernoulli), I = pi d^4 / 64. Flutes bend like a bar of 0.8 of their
diameter (Kops and Vo, Determination of the equivalent diameter of an end mill based on its compliance, CIRP Annals 39,
1990). Along a tapered cutting part the diameter is that of the cone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.programs.tool_figures import ToolFigures

FLUTES = 0.8
"""Diameter of the bar that bends as flutes do, as a share of theirs (Kops and Vo 1990)."""
YOUNGS_MODULUS = {"carbide": 580e9, "hss": 207e9, "steel": 207e9, "ceramic": 310e9, "cermet": 450e9}
"""Of the material of tools [Pa]: what makers and textbooks give for the usual grades; carbide with 8 to 12 percent of
cobalt is at 550 to 620 GPa."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class ToolBeam:
    """The bar that a tool is."""

    breaks: Floats
    """(k + 1,) heights at which pieces end, from the tip to the holder [m]."""
    diameter: Floats
    """(k, 2) at the lower and the upper end of each piece [m]."""
    youngs_modulus: float
    """[Pa]"""

    @property
    def length(self) -> float:
        """From the tip to the holder [m]."""
        return float(self.breaks[-1])

    @classmethod
    def of(cls, tool: ToolFigures, youngs_modulus: float | None = None) -> ToolBeam:
        """The bar of a tool. Raises UsageError where its stick-out or its material is not known."""
        if tool.stick_out is None or not tool.stick_out > 0.0:
            raise UsageError("bending of a tool: its stick_out is missing; give it in the tool table")
        modulus = modulus_of(tool.material) if youngs_modulus is None else youngs_modulus
        flutes = min(tool.stick_out if tool.flute_length is None else tool.flute_length, tool.stick_out)
        cone = tool.taper if tool.kind in ("taper", "chamfer") else 0.0
        lower = tool.diameter
        upper = lower + 2.0 * flutes * math.tan(cone)
        pieces = [(flutes, FLUTES * lower, FLUTES * upper)]
        pieces += [(part.length, part.lower_diameter, part.upper_diameter) for part in tool.shank]
        left = tool.stick_out - sum(piece[0] for piece in pieces)
        if left > 0.0:
            shank = pieces[-1][2] if tool.shank else tool.shank_diameter or tool.diameter
            pieces.append((left, shank, shank))
        breaks = np.minimum(np.concatenate([[0.0], np.cumsum([piece[0] for piece in pieces])]), tool.stick_out)
        whole = np.diff(breaks) > 0.0
        return cls(np.append(breaks[:-1][whole], breaks[-1]), np.array(pieces)[whole, 1:], modulus)

    def compliance(self, at: Floats, force: Floats) -> Floats:
        """(n, m) deflection at heights (n,) per force at heights (m,) [m/N]; beyond the holder there is none."""
        w, z = at[:, None, None], force[None, :, None]
        found = np.zeros((len(at), len(force)))
        for low, high, ends in zip(self.breaks[:-1], self.breaks[1:], self.diameter):
            begin = np.clip(np.maximum(w, z), low, high)
            half = 0.5 * (high - begin)
            x = begin + half * (NODES + 1.0)
            d = ends[0] + (ends[1] - ends[0]) * (x - low) / (high - low)
            inertia = math.pi * d**4 / 64.0
            found += (half * WEIGHTS * (x - z) * (x - w) / (self.youngs_modulus * inertia)).sum(axis=2)
        return found


def bends(tool: ToolFigures) -> bool:
    """Whether the figures of a tool tell how far it bends: its stick-out and its material do."""
    return tool.stick_out is not None and bool(tool.material.strip())


def modulus_of(material: str) -> float:
    """Young's modulus of a tool's material [Pa]. Raises UsageError for one that is not known."""
    word = material.strip().lower()
    for name, modulus in YOUNGS_MODULUS.items():
        if name in word or (name == "carbide" and word in ("vhm", "hm", "solid carbide")):
            return modulus
    hint = did_you_mean(word[:40], list(YOUNGS_MODULUS)) if word else f"one of {', '.join(YOUNGS_MODULUS)}"
    raise UsageError(f"bending of a tool: its material '{material[:40]}' has no Young's modulus; {hint}")
