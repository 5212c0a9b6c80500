"""Programs to be given other feeds: at random in every mode of feed, in mm and inch; and one that cuts a stock."""

from __future__ import annotations

import numpy as np

from tests.support.set_up_sheets import milling_sheet

TURNS, TEETH = 6000.0, 3
SHEET = milling_sheet([(0, -20, -20), (60, 20, 0)], 10, 20, 40, uncertainty=0.5, spindle_speed=6000)
TWO_SLOTS = """G21 G90 G54 G17
T1 M6
G43 H1
S6000 M3
G0 X-30 Y0 Z20
G0 Z-2
G1 X90 F600
G0 Z20
G0 X-30 Y14
G0 Z-2
G1 X90
G0 Z20
M30
"""
"""Across that stock, from air to air, one at the middle and one at its side."""
WORDS = {"minute": "G94", "inverse": "G93", "turn": "G95", "tooth": "G95"}
GCODE = ("minute", "inverse", "turn")
MODES = {
    "linuxcnc": GCODE, "fanuc": GCODE, "haas": GCODE, "mazak": GCODE, "iso": GCODE, "millplus": ("minute", "turn"),
    "sinumerik": (*GCODE, "tooth"), "heidenhain": ("minute", "turn", "tooth", "M136"), "cldata": GCODE,
}  # fmt: skip
"""By dialect; a program of the mode "mixed" changes between all of them."""
EXTRAS = ("arcs", "cycles", "subprogram", "loop")
IN_TIP_MODE = {
    "millplus": ("G141 L2=0 F2=15000", "G40"), "sinumerik": ("TRAORI", "TRAFOOF"), "heidenhain": ("L M128", "L M129"),
}  # fmt: skip


def feed_program(dialect: str, mode: str, inch: bool, five: bool, extras: tuple[str, ...], seed: int) -> str:
    """The text of a program; of extras a dialect has those that it has words for, cycles not in tip mode."""
    kind = {"heidenhain": Klartext, "cldata": Cldata, "sinumerik": Sinumerik}.get(dialect, GCode)
    return kind(dialect, mode, inch, five, seed).text(extras)


class GCode:
    """Writes one program, a block a line."""

    def __init__(self, dialect: str, mode: str, inch: bool, five: bool, seed: int) -> None:
        self.dialect, self.mixed, self.inch, self.five = dialect, mode == "mixed", inch, five
        self.modes = MODES[dialect] if self.mixed else (mode,)
        self.rng = np.random.default_rng(seed)
        self.mode, self.in_force = "", False
        self.lines: list[str] = []
        self.routines: list[str] = []
        self.place = np.zeros(3)

    def text(self, extras: tuple[str, ...]) -> str:
        self.begin()
        self.lines += self.motions(6)
        for extra in extras:
            self.lines += getattr(self, extra)()
            self.lines += self.motions(2)
        self.end()
        return "\n".join([*self.lines, *self.routines, ""])

    def figure(self, value: float, digits: int = 4) -> str:
        """A length [mm] in the program's unit."""
        return f"{value / 25.4 if self.inch else value:.{digits}f}"

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def next_place(self) -> np.ndarray:
        return np.array([*self.rng.uniform(-60.0, 60.0, 2), self.rng.uniform(-5.0, 5.0)]).round(3)

    def feed(self, way: float, must: bool = False) -> tuple[list[str], str]:
        """Lines before a motion over a way [mm], and its F."""
        before, mode = [], self.mode
        if not mode or (self.mixed and self.chance(0.3)):
            mode = str(self.rng.choice(self.modes))
        if mode != self.mode:
            before, self.in_force = self.change_mode(mode), False
            self.mode = mode
        if self.in_force and not must and mode != "inverse" and self.chance(0.5):
            return before, ""
        self.in_force = True
        speed = float(self.rng.integers(20, 300) * 10)
        return before, self.word(mode, speed, way)

    def change_mode(self, mode: str) -> list[str]:
        return [WORDS[mode]]

    def word(self, mode: str, speed: float, way: float) -> str:
        per = {"minute": 1.0, "turn": TURNS, "inverse": max(way, 1.0)}[mode]
        return f" F{speed / per:.5f}" if mode == "inverse" else f" F{self.figure(speed / per, 6)}"

    # Blocks

    def begin(self) -> None:
        unit = ("G71", "G70") if self.dialect == "millplus" else ("G21", "G20")
        if self.dialect == "millplus":
            self.lines += ["%PM1234", "N1234 (PART)"]
        elif self.dialect != "linuxcnc":
            self.lines += ["%", "O1234 (PART)"]
        self.lines += [f"G90 {unit[self.inch]} G17 G94 G40", "T1 M6", "G54", f"S{TURNS:g} M3"]
        if self.dialect != "millplus":
            self.lines.append("G43.4 H1" if self.five else "G43 H1")
        elif self.five:
            self.lines.append(IN_TIP_MODE["millplus"][0])
        self.lines.append("G0 X0 Y0 Z" + self.figure(5.0))

    def end(self) -> None:
        if self.five:
            self.lines.append(IN_TIP_MODE.get(self.dialect, ("", "G49"))[1])
        self.lines.append("M2" if self.dialect == "linuxcnc" else "M30")

    def words(self, place: np.ndarray) -> str:
        return " ".join(f"{letter}{self.figure(value)}" for letter, value in zip("XYZ", place))

    def rotary(self) -> str:
        a, c = self.rng.uniform(5.0, 30.0), self.rng.uniform(-40.0, 40.0)
        return f" A{a:.2f} C{c:.2f}" if self.five and self.chance(0.5) else ""

    def motions(self, count: int) -> list[str]:
        found: list[str] = []
        for _ in range(count):
            to = self.next_place()
            if self.chance(0.15):
                found.append(f"G0 {self.words(to)}")
            else:
                before, feed = self.feed(float(np.linalg.norm(to - self.place)))
                found += [*before, f"G1 {self.words(to)}{self.rotary()}{feed}"]
            self.place = to
        return found

    def arcs(self) -> list[str]:
        before, feed = self.feed(20.0)
        x, y, _ = self.place
        end = np.array([x + 10.0, y + 10.0, self.place[2]])
        centre = self.centre(np.array([x, y + 10.0]))
        self.place = end
        return [*before, f"G3 {self.words(end)} {centre}{feed}"]

    def centre(self, centre: np.ndarray) -> str:
        if self.dialect != "millplus":
            centre = centre - self.place[:2]
        return f"I{self.figure(centre[0])} J{self.figure(centre[1])}"

    def cycles(self) -> list[str]:
        if self.five:
            return []
        first, second, third = (self.next_place() for _ in range(3))
        self.place, self.mode, self.in_force = third, "minute", True
        feed = f"F{self.figure(200.0)}"
        if self.dialect == "millplus":
            holes = [f"G79 {self.words(each)}" for each in (first, second)]
            return ["G94", f"G81 Z{self.figure(-4.0)} Y{self.figure(1.0)} {feed}", *holes, f"G0 {self.words(third)}"]
        x, y = (f"X{self.figure(each[0])} Y{self.figure(each[1])}" for each in (first, second))
        cycle = f"G81 {x} Z{self.figure(-8.0)} R{self.figure(6.0)} {feed}"
        return ["G94", "G0 Z" + self.figure(6.0), cycle, y, "G80", f"G0 {self.words(third)}"]

    def body(self) -> list[str]:
        """Blocks that begin from anywhere, in the mode and with the F that are in force."""
        mixed, self.mixed = self.mixed, False
        found = self.motions(2)
        self.mixed = mixed
        return found

    def subprogram(self) -> list[str]:
        if self.dialect == "millplus":
            return []
        before, feed = self.feed(30.0, must=True)
        start = [*before, f"G1 {self.words(self.next_place())}{feed}"]
        body, again = self.body(), self.feed(30.0, must=self.mode == "inverse")[1] if not self.mixed else ""
        to = self.next_place()
        between = [f"G1 {self.words(to)}{again}"] if again or self.mode != "inverse" else []
        return [*start, *self.called(100, body), *between, *self.called(100, body)]

    def called(self, name: int, body: list[str]) -> list[str]:
        linuxcnc = self.dialect == "linuxcnc"
        if not self.routines and linuxcnc:
            # before it is called
            self.lines[0:0] = [f"o{name} sub", *body, f"o{name} endsub"]
        elif not self.routines:
            self.routines += [f"O{name}", *body, "M99"]
        self.routines = self.routines or [""]
        return [f"o{name} call" if linuxcnc else f"M98 P{name}"]

    def loop(self) -> list[str]:
        if self.dialect == "millplus":
            return []
        before, feed = self.feed(30.0, must=True)
        start = [*before, f"G1 {self.words(self.next_place())}{feed}"]
        if self.dialect == "linuxcnc":
            return [*start, "o7 repeat [2]", *self.body(), "o7 endrepeat"]
        if self.dialect == "iso":
            return start
        return [*start, "#1=0", "WHILE [#1 LT 2] DO1", *self.body(), "#1=#1+1", "END1"]


class Sinumerik(GCode):
    """Sinumerik 840D."""

    def begin(self) -> None:
        head = f"G90 {('G710', 'G700')[self.inch]} G17 G94 G40"
        self.lines += [head, "T1 M6", "D1", "G54", f"S{TURNS:g} M3"]
        self.lines += ["TRAORI"] if self.five else []
        self.lines.append("G0 X0 Y0 Z" + self.figure(5.0))

    def word(self, mode: str, speed: float, way: float) -> str:
        if mode == "tooth":
            return f" FZ={self.figure(speed / TURNS / TEETH, 7)}"
        return super().word(mode, speed, way)

    def cycles(self) -> list[str]:
        if self.five:
            return []
        first, second, third = (self.next_place() for _ in range(3))
        self.place, self.mode, self.in_force = third, "minute", True
        levels = ",".join(self.figure(each) for each in (8.0, 2.0, 1.0, -6.0))
        holes = [f"X{self.figure(each[0])} Y{self.figure(each[1])}" for each in (first, second)]
        begin = ["G94", f"G0 Z{self.figure(8.0)} F{self.figure(200.0)}", f"MCALL CYCLE81({levels})"]
        return [*begin, *holes, "MCALL", f"G0 {self.words(third)}"]

    def called(self, name: int, body: list[str]) -> list[str]:
        if not self.routines:
            self.routines += [f"%_N_L{name}_SPF", *body, "M17"]
            self.lines[0:0] = ["%_N_PART_MPF"]
        return [f"L{name}"]

    def loop(self) -> list[str]:
        before, feed = self.feed(30.0, must=True)
        start = [*before, f"G1 {self.words(self.next_place())}{feed}"]
        return [*start, "R1=0", "WHILE R1<2", *self.body(), "R1=R1+1", "ENDWHILE"]


class Klartext(GCode):
    """Heidenhain: FU and FZ are modes of their own F, M136 is one of F."""

    def begin(self) -> None:
        self.lines += [f"BEGIN PGM PART {('MM', 'INCH')[self.inch]}", f"TOOL CALL 1 Z S{TURNS:g}", "L M3"]
        self.lines += ["L M128"] if self.five else []
        self.lines.append(f"L {self.words(np.array([0.0, 0.0, 5.0]))} FMAX")

    def end(self) -> None:
        self.lines += ["L M129"] if self.five else []
        self.lines.append("M30")
        self.routines.append(f"END PGM PART {('MM', 'INCH')[self.inch]}")
        self.lines += self.routines
        self.routines = []

    def words(self, place: np.ndarray) -> str:
        signed = [f"{'+' if value >= 0 else ''}{self.figure(value)}" for value in place]
        return " ".join(letter + value for letter, value in zip("XYZ", signed))

    def change_mode(self, mode: str) -> list[str]:
        before = ["L M137"] if self.mode == "M136" else []
        return [*before, "L M136"] if mode == "M136" else before

    def word(self, mode: str, speed: float, way: float) -> str:
        words = {"minute": ("F", 1.0), "turn": ("FU", TURNS), "tooth": ("FZ", TURNS * TEETH), "M136": ("F", TURNS)}
        letters, per = words[mode]
        return f" {letters}{self.figure(speed / per, 7)}"

    def motions(self, count: int) -> list[str]:
        found = [f"{each} FMAX" if each[:3] == "G0 " else each for each in super().motions(count)]
        return [each.replace("G0 ", "L ").replace("G1 ", "L ") for each in found]

    def rotary(self) -> str:
        text = super().rotary().replace("A", "A+")
        return text.replace("C", "C+") if "C-" not in text else text

    def arcs(self) -> list[str]:
        before, feed = self.feed(20.0)
        x, y, z = self.place
        end, centre = np.array([x + 10.0, y + 10.0, z]), np.array([x, y + 10.0, z])
        self.place = end
        at = [" ".join(self.words(each).split()[:2]) for each in (centre, end)]
        return [*before, f"CC {at[0]}", f"C {at[1]} DR+{feed}"]

    def cycles(self) -> list[str]:
        if self.five:
            return []
        first, second = self.next_place(), self.next_place()
        self.place = second
        figures = {200: 2.0, 201: -6.0, 206: 200.0, 202: 10.0, 210: 0.0, 203: 0.0, 204: 20.0, 211: 0.0}
        told = [f"  Q{key}={self.figure(value)} ;FIGURE" for key, value in figures.items()]
        at = [" ".join(self.words(each).split()[:2]) for each in (first, second)]
        return ["CYCL DEF 200 HOLES ~", *[f"{each} ~" for each in told[:-1]], told[-1],
                *(f"L {each} FMAX M99" for each in at)]  # fmt: skip

    def subprogram(self) -> list[str]:
        return [each.replace("G1 ", "L ") for each in super().subprogram()]

    def called(self, name: int, body: list[str]) -> list[str]:
        if not self.routines:
            self.routines += [f"LBL {name}", *body, "LBL 0"]
        return [f"CALL LBL {name}"]

    def loop(self) -> list[str]:
        before, feed = self.feed(30.0, must=True)
        start = [*before, f"L {self.words(self.next_place())}{feed}"]
        return [*start, "LBL 7", *self.body(), "CALL LBL 7 REP 1"]


class Cldata(GCode):
    """APT."""

    def begin(self) -> None:
        self.lines += ["PARTNO/PART", f"UNITS/{('MM', 'INCHES')[self.inch]}", "LOADTL/1"]
        self.lines += ["SPINDL/6000,RPM,CLW", "RAPID"]
        self.lines += ["MULTAX/ON"] if self.five else []
        self.lines.append(self.goto(np.array([0.0, 0.0, 5.0])))

    def end(self) -> None:
        self.lines.append("FINI")

    def goto(self, place: np.ndarray) -> str:
        axis = self.rng.uniform([-0.4, -0.4, 1.0], [0.4, 0.4, 1.2])
        axis = axis / np.linalg.norm(axis) if self.five else np.zeros(0)
        return "GOTO/" + ",".join([*(self.figure(value) for value in place), *(f"{value:.9f}" for value in axis)])

    def change_mode(self, mode: str) -> list[str]:
        return []

    def word(self, mode: str, speed: float, way: float) -> str:
        if mode == "inverse":
            return f"FEDRAT/INVERS,{speed / max(way, 1.0):.5f}"
        words = {"minute": ("MMPM", "IPM"), "turn": ("MMPR", "IPR")}[mode]
        return f"FEDRAT/{self.figure(speed / (1.0 if mode == 'minute' else TURNS), 6)},{words[self.inch]}"

    def motions(self, count: int) -> list[str]:
        found: list[str] = []
        for _ in range(count):
            to = self.next_place()
            if self.chance(0.15):
                found.append("RAPID")
            elif feed := self.feed(float(np.linalg.norm(to - self.place)))[1]:
                found.append(feed)
            found.append(self.goto(to))
            self.place = to
        return found

    def arcs(self) -> list[str]:
        return []

    cycles = subprogram = loop = arcs
