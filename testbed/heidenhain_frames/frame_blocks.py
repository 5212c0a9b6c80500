"""Blocks that shift, mirror, turn and scale."""

from __future__ import annotations

from testbed.heidenhain_frames.words import Words


class FrameBlocks(Words):
    """Writes them; before a plane it ends what a plane is not laid over, but in some programs."""

    def mark(self, kind, on):
        """Note a transformation that is in force, or that is none."""
        (self.kinds.add if on else self.kinds.discard)(kind)

    def cleared(self, *kinds):
        """Reset transformations of these kinds, where the program may not write what is refused."""
        for kind in kinds if not self.loose else ():
            if kind in self.kinds:
                self.ended(kind)

    def ended(self, kind):
        if kind == "shift":
            letters = "XYZ" if self.plane or self.tip else ["X", "Y", "Z", *self.chain.rotary]
            words = [f"{letter}+0" for letter in letters]
            lines = [f"CYCL DEF 7.{k} {word}" for k, word in enumerate(words, 1)]
            given = dict.fromkeys(letters, (0.0, False))
            self.say("\n".join(["CYCL DEF 7.0 DATUM SHIFT", *lines]), "take_shift", given)
        elif kind in ("mirror", "mirror of rotary"):
            self.say("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1", "mirror", [])
            self.mark("mirror of rotary", False)
        elif kind == "rotation":
            self.say("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0", "rotate", 0.0, False)
        elif kind == "scale":
            self.say("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1", "scale", 1.0)
        else:
            self.say("CYCL DEF 26.0 SCALING\nCYCL DEF 26.1 X1 Y1", "scale_axes", [1.0] * 3, (0.0, 0.0, 0.0))
        self.mark(kind, False)

    def frame(self):
        self.pick(self.shift, self.shift, self.mirror, self.rotate, self.scale, self.scale_axes)()

    def shift(self):
        words, given = self.axes("XYZ", -30.0, 30.0)
        if not self.plane and not self.tip and self.chance(0.15):
            name, value = self.pick(*self.chain.rotary), self.number(-10.0, 10.0)
            words, given = f"{words} {name}{value:+g}", given | {name: (value, False)}
        if self.chance(0.2):
            words, given = "X+0 Y+0 Z+0", dict.fromkeys("XYZ", (0.0, False))
        if not given:
            return
        if any(name in given for name in self.chain.rotary) and not self.loose:
            self.cleared("mirror of rotary")
            self.mark("shift of rotary", True)
        self.mark("shift", True)
        if self.chance(0.3) and "I" not in words:
            self.say(f"TRANS DATUM AXIS {words}", "take_shift", given)
        else:
            lines = [f"CYCL DEF 7.{k} {word}" for k, word in enumerate(words.split(), 1)]
            self.say("\n".join(["CYCL DEF 7.0 DATUM SHIFT", *lines]), "take_shift", given)

    def mirror(self):
        letters = [letter for letter in "XY" if self.chance(0.4)]
        if not self.plane and not self.tip and self.chance(0.2):
            if "shift of rotary" in self.kinds and not self.loose:
                self.ended("shift")
                self.mark("shift of rotary", False)
            letters += [name for name in self.chain.rotary if self.chance(0.5)]
        self.mark("mirror", bool(letters))
        self.mark("mirror of rotary", any(name in letters for name in self.chain.rotary))
        self.say(f"CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 {' '.join(letters)}".rstrip(), "mirror", letters)

    def rotate(self):
        adds, angle = self.chance(0.3), self.number(-170.0, 170.0)
        angle = 0.0 if self.chance(0.3) else angle
        self.mark("rotation", adds or angle != 0.0)
        self.say(f"CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 {'I' if adds else ''}ROT{angle:+g}", "rotate", angle, adds)

    def scale(self):
        by = self.pick(0.5, 1.0, 1.0, 2.0, 0.99537)
        self.mark("scale", by != 1.0)
        self.say(f"CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL {by:g}", "scale", by)

    def scale_axes(self):
        by = [1.0] * 3 if self.chance(0.5) else [self.pick(1.4, 0.6, 1.0), self.pick(1.4, 0.75), 1.0]
        centre = [self.number(-20.0, 20.0), self.number(-20.0, 20.0)]
        words = f"X{by[0]:g} Y{by[1]:g} CCX{centre[0]:+g} CCY{centre[1]:+g}"
        told = (*(value * self.unit for value in centre), 0.0)
        self.mark("axes", by != [1.0] * 3)
        self.say(f"CYCL DEF 26.0 AXIS-SPECIFIC SCALING\nCYCL DEF 26.1 {words}", "scale_axes", by, told)
