"""Steps that swivel planes with CYCLE800, and switch TRAORI."""

from __future__ import annotations

import numpy as np

from testbed.sinumerik_frames.frame_steps import FrameSteps
from testbed.sinumerik_frames.matrices import about, linear, shift, solid
from testbed.sinumerik_frames.truth import DEG

MODES = {57: "XYZ", 45: "XZY", 54: "YXZ", 30: "YZX", 39: "ZXY", 27: "ZYX"}
PAIRS = {185: "XYZ", 182: "YXZ", 173: "XZY", 158: "YZX", 167: "ZXY", 155: "ZYX"}
"""_MODE of projection angles (128 and the axes) to the axes of its three angles."""


class PlaneSteps(FrameSteps):
    """CYCLE800 and TRAORI."""

    def swivel(self):
        """CYCLE800, all kinds of _MODE."""
        if self.carried and self.tables and self.rng.random() < 0.9:
            return
        rng = self.rng
        before, behind = ([self.number(15) for _ in range(3)] for _ in range(2))
        kind = rng.choice(["axes", "axes", "solid", "projection", "direct"])
        follow, additive = rng.random() < 0.3, rng.random() < 0.3 and kind != "direct"
        direction = int(rng.choice([-1, 1, 1, 0]))
        rotary: dict[str, float] = {}
        if kind == "axes":
            mode = int(rng.choice(list(MODES)))
            angles = [self.number(25) if x != "Z" else self.number(60) for x in MODES[mode]]
            turn = np.eye(3)
            for letter, angle in zip(MODES[mode], angles):
                turn = turn @ about(letter, angle)
        elif kind == "solid":
            mode, angles = 64, [self.number(90), self.number(25), 0.0]
            turn = about("Z", angles[0]) @ about("Y", angles[1])
        elif kind == "projection":
            mode = int(rng.choice(list(PAIRS)))
            letters = PAIRS[mode]
            angles = [self.number(25), self.number(25), self.number(60)]
            turn = solid(dict(zip(letters[:2], angles))) @ about(letters[2], angles[2])
        else:
            mode = 192
            order = [*self.heads, *self.tables]  # in a table and in a head from the bed on; of both the head first
            angles = [self.angle(order[0]), self.angle(order[1]), 0.0]
            if self.heads and len(self.heads) == 2:
                angles[0] = 0.0
            rotary = {x: v * DEG for x, v in zip(order, angles)}
            turn = None
        status = 100000 + 10 * follow + additive
        numbers = [*before, *angles, *behind]
        inside = ",".join(f"{v:.3f}" for v in numbers)
        upon = additive

        def act(truth, found):
            made = linear(turn) if turn is not None else truth.square(rotary)
            first, second = (shift(np.array(by) * truth.unit) for by in (before, behind))
            truth.swivel(first @ made @ second, additive=upon)
            if not direction:
                return
            normal = truth.plane[:3, :3] @ [0.0, 0.0, 1.0]
            joints = rotary or found.rotary(normal / np.linalg.norm(normal))
            if follow:
                truth.move({}, joints)
            else:
                truth.turn(joints)

        self.say(f'CYCLE800(0,"",{status},{mode},{inside},{direction},0,1)', act, straight=bool(follow))
        self.tilted, self.waiting, self.even, self.upon = True, direction == 0, True, False
        self.assigned = False
        if direction == 0 and kind == "direct" and not self.traori:
            self._motion({x: v / DEG for x, v in rotary.items()})
            self.waiting = False

    def flat(self):
        self.say("CYCLE800()", lambda truth, found: truth.flatten())
        self.tilted = self.waiting = self.upon = False

    def transform(self):
        """TRAORI, TRAFOOF."""
        on = not self.traori
        if not on and self.tilted:
            self.flat()

        def act(truth, found):
            truth.traori = on

        word = str(self.rng.choice(["TRAORI", "TRAORI(1)", "TRAORI(1,0,0,1)"])) if on else "TRAFOOF"
        self.say(word, act)
        self.traori = on
