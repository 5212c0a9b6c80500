"""Whatever the bytes: a sound ToolPath or a one-line ToolpaceError, nothing else."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.controllers import read_for
from tests.support.table_table import MACHINE
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.source import Source

GCODE = """%
O1 (SEED)
G21 G90 G94 G17 G40 G49 G80 G54
T1 M6
S9000 M3
G0 X0 Y0 Z20 A0 C0
G43.4 H1
G1 X10.5 Y-3.25 Z5. A-20 C45 F1200
G2 X14.5 Y.75 I4. J0.
G3 X10.5 Y-3.25 R4.
G93 G1 X12 A-21 F60
G94 G91 G1 X1 F500
G90 G61 G1 Z8
G64 P0.01
G4 P.5
G49 G0 X0 Y0 Z50
G18 G2 X10 Z60 K10 F300
M30
%
"""
APT = """PARTNO SEED
UNITS/MM
MULTAX
FEDRAT/MMPM,250
SPINDL/2000,RPM,CLW
FROM/0,0,50,0,0,1
RAPID
GOTO/10,0,0,0.6,0,0.8
GOTO/12,1,0.5 $
,0.5,0.1,0.86
GODLTA/0,0,4
CIRCLE/12,0,0,0,0,-1,1,0.1
GOTO/11,0,0
DELAY/2
FEDRAT/0.1,MMPR
GOTO/1,2,3
FINI
"""
TABLE = """x [mm],y [mm],z [mm],i,j,k,feed [mm/min],rapid,stop,dwell [s]
0,0,0,0,0,1,100,0,0,0
1,2,3,0,0.6,0.8,100,0,0,0.5
4,5,6,0,0,1,100,1,1,0
"""
MACRO = """%
O1000 (SEED)
G91 G28 Z0.
G90 G54.1 P3 G05.1 Q1
T08 M06
#1=1
WHILE [#1 LE 3] DO1
IF [#1 EQ 2] GOTO 10
G43.4 H1 X[#1*10.] Y#1 Z50. A-20. C45.
N10 #1=#1+1
END1
G49
G98 G83 X5. Y5. Z-5. R2. Q1. F250. P60 K2
G80
G68.2 X1. Y2. Z3. I0 J30. K0
G53.1
G1 Z5. F300.
G69
G65 P2000 A1.5 I2. I3.
G66 P2000 I2.
G1 X1. /M8
G67
G1 X20. ,R2.
Y9. ,C1.
X1.
Y3.
M98 P2000 L2
G52 X1.
G10 L2 P1 X0
G28 X0 Y0
M30
O2000
G2 X[#5001+4.] I2. F#[100+1]
M99
%
"""
O_WORDS = """o<hole> sub
G81 X#1 Y#2 Z-3 R2 F100
o<hole> endsub
#<n> = 0
G0 X0 Y0 Z10 A0 C0
o1 while [#<n> LT 4]
o2 if [[#<n> MOD 2] EQ 0]
o<hole> call [#<n>*5] [ATAN[1]/[2]]
o2 else
G1 X#<n> F500
o2 endif
#<n> = [#<n>+1]
o1 endwhile
o3 repeat [2]
G91 G1 X1
G90
o3 endrepeat
G92 X5
G53 G0 Z0
M428
G1 W-2 F50
G5 I0 J3 P0 Q-3 X1 Y1
G5.1 X2 I2 J-8
G5.2 P1 L3
X0 Y1 P1
X2 Y2 P1
G5.3
M2
"""
INDEXED = """%PM1
N10 G71 G90 G54 I1
N20 G93 X1. Y2. Z0.
N30 G74 Z-.1 L1
N40 G7 A5=15. C5=30. A7=254 C7=255
N50 G00 A=E254 C=E255
N60 X0. Y0. Z5.
N70 G03 X10. Y0. I5. J0. F200.
N80 G7 L1=1
N90 G141 L2=0 F2=15000.
N100 G1 X5. C45. F2000.
N110 G40
N120 G81 Y2. Z-5. B3. F50.
N130 G79 X4. Y0. Z0.
N140 M30
"""
SEEDS = {"gcode": GCODE, "apt": APT, "csv": TABLE}
HAAS = MACRO.replace("G43.4", "G234").replace("G54.1", "G154").replace("G68.2 X1. Y2. Z3. I0 J30. K0\nG53.1", "G254")
NURBS = "G1 X1. Y3.\nG6.2 P3 K0 X1. Y3.\nK0 X2. R2.\nK0 Y3.\nK1. X5.\nK2.\nK2.\nK2.\n"
CONTROLLED = {"fanuc": MACRO.replace("G68.2", NURBS + "G68.2"), "haas": HAAS, "linuxcnc": O_WORDS, "millplus": INDEXED}
SCRAPS = [
    "nan", "inf", "-", "+", ".", "1e999", "$", "%", "(", ")", ";", "/", ",", "G",
    "#1", "G2", "G3", "R1", "P9", "C99999", "CIRCLE/", "G91", "G20", "M429", "M428", "é",
    "9" * 400, "\x00", "\n", "\t", "\f", "\u2028", "\u0660",
]  # fmt: skip


def check(data: bytes, dialect: str | None, machine=MACHINE) -> None:
    try:
        text = Source.from_bytes(data)
        p = read_text("\n".join(text.lines) + "\n" * text.last_line_ended, machine, dialect)
    except ToolpaceError as error:
        assert "\n" not in str(error) and str(error)
        return
    n = len(p)
    assert n >= 2 and p.tip.shape == (n, 3) == p.axis.shape
    for values in (p.tip, p.axis, p.least_time, p.dwell):
        assert np.isfinite(values).all()
    assert (p.feed > 0).all() and (p.least_time >= 0).all() and (p.dwell >= 0).all()
    assert np.abs(np.linalg.norm(p.axis, axis=1) - 1).max() < 1e-9
    assert (np.diff(p.block) >= 0).all() and p.stop[0] and p.stop[-1]
    assert p.rotary is None or np.isfinite(p.rotary).all()


@pytest.mark.parametrize("dialect", SEEDS)
def test_the_seeds_are_sound(dialect):
    assert len(read_text(SEEDS[dialect], MACHINE, dialect)) > 2


def mutated(seed: str, chance: random.Random) -> bytes:
    data = seed
    for _ in range(chance.randint(1, 4)):
        at, to = sorted((chance.randrange(len(data) + 1), chance.randrange(len(data) + 1)))
        kind = chance.randrange(6)
        if kind == 0:
            data = data[:at] + chance.choice(SCRAPS) + data[at:]
        elif kind == 1:
            data = data[:at] + data[at + chance.randint(1, 5) :]
        elif kind == 2:
            data = data[:at] + chr(chance.randrange(32, 127)) + data[at + 1 :]
        elif kind == 3:
            data = data[:at] if chance.random() < 0.3 else data[:at] + data[at:to] + data[at:]
        elif kind == 4:
            lines = data.split("\n")
            chance.shuffle(lines)
            data = "\n".join(lines)
        else:
            data = data[:at] + str(chance.choice([0, -1, 1e3, 0.5, 123456789])) + data[at:]
        data = data or " "
    return data.encode()


@pytest.mark.parametrize("numbers", [range(800), pytest.param(range(800, 2000), marks=pytest.mark.thorough)], ids=str)
@pytest.mark.parametrize("dialect", [pytest.param(d, marks=pytest.mark.sweep) if d == "gcode" else d for d in SEEDS])
def test_mutated_programs(dialect, numbers):
    chance = random.Random(20260101 + numbers.start)
    for number in numbers:
        check(mutated(SEEDS[dialect], chance), dialect if number % 4 else None, MACHINE if number % 3 else None)


@pytest.mark.parametrize("numbers", [range(280), pytest.param(range(280, 700), marks=pytest.mark.thorough)], ids=str)
@pytest.mark.parametrize("controller", CONTROLLED)
@pytest.mark.sweep
def test_mutated_programs_of_a_controller(controller, numbers):
    """Loops, calls, cycles and planes with something wrong in them end in a path or in one clear error."""
    chance = random.Random(20260102 + numbers.start)
    assert len(read_for(controller, CONTROLLED[controller].replace("F#[100+1]", "F100"), MACHINE)) > 5
    for number in numbers:
        text = mutated(CONTROLLED[controller], chance).decode("latin-1")
        try:
            path = read_for(controller, text or " ", MACHINE if number % 3 else None, most_blocks=3000)
            assert np.isfinite(path.tip).all()
        except ToolpaceError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize("dialect", SEEDS)
def test_programs_cut_off_anywhere(dialect):
    for end in range(len(SEEDS[dialect])):
        check(SEEDS[dialect][:end].encode(), dialect)


def test_random_bytes():
    chance = random.Random(7)
    for _ in range(1000):
        check(chance.randbytes(chance.randint(0, 200)), chance.choice([None, *SEEDS]))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.text(alphabet=" GMXYZABCFIJKRPNOSTHD0123456789.-+/%()\n", max_size=120))
def test_anything_spelt_like_gcode(text):
    check(("G0 X0 Y0 Z0\n" + text).encode(), "gcode")


@pytest.mark.sweep
@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.text(max_size=80))
def test_any_text(text):
    for dialect in (None, *SEEDS):
        check(text.encode("utf-8", "replace"), dialect)
