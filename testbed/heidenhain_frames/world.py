"""What a control with a machine does with each block: joints, by the kinematics of the machine file read anew."""

from __future__ import annotations

import numpy as np

from testbed.heidenhain_frames.frames import Chained, scales, shift, spatial, turn

DEG = np.pi / 180.0
MASTER = {("B", "C"): "B", ("A", "C"): "A", ("A", "B"): "A"}
"""Of the rotary axes of a machine the one whose sign SEQ tells."""


class WrongError(AssertionError):
    """The reader went where the control does not."""


class World:
    """A machine with a control. `seen` of a method: rotary joints (by letter) that the reader came to, where the
    control chooses between solutions; they are held against the direction that was asked for."""

    def __init__(self, chain, zero, presets, tools):
        self.chain, self.zero, self.presets, self.tools = chain, zero, presets, tools
        self.index = {name: k for k, name in enumerate(chain.names)}
        self.linear = [self.index[name] for name in "XYZ"]
        self.q = np.zeros(len(chain.names))
        self.preset, self.length = next(iter(presets)), 0.0
        self.before, self.within = Chained(), Chained()
        self.plane: np.ndarray | None = None
        self.tip = self.spatial = False
        self.angles = {"A": 0.0, "B": 0.0, "C": 0.0}
        self.rotary_shift = dict.fromkeys(chain.rotary, 0.0)
        self.mirrored: set[str] = set()
        self.shortest = False
        upright = {name: np.zeros(1) for name in chain.rotary}
        nose, higher = (chain.joints(np.zeros((1, 3)), upright, length)[0] for length in (0.0, 1.0))
        self.lift = (higher - nose)[self.linear]
        self.axial = dict.fromkeys(chain.rotary, 0.0)

    # Places

    def forward(self, q):
        """Tip and axis (3,) on the part."""
        tip, axis = self.chain.forward(q[None], self.length)
        return tip[0], axis[0]

    @property
    def level(self):
        return self.before if self.plane is None else self.within

    def frame(self):
        """From words to the coordinates of the preset (4, 4)."""
        plane = np.eye(4) if self.plane is None else self.plane
        return self.before.matrix() @ plane @ self.within.matrix()

    def on_part(self):
        return self.tip or self.plane is not None

    def origin(self):
        """Linear joints of the nose at the preset (3,)."""
        return self.zero + self.presets[self.preset]

    def preset_on_part(self):
        q = np.zeros(len(self.q))
        q[self.linear] = self.origin()
        return self.chain.forward(q[None], 0.0)[0][0]

    def base(self):
        """From words to the part, or to linear joints (4, 4)."""
        at = self.preset_on_part() if self.on_part() else self.origin() + self.lift * self.length
        return shift(at) @ self.frame()

    def words(self):
        """X, Y, Z of where the machine stands (3,) [m]."""
        place = self.forward(self.q)[0] if self.on_part() else self.q[self.linear]
        return (np.linalg.inv(self.base()) @ [*place, 1.0])[:3]

    def go(self, words, rotary):
        """To words (3,) with rotary joints by letter [rad]."""
        place = (self.base() @ [*words, 1.0])[:3]
        if self.on_part():
            told = {name: np.array([rotary[name]]) for name in self.chain.rotary}
            self.q = self.chain.joints(place[None], told, self.length)[0]
        else:
            self.q[self.linear] = place
            for name, value in rotary.items():
                self.q[self.index[name]] = value

    def rotary(self):
        return {name: self.q[self.index[name]] for name in self.chain.rotary}

    def linear_words(self, given):
        """Words (3,) after those that a block names: letter to value [m] and whether it is incremental."""
        words = self.words()
        for letter, (value, adds) in given.items():
            k = "XYZ".index(letter)
            words[k] = words[k] + value if adds else value
        return words

    def rotary_words(self, given):
        rotary = self.rotary()
        for letter, (value, adds) in given.items():
            sign = -1.0 if letter in self.mirrored else 1.0
            at = rotary[letter] if adds else self.rotary_shift[letter]
            wanted = at + sign * value * DEG
            if self.shortest and not adds:
                low, high = self.chain.travel[letter]
                turns = [wanted + 2.0 * np.pi * k for k in range(-40, 41)]
                inside = [each for each in turns if low - 1e-9 <= each <= high + 1e-9]
                wanted = min(inside, key=lambda each, here=rotary[letter]: abs(each - here), default=wanted)
            rotary[letter] = wanted
        return rotary

    def chosen(self, seen, direction, sign=0):
        """Rotary joints that the reader took for a direction (3,) on the part; WrongError where they miss it."""
        q = np.zeros(len(self.q))
        for name, value in seen.items():
            q[self.index[name]] = value
            low, high = self.chain.travel[name]
            if not low - 1e-9 <= value <= high + 1e-9:
                raise WrongError(f"{name} out of travel")
        axis = self.chain.forward(q[None], 0.0)[1][0]
        wanted = np.asarray(direction) / np.linalg.norm(direction)
        if np.linalg.norm(axis - wanted) > 1e-8:
            raise WrongError(f"axis {axis} in place of {wanted}")
        master = MASTER[tuple(sorted(self.chain.rotary))]
        if sign and seen[master] * sign < -1e-6:
            raise WrongError(f"SEQ: {master} is {seen[master]}")
        return seen

    # Frames

    def take_preset(self, seen, name):
        self.preset, self.before, self.within = name, Chained(), Chained()
        self.rotary_shift, self.mirrored = dict.fromkeys(self.chain.rotary, 0.0), set()

    def take_shift(self, seen, given):
        level = self.level
        for letter, (value, adds) in given.items():
            if letter in "XYZ":
                k = "XYZ".index(letter)
                level.at[k] = level.at[k] + value if adds else value
            else:
                self.rotary_shift[letter] = value * DEG + (self.rotary_shift[letter] if adds else 0.0)
        level.put("shift", shift(level.at))

    def mirror(self, seen, letters):
        self.mirrored = {letter for letter in letters if letter not in "XYZ"}
        self.level.put("mirror", scales(*(-1.0 if letter in letters else 1.0 for letter in "XYZ")))

    def rotate(self, seen, angle, adds):
        level = self.level
        level.angle = angle + (level.angle if adds else 0.0)
        level.put("rotation", turn(2, level.angle))

    def scale(self, seen, by):
        self.level.put("scale", scales(by, by, by))

    def scale_axes(self, seen, by, centre):
        self.level.put("axes", shift(centre) @ scales(*by) @ shift(-np.asarray(centre)))

    # Planes

    def tilt(self, seen, how, matrix, relative=False, sign=0, pivot=0.0):
        """A plane, and how the axes turn to it."""
        self.plane = (np.eye(4) if self.plane is None else self.plane) @ matrix if relative else matrix
        self.turn_to(seen, how, pivot, sign)

    def turn_to(self, seen, how, pivot, sign=0):
        if how != "STAY":
            self.turned(how, self.chosen(seen, self.frame()[:3, 2], sign), pivot)

    def turned(self, how, rotary, pivot):
        """TURN: the linear joints stand; MOVE: the point `pivot` above the tip does."""
        tip, axis = self.forward(self.q)
        for name, value in rotary.items():
            self.q[self.index[name]] = value
        if how == "MOVE":
            point = tip + pivot * axis
            after = self.forward(self.q)[1]
            told = {name: np.array([value]) for name, value in rotary.items()}
            self.q = self.chain.joints((point - pivot * after)[None], told, self.length)[0]

    def tilt_axial(self, seen, how, given):
        for letter, (value, adds) in given.items():
            self.axial[letter] = value + (self.axial[letter] if adds else 0.0)
        rotary = {name: value * DEG for name, value in self.axial.items()}
        q = np.zeros((2, len(self.q)))
        for name, value in rotary.items():
            q[1, self.index[name]] = value
        head, _ = self.chain._carried(self.chain.tool, q, np.zeros(3))
        table, _ = self.chain._carried(self.chain.workpiece, q, np.zeros(3))
        first, second = (self.chain.frame.T @ table[k].T @ head[k] for k in (0, 1))
        self.plane = np.eye(4)
        self.plane[:3, :3] = second @ first.T
        if how != "STAY":
            self.turned(how, rotary, 0.0)

    def untilt(self, seen, how):
        self.plane, self.within = None, Chained()
        self.axial = dict.fromkeys(self.chain.rotary, 0.0)
        if how != "STAY":
            self.turned(how, dict(self.rotary_shift), 0.0)

    def position(self, seen):
        """The rotary axes to Q120, Q121, Q122: the tool upright on the plane, the linear joints standing or the tip."""
        rotary = self.chosen(seen, self.frame()[:3, 2])
        self.turned("MOVE" if self.tip else "TURN", rotary, 0.0)

    # Modes and tools

    def tip_mode(self, seen, on, spatial=False):
        self.tip, self.spatial = on, on and spatial
        self.angles = {"A": 0.0, "B": 0.0, "C": 0.0}

    def shorter_way(self, seen, on):
        """M126 and M127."""
        self.shortest = on

    def tool(self, seen, name, oversize):
        self.length = self.tools[name] + oversize

    # Motion

    def line(self, seen, given, rotary):
        """L; in a tilted plane without M128 rotary axes alone leave the linear joints where they are."""
        if rotary and not given and self.plane is not None and not self.tip:
            self.turned("TURN", self.rotary_words(rotary), 0.0)
            return
        self.go(self.linear_words(given), self.rotary_words(rotary))

    def spatial_line(self, seen, given, angles):
        for letter, (value, adds) in angles.items():
            self.angles[letter] = value + (self.angles[letter] if adds else 0.0)
        axis = self.frame()[:3, :3] @ spatial(*(self.angles[letter] for letter in "ABC"))[:3, 2]
        self.go(self.linear_words(given), self.chosen(seen, axis))

    def vector_line(self, seen, given, vector):
        """LN."""
        words = self.linear_words(given)
        self.go(words, self.chosen(seen, self.frame()[:3, :3] @ vector) if self.tip else self.rotary())

    def machine_line(self, seen, given, rotary):
        """L with M91."""
        for letter, value in given.items():
            self.q[self.index[letter]] = self.zero["XYZ".index(letter)] + value
        for letter, value in rotary.items():
            self.q[self.index[letter]] = value * DEG

    def retract(self, seen, by):
        """M140 MB."""
        tip, axis = self.forward(self.q)
        told = {name: np.array([value]) for name, value in self.rotary().items()}
        self.q = self.chain.joints((tip + by * axis)[None], told, self.length)[0]
