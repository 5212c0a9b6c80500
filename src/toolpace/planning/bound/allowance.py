"""A budget of time for a proof."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np


@dataclass
class Allowance:
    """How much may be spent on a proof: until when, or on how much work, which does not depend on the clock."""

    until: float = np.inf
    """By time.monotonic() [s]."""
    knots: float = np.inf
    """Knots of all the relaxations that are solved for it."""

    @property
    def is_spent(self) -> bool:
        """Whether nothing is left."""
        return self.knots <= 0 or time.monotonic() >= self.until

    def take(self, knots: int) -> bool:
        """Take so many knots off, if there are as many; else there are none any more."""
        enough = knots <= self.knots
        self.knots = self.knots - knots if enough else 0
        return enough
