"""What may be spent on a proof."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np


@dataclass
class Allowance:
    """How much may be spent on a proof: until when, or how many questions. Questions do not depend on the clock."""

    until: float = np.inf
    """By time.monotonic() [s]."""
    questions: float = np.inf
    """What the relaxation beyond some speed takes, asked of a knot."""

    @property
    def is_spent(self) -> bool:
        """Whether nothing is left."""
        return self.questions <= 0 or time.monotonic() >= self.until

    def take(self, questions: int) -> bool:
        """Take so many questions off, if there are as many; else there are none any more."""
        enough = questions <= self.questions
        self.questions = self.questions - questions if enough else 0
        return enough
