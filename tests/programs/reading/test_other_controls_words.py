"""Words by which controls that are not read move, and that mean nothing, or something else, on those that are read."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp

MACHINE = tp.Machine.load("xyzac-trunnion")


def said(text, **options):
    with pytest.raises(tp.ToolpaceError) as caught:
        tp.read_text(text, MACHINE, **options)
    return str(caught.value)


@pytest.mark.parametrize("word", ["G15 H1", "N10 G15 H2"])
def test_the_work_offset_of_okuma_is_refused_by_its_word(word):
    message = said(f"G21 G90\n{word}\nG0 X0 Y0 Z5\nG56 H1\nG1 X10 F100\nM2\n")
    assert ":2: G15 H" in message and "Okuma" in message


def test_din_iso_of_heidenhain_is_named_and_not_mended():
    """Without its stars it would be read, and G54 is a shift there, G28 a mirror."""
    message = said("N10 T1 G17 S5000 *\nN20 G00 G40 G90 Z+100 *\nN30 G54 X+25 Y+10 *\nN40 M30 *\n")
    assert ":1: " in message and "Klartext" in message


@pytest.mark.parametrize("word", ["G08 X20 Y10", "G63 Z-10 F100"])
def test_a_word_that_moves_on_some_controls_is_refused_beside_axes(word):
    assert "--controller" in said(f"G21 G90\nG0 X0 Y0 Z5\nG1 X10 F100\n{word}\nM30\n")


def test_alone_it_moves_nothing():
    path = tp.read_text("G21 G90\nG0 X0 Y0 Z5\nG08 P1\nG1 X10 F100\nG08 P0\nM30\n", MACHINE)
    np.testing.assert_allclose(path.tip, [[0.0, 0.0, 0.005], [0.01, 0.0, 0.005]], atol=1e-12)
    assert path.skipped == {"G8": 2}


def test_the_word_of_an_extruder_is_said_to_be_one():
    assert "printers" in said("G21\nG90\nG0 X0 Y0 Z5\nG1 X77.776 F900 E0.06844\nM2\n")


@pytest.mark.parametrize("block", ['R1=GETT("MILL",1)', 'G1 AX[AXNAME("X")]=10 F100'])
def test_a_function_of_sinumerik_that_is_not_read_is_named(block):
    message = said(f"G0 X0 Y0 Z0\n{block}\nG1 X10 F100\nM30\n", controller="sinumerik")
    assert ":2: " in message and "no function that is read" in message
