"""APT and CLSF: each test is one statement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.errors import ProgramError
from toolpace.reading import read_text
from toolpace.toolpath import ToolPath

MM_MIN = 1e-3 / 60


def path(body: str, **options) -> ToolPath:
    return read_text(body + "\n", None, "apt", **options)


def test_goto_with_commas_or_blanks_and_a_modal_axis():
    p = path("FEDRAT/250\nGOTO/1,2,3,0,0.6,0.8\nGOTO / 4 5.5 -6\ngoto/4.5,5, 6 ,0 1 0")
    assert p.tip * 1e3 == pytest.approx(np.array([[1, 2, 3], [4, 5.5, -6], [4.5, 5, 6]]))
    assert p.axis == pytest.approx(np.array([[0, 0.6, 0.8], [0, 0.6, 0.8], [0, 1, 0]]))
    assert p.block.tolist() == [2, 3, 4] and p.rotary is None


def test_rounded_axes_become_unit_vectors():
    assert np.linalg.norm(path("FEDRAT/1\nGOTO/0,0,0,0.577,0.577,0.577\nGOTO/1,0,0").axis, axis=1) == pytest.approx(1.0)


def test_godlta_goes_by_a_distance_or_along_the_axis():
    p = path("FEDRAT/1\nFROM/1,0,0,0,1,0\nGODLTA/1,2,3\nGODLTA/-10")
    assert p.tip * 1e3 == pytest.approx(np.array([[1, 0, 0], [2, 2, 3], [2, -8, 3]]))


@pytest.mark.parametrize(
    ("statement", "feed"),
    [
        ("FEDRAT/250", 250),
        ("FEDRAT/MMPM,250.0", 250),
        ("FEDRAT/250,MMPM", 250),
        ("FEDRAT / 10, IPM", 254),
        ("FEDRAT/IPM,10", 254),
        ("FEDRAT/250,PERMIN", 250),
        ("UNITS/INCHES\nFEDRAT/10", 254),
        ("SPINDL/2000,RPM,CLW\nFEDRAT/0.1,MMPR", 200),
        ("SPINDL/RPM,2000\nFEDRAT/IPR,0.01", 508),
        ("SPINDL/2000\nFEDRAT/0.1,PERREV", 200),
    ],
)
def test_fedrat_in_its_forms(statement, feed):
    assert path(f"{statement}\nGOTO/0,0,0\nGOTO/1,0,0").feed[1] / MM_MIN == pytest.approx(feed)


def test_rapid_holds_for_one_motion():
    p = path("FEDRAT/100\nGOTO/0,0,0\nRAPID\nPAINT/COLOR,3\nGOTO/1,0,0\nGOTO/2,0,0")
    assert p.feed / MM_MIN == pytest.approx([np.inf, np.inf, 100])


def test_units_comments_and_continuation():
    p = path(
        "$$ GOTO/9,9,9\nUNITS/INCHES $$ old\nFEDRAT/1\nGOTO/1,0,0\nGOTO/ 2, $ ignored\n"
        " $$ between\n 0,$\n0\nUNITS/MM\nGOTO/1,0,0"
    )
    assert p.tip[:, 0] * 1e3 == pytest.approx([25.4, 50.8, 1])
    assert p.block.tolist() == [4, 5, 10]


def test_meaningless_statements_are_counted():
    p = path(
        "PARTNO A $ PART\n B\nMULTAX/ON\nCYCLE/OFF\nPAINT/PATH\nPAINT/COLOR,1\n"
        "FEDRAT/9\nGOTO/0,0,0\nTOOL PATH/A,TOOL,B\n"
        "REMARK any / text, 3\nGOTO/1,0,0\nEND-OF-PATH"
    )
    assert p.skipped == {
        "PARTNO": 1,
        "MULTAX": 1,
        "CYCLE": 1,
        "PAINT": 2,
        "TOOL PATH": 1,
        "REMARK": 1,
        "END-OF-PATH": 1,
    }
    assert p.blocks == 11


@pytest.mark.parametrize(
    "statement", ["STOP", "OPSTOP", "LOADTL/3", "LOAD/TOOL,2", "COOLNT/ON", "SPINDL/OFF", "DELAY/0"]
)
def test_stops(statement):
    assert path(f"FEDRAT/9\nGOTO/0,0,0\nGOTO/1,0,0\n{statement}\nGOTO/2,0,0\nGOTO/3,0,0").stop.tolist() == [
        1,
        1,
        0,
        1,
    ]


def test_delay_waits_seconds_or_revolutions():
    p = path("FEDRAT/9\nSPINDL/600,RPM\nGOTO/0,0,0\nGOTO/1,0,0\nDELAY/2\nDELAY/5,REV\nGOTO/2,0,0")
    assert p.dwell.tolist() == [0, 2.5, 0]


def test_fini_ends():
    assert len(path("FEDRAT/9\nGOTO/0,0,0\nGOTO/1,0,0\nFINI\nGOFWD")) == 2


@pytest.mark.parametrize(("k", "sweep"), [(-1, math.pi / 2), (1, -1.5 * math.pi)])
def test_circle_turns_clockwise_seen_from_the_tip_of_its_vector(k, sweep):
    p = path(f"FEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,{k},10,0.002,0.5,1,0\nGOTO/0,10,0")
    assert np.hypot(p.tip[:, 0], p.tip[:, 1]) == pytest.approx(0.01, abs=1e-12)
    angle = np.unwrap(np.arctan2(p.tip[:, 1], p.tip[:, 0]))
    assert angle[-1] == pytest.approx(sweep)
    assert 0.01 * (1 - np.cos(np.diff(angle) / 2)).max() <= 0.5e-6
    assert set(p.block[1:]) == {4} and p.feed[1:] == pytest.approx(9 * MM_MIN)


def test_circle_in_any_plane_with_turning_axis_and_helix():
    n = np.array([1, 2, 2]) / 3
    u = np.array([2, 1, -2]) / 3
    start, end = 5 * u, 5 * u + 4 * n
    words = ",".join(f"{x:.9f}" for x in (*np.zeros(3), *n, 5.0))
    p = path(
        "FEDRAT/9\nGOTO/{:.9f},{:.9f},{:.9f},0,0,1\n".format(*start)
        + f"CIRCLE/{words},TIMES,3\n"
        + "GOTO/{:.9f},{:.9f},{:.9f},0,1,0".format(*end)
    )
    radial = p.tip * 1e3 - np.outer(p.tip * 1e3 @ n, n)
    assert np.linalg.norm(radial, axis=1) == pytest.approx(5.0, abs=1e-6)
    turn = np.arctan2(np.cross(radial[:-1], radial[1:]) @ n, (radial[:-1] * radial[1:]).sum(axis=1))
    assert turn.sum() == pytest.approx(-6 * math.pi)
    assert p.axis[len(p) // 2] == pytest.approx([0, 0.5**0.5, 0.5**0.5], abs=2e-3)


START = "FEDRAT/100\nGOTO/0,0,0\n"


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("GOTO/1,2", "has 2 numbers: it takes x, y, z"),
        ("GOTO/1,2,3,0,1", "has 5 numbers"),
        ("GOTO/1,,3", "is empty"),
        ("GOTO/1,nan,3", "is not finite"),
        ("GOTO/1,inf,3", "is not finite"),
        ("GOTO/1,1e300,3", "beyond 1e9"),
        ("GOTO/1,2e8,3", "more than a kilometre"),
        ("GOTO/1,2,3,0,0,0", "the tool axis i, j, k is zero"),
        ("GOTO/1,2,3,0,0,0.9", "has length 0.9, not 1"),
        ("GODLTA/1,2", "has 2 numbers"),
        ("FEDRAT/0", "above zero"),
        ("FEDRAT/-5,MMPM", "above zero"),
        ("FEDRAT/MMPM", "has no number"),
        ("FEDRAT/5,INVERS", "'INVERS' in FEDRAT is not read"),
        ("FEDRAT/0.1,MMPR", "needs the spindle speed"),
        ("DELAY/-1", "not between 0 and a day"),
        ("DELAY/NONE", "takes one number"),
        ("DELAY/5,REV", "needs the spindle speed"),
        ("UNITS/FEET", "use UNITS/MM"),
        ("GOFWD/C1", "GOFWD is not known here and might move something"),
        ("TLLFT,GOFWD/C1", "no statement of the form"),
        ("CYCLE/DRILL,5", "CYCLE is not known here"),
        ("CUTCOM/LEFT", "CUTCOM is not known here"),
        ("ROTATE/TABLE,90", "ROTATE is not known here"),
        ("ORIGIN/1,0,0", "ORIGIN shifts the points"),
        ("INSERT/G0", "INSERT is not known here"),
        ("FROM/1,0,0", "FROM names the start"),
        ("CIRCLE/0,0,0,0,0,1", "it takes centre, direction and radius"),
        ("?", "no statement of the form"),
    ],
)
def test_refuses_with_line_text_and_cure(statement, says):
    with pytest.raises(ProgramError) as caught:
        read_text(START + statement + "\nGOTO/5,5,5,0,0,1\nFINI\n", None, "apt", name="part.apt")
    message = str(caught.value)
    assert says in message and "\n" not in message
    line = 4 if "needs the spindle" in says and "FEDRAT" in statement else 3
    assert message.startswith(f"part.apt:{line}: ")


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("CIRCLE/0,0,0,0,0,1,10\nGOTO/10,0,0", "CIRCLE before any position"),
        ("GODLTA/1,0,0", "GODLTA before any position"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,0,10\nGOTO/0,10,0", "has length 0, not 1"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,9\nGOTO/0,10,0", "says radius 9 mm, but it starts 10 mm"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,11,0", "mm off its circle"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10", "not followed by the GOTO"),
        ("GOTO/10,0,0\nGOTO/0,0,$", "cut off"),
        ("GOTO/10,0,0\nMSYS/0,0,0\nGOTO/1,0,0\nMSYS/1,0,0", "MSYS changes"),
        ("GOTO/10,0,0", "no motion"),
        ("PAINT/PATH", "no motion"),
    ],
)
def test_refuses_what_does_not_fit_together(body, says):
    with pytest.raises(ProgramError, match=says):
        path("FEDRAT/100\n" + body)


def test_feed_missing_names_the_line_and_the_cure():
    with pytest.raises(ProgramError, match=r":2: feed missing.*--feed 3000mm/min"):
        path("GOTO/0,0,0\nGOTO/1,0,0")
    assert path("GOTO/0,0,0\nGOTO/1,0,0", feed="3000mm/min").feed[1] == pytest.approx(0.05)


def test_a_goto_cut_in_the_middle_says_so():
    with pytest.raises(ProgramError, match="cut off"):
        read_text("FEDRAT/1\nGOTO/0,0,0\nGOTO/1,2", None, "apt")
