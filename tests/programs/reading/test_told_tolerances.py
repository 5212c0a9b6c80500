"""What a program says itself about how far its path may stray, in every dialect, and the numbers of its blocks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text

MACHINE = Machine.load("xyzac-trunnion")
HEAD = "G21 G90 G94 F600\nG0 X0 Y0 Z0\n"


def told(controller, body, dialect="gcode"):
    """Tolerances of the tip [um] and the axis [deg] on the way to each point."""
    path = read_text(body, MACHINE, dialect, controller=controller)
    return np.round(1e6 * path.tip_tolerance, 6).tolist(), np.round(np.degrees(path.axis_tolerance), 6).tolist()


def same(found, wanted):
    np.testing.assert_allclose(found, [math.nan if each is None else each for each in wanted])


def test_g64_p_of_linuxcnc():
    tip, axis = told("linuxcnc", HEAD + "G1 X1\nG64 P0.02\nX2\nG64\nX3\nG64 P0.05\nX4\nG61\nX5\nM2\n")
    same(tip, [None, None, 20.0, None, 50.0, None])
    same(axis, [None] * 6)


def test_g64_p_is_in_the_unit_of_the_program():
    tip, _ = told("linuxcnc", "G20 G90 G94 F20\nG64 P0.001\nG0 X0 Y0 Z0\nG1 X1\nM2\n")
    same(tip, [25.4, 25.4])


def test_g187_e_of_haas():
    tip, _ = told("haas", HEAD + "G1 X1.\nG187 P1 E0.01\nX2.\nG187 P2\nX3.\nM30\n")
    same(tip, [None, None, 10.0, None])


def test_cycle832_and_words_of_sinumerik():
    body = (
        "G90 G71 G64\nG0 X0 Y0 Z0\nG1 F600 X1\nCYCLE832(0.02,_ORI_FINISH,0.5)\nX2\nCYCLE832(0.05,_ROUGH)\nX3\n"
        "CTOL=0.004 X4\nOTOL=0.2\nX5\nCTOL=-1\nX6\nCYCLE832(0,_OFF,1)\nX7\nM30\n"
    )
    tip, axis = told("sinumerik", body)
    same(tip, [None, None, 20.0, 50.0, 4.0, 4.0, None, None])
    same(axis, [None, None, 0.5, None, None, 0.2, 0.2, None])


def test_cycle_32_of_klartext():
    body = (
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X+0 Y+0 Z+0 R0 FMAX\n3 CYCL DEF 32.0 TOLERANCE\n"
        "4 CYCL DEF 32.1 T0.02\n5 CYCL DEF 32.2 HSC-MODE:0 TA0.5\n6 L X+1 F600\n7 CYCL DEF 32.0 TOLERANCE\n"
        "8 CYCL DEF 32.1\n9 L X+2\n10 END PGM A MM\n"
    )
    tip, axis = told("heidenhain", body, "gcode")
    same(tip, [None, 20.0, None])
    same(axis, [None, 0.5, None])


@pytest.mark.parametrize(
    "text, numbered",
    [
        (
            "N10 G90\nN20G0X0\n\nX1\n/N30 X2\n/2N40 X3\n:50 X4\nn060 X5\nG1 X6\n",
            [(10, 1), (20, 2), (30, 5), (40, 6), (50, 7), (60, 8)],
        ),
        ("0 BEGIN PGM A MM\n12 L X+1\n/13 L X+2\n", [(0, 1), (12, 2), (13, 3)]),
    ],
)  # fmt: skip
def test_numbers_of_blocks(text, numbered):
    from toolpace.programs.reading.source import Source, numbered_blocks

    assert list(map(tuple, numbered_blocks(Source.from_text(text)).tolist())) == numbered
