"""Steps that move: words, distances, arcs, machine coordinates, and what stands for the tool's length."""

from __future__ import annotations

import numpy as np

from testbed.sinumerik_frames.plane_steps import PlaneSteps
from testbed.sinumerik_frames.truth import DEG


class MotionSteps(PlaneSteps):
    """Motions in the frames in force."""

    def motion(self):
        """X, Y, Z, and rotary words where nothing refuses them."""
        if self.waiting and not self.traori:
            self.transform()
        place = {x: self.number(40) for x in self.some("XYZ")}
        if self.traori or not self.tilted:
            place |= {x: self.angle(x) for x in self.some(self.chain.rotary, 0)}
        self._motion(place)

    def _named(self):
        """X, Y and Z, then perhaps another frame: distances are read where their axes were named before."""
        self._motion({x: self.number(40) for x in "XYZ"})
        if self.rng.random() < 0.5:
            self.translate()

    def distance(self):
        """IC(): from the end of the motion before it, in the words of then."""
        if self.waiting and not self.traori:
            self.transform()
        self._named()
        by = {x: self.number(20) for x in self.some("XYZ")}

        def act(truth, found):
            words = truth.said / truth.unit
            truth.move({x: words["XYZ".index(x)] + v for x, v in by.items()}, {})

        self.say("G1 " + " ".join(f"{x}=IC({v:.3f})" for x, v in by.items()), act, straight=True)

    def arc(self):
        """G2 or G3 about a centre by its distance, by an opening angle, with a rise."""
        if not self.even:
            return
        if self.waiting and not self.traori:
            self.transform()
        self._named()
        i, j, opening, rise = self.number(15), self.number(15), abs(self.number(300)) + 10, self.number(10)
        clockwise = bool(self.rng.random() < 0.5)

        def act(truth, found):
            words = truth.words() / truth.unit
            centre = words[:2] + np.array([i, j])
            a = np.radians(-opening if clockwise else opening)
            turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
            x, y = centre + turn @ (words[:2] - centre)
            end = truth.said[2] / truth.unit + rise
            heights = words[2] * truth.unit, (end - words[2]) * truth.unit
            truth.arc = centre * truth.unit, float(np.hypot(i, j)) * truth.unit, *heights, a
            truth.move({"X": x, "Y": y, "Z": end}, {})

        code = "G2" if clockwise else "G3"
        self.say(f"{code} I{i:.3f} J{j:.3f} AR={opening:.3f} Z=IC({rise:.3f})", act)

    def in_machine(self):
        """SUPA: slides and rotary joints by machine coordinates."""
        if self.traori or self.tilted:
            return
        told = {x: self.number(100) for x in self.some("XYZ")}
        turned = {x: self.angle(x) for x in self.some(self.chain.rotary, 0)}
        words = " ".join(f"{x}={v:.3f}" for x, v in (told | turned).items())
        joints = {x: v * DEG for x, v in turned.items()}
        self.say(f"SUPA G0 {words}", lambda truth, found: truth.to_machine(told, joints))

    def without_length(self):
        """D0, motions of joints, D1."""
        if self.traori or self.tilted:
            return

        def act(truth, found):
            truth.reckoned = 0.0

        self.say("D0", act, counts=False)
        self.motion()

        def back(truth, found):
            truth.reckoned = truth.length

        self.say("D1", back, counts=False)
