"""Blocks that tilt the plane, and switch M128 and FUNCTION TCPM."""

from __future__ import annotations

import numpy as np

from testbed.heidenhain_frames.frame_blocks import FrameBlocks
from testbed.heidenhain_frames.frames import euler, of_vectors, spatial

SIGNS = {"": 0, " SEQ+": 1, " SEQ-": -1, " SYM+": 1, " SYM-": -1}


class PlaneBlocks(FrameBlocks):
    """Writes them."""

    def plane_block(self):
        if self.plane:
            self.cleared("shift", "mirror", "rotation", "scale", "axes")
        else:
            self.cleared("rotation", "axes", "mirror of rotary")
            if "shift of rotary" in self.kinds and not self.loose:
                self.ended("shift")
                self.mark("shift of rotary", False)
        if self.chance(0.12) or (self.axial_before and self.chance(0.5)):
            self.axial()
            return
        form, matrix, relative = self.form()
        if form == "19":
            self.cleared("mirror")
        how = self.pick("TURN", "MOVE", "MOVE", "STAY")
        sign = self.pick("", "", *SIGNS)
        pivot = self.number(0.0, 80.0) if how == "MOVE" and self.chance(0.4) else 0.0
        words = f"{how} " + (f"DIST{pivot:g} " if pivot else "")
        if form == "19":
            a, b, c = matrix
            how = "STAY"
            self.say(f"CYCL DEF 19.0 PLANE\nCYCL DEF 19.1 A{a:+g} B{b:+g} C{c:+g}", "tilt", how, spatial(a, b, c))
        else:
            feed = "" if how == "STAY" else self.pick("FMAX", "F2000")
            self.say(f"PLANE {form} {words}{feed}{sign if how != 'STAY' else ''}", "tilt", how, matrix, relative,
                     SIGNS[sign], pivot * self.unit)  # fmt: skip
        self.into_plane()
        self.plane, self.turned, self.axial_before = True, how != "STAY", False
        if how == "STAY":
            self.stay()

    def stay(self):
        """Behind STAY the axes turn by Q120 to Q122, or M128 holds the tip."""
        if self.chance(0.2):
            self.tip_on()
            return
        words = " ".join(f"{name}+Q{120 + 'ABC'.index(name)}" for name in self.chain.rotary)
        self.say(f"L {words} FMAX", "position")
        self.turned = True

    def form(self):
        """Words of a plane, its matrix, and whether it adds."""
        a, b, c = self.number(-30, 30), self.number(-30, 30), self.number(-120, 120)
        a, b = self.pick((a, b), (a, 0.0), (0.0, b))
        kind = self.pick("SPATIAL", "EULER", "VECTOR", "POINTS", "RELATIV", "19")
        if kind == "SPATIAL":
            return f"SPATIAL SPA{a:+g} SPB{b:+g} SPC{c:+g}", spatial(a, b, c), False
        if kind == "EULER":
            return f"EULER EULPR{c:+g} EULNU{a:+g} EULROT{b:+g}", euler(c, a, b), False
        if kind == "RELATIV":
            k = int(self.rng.integers(3))
            angles = [0.0] * 3
            angles[k] = (a, b, c)[k]
            return f"RELATIV SP{'ABC'[k]}{angles[k]:+g}", spatial(*angles), True
        if kind == "19":
            return kind, (a, b, c), False
        turned = spatial(a, b, c)[:3, :3]
        if kind == "VECTOR":
            x, z = np.round(turned[:, 0], 6), np.round(turned[:, 2], 6)
            words = [f"{name}{k}{v:+.6f}" for name, vector in (("B", x), ("N", z)) for k, v in zip("XYZ", vector)]
            return "VECTOR " + " ".join(words), of_vectors(x, z), False
        points = np.round(self.rng.uniform(-20, 20, 3) + np.array([[0, 0, 0], [31, 0, 0], [9, 27, 0]]) @ turned.T, 4)
        words = [f"P{k}{letter}{v:+.4f}" for k, point in enumerate(points, 1) for letter, v in zip("XYZ", point)]
        x = points[1] - points[0]
        return "POINTS " + " ".join(words), of_vectors(x, np.cross(x, points[2] - points[0])), False

    def axial(self):
        """PLANE AXIAL: all axes at first, then some."""
        told, given = [], {}
        for name in self.chain.rotary:
            adds = self.axial_before and self.chance(0.4)
            if not self.axial_before or self.chance(0.6):
                value = self.number(-5, 5) if adds else self.pick(self.number(-25, 25), 0.0)
                told.append(f"{'I' if adds else ''}{name}{value:+g}")
                given[name] = (value, adds)
        if not given:
            return
        self.cleared("mirror")
        how = self.pick("TURN", "MOVE")
        idle = self.pick("", " SEQ+", " TABLE ROT")
        self.say(f"PLANE AXIAL {' '.join(told)} {how} FMAX{idle}", "tilt_axial", how, given)
        self.into_plane()
        self.plane = self.turned = self.axial_before = True

    def into_plane(self):
        """What stood before the plane is under it now."""
        if not self.plane:
            self.under, self.kinds = self.kinds, set()

    def untilt(self):
        how = self.pick("TURN", "MOVE", "STAY")
        self.say(f"PLANE RESET {how}" + (" FMAX" if how != "STAY" else ""), "untilt", how)
        self.plane = self.turned = self.axial_before = False
        self.kinds.clear()
        self.kinds |= self.under

    # Modes

    def tip_on(self):
        how = self.pick("M128", "L M128", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", "SPAT", "SPAT")
        self.cleared("axes")
        if how == "SPAT":
            self.cleared("mirror of rotary")
        self.spatial, self.told_angles = how == "SPAT", False
        text = "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS" if how == "SPAT" else how
        self.say(text, "tip_mode", True, self.spatial)
        self.tip = True

    def tip_off(self):
        self.say(self.pick("M129", "L M129", "FUNCTION RESET TCPM"), "tip_mode", False)
        self.tip = self.spatial = False
        if self.plane:
            self.stay_upright()

    def stay_upright(self):
        """Out of M128 in a plane: the plane once more, since the tool may stand anywhere."""
        self.untilt()
