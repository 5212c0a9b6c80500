"""Random programs: frames, planes, motions and tool directions in any order that the manuals allow."""

from __future__ import annotations

import numpy as np

from testbed.sinumerik_frames.matrices import of_angles
from testbed.sinumerik_frames.motion_steps import MotionSteps
from testbed.sinumerik_frames.truth import DEG


class Program(MotionSteps):
    """One program of a seed."""

    def __init__(self, seed: int, machine: str | None = None) -> None:
        super().__init__(seed, machine)
        self._make()

    def _make(self):
        rng = self.rng
        self.say(f"G54 G90 {'G700' if self.inches else 'G710'} G94 G17 G64 F1000", lambda truth, found: None)
        self.say("T1 D1 M6", lambda truth, found: None)
        place = {x: self.number(40) for x in "XYZ"} | {x: self.angle(x) for x in self.chain.rotary}
        self._motion(place)
        choices = [
            self.motion, self.motion, self.motion, self.translate, self.rotate, self.solid, self.scale, self.mirror,
            self.offset, self.axial, self.assign, self.swivel, self.swivel, self.swivel, self.flat, self.transform,
            self.transform, self.vector, self.vector, self.angles, self.kinds, self.torot, self.reset,
            self.distance, self.arc, self.arc, self.in_machine, self.without_length,
        ]  # fmt: skip
        for _ in range(int(rng.integers(6, 18))):
            choices[int(rng.integers(len(choices)))]()
        self.motion()
        self.say("M30", lambda truth, found: None)

    def _directed(self, words, vector):
        place = {x: self.number(40) for x in self.some("XYZ", 0)}
        told = "".join(f" {x}{v:.3f}" for x, v in place.items())

        def act(truth, found):
            direction = truth.frame()[:3, :3] @ vector
            truth.move(place, found.rotary(direction / np.linalg.norm(direction)))

        self.say(f"G1{told} {words}", act, straight=True)

    def vector(self):
        """A3, B3, C3 of any length."""
        if not self.even:
            return
        if not self.traori:
            self.transform()
        vector = np.array([self.number(0.45), self.number(0.45), 1.0]) * self.rng.uniform(0.5, 3.0)
        vector = np.round(vector, 6)
        self._directed(" ".join(f"{x}3={v:.6f}" for x, v in zip("ABC", vector)), vector)

    def angles(self):
        """A2, B2, C2."""
        if not self.even:
            return
        if not self.traori:
            self.transform()
        self.kind = str(self.rng.choice(["ORIEULER", "ORIRPY"]))
        self.say(self.kind, lambda truth, found: None, counts=False)
        a, b, c = self.number(25), self.number(25), self.number(60)
        self._directed(f"A2={a:.3f} B2={b:.3f} C2={c:.3f}", of_angles(self.kind, a, b, c))

    def kinds(self):
        """How the tool turns on its way."""
        word = str(self.rng.choice(["ORIWKS", "ORIMKS", "ORIVECT", "ORIAXES"]))
        self.say(word, lambda truth, found: None, counts=False)

    def torot(self):
        """TOROT, later TOROTOF."""
        if self.upon or not self.traori:
            return
        self.say("TOROT", lambda truth, found: truth.along_tool())
        self.upon = True
        for _ in range(int(self.rng.integers(1, 3))):
            self.motion()
        if not self.tilted and self.rng.random() < 0.8:

            def act(truth, found):
                truth.tool = np.eye(4)

            self.say(str(self.rng.choice(["TOROTOF"])), act)
            self.upon = False

    def reset(self):
        """ORIRESET."""
        if not self.traori:
            return
        order = [*self.heads, *self.tables]
        mixed = len(self.heads) == 1
        angles = [] if mixed else [self.angle(order[0]), self.angle(order[1])]
        joints = {x: v * DEG for x, v in zip(order, angles or [0.0, 0.0])}
        inside = ",".join(f"{v:.3f}" for v in angles)
        self.say(f"ORIRESET({inside})", lambda truth, found: truth.move({}, joints), straight=True)
