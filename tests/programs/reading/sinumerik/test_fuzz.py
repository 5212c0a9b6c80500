"""Whatever stands in a program, reading it ends with a tool path or one ProgramError, and soon."""

from __future__ import annotations

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.sinumerik import read
from toolpace.common.errors import ProgramError

PIECES = (
    "G0", "G1", "G2", "G3", "CIP", "CT", "BSPLINE",
    "SD=2", "PW=0.5", "PL=1", "RND=1", "CHF=1", "CHR=1", "RNDM=2", "RNDM=0",
    "G4", "G9", "G17", "G18", "G19", "G40", "G41", "G53", "SUPA", "G54",
    "G505", "G500", "G58", "G60", "G64", "G70", "G71", "G90", "G91", "G93", "G94", "G95", "G110", "G111",
    "G112", "G331", "G74", "G75", "TRANS", "ATRANS", "ROT", "AROT", "ROTS", "SCALE", "MIRROR", "TRAORI",
    "TRAFOOF", "ORIAXES", "ORIVECT", "MCALL", "CYCLE81(5,0,1,-3)", "CYCLE83(5,0,1,-9,,,3,1)",
    "CYCLE84(5,0,1,-3,,,,6)", "CYCLE86(5,0,1,-3,,1,3,1,1,1,0)", "CYCLE90(5,0,0,-8,,28,25,2,1000,2,0,10,20)",
    "HOLES2(0,0,5,0,0,3)", 'CYCLE800(0,"",0,57,0,0,0,10,20,0,0,0,0,1,0)', "CYCLE800()", "CYCLE832(0.01,1,1)",
    "X10", "Y-5", "Z3.5", "A20", "C=DC(350)", "X=IC(R1)", "Y=R2*2", "I5", "J=AC(2)", "CR=7", "AR=90",
    "TURN=2", "AP=30", "RP=5", "I1=2", "J1=3", "A3=0.1", "B3=0.2", "C3=1", "A2=10", "F500", "S100", "T1",
    "M6", "D0", "D1", "K2", "RPL=30", "R1=R1+1", "R2=1/R1", "DEF REAL AA=2", "AA=AA*2", "IF R1>2", "ELSE",
    "ENDIF", "FOR R3=1 TO 3", "ENDFOR", "WHILE R1<4", "ENDWHILE", "LOOP", "ENDLOOP", "REPEAT", "UNTIL R1>5",
    "GOTOF LAB", "GOTOB LAB", "LAB:", "REPEAT LAB P=2", "REPEATB LAB", "SUB1", "SUB1(5)", "L10 P2",
    "PROC SUB1(REAL XX)", "RET", "M17", "CASE(R1) OF 1 GOTOF LAB DEFAULT GOTOB LAB", 'MSG("hello")', "/",
    "N10", "$P_UIFR[1]=CTRANS(X,5):CROT(Z,10)", "X=$P_EP[Y]", "'HFF'", '"', "(", ")", "[", "=", ",", ";", ":",
    "<<", "\x01", "ß", "1EX999999",
)  # fmt: skip


def tried(text: str, on: str | None) -> None:
    try:
        read(text, on, most_blocks=3000, compensation="program")
    except ProgramError as error:
        assert str(error).startswith("part.mpf") and "\n" not in str(error)


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.lists(st.sampled_from(PIECES), min_size=1, max_size=5).map(" ".join), max_size=12).map("\n".join),
    st.sampled_from([None, "xyzac-trunnion"]),
)
def test_blocks_of_real_words(text, on):
    tried(text, on)


@settings(max_examples=200, deadline=None)
@given(st.text(alphabet="GXYZR019=+-*/().,;:[]<>\"'$_ABEIFNP \n", max_size=120))
def test_any_characters(text):
    tried(text, None)


GOOD = """DEF REAL DEPTH=2, WIDE
TRAORI
FOR R1=1 TO 3
IF R1<>2
G1 X=R1*10 Y=IC(2) A=R1 A3=0.1 C3=1
ELSE
G2 X20 Y5 CR=30
ENDIF
ENDFOR
MCALL CYCLE83(5,0,1,-DEPTH,,,1,0.5)
G0 X5 Y5
MCALL
TRAFOOF
CYCLE800(0,"",0,57,0,0,0,10,0,0,0,0,0,1,0)
SUB1(DEPTH)
M30
PROC SUB1(REAL TO_X) SAVE
G91 G1 X=TO_X
RET
"""


@pytest.mark.parametrize("seed", range(150))
def test_programs_that_are_damaged(seed):
    chance = random.Random(seed)
    text = list(GOOD)
    for _ in range(chance.randint(1, 6)):
        place = chance.randrange(len(text))
        kind = chance.randrange(3)
        if kind == 0:
            del text[place]
        elif kind == 1:
            text.insert(place, chance.choice('GXR059=()[],.;:"-+\n '))
        else:
            other = chance.randrange(len(text))
            text[place], text[other] = text[other], text[place]
    tried("".join(text), "xyzac-trunnion")
