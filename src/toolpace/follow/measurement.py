"""What was measured of the tool, and when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.errors import UsageError
from toolpace.kernels.follow.layout import AXIS, DEFLECTION, FORCE, MEASURED_AT, TIP


@dataclass(frozen=True, eq=False)
class Measurement:
    """Position of the tip or its deflection, direction of the tool, or force on it, at a time; what is not given was
    not measured.

    Any figures are taken, nan and absurd ones too: a follower says what it made of them, and goes on.
    """

    t: float
    """When it was measured, on the follower's clock [s]."""
    tip: npt.ArrayLike | None = None
    """(3,) tool tip in the workpiece frame [m]."""
    axis: npt.ArrayLike | None = None
    """(3,) unit vector from the tip to the spindle, in the workpiece frame."""
    force: npt.ArrayLike | None = None
    """(3,) force on the tool, in the workpiece frame [N]."""
    deflection: npt.ArrayLike | None = None
    """(3,) how far the tip was from where it was commanded `delay` before, correction and all, in the workpiece frame
    [m]: what `tip` less that place would be, and taken in place of it."""

    def write(self, into: Floats) -> None:
        """Write to an array (13,) as kernels/follow/layout.py has it. Raises UsageError for a wrong shape."""
        into[MEASURED_AT] = self.t
        for at, name, value in (
            (TIP, "tip", self.tip),
            (AXIS, "axis", self.axis),
            (FORCE, "force", self.force),
            (DEFLECTION, "deflection", self.deflection),
        ):
            if value is None:
                into[at : at + 3] = np.nan
                continue
            given = np.asarray(value, dtype=float)
            if given.shape != (3,):
                raise UsageError(f"measurement: {name} has shape {given.shape}; give three figures (x, y, z)")
            into[at : at + 3] = given
