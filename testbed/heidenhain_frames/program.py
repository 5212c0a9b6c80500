"""Klartext programs of a seed: each block that changes something is written down with the method of `World` for it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from testbed.heidenhain_frames.plane_blocks import PlaneBlocks
from testbed.heidenhain_frames.words import MM
from testbed.true_tip.chain import Chain


@dataclass
class Written:
    """A program, its sheet and what its blocks are."""

    machine: str
    text: str
    sheet: str
    chain: Chain
    zero: np.ndarray
    presets: dict[str, np.ndarray]
    tools: dict[str, float]
    steps: list[tuple[int, str, tuple]]
    """Line, method of `World`, its arguments."""
    said: set[str] = field(default_factory=set)
    """Words that it has, for counting."""


class Writer(PlaneBlocks):
    """Writes the program of a seed."""

    def write(self) -> Written:
        """The program."""
        self.tool_call()
        number = self.pick("1", "2", "3")
        self.say(f"CYCL DEF 247 PRESET ~\n Q339=+{number} ;PRESET NUMBER", "take_preset", number)
        letters, level = " ".join(f"{name}+0" for name in self.chain.rotary), 4.0 if self.inch else 100.0
        self.say(
            f"L X+0 Y+0 Z+{level:g} {letters} R0 FMAX", "line",
            {"X": (0.0, False), "Y": (0.0, False), "Z": (level * self.unit, False)},
            dict.fromkeys(self.chain.rotary, (0.0, False)),
        )  # fmt: skip
        for _ in range(int(self.rng.integers(12, 30))):
            choices = [self.move] * 5
            if not self.tip:
                choices += [self.frame] * 3 + [self.plane_block] * 2 + [self.tip_on]
                choices += [self.tool_call] if self.chance(0.5) else []
                if not self.plane:
                    choices += [self.preset] if self.chance(0.4) else []
                    choices += [self.machine_move]
                else:
                    choices += [self.untilt]
                choices += [self.retract] if self.turned or not self.plane else []
            else:
                choices += [self.tip_off, self.retract]
            choices += [self.shorter] if self.chance(0.3) else []
            if self.tip:
                choices += [self.shift, self.rotate] if self.chance(0.4) else []
            self.pick(*choices)()
        self.say(f"END PGM S {'INCH' if self.inch else 'MM'}")
        return Written(
            self.machine, "\n".join(self.lines) + "\n", self.sheet(), self.chain, self.zero, self.presets, self.tools,
            self.steps, self.said,
        )  # fmt: skip

    def sheet(self):
        parts = ["[units]", 'length = "mm"', 'angle = "deg"', "[machine_zero]"]
        parts += [f"{letter} = {value / MM:.6f}" for letter, value in zip("XYZ", self.zero)]
        for name, place in self.presets.items():
            parts.append(f"[offsets.{name}]")
            parts += [f"{letter} = {value / MM:.6f}" for letter, value in zip("XYZ", place)]
        for name, length in self.tools.items():
            parts += [f"[tools.{name}]", f"length = {length / MM:.6f}"]
        return "\n".join(parts) + "\n"

    # What belongs to the machine

    def tool_call(self):
        name = self.pick(*self.tools)
        words, oversize = "", 0.0
        if self.chance(0.3):
            oversize = self.number(-1.0, 1.0)
            words = f" DL{oversize:+g}" + (f" DR{self.number(-1, 1):+g}" if self.chance(0.5) else "")
        self.oversize = bool(words)
        self.say(f"TOOL CALL {name} Z S2000{words}", "tool", name, oversize * self.unit)

    def preset(self):
        name = self.pick(*self.presets)
        text = f"CYCL DEF 247 PRESET ~\n Q339=+{name}" if self.chance(0.5) else f"PRESET SELECT #{name}"
        self.say(text, "take_preset", name)
        self.kinds.clear()

    def shorter(self):
        on = self.chance(0.6)
        self.say("M126" if on else "L M127", "shorter_way", on)

    # Motion

    def move(self):
        words, given = self.axes("XYZ")
        if self.tip and self.chance(0.75):
            if self.chance(0.35):
                self.vector(words, given)
            elif self.spatial:
                self.spatial_move(words, given)
            else:
                told, rotary = self.rotary()
                self.say(f"L {words} {told} {self.feed()}", "line", given, rotary)
            return
        if not self.plane and not self.tip and self.chance(0.3):
            told, rotary = self.rotary()
            self.say(f"L {words} {told} FMAX", "line", given, rotary)
        elif given and not (self.plane and not self.turned and not self.tip):
            self.say(f"L {words} {self.feed()}", "line", given, {})

    def spatial_move(self, words, given):
        told, angles = [], {}
        for letter, span in (("A", 25), ("B", 25), ("C", 100)):
            if not self.told_angles or self.chance(0.5):
                adds = self.told_angles and self.chance(0.3)
                value = self.number(-span, span) / (5.0 if adds else 1.0)
                value = round(value, 4)
                told.append(f"{'I' if adds else ''}{letter}{value:+g}")
                angles[letter] = (value, adds)
        if angles:
            self.told_angles = True
            self.say(f"L {words} {' '.join(told)} {self.feed()}", "spatial_line", given, angles)

    def vector(self, words, given):
        a, b = np.radians(self.rng.uniform(-30, 30, 2))
        vector = np.round([np.sin(b), -np.sin(a) * np.cos(b), np.cos(a) * np.cos(b)], 7)
        other = np.round(vector + self.rng.uniform(-0.2, 0.2, 3), 7)
        normal = " ".join(f"N{k}{v:+.7f}" for k, v in zip("XYZ", other if self.chance(0.5) else vector))
        tool = " ".join(f"T{k}{v:+.7f}" for k, v in zip("XYZ", vector))
        kind = "T" if self.oversize and not self.loose else self.pick("T", "NT", "N")
        if kind == "N":
            normal = " ".join(f"N{k}{v:+.7f}" for k, v in zip("XYZ", vector))
        told = {"T": tool, "NT": f"{normal} {tool}", "N": normal}[kind]
        self.told_angles = False
        self.say(f"LN {words} {told} {self.feed()}", "vector_line", given, vector)

    def machine_move(self):
        told, given = [], {}
        for letter in "XYZ":
            if self.chance(0.5):
                value = self.number(-80.0, -1.0)
                told.append(f"{letter}{value:+g}")
                given[letter] = value * self.unit
        rotary = {name: 0.0 for name in self.chain.rotary if self.chance(0.3)}
        if given or rotary:
            words = " ".join([*told, *(f"{name}+0" for name in rotary)])
            self.say(f"L {words} R0 FMAX M91", "machine_line", given, rotary)

    def retract(self):
        by = self.number(1.0, 40.0) if not self.inch else self.number(0.1, 2.0)
        self.say(f"L M140 MB{by:g}" if self.chance(0.5) else f"M140 MB {by:g} F900", "retract", by * self.unit)
