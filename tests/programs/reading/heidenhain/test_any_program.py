"""Whatever the program: a sound tool path or one error of one line; and in linear time."""

from __future__ import annotations

import random
import time

import numpy as np
import pytest

from tests.support.heidenhain import CONTROLLER, MACHINE, START, reader
from toolpace.common.errors import ProgramError, ToolpaceError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.reader import HeidenhainReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

LETTERS = ("X", "Y", "Z", "A", "C", "IX", "IY", "IZ", "IA", "IC")
M_WORDS = ("M3", "M8", "M99", "M89", "M91", "M94", "M126", "M127", "M128", "M129", "M130", "M136", "M137", "M0", "M57",
           "M116", "M140 MB 5", "M140 MB+3 F100", "M109", "M120 LA3", "M118 X1", "M")  # fmt: skip
FIXED = (
    "CC", "CC X+0 Y+0", "CYCL CALL", "CYCL CALL PAT FMAX", "PLANE RESET STAY", "PLANE RESET TURN FMAX", "STOP",
    "CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 8.1 X", "CYCL DEF 8.1", "CYCL DEF 10.1 ROT+30", "CYCL DEF 11.1 SCL 0.9",
    "CYCL DEF 26.1 X1.1 Y0.9 CCX+1", "CYCL DEF 9.1 DWELL 0.1", "CYCL DEF 32.1 T0.01", "FUNCTION RESET TCPM", "RND R1",
    "CHF 0.5", "L IX+3 F100\nRND R1\nL IY+3", "PLANE RESET MOVE DIST5 F500",
    "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR", "TRANS DATUM RESET",
    "PATTERN DEF POS1 (X+1 Y+2 Z+0)", "PATTERN DEF ROW1 (X+1 Y+2 D+1 NUM3)", "CYCL DEF 247 Q339=+1", "M30", "LBL 0",
    "CYCL DEF 19.1 A+10 B+0 C+5", "CYCL DEF 19.1", "CYCL DEF 251 POCKET Q200=+2", "APPR LT X+1 Y+1 LEN5 RL",
    "APPR LCT X+1 Y+9 Z-1 R3 RR F200\nL IX+7",
    "APPR CT X+1 Y+1 CCA90 R-3\nCR X+9 Y+9 R+20 DR-", "APPR PLN PR+9 PA+30 LEN4 R0", "DEP LT LEN3",
    "DEP CT CCA 90 R2 RL",
    "DEP LCT X+3 Y+4 R1 M3", "DEP PLCT PR+30 PA+9 R1", "* - PART",
    "PLANE AXIAL A+10 C+5 TURN FMAX", "TOOL DEF 5", "BLK FORM 0.1 Z X+0 Y+0 Z-20", "FN 18: SYSREAD Q5 = ID20 NR1",
    "CYCL DEF 220 Q216=+0 ~\nQ217=+0 ~\nQ244=+5 ~\nQ245=+0 ~\nQ246=+90 ~\nQ247=+0 ~\nQ241=+3", "",
)  # fmt: skip


SCRAPS = ("+", "-", "Q", "=", "~", ";", '"', "9" * 400, "(", "/", "\n", "\t", "é", "\u0663", "~\n", "L ", "M")
ODD = ("", " ", "~\n~\n~", '"', "Q1 = " + "(" * 3000, "L " + "X+1 " * 5000, "* -", "0", "9" * 99)

GIVEN = """QS1 = "T"
Q1 = 1
Q2 = 2
QL3 = 3
QR4 = 4
Q120 = 5
TOOL CALL 1 Z S1000 F300
L X+1 Y+1 Z+5 A+0 C+0 F1000
L X+2
CC X+0 Y+0
PATTERN DEF POS1 (X+1 Y+2 Z+0)
CYCL DEF 200 HOLE Q200=+2 Q201=-5 Q206=+150 Q202=+5 Q203=+0 Q204=+20
LBL 1
"""
"""What most blocks need before them."""


class Chance:
    """Random blocks of every kind."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.labels = 1

    def one(self, *choices):
        return self.random.choice(choices)

    def value(self):
        if self.random.random() < 0.2:
            return self.one("+", "-", "") + self.one("Q1", "Q2", "QL3", "QR4", "Q120")
        return self.one("+", "-") + self.one("0", "1", "2.5", ".5", "10.", "7,25", "30", "0.001")

    def axes(self, letters=LETTERS):
        chosen = {letter[-1]: letter for letter in self.random.sample(letters, self.random.randint(1, 3))}
        return " ".join(letter + self.value() for letter in chosen.values())

    def tail(self):
        feed = self.one("", "", "FMAX", "F500", "F", "FQ1", "FAUTO", "FU0.1")
        side = self.one("", "", "R0", "R0", "RL")
        return f"{side} {feed} {self.one('', '', '', *M_WORDS)}"

    def formula(self):
        left = self.one("", "", "SIN ", "SQRT ", "ABS ") + self.one("Q1", "QL3", "2.5", "( Q2 + 1 )", "PI")
        return f"{self.one('Q1', 'Q2', 'QL3', 'QR4')} = {left} {self.one(*'+-*/%')} {self.one('Q2', '3')}"

    def block(self):
        v = self.value
        return self.one(
            f"L {self.axes()} {self.tail()}",
            f"L {self.axes()} {self.tail()}",
            f"L {self.one(*M_WORDS)}",
            f"LN X{v()} Y{v()} TX{v()} TY{v()} TZ+1 {self.tail()}",
            f"CC IX+5 IY-1\nC IX+0 IY+0 DR{self.one('+', '-')} {self.tail()}",
            f"CR X{v()} Y{v()} R{self.one('+', '-')}20 DR{self.one('+', '-')}",
            f"L IX+1 IY+1 IZ+1 F100\nCT IX{v()} IY{v()} IZ+1",
            f"CC {self.axes(('X', 'Y', 'IX', 'IY', 'Z'))}",
            f"LP {self.one('PR', 'IPR')}{v()} {self.one('PA', 'IPA')}{v()} {self.tail()}",
            f"CP {self.one('PA-30', 'PA+400', 'IPA+750')} IZ{v()} DR+",
            f"CTP PR{v()} PA{v()}",
            f"PLANE SPATIAL SPA{v()} SPB{v()} SPC{v()} {self.one('TURN', 'MOVE', 'STAY')} FMAX {self.one('', 'SEQ-')}",
            f"PLANE RELATIV SPB{v()} {self.one('TURN', 'STAY')} F500",
            f"CYCL DEF 7.1 {self.axes(('X', 'IY', 'Z', 'C'))}",
            f"TRANS DATUM AXIS {self.axes(('X', 'IY', 'Z'))}",
            f"CYCL DEF {self.one(200, 201, 203, 205, 207, 240)} HOLE Q200=+2 Q201=-{self.one(5, 10)} "
            f"Q206={self.one('100', 'FAUTO')} Q202=+4 Q203={v()} Q204=+20 Q239=+1",
            f"TOOL CALL {self.one('1', '2', 'Q1', 'QS1', '')} {self.one('X', 'Y', 'Z', 'Z')} S1000 F300",
            self.formula(),
            f"FN {self.one('1: Q1 = +Q1 + +1', '4: Q2 = +Q1 DIV +Q2', '13: QR4 = +1 ANG +Q2', '0: Q1 = +1')}",
            self.jump(),
            self.one(*FIXED),
            self.one(*FIXED),
        )

    def jump(self):
        self.labels += 1
        label = self.random.randint(1, max(self.labels, 1))
        return self.one(
            f"LBL {self.labels}",
            f"CALL LBL {label}",
            f"CALL LBL {label} REP {self.one(1, 2, 'Q1')}",
            f"FN {self.one('9: IF +Q1 EQU', '12: IF +Q1 LT', '11: IF +Q2 GT')} +3 GOTO LBL {label}",
        )

    def program(self):
        return GIVEN + "\n".join(self.block() for _ in range(self.random.randint(2, 25)))


def check(text, machine=MACHINE, **options):
    """Read; returns whether it reads."""
    try:
        path = reader(text, machine, most_blocks=3000, **options).executed().toolpath()
    except ToolpaceError as error:
        assert isinstance(error, ProgramError) and "\n" not in str(error) and str(error).startswith("test.h")
        return False
    for values in (path.tip, path.axis, path.least_time, path.dwell, path.rotary):
        assert values is None or np.isfinite(values).all()
    assert (path.feed > 0).all() and (path.dwell >= 0).all() and path.stop[[0, -1]].all()
    assert np.abs(np.linalg.norm(path.axis, axis=1) - 1).max() < 1e-9
    return True


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(640), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(640, 1600), marks=pytest.mark.thorough, id="many"),
    ],
)
def test_random_programs_read_or_say_why(seeds):
    read = sum(check(Chance(seed).program(), skip_unknown=True, compensation="program") for seed in seeds)
    assert read > 0.37 * len(seeds)


def test_random_programs_without_a_machine():
    for seed in range(300):
        check(Chance(seed).program(), None)


@pytest.mark.sweep
def test_mutated_programs():
    for seed in range(1500):
        chance = random.Random(seed)
        text = Chance(seed % 100).program()
        for _ in range(chance.randint(1, 4)):
            at, to = sorted((chance.randrange(len(text) + 1), chance.randrange(len(text) + 1)))
            scrap = chance.choice(
                ["+", "-", "Q", "=", "~", ";", '"', "9" * 400, "(", "/", "\n", "\t", "é", "٣", "~\n", "L ", "M"]
            )
            text = chance.choice([text[:at] + scrap + text[at:], text[:at] + text[at + 3 :], text[:at] + text[to:]])
        check(text or "L", skip_unknown=bool(seed % 2))


@pytest.mark.parametrize(
    "text", ["", " ", "~\n~\n~", '"', "Q1 = " + "(" * 3000, "L " + "X+1 " * 5000, "* -", "0", "9" * 99]
)
def test_odd_texts(text):
    check(text)


def test_a_program_without_its_frame():
    for text in ("L X+0 Y+0 Z+0 FMAX\nL X+1 F100\n", "END PGM A MM\n", "\n\n;\n", "LBL 0\n"):
        try:
            HeidenhainReader(Source.from_text(text), None, CONTROLLER, ReadOptions(), Findings()).executed().toolpath()
        except ProgramError as error:
            assert "\n" not in str(error)


def timed(text):
    began = time.process_time()
    made = reader(text, begin=START).executed().toolpath()
    return time.process_time() - began, made


@pytest.mark.sweep
def test_a_hundred_thousand_blocks_with_parameters_in_five_seconds():
    """In a loop, and line by line."""
    loop = (
        "Q1 = 0\nLBL 1\nQ2 = 50 * COS Q1\nQ3 = ( 50 + Q1 / 10 ) * SIN Q1\nL X+Q2 Y+Q3 Z-Q1 R0 F1000\n"
        "FN 1: Q1 = +Q1 + +0.01\nFN 12: IF +Q1 LT +199.995 GOTO LBL 1"
    )
    lines = "".join(
        f"{2 * k} Q{k % 50} = {k} * 0.001 + 3\n{2 * k + 1} L X+Q{k % 50} Y-{k / 999:.4f} F1000\n" for k in range(50_000)
    )
    for text, blocks in ((loop, 100_000), (lines, 100_000)):
        taken, path = timed(text)
        assert path.blocks > blocks and taken < 5.0


@pytest.mark.sweep
def test_time_grows_with_the_length_of_the_text_only():
    """Lines that go on and on, labels, and calls: twice as many take at most thrice the time and a bit."""
    kinds = {
        "continued": lambda n: (
            ("CYCL DEF 200 HOLE ~\n" + "Q200=+2 ~\n" * 100 + "Q201=-1\n") * (n // 100) + "L X+1 F100"
        ),
        "labels": lambda n: "L X+1 F100\n" + "".join(f"LBL {k}\n" for k in range(1, n)),
        "calls": lambda n: "L X+1 F100\nLBL 1\nIX+0.001 F100\nLBL 0\n" + "CALL LBL 1\n" * n,
    }
    for text in kinds.values():
        short, long = timed(text(10_000))[0], timed(text(40_000))[0]
        assert long < 12 * short + 0.3
