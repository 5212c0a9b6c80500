"""A time law from several, one after the other on one run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.laws.law import Probe, TimeLaw

SIDE = 1e-13
"""Time before the end of a piece at which its last state is taken, relative [s]."""


@dataclass(frozen=True, eq=False)
class LawPiece:
    """A law between two of its times [s]."""

    law: TimeLaw
    begin: float
    end: float


class ChainLaw(TimeLaw):
    """Pieces of laws, each beginning in the state in which the one before ends."""

    def __init__(self, pieces: Sequence[LawPiece]) -> None:
        self.pieces = tuple(pieces)
        self.times = np.concatenate([[0.0], np.cumsum([piece.end - piece.begin for piece in pieces])])
        """(pieces + 1,) when the pieces begin and end [s]."""
        self.duration = float(self.times[-1])
        first, last = pieces[0], pieces[-1]
        self.s0 = float(first.law.at(np.array([first.begin]))[0, 0])
        self.s1 = float(last.law.at(np.array([last.end]))[0, 0])

    def at(self, t: Floats) -> Floats:
        t = np.asarray(t, dtype=float)
        which = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.pieces) - 1)
        out = np.empty((4, len(t)))
        for k in np.unique(which):
            piece, here = self.pieces[k], which == k
            out[:, here] = piece.law.at(np.clip(piece.begin + (t[here] - self.times[k]), piece.begin, piece.end))
        return out

    def probes(self) -> Iterator[Probe]:
        for piece in self.pieces:
            # the end of a piece belongs to its own side of a jump of the third derivative
            ends = piece.law.at(np.array([piece.begin, piece.end - SIDE * piece.end]))
            total = 0.0
            for probe in piece.law.probes():
                inside = (probe.state[0] > ends[0, 0]) & (probe.state[0] < ends[0, 1])
                if inside.any():
                    total += float(probe.share[inside].sum())
                    yield Probe(probe.state[:, inside], probe.right[inside], probe.share[inside])
            # what the cut leaves of the time is that of the ends
            rest = max(piece.end - piece.begin - total, 0.0) / 2.0
            yield Probe(ends, np.array([1.0, 0.0]), np.full(2, rest))
