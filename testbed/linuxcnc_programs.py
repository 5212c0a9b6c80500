"""Random programs of the words that LinuxCNC knows, with tables of offsets, references and tools.

Most can be run; about one in eight has a block that no controller takes. Lines carry their number as N, so that what
an interpreter says of them can be told apart.
"""

from __future__ import annotations

import math
from random import Random

PLANES = {"G17": ("X", "Y", "Z", "I", "J"), "G18": ("Z", "X", "Y", "K", "I"), "G19": ("Y", "Z", "X", "J", "K")}
"""First and second axis, the normal, and the words of the centre."""
OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
WRONG = (
    "G1 X1 X2", "G2 X900 R1", "G4", "G4 P-1", "G0 G1 X1", "G81 X1 Y1", "G1 X", "X1 G90 G91", "G54 G55", "H2",
    "G10 L2 P12 X1", "G10 L2 P1.3 X1", "M6 T1 T2", "#1=[1/0]", "G1 X[SQRT[-1]]", "G1 X#<never_set>", "G17 G18",
    "G2 X1 Y1", "G1 F-5 X2", "G28.7", "M3 M4", "o900 call", "G80 X1", "G83 X1 Y1 Z-2 R1 Q-1", "G82 X1 Y1 Z-2 R1 L-1",
    "G1 X1 Y", "X1 = 3", "G1 X[1+]", "G1 X[2", "G1 X1)", "G92", "G5 X1", "Q3", "G3 I0 J0", "T-1", "S-5", "G1 K3 X9",
    "G53 X1 G2 I1", "G91 G53 X1 I3", "M61", "G64 P-1", "G1 X1 L2", "G2 X3 Y4 R10 I2", "G10 L20 P1",
    "G52", "G43.1", "D3", "G1 X1 P3", "G0 X1 R2", "G93 G1 X77", "G20 G21",
)  # fmt: skip
"""Blocks that are, most of them, refused."""


class Writer:
    """Writes one program."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.lines: list[str] = []
        self.inch, self.absolute, self.plane, self.mode = False, True, "G17", "G94"
        self.labels = 100
        self.subs: list[list[str]] = []
        self.behind: list[str] = []
        """Programs that stand behind the end of the main one."""
        self.told_tool = False
        """Whether there was M61 or T0: the stand-alone interpreter then does not know the length of the tool."""
        self.named: list[str] = []
        """Variables that have a value."""

    # Words

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def put(self, *words: str) -> None:
        text = " ".join(word for word in words if word)
        if not text:
            return
        if self.chance(0.04):
            text += self.random.choice([" (said)", " ; said", " (MSG, said)"])
        if self.chance(0.05):
            text = text.lower()
        elif self.chance(0.03):
            text = text.replace(" ", "")
        elif self.chance(0.06) and not any(mark in text for mark in "#[(;/"):
            text = " ".join(self.random.sample(text.split(), len(text.split())))
        self.lines.append(text)

    def number(self, low: float, high: float) -> str:
        """A number in the unit in force, sometimes as an expression."""
        scale = 25.4 if self.inch else 1.0
        value = self.random.uniform(low, high) / scale
        text = f"{value:.4f}" if self.inch else f"{value:.3f}"
        if self.chance(0.3):
            text = f"{value:.1f}"
        elif self.chance(0.05):
            text = f"{value:.0f}"
        elif self.chance(0.05):
            text = text.replace("0.", ".", 1) if abs(value) < 1 else f"{value:.0f}."
        elif self.chance(0.03) and value > 0:
            text = f"+{text}"
        return self.wrapped(text) if self.chance(0.15) else text

    def wrapped(self, text: str) -> str:
        """An expression that comes to a number, nearly."""
        ways = [
            f"[{text}]", f"[{text}*2/2]", f"[{text}+SIN[30]-.5]", f"[ABS[{text}]]", f"[[{text}] + 7 MOD 3]",
            f"[ROUND[{text}]]", f"[FIX[{text}]]", f"[FUP[{text}]]", f"[{text} - ATAN[1]/[1] + 45]", f"-[{text}]",
            f"[{text}+2**2-4]", f"[{text}*[1 LT 2]]", f"[{text}+[3 GT 4 OR 1 EQ 2]]", f"[SQRT[[{text}]**2]]",
            f"[{text}+ACOS[0]-90]", f"[{text}+LN[EXP[1]]]", f"[{text}+[-7.5 MOD 4]]", f"[{text}-TAN[45]*COS[60]]",
            f"[{text}+[2 AND 0]+[1 XOR 0]]", f"[[{text}]+EXISTS[#<never>]]", "-" + f"[-[{text}]]",
            f"[{text} + ASIN[.5] - 30 + 1 - 2 * 3 / 4]",
        ]  # fmt: skip
        if self.named:
            name = self.random.choice(self.named)
            ways += [f"[{text}+{name}]", name, f"[{name}/2]", f"[{text}*[{name} LE 3]]"]
        return self.random.choice(ways)

    def axes(self, share: float, letters: str = "XYZ", *, turning: float = 0.12) -> str:
        """Some axis words, at least one."""
        reach = 60.0 if self.absolute else 15.0
        chosen = [letter for letter in letters if self.chance(share)] or [self.random.choice(letters)]
        words = [letter + self.number(-reach, reach) for letter in chosen]
        for letter in "AC":
            if self.chance(turning):
                words.append(f"{letter}{self.random.uniform(-2 * reach, 2 * reach):.2f}")
        return " ".join(words)

    def f(self) -> str:
        """F as the mode of feed wants it."""
        if self.mode == "G93":
            return f"F{self.random.uniform(2, 60):.1f}"
        if self.mode == "G95":
            return f"F{self.random.uniform(0.05, 0.3) / (25.4 if self.inch else 1):.3f}"
        return f"F{self.random.uniform(100, 3000) / (25.4 if self.inch else 1):.1f}"

    def to(self, reach: float = 40.0) -> dict[str, float]:
        """Position X, Y, Z under G90; where the machine then is, in the unit in force."""
        digits = 4 if self.inch else 3
        place = {a: round(self.random.uniform(-reach, reach) / (25.4 if self.inch else 1.0), digits) for a in "XYZ"}
        self.put("G90 G0", *(f"{letter}{value}" for letter, value in place.items()))
        if not self.absolute:
            self.put("G91")
        return place

    # Blocks

    def line(self) -> None:
        word = self.random.choice(["G0", "G1", "G1", "G01", "G00"])
        feed = self.f() if word in ("G1", "G01") and (self.mode == "G93" or self.chance(0.3)) else ""
        self.put(word, self.axes(0.5), feed)
        if self.mode != "G93":
            for _ in range(self.random.choice([0, 0, 1, 3])):
                self.put(self.axes(0.4))

    def turn(self) -> None:
        self.put(
            "G1", f"A{self.number(-90, 90)}" if self.chance(0.5) else f"C{self.random.uniform(-200, 200):.2f}", self.f()
        )

    def arc(self) -> None:
        place = self.to()
        first, second, normal, i, j = PLANES[self.plane]
        scale, digits = (1 / 25.4, 5) if self.inch else (1.0, 4)
        radius, begin = self.random.uniform(1, 30) * scale, self.random.uniform(0, 2 * math.pi)
        word = self.random.choice(["G2", "G3"])
        full = self.chance(0.2)
        sweep = 2 * math.pi if full else self.random.uniform(0.1, 6.1)
        sweep = -sweep if word == "G2" else sweep
        centre = (-radius * math.cos(begin), -radius * math.sin(begin))
        end = (centre[0] + radius * math.cos(begin + sweep), centre[1] + radius * math.sin(begin + sweep))
        words = []
        start = (place[first], place[second])
        if not full or self.chance(0.3):
            base = start if self.absolute else (0.0, 0.0)
            shift = (0.0, 0.0) if full else end
            words += [f"{a}{b + s:.{digits}f}" for a, b, s in zip((first, second), base, shift)]
        if self.chance(0.25):
            words.append(normal + self.number(-5, 5))
        if self.chance(0.1):
            words.append(f"{self.random.choice('AC')}{self.random.uniform(-40, 40):.2f}")
        by_radius = not full and self.chance(0.3) and not 3.0 < abs(sweep) < 3.3 and abs(sweep) < 5.5
        if by_radius:
            words.append(f"R{radius * (1 if abs(sweep) < math.pi else -1):.{digits}f}")
        else:
            absolute = self.chance(0.25)
            base = start if absolute else (0.0, 0.0)
            words += [f"{letter}{b + c:.{digits}f}" for letter, b, c in zip((i, j), base, centre)]
            words.append("G90.1" if absolute else "G91.1")
        if self.chance(0.15):
            words.append(f"P{self.random.randint(1, 4)}")
        self.put(word, *words, self.f() if self.mode == "G93" or self.chance(0.2) else "")

    def unit(self) -> None:
        self.inch = not self.inch
        self.put("G20" if self.inch else "G21", self.f() if self.chance(0.3) and self.mode == "G94" else "")

    def distance(self) -> None:
        self.absolute = not self.absolute
        self.put("G90" if self.absolute else "G91")

    def planes(self) -> None:
        self.plane = self.random.choice(list(PLANES))
        self.put(self.plane)

    def feed(self) -> None:
        self.mode = self.random.choice(["G93", "G94", "G94", "G95"])
        self.put(self.mode, "" if self.mode == "G93" else self.f())

    def dwell(self) -> None:
        self.put("G4", f"P{self.random.choice(['0', '.5', '1', '2.25', '[1/4]'])}")

    def offset(self) -> None:
        self.put(self.random.choice(OFFSETS), self.random.choice(["", "", "G0 " + self.axes(0.5)]))

    def position(self) -> None:
        word = self.random.choice(["G92", "G92", "G52", "G92.1", "G92.2", "G92.3", "G92.2", "G52 X0 Y0 Z0 A0 C0"])
        self.put(word, self.axes(0.5) if word in ("G92", "G52") else "")

    def origin(self) -> None:
        """G10."""
        number = self.random.choice([0, 0, 1, 2, 3, 5, 9])
        kind = self.random.choice(["L2", "L2", "L20"])
        turned = f"R{self.random.uniform(-90, 90):.2f}" if self.chance(0.3) else ""
        if turned and self.chance(0.3):
            turned = "R0"
        self.put("G10", kind, f"P{number}", self.axes(0.6), turned)

    def length(self) -> None:
        known = "G43 H1" if self.told_tool else "G43"
        offset = self.axes(0.3, turning=0.0)
        lift = self.number(-20, 20)
        words = [known, "G43 H1", "G43 H2", "G43 H0", "G49", "G49", f"G43.1 {offset}", "G43.2 H1", "G43.2 H3"]
        self.put(self.random.choice([*words, f"G43.1 Z{lift}", f"G43 H2 G0 Z{lift}"]))

    def tool(self) -> None:
        # `rs274` reads its position back behind M6, as it was told it last: offsets of tools would be forgotten
        self.put("G49")
        self.to()
        self.put(self.random.choice(["T1 M6", "T2 M6", "M6 T3", "T3", "M6", "M61 Q1", "T0 M6"]))
        self.told_tool |= any(word in self.lines[-1].upper() for word in ("M61", "T0"))
        move = f"G1 {self.axes(0.3, turning=0.0)} {self.f()}"
        self.put(self.random.choice(["G43 H2" if self.told_tool else "G43", "G43 H1", "", move]))

    def machine(self) -> None:
        word = self.random.choice(["G0", "G1", "G0"])
        if self.mode == "G93":
            word = "G0"
        was, self.absolute = self.absolute, True
        words = self.axes(0.5)
        self.absolute = was
        self.put("G53", word, words)

    def reference(self) -> None:
        self.put(self.random.choice(["G28", "G30"]), self.random.choice(["", self.axes(0.3), self.axes(0.3)]))

    def cycle(self) -> None:
        if self.mode != "G94":
            self.mode = "G94"
            self.put("G94", self.f())
        place = self.to()
        normal = PLANES[self.plane][2]
        flat = "".join(PLANES[self.plane][:2])
        word = self.random.choice(["G81", "G82", "G83", "G73", "G85", "G89", "G81", "G83", "G86", "G84", "G74"])
        if self.chance(0.06):
            word = "G87"
        if self.plane != "G17" and word in ("G84", "G74"):
            word = "G85"  # its interpreter mixes the axes of taps up outside XY
        scale = 25.4 if self.inch else 1.0
        base = place[normal] if self.absolute else 0.0
        top = base + self.random.choice([-8, -3, 0, 4, 9]) / scale
        depth = self.random.choice([2, 5.5, 12]) / scale
        bottom = top - depth if self.absolute else -depth
        words = [f"{normal}{bottom:.4f}", f"R{top:.4f}"]
        if word in ("G83", "G73"):
            words.append(f"Q{self.random.choice([1.37, 2.61, 20, 3.17]) / scale:.4f}")
        if word in ("G82", "G89", "G86", "G84", "G74"):
            words.append(f"P{self.random.choice(['.5', '1', '0'])}")
        if word in ("G86", "G84", "G74", "G87"):
            self.put("M4 S800" if word == "G74" else "M3 S800")
        if word == "G87":
            middle = self.random.choice([0.5, 1.5]) / scale
            level = "IJK"["XYZ".index(normal)]
            words += [f"{letter}{self.number(-3, 3)}" for letter in "IJK" if letter != level]
            words.append(f"{level}{middle + (bottom if self.absolute else 0):.4f}")
        if self.chance(0.3) and word != "G74":  # its interpreter knows no L there
            words.append(f"L{self.random.choice([1, 2, 3])}")
        self.put(self.random.choice(["G98", "G99", ""]), word, self.axes(0.8, flat, turning=0.01), *words)
        for _ in range(self.random.choice([0, 0, 1, 2, 3])):
            self.put(
                self.random.choice(["", "", "G98", "G99", word]),
                self.axes(0.6, flat, turning=0.0),
                self.random.choice(["", "", "", f"R{top + 1:.4f}", f"{normal}{bottom - 1:.4f}"]),
                self.random.choice(["", "", "", "L2" if word != "G74" else "", "", "", "L0"]),
            )
        if self.chance(0.2):
            other = self.random.choice(["G81", "G85"])
            self.put(other, self.axes(0.8, flat, turning=0.0), self.random.choice(["", *[" ".join(words[:2])] * 5]))
        self.put(self.random.choice(["G80", "G80", "G0 " + self.axes(0.5)]))

    def mode_of_path(self) -> None:
        self.put(
            self.random.choice(["G61", "G64", "G64 P.01", "G64 P.02 Q.01", "G61.1", "G40", "M8", "M9", "S500 M3", "M5"])
        )
        if self.lines[-1].upper().startswith("M5") and self.mode == "G95":
            self.put("M3")

    def assign(self) -> None:
        name = self.random.choice(["#1", "#2", "#100", "#31", "#<a>", "#<_wide>", "#<two words>", "#[50+3]"])
        self.put(f"{name}={self.number(-9, 9)}", self.random.choice(["", "", f"#5={self.number(1, 3)}"]))
        if name not in self.named:
            self.named.append(name)

    def system(self) -> None:
        """Variables of the controller itself, but those in units of the machine."""
        name = self.random.choice([
            "#5420", "#5421", "#5422", "#5423", "#5425", "#<_x>", "#<_y>", "#<_z>", "#<_a>", "#5220", "#5400",
            "#<_metric>", "#<_imperial>", "#<_absolute>", "#<_incremental>", "#<_current_tool>", "#<_coord_system>",
            "#<_feed>", "#<_plane>", "#<_line>", "#<_selected_tool>", "#<_motion_mode>", "#<_rpm>",
            "#<_inverse_time>", "#<_units_per_minute>", "#<_units_per_rev>", "#<_retract_r_plane>",
            "#<_ijk_absolute_mode>", "#<_tool_offset>",
        ])  # fmt: skip
        self.put("G1", f"X[{name}/10]", self.f())

    def deleted(self) -> None:
        self.put("/G1", self.axes(0.5), self.f())

    # Flow

    def inside(self) -> None:
        """Blocks within a loop, which leave all modes as they were."""
        if self.mode == "G93":
            self.put("G1", self.axes(0.5), self.f())
            return
        was, self.absolute = self.absolute, False
        self.put("G91 G1", self.axes(0.5))
        self.absolute = was
        if was:
            self.put("G90")

    def loop(self) -> None:
        self.labels += 1
        name = f"o{self.labels}" if self.chance(0.7) else f"o<loop{self.labels}>"
        kind = self.random.choice(["while", "repeat", "do", "if", "elseif"])
        times = self.random.randint(0, 3)
        if kind == "repeat":
            self.put(f"{name} repeat [{times}]")
            self.inside()
            if self.chance(0.3):
                self.loop()
            self.put(f"{name} endrepeat")
        elif kind == "while":
            self.put("#10=0")
            self.put(f"{name} while [#10 LT {times}]")
            self.inside()
            self.put("#10=[#10+1]")
            if self.chance(0.3):
                self.labels += 1
                self.put(f"o{self.labels} if [#10 EQ 2]")
                self.put(f"{name} {self.random.choice(['break', 'continue'])}")
                self.put(f"o{self.labels} endif")
            self.inside()
            self.put(f"{name} endwhile")
        elif kind == "do":
            self.put("#11=0")
            self.put(f"{name} do")
            self.put("#11=[#11+1]")
            self.inside()
            self.put(f"{name} while [#11 LT {times}]")
        else:
            self.put(f"#12={times}")
            self.put(f"{name} if [#12 GT 1]")
            self.inside()
            if kind == "elseif":
                self.put(f"{name} elseif [#12 EQ 1]")
                self.inside()
            if self.chance(0.7):
                self.put(f"{name} else")
                self.inside()
            self.put(f"{name} endif")

    def call(self) -> None:
        self.labels += 1
        name = f"o{self.labels}" if self.chance(0.5) else f"o<part{self.labels}>"
        was, self.lines, named, self.named = self.lines, [], self.named, ["#1", "#2", "#3"]
        self.put(f"{name} sub")
        if self.chance(0.3):
            self.put("#1=[#1+1]")
        self.inside()
        if self.mode == "G93":
            self.put(f"G1 X#1 Y#2 {self.f()}")
        else:
            self.put("G1 X#1 Y[#2/2]")
        if self.chance(0.3):
            self.put(f"{name} return [#1*2]" if self.chance(0.5) else f"{name} return")
            self.put("G1 X99")
        self.put(f"{name} endsub {self.random.choice(['', '[#1+3]'])}".rstrip())
        body, self.lines, self.named = self.lines, was, named
        if self.chance(0.5):
            self.subs.append(body)
        else:
            self.lines += body
        for _ in range(self.random.randint(1, 2)):
            arguments = " ".join(f"[{self.number(-20, 20)}]" for _ in range(self.random.randint(0, 3)))
            self.put(f"{name} call {arguments}".rstrip())
        if self.chance(0.3):
            self.put("G1 X[#<_value>/2]", self.f())

    def deep(self) -> None:
        """Calls within each other: variables of their own, values returned early and late, recursion that ends."""
        self.labels += 2
        inner, outer = f"o{self.labels}", f"o{self.labels - 1}"
        here = "G91 G1 " + self.axes(0.4, turning=0.0) + (self.f() if self.mode == "G93" else "")
        back = "G90" if self.absolute else ""
        f = self.f() if self.mode == "G93" else ""
        self.subs.append([
            f"{inner} sub", "#3=[#1*2]", "#<a>=[#2+1]", "#<_wide>=[#<_wide>+1]", f"{outer} if [#1 GT 2.5]",
            f"{inner} return [#3+#<a>]", f"{outer} endif", here, *([back] if back else []), f"{inner} call [#1+1] [#3]",
            f"G1 X[#<_value>/9] Y#1 Z#<a> {f}".rstrip(), f"{inner} endsub [#<_value>-1]",
        ])  # fmt: skip
        self.put(f"#<_wide>={self.random.randint(0, 3)}", "#3=7")
        self.put(f"{inner} call [{self.random.randint(0, 3)}] [#3]")
        self.put(f"G1 X#3 Y#<_wide> Z[#<_value>/7] {self.f()}")

    def by_number(self) -> None:
        """Programs called by M98."""
        if self.mode == "G93":
            return
        self.labels += 1
        self.behind += [f"O{self.labels}", f"G1 {self.axes(0.4)}", "G1 X[#30+1]", "#30=[#30+2]", "M99"]
        self.put(f"#30={self.random.randint(0, 5)}")
        self.lines.append(" ".join([f"M98 P{self.labels}", self.random.choice(["", "L2", "L3"])]))

    def at_once(self) -> None:
        """Many words in one block."""
        self.mode, self.absolute, self.plane, self.inch = "G94", True, "G17", self.chance(0.5)
        unit = "G20" if self.inch else "G21"
        self.put(
            f"{unit} G90 G94 G17 G64 G1 {self.axes(0.6)} {self.f()} S900 M3 M8", self.random.choice(["", "G54", "G55"])
        )

    def together(self) -> None:
        """Variables set in the block that uses them keep their old values in it."""
        self.put(f"#1={self.number(-9, 9)}", f"#2={self.number(-9, 9)}")
        self.put(f"G1 X#1 #1=[#1+5] Y[#2*#1] #2=#1 {self.f()}")
        self.put(f"G1 X##3 Y#[#3+1] #3=1 {self.f()}" if self.chance(0.3) else f"G1 X#1 Y#2 {self.f()}")

    def modes_kept(self) -> None:
        """M70 and M72, or M73 in a subprogram."""
        was = self.inch, self.absolute, self.plane, self.mode
        changes = [self.unit, self.distance, self.planes, self.mode_of_path, self.line, self.offset, self.line]
        in_sub = self.chance(0.5)
        if in_sub:
            self.labels += 1
            lines, self.lines = self.lines, []
            self.put(f"o{self.labels} sub")
        self.put("M73" if in_sub else "M70")
        for _ in range(4):
            self.random.choice(changes)()
        if in_sub:
            self.put(f"o{self.labels} endsub")
            self.subs.append(self.lines)
            self.lines = lines
            self.put(f"o{self.labels} call")
        else:
            self.put("M72")
        self.inch, self.absolute, self.plane, self.mode = was
        self.put("G1", self.axes(0.5), self.f())

    def wrong(self) -> None:
        self.put(self.random.choice(WRONG))

    # The whole

    def program(self) -> str:
        common = [self.line] * 8 + [self.arc] * 5 + [self.cycle] * 3
        rare = [
            self.unit, self.distance, self.planes, self.feed, self.dwell, self.offset, self.position, self.origin,
            self.length, self.tool, self.machine, self.reference, self.mode_of_path, self.assign, self.system,
            self.deleted, self.loop, self.call, self.turn, self.deep, self.by_number, self.at_once, self.together,
            self.modes_kept,
        ]  # fmt: skip
        # few kinds in each program: a difference is told by what it stands among
        kinds = common + [self.random.choice(rare) for _ in range(10)]
        self.put("G21 G90 G94 G17 G91.1 F600 M3 S1000")
        for _ in range(self.random.randint(3, 14)):
            self.random.choice(kinds)()
        if self.chance(0.12):
            self.wrong()
            self.line()
        self.put(self.random.choice(["M2", "M30"]))
        whole = [line for body in self.subs for line in body] + self.lines + self.behind
        return "".join(_numbered(number, line) + "\n" for number, line in enumerate(whole, start=1))

    def tables(self) -> tuple[dict[str, dict[str, float]], dict[int, dict[str, float]], dict[int, float]]:
        """Offsets, references and tools [mm, deg]."""
        offsets = {name: self.place(0.7) for name in OFFSETS if self.chance(0.5)}
        return offsets, {1: self.place(1.0), 2: self.place(1.0)}, {1: 50.0, 2: 80.5, 3: self.random.randint(0, 90)}

    def place(self, share: float) -> dict[str, float]:
        reach = {"X": 300, "Y": 200, "Z": 150, "A": 40, "C": 90}
        return {
            letter: round(self.random.uniform(-most, most), 2) for letter, most in reach.items() if self.chance(share)
        }


def _numbered(number: int, line: str) -> str:
    """A line with its number as N word, behind a slash; O-words and comments stand alone."""
    if line[:1] in "oO(;":
        return line
    return f"/N{number} {line[1:]}" if line.startswith("/") else f"N{number} {line}"


def random_program(
    seed: int,
) -> tuple[str, dict[str, dict[str, float]], dict[int, dict[str, float]], dict[int, float]]:
    """Text, work offsets, reference points and tool lengths of a program [mm, deg]."""
    writer = Writer(seed)
    text = writer.program()
    return text, *writer.tables()
