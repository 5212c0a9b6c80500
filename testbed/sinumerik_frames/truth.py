"""A control in joints and matrices: where frames, offsets and modes put the machine."""

from __future__ import annotations

import numpy as np

from testbed.sinumerik_frames.matrices import least_turn, linear, shift

MM, DEG = 1e-3, np.pi / 180.0


class Truth:
    """The machine at its joints (m,), and all that its words mean."""

    def __init__(self, chain, length, zero, offsets, unit):
        self.chain, self.length, self.zero, self.offsets, self.unit = chain, length, zero, offsets, unit
        self.reckoned = length
        """The length that words of joints reckon with: zero after D0."""
        self.said = np.zeros(3)
        """X, Y, Z that distances count from [m]."""
        self.arc = None
        """Of an arc: centre (2,), radius, height at its start, rise [m] and angle [rad], in the words of its block."""
        self.q = np.zeros(len(chain.names))
        self.slides = [chain.names.index(name) for name in "XYZ"]
        self.turns = [chain.names.index(name) for name in chain.rotary]
        upright = {name: np.zeros(1) for name in chain.rotary}
        short, long = (chain.joints(np.zeros((1, 3)), upright, given)[0][self.slides] for given in (0.0, 1.0))
        self.lift = long - short
        """By what a metre of tool moves the slides."""
        self.offset = None
        self.plane, self.tool = np.eye(4), np.eye(4)
        self.coarse, self.fine, self.linear = np.zeros(3), np.zeros(3), np.eye(3)
        self.coarse_turn, self.fine_turn = (dict.fromkeys(chain.rotary, 0.0) for _ in range(2))
        self.tilted = self.traori = False

    # What words mean

    def programmed(self):
        """(4, 4) of TRANS, ROT, SCALE and MIRROR."""
        return shift(self.coarse + self.fine) @ linear(self.linear)

    def frame(self):
        """(4, 4) of all frames but the settable offset."""
        return self.plane @ self.tool @ self.programmed()

    def origin(self):
        """Slides (3,) at the origin of the offset, without a tool; and rotary joints by name."""
        at, turned = self.offsets[self.offset]
        return self.zero + at, turned

    @property
    def on_part(self):
        """Whether X, Y, Z are the tip on the part."""
        return self.traori or self.tilted

    def part_origin(self):
        """(3,) of the offset, on the part with its tables at zero."""
        q = np.zeros(len(self.q))
        q[self.slides] = self.origin()[0]
        return self.chain.forward(q, 0.0)[0][0]

    def shifts(self):
        """Added to rotary words, by name [rad]."""
        turned = self.origin()[1]
        return {n: turned.get(n, 0.0) + self.coarse_turn[n] + self.fine_turn[n] for n in self.chain.rotary}

    def words(self):
        """X, Y, Z (3,) [m] where the machine is."""
        if self.on_part:
            point = self.tip() - self.part_origin()
        else:
            point = self.q[self.slides] - self.origin()[0] - self.lift * self.reckoned
        return np.linalg.solve(self.frame(), [*point, 1.0])[:3]

    def words_of(self, points, slides):
        """X, Y, Z (n, 3) [m] of tips on the part, or of slides (n, 3)."""
        places = points - self.part_origin() if self.on_part else slides - self.origin()[0] - self.lift * self.reckoned
        return np.linalg.solve(self.frame(), np.c_[places, np.ones(len(places))].T).T[:, :3]

    def tip(self):
        """(3,) on the part."""
        return self.chain.forward(self.q, self.length)[0][0]

    def axis(self):
        """(3,) on the part."""
        return self.chain.forward(self.q, self.length)[1][0]

    def rotary(self):
        """Joints by name [rad]."""
        return {name: self.q[self.chain.names.index(name)] for name in self.chain.rotary}

    # Motion

    def move(self, told, rotary):
        """To words X, Y, Z by letter [units] and rotary joints by name [rad]; what is not named keeps its words."""
        words = self.words()
        for letter, value in told.items():
            words["XYZ".index(letter)] = value * self.unit
        point = (self.frame() @ [*words, 1.0])[:3]
        self.q = self.q.copy()
        for name, value in rotary.items():
            self.q[self.chain.names.index(name)] = value
        if self.on_part:
            turned = {name: np.array([value]) for name, value in self.rotary().items()}
            self.q = self.chain.joints((point + self.part_origin())[None], turned, self.length)[0]
        else:
            self.q[self.slides] = point + self.origin()[0] + self.lift * self.reckoned

    def to_machine(self, told, rotary):
        """To machine coordinates by letter [units] and rotary joints by name [rad]."""
        self.turn(rotary)
        for letter, value in told.items():
            self.q[self.slides["XYZ".index(letter)]] = self.zero["XYZ".index(letter)] + value * self.unit

    def turn(self, rotary):
        """Rotary joints by name [rad]; the slides stay."""
        self.q = self.q.copy()
        for name, value in rotary.items():
            self.q[self.chain.names.index(name)] = value

    # Frames

    def clear(self):
        """No programmed frame."""
        self.coarse, self.fine, self.linear = np.zeros(3), np.zeros(3), np.eye(3)
        self.coarse_turn, self.fine_turn = (dict.fromkeys(self.chain.rotary, 0.0) for _ in range(2))

    def translate(self, by, turned, *, additive):
        """TRANS, ATRANS (3,) [units], and of rotary words by name [deg]."""
        if additive:
            self.fine = self.fine + self.linear @ (np.array(by) * self.unit)
            self.fine_turn = {n: v + turned.get(n, 0.0) * DEG for n, v in self.fine_turn.items()}
            return
        self.clear()
        self.coarse = np.array(by) * self.unit
        self.coarse_turn = {n: turned.get(n, 0.0) * DEG for n in self.coarse_turn}

    def turn_frame(self, matrix, *, additive):
        """ROT, SCALE, MIRROR and their kin, (3, 3)."""
        if not additive:
            self.clear()
        self.linear = self.linear @ matrix

    def axial(self, told, turned, *, fine):
        """G58, G59: shifts of the axes that are named [units, deg]."""
        part, turns = (self.fine.copy(), self.fine_turn) if fine else (self.coarse.copy(), self.coarse_turn)
        for letter, value in told.items():
            part["XYZ".index(letter)] = value * self.unit
        turns = turns | {name: value * DEG for name, value in turned.items()}
        if fine:
            self.fine, self.fine_turn = part, turns
        else:
            self.coarse, self.coarse_turn = part, turns

    def swivel(self, made, *, additive):
        """CYCLE800: (4, 4) of the new plane [m]."""
        self.plane = self.plane @ self.tool @ self.programmed() @ made if additive else made
        self.tilted = True
        self.tool = np.eye(4)
        self.clear()

    def flatten(self):
        """CYCLE800()."""
        self.plane, self.tool, self.tilted = np.eye(4), np.eye(4), False

    def along_tool(self):
        """TOROT: the frame in force about its origin, until Z is along the tool."""
        if not self.on_part:
            return
        old = self.frame()
        direction = old[:3, :3].T @ self.axis()
        new = old @ linear(least_turn(direction))
        self.tool = np.linalg.inv(self.plane) @ new @ np.linalg.inv(self.programmed())

    def square(self, rotary):
        """(4, 4) of the machine's X and Y and the tool's Z on the part, at rotary joints by name [rad]."""
        q = np.zeros((1, len(self.q)))
        for name, value in rotary.items():
            q[0, self.chain.names.index(name)] = value
        table = self.chain._carried(self.chain.workpiece, q, np.zeros(3))[0][0]
        head = self.chain._carried(self.chain.tool, q, np.zeros(3))[0][0]
        return linear(self.chain.frame.T @ table.T @ head @ self.chain.frame)
