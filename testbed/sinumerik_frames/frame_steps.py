"""Steps that change frames: TRANS, ROT, ROTS, SCALE, MIRROR, their additive kin, offsets, G58, G59, $P_PFRAME."""

from __future__ import annotations

import numpy as np

from testbed.sinumerik_frames.maker import Maker
from testbed.sinumerik_frames.matrices import about, rpy, solid

OFFSETS = {"G54": "G54", "G55": "G55", "G505": "G505", "G500": None}


class FrameSteps(Maker):
    """Frames of the program, and settable offsets."""

    def translate(self):
        additive = self.rng.random() < 0.5
        if self.upon and not additive:
            return
        by = {x: self.number(20) for x in self.some("XYZ")}
        turned = {}
        if self.rng.random() < 0.3 and not self.tilted:
            shifted = self.chain.rotary if self.carried else self.heads
            turned = {x: self.number(15) for x in shifted[:1]}
        words = " ".join(f"{x}{v:.3f}" for x, v in (by | turned).items())
        vector = [by.get(x, 0.0) for x in "XYZ"]
        self.even |= not additive
        self.assigned &= additive
        self.say(
            f"{'A' if additive else ''}TRANS {words}",
            lambda truth, found: truth.translate(vector, turned, additive=additive),
            counts=False,
        )

    def _turned(self, name, words, matrix):
        """A block of ROT, SCALE, MIRROR or their kin, new or additive."""
        additive = self.rng.random() < 0.5 or self.upon
        self.even |= not additive
        self.assigned &= additive
        self.say(
            f"{'A' if additive else ''}{name} {words}",
            lambda truth, found: truth.turn_frame(matrix, additive=additive),
            counts=False,
        )

    def rotate(self):
        if self.rng.random() < 0.2:
            angle = self.number(180)
            self._turned("ROT", f"RPL={angle:.3f}", about("Z", angle))
            return
        angles = {x: self.number(40 if x != "Z" else 170) for x in self.some("XYZ")}
        self._turned("ROT", " ".join(f"{x}{v:.3f}" for x, v in angles.items()), rpy(angles))

    def solid(self):
        pair = self.some("XYZ", 2)[:2]
        angles = {x: self.number(50) for x in pair}
        self._turned("ROTS", " ".join(f"{x}{v:.3f}" for x, v in angles.items()), solid(angles))

    def scale(self):
        if self.rng.random() < 0.7:
            by = dict.fromkeys("XYZ", float(np.round(self.rng.uniform(0.5, 2.0), 3)))
        else:
            by = {x: float(np.round(self.rng.uniform(0.5, 2.0), 3)) for x in self.some("XYZ")}
        self._turned(
            "SCALE", " ".join(f"{x}{v:.3f}" for x, v in by.items()), np.diag([by.get(x, 1.0) for x in "XYZ"])
        )
        self.even &= len({by.get(x, 1.0) for x in "XYZ"}) == 1

    def mirror(self):
        axes = self.some("XYZ")[:2]
        self._turned("MIRROR", " ".join(f"{x}0" for x in axes), np.diag([-1.0 if x in axes else 1.0 for x in "XYZ"]))

    def offset(self):
        word = str(self.rng.choice(list(OFFSETS)))

        def act(truth, found):
            truth.offset = OFFSETS[word]

        self.say(word, act, counts=False)

    def axial(self):
        if self.assigned:
            return
        fine = bool(self.rng.random() < 0.5)
        told = {x: self.number(20) for x in self.some("XYZ")}
        turned = {}
        if self.rng.random() < 0.3 and not self.tilted:
            shifted = self.chain.rotary if self.carried else self.heads
            turned = {x: self.number(15) for x in shifted[-1:]}
        words = " ".join(f"{x}{v:.3f}" for x, v in (told | turned).items())
        act = self._axial_act(told, turned, fine)
        self.say(f"{'G59' if fine else 'G58'} {words}", act, counts=False)

    @staticmethod
    def _axial_act(told, turned, fine):
        return lambda truth, found: truth.axial(told, turned, fine=fine)

    def assign(self):
        if self.upon:
            return
        by, angle = {x: self.number(20) for x in self.some("XYZ")}, self.number(90)

        def act(truth, found):
            truth.translate([by.get(x, 0.0) for x in "XYZ"], {}, additive=False)
            truth.linear = about("Z", angle)

        self.even = self.assigned = True
        inside = ",".join(f"{x},{v:.3f}" for x, v in by.items())
        self.say(f"$P_PFRAME=CTRANS({inside}):CROT(Z,{angle:.3f})", act, counts=False)
