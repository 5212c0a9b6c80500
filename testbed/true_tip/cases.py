"""Programs at random with tools of several lengths, as posts write them, and where each cut is on the part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from testbed.true_tip.chain import Chain

BUILTIN = Path(__file__).parents[2] / "src" / "toolpace" / "machine" / "builtin"
MACHINES = (
    "xyzac-trunnion", "xyzbc-trunnion", "xyzab-trunnion-inch", "xyzbc-table", "xyzab-table", "linuxcnc-xyzac-trt",
    "xyzbc-head", "xyzac-head", "linuxcnc-xyzbc-bridgemill", "xyzbc-nutating", "xyzbc-nutating-large",
    "xyzbc-millturn", "paper-ab",
)  # fmt: skip
MODES = ("m428", "g43.4", "g43.5", "traori", "traori-vectors", "m128", "joints", "cldata")
CONTROLLERS = {
    "m428": "linuxcnc", "g43.4": "fanuc", "g43.5": "fanuc", "traori": "sinumerik", "traori-vectors": "sinumerik",
    "m128": "heidenhain", "joints": "fanuc",
}  # fmt: skip
MM, DEG = 1e-3, np.pi / 180.0
LIFT = np.array([0.0, 0.0, 0.03])
"""By which the tool is above the part where it comes and goes [m]."""


@dataclass
class Cut:
    """A stretch of the program that is cut with one tool."""

    lines: tuple[int, int]
    """First and last line of the blocks that end in it."""
    length: float
    """Of the tool [m]."""
    tip: np.ndarray
    """(k, 3) its way on the part, straight from one to the next [m]."""
    joints: np.ndarray | None = None
    """(k, m) where the words are joints, and the tip between them is where these take it."""


@dataclass
class Case:
    """A program, its sheet, and the truth."""

    machine: str
    mode: str
    text: str
    sheet: str
    feed: float
    """[m/s]"""
    cuts: list[Cut]
    chain: Chain
    """The machine, with the part where it is clamped."""

    @property
    def controller(self):
        return CONTROLLERS.get(self.mode)

    @property
    def suffix(self):
        """Of its file."""
        by_mode = {"cldata": ".apt", "m128": ".h", "traori": ".mpf", "traori-vectors": ".mpf"}
        return by_mode.get(self.mode, ".nc")


class Maker:
    """Makes one case of a seed."""

    def __init__(self, seed, machine=None, mode=None, lengths=None, points=None, offsets=None):
        self.rng = rng = np.random.default_rng(seed)
        self.machine = machine or MACHINES[seed % len(MACHINES)]
        self.chain = Chain((BUILTIN / f"{self.machine}.toml").read_text())
        self.mode = mode or str(rng.choice(MODES))
        self.points = points or int(rng.integers(20, 80))
        self.feed = float(rng.choice([600, 1500, 3000, 6000]))
        self.count = int(rng.integers(1, 4))
        self.given = lengths
        own = self.chain.own_length
        self.lengths = lengths or [round(float(own * rng.uniform(0.5, 1.6)), 5) for _ in range(self.count)]
        self.with_offsets = bool(rng.random() < 0.5) if offsets is None else offsets
        self.with_offsets &= self.mode != "cldata"
        self.lines: list[str] = []
        self.cuts: list[Cut] = []
        self.shift = np.zeros(3)
        """Origin of the program on the part [m]."""
        self.zero, self.offset = np.zeros(3), np.zeros(3)
        self.part = {}
        """Where the part is clamped, if not as in the machine file."""
        if rng.random() < 0.3:
            self._place_part()
        if self.with_offsets:
            self._place_offset()

    def _place_part(self):
        """The part elsewhere on the table, and turned about its normal."""
        angle = self.rng.uniform(-0.5, 0.5)
        self.chain.origin = np.round(self.chain.origin + self.rng.uniform(-0.01, 0.01, 3), 6)
        x = np.round(self.chain.frame @ [np.cos(angle), np.sin(angle), 0.0], 6)
        z = self.chain.frame[:, 2]
        if abs(x @ z) > 1e-9:
            return
        self.chain.place(x, z)
        self.part = {"origin": list(self.chain.origin / MM), "x": list(x), "z": list(z)}

    def _place_offset(self):
        """A machine zero anywhere, and G54 so that its origin is at `shift` on the part."""
        self.zero = np.round(self.rng.uniform(-0.2, 0.5, 3), 4)
        self.shift = np.round(self.rng.uniform(-0.02, 0.02, 3), 4)
        q = self.chain.joints(self.shift[None], {name: np.zeros(1) for name in self.chain.rotary}, 0.0)[0]
        at = np.array([q[self.chain.names.index(name)] for name in "XYZ"])
        self.offset = np.round(at - self.zero, 9)

    def surface(self, k):
        """Tips (n, 3) [m] and rotary joints of a cut: a wave over a patch, the tool swinging."""
        rng, n = self.rng, self.points
        u = np.linspace(0.0, 1.0, n)
        width, phase = rng.uniform(0.008, 0.02), rng.uniform(0.0, 2.0 * np.pi, 4)
        tip = np.stack(
            [
                0.03 * (2.0 * u - 1.0), width * np.sin(2.0 * np.pi * u + phase[0]),
                0.006 * np.sin(3.0 * np.pi * u + phase[1]) + 0.01,
            ],
            axis=1,
        )  # fmt: skip
        first, second = self.chain.rotary
        swing = {}
        for name, at in ((first, phase[2]), (second, phase[3])):
            low, high = self.chain.travel[name]
            most = min(30.0 * DEG if name == "C" else 20.0 * DEG, 0.8 * high, -0.8 * low)
            swing[name] = most * np.sin(1.5 * np.pi * u + at)
        return np.round(tip, 7), {name: np.round(value / DEG, 5) * DEG for name, value in swing.items()}

    def make(self):
        """The case; None where the machine has not the travel for it."""
        surfaces = [self.surface(k) for k in range(len(self.lengths))]
        for (tip, rotary), length in zip(surfaces, self.lengths):
            lifted = tip + LIFT
            upright = {name: np.zeros(1) for name in rotary}
            places = [
                self.chain.joints(tip, rotary, length), self.chain.joints(lifted[-1:], upright, length),
                self.chain.joints(lifted[:1], upright, length),
            ]  # fmt: skip
            if not all(self.chain.within(q) for q in places):
                return None
        getattr(self, "_" + self.mode.replace(".", "_").replace("-", "_"))(surfaces)
        text = "\n".join(self.lines) + "\n"
        return Case(self.machine, self.mode, text, self.sheet(), self.feed / 60e3, self.cuts, self.chain)

    def sheet(self):
        """The set-up sheet, in millimetres."""
        parts = ["[units]", 'length = "mm"', 'angle = "deg"']
        for k, length in enumerate(self.lengths):
            parts += [f"[tools.{k + 1}]", f"length = {length / MM:.6f}"]
        if self.part:
            parts.append("[part]")
            parts += [f"{key} = [{', '.join(f'{v:.9f}' for v in vector)}]" for key, vector in self.part.items()]
        if self.with_offsets:
            name = "1" if self.mode == "m128" else "G54"
            zero = "\n".join(f"{letter} = {value / MM:.6f}" for letter, value in zip("XYZ", self.zero))
            offset = "\n".join(f"{letter} = {value / MM:.6f}" for letter, value in zip("XYZ", self.offset))
            parts += ["[machine_zero]", zero, f"[offsets.{name}]", offset]
        return "\n".join(parts) + "\n"

    # Words

    def say(self, text):
        self.lines.append(text)

    def xyz(self, tip):
        """X, Y, Z of a place on the part (3,)."""
        x, y, z = (tip - self.shift) / MM
        return f"X{x:.6f} Y{y:.6f} Z{z:.6f}"

    def turned(self, rotary, k, equals=""):
        return " ".join(f"{name}{equals}{value[k] / DEG:.6f}" for name, value in rotary.items())

    def upright(self, equals=""):
        return " ".join(f"{name}{equals}0" for name in self.chain.rotary)

    def vector(self, rotary, k):
        """The tool axis (3,) on the part."""
        q = np.zeros((1, len(self.chain.names)))
        for name, value in rotary.items():
            q[0, self.chain.names.index(name)] = value[k]
        return self.chain.forward(q, 0.0)[1][0]

    def note(self, tip, length, joints=None):
        """The lines just written, one a point of a cut."""
        last = len(self.lines)
        self.cuts.append(Cut((last - len(tip) + 2, last), length, tip, joints))

    # One writer a mode

    def _m428(self, surfaces):
        self.say("G21 G90 G94 G17 G40")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"T{k + 1} M6")
            self.say(f"G43 H{k + 1}")
            self.say("G54" if self.with_offsets else "G94")
            self.say("M428")
            above = tip + LIFT
            self.say(f"G0 {self.xyz(above[0])} {self.upright()}")
            self.say(f"G0 {self.xyz(above[0])} {self.turned(rotary, 0)}")
            self.say(f"G1 {self.xyz(tip[0])} F{self.feed:g}")
            for i in range(1, len(tip)):
                self.say(f"G1 {self.xyz(tip[i])} {self.turned(rotary, i)}")
            self.note(tip, length)
            self.say(f"G0 {self.xyz(above[-1])}")
            self.say(f"G0 {self.xyz(above[-1])} {self.upright()}")
            self.say("M429")
            if self.rng.random() < 0.5:
                self.say("G49")
        self.say("M2")

    def _g43_4(self, surfaces, vectors=False):
        self.say("%")
        self.say("O1000")
        self.say("G21 G90 G94 G17 G40 G49 G80")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"T{k + 1} M6")
            self.say("G54")
            above = tip + LIFT
            if k == 0:
                self.say(f"G0 {self.upright()}")
            self.say(f"G43.{5 if vectors else 4} H{k + 1}")
            start = "I0 J0 K1" if vectors else self.upright()
            self.say(f"G0 {self.xyz(above[0])} {start}")
            self.say(f"G0 {self.xyz(above[0])} {self._axis_words(rotary, 0) if vectors else self.turned(rotary, 0)}")
            self.say(f"G1 {self.xyz(tip[0])} F{self.feed:g}")
            for i in range(1, len(tip)):
                words = self._axis_words(rotary, i) if vectors else self.turned(rotary, i)
                self.say(f"G1 {self.xyz(tip[i])} {words}")
            self.note(tip, length)
            self.say(f"G0 {self.xyz(above[-1])}")
            self.say(f"G0 {self.xyz(above[-1])} {start}")
            self.say("G49")
            # the frame of the next G43.5 is fixed to the table where that stands then
            self.say(f"G0 {self.upright()}")
        self.say("M30")
        self.say("%")

    def _g43_5(self, surfaces):
        self._g43_4(surfaces, vectors=True)

    def _axis_words(self, rotary, k):
        i, j, w = self.vector(rotary, k)
        return f"I{i:.9f} J{j:.9f} K{w:.9f}"

    def _traori(self, surfaces, vectors=False):
        self.say("G71 G90 G94 G17 G40")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"T{k + 1} D1")
            self.say("M6")
            self.say("G54" if self.with_offsets else "G500")
            self.say("TRAORI")
            above = tip + LIFT
            self.say(f"G0 {self.xyz(above[0])} {self.upright('=')}")
            self.say(f"G0 {self.xyz(above[0])} {self._of(rotary, 0, vectors)}")
            self.say(f"G1 {self.xyz(tip[0])} F{self.feed:g}")
            for i in range(1, len(tip)):
                self.say(f"G1 {self.xyz(tip[i])} {self._of(rotary, i, vectors)}")
            self.note(tip, length)
            self.say(f"G0 {self.xyz(above[-1])}")
            self.say(f"G0 {self.xyz(above[-1])} {self.upright('=')}")
            self.say("TRAFOOF")
        self.say("M30")

    def _traori_vectors(self, surfaces):
        self._traori(surfaces, vectors=True)

    def _of(self, rotary, k, vectors):
        if not vectors:
            return self.turned(rotary, k, "=")
        i, j, w = self.vector(rotary, k)
        return f"A3={i:.9f} B3={j:.9f} C3={w:.9f}"

    def _m128(self, surfaces):
        def signed(text):
            return " ".join(word[0] + (word[1:] if word[1] == "-" else "+" + word[1:]) for word in text.split())

        self.say("BEGIN PGM CASE MM")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"TOOL CALL {k + 1} Z S8000")
            if self.with_offsets and k == 0:
                self.say("CYCL DEF 247 DATUM SETTING Q339=+1 ;DATUM NUMBER")
            self.say("M128")
            above = tip + LIFT
            self.say(f"L {signed(self.xyz(above[0]))} {signed(self.upright())} FMAX")
            self.say(f"L {signed(self.xyz(above[0]))} {signed(self.turned(rotary, 0))} FMAX")
            self.say(f"L {signed(self.xyz(tip[0]))} F{self.feed:g}")
            for i in range(1, len(tip)):
                self.say(f"L {signed(self.xyz(tip[i]))} {signed(self.turned(rotary, i))}")
            self.note(tip, length)
            self.say(f"L {signed(self.xyz(above[-1]))} FMAX")
            self.say(f"L {signed(self.xyz(above[-1]))} {signed(self.upright())} FMAX")
            self.say("M129")
        self.say("END PGM CASE MM")

    def _joints(self, surfaces):
        """No tool-centre-point mode: the post has worked out the joints for each tool."""
        self.say("%")
        self.say("O1000")
        self.say("G21 G90 G94 G17 G40 G49 G80")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"T{k + 1} M6")
            self.say("G54")
            upright = {name: np.zeros(1) for name in rotary}
            above = tip[:1] + LIFT
            self.say(f"G0 {self._slides(above, upright, length, 0)}")
            self.say(f"G43 H{k + 1} {self._slides(above, upright, length, 0)}")
            for i in range(len(tip)):
                self.say(f"G1 {self._slides(tip, rotary, length, i)} F{self.feed:g}")
            self.note(tip, length, self.chain.joints(tip, rotary, length))
            above = tip[-1:] + LIFT
            self.say(f"G0 {self._slides(above, upright, length, 0)}")
            self.say("G49" if self.rng.random() < 0.5 else "G80")
        self.say("M30")
        self.say("%")

    def _slides(self, tip, rotary, length, k):
        """Words of joints X, Y, Z, which G43 lifts by the length of the tool, and of the rotary ones."""
        some = {name: value[k : k + 1] for name, value in rotary.items()}
        q = self.chain.joints(tip[k : k + 1], some, length)[0]
        home, lift = self._home_and_lift()
        at = np.array([q[self.chain.names.index(name)] for name in "XYZ"])
        x, y, z = (at - home - lift * length) / MM
        return f"X{x:.7f} Y{y:.7f} Z{z:.7f} {self.turned(some, 0)}"

    def _home_and_lift(self):
        """Joints X, Y, Z at which the nose is in the program's origin, and by what a metre of tool lifts them."""
        upright = {name: np.zeros(1) for name in self.chain.rotary}
        nose, higher = (self.chain.joints(self.shift[None], upright, length)[0] for length in (0.0, 1.0))
        picked = [self.chain.names.index(name) for name in "XYZ"]
        return nose[picked], (higher - nose)[picked]

    def _cldata(self, surfaces):
        self.say("UNITS/MM")
        self.say("MULTAX/ON")
        for k, ((tip, rotary), length) in enumerate(zip(surfaces, self.lengths)):
            self.say(f"LOADTL/{k + 1}")
            above = tip + LIFT
            self.say("RAPID")
            self.say(f"GOTO/{self._point(above[0], [0.0, 0.0, 1.0])}")
            self.say("RAPID")
            self.say(f"GOTO/{self._point(above[0], self.vector(rotary, 0))}")
            self.say(f"FEDRAT/{self.feed:g},MMPM")
            for i in range(len(tip)):
                self.say(f"GOTO/{self._point(tip[i], self.vector(rotary, i))}")
            self.note(tip, length)
            self.say("RAPID")
            self.say(f"GOTO/{self._point(above[-1], [0.0, 0.0, 1.0])}")
        self.say("FINI")

    def _point(self, tip, axis):
        return ",".join(f"{value:.9f}" for value in [*(tip / MM), *axis])
