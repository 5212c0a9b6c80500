"""APT and CLSF: each test is one statement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.toolpath import Operation, ToolPath

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
        ("SPINDL/RPM,2000,FWD\nFEDRAT/0.1,MMPR", 200),
        ("FEDRAT/FPM,1", 304.8),
        ("SPINDL/100,RPM\nFEDRAT/FPR,0.01", 304.8),
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


@pytest.mark.parametrize(("k", "sweep"), [(1, math.pi / 2), (-1, -1.5 * math.pi)])
def test_circle_without_radius_turns_by_the_right_hand_rule(k, sweep):
    """SolidWorks CAM: the radius is that of the start. Fillets of its contours tell the sense."""
    p = path(f"FEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,{k}\nGOTO/0,10,0")
    assert np.hypot(p.tip[:, 0], p.tip[:, 1]) == pytest.approx(0.01, abs=1e-12)
    angle = np.unwrap(np.arctan2(p.tip[:, 1], p.tip[:, 0]))
    assert angle[-1] == pytest.approx(sweep)


def test_what_solidworks_cam_tells_of_tools_and_stock():
    body = (
        "UNIT/MM\nINSERT/[HOLDER=C40-M20EM3] 20MM CRB 2FL 38 LOC\nCSI_SET_FLUTE_LENGTH/38.\n"
        "INSERT/Stock Size X50. Y100. Z60.\nTRNTYP/WORLD,0,0,0\nFEDRAT/9,MMPM\n"
        "GOTO/0,0,0\nCUTCOM/LEFT\nGOTO/1,0,0\nCUTCOM/OFF"
    )
    p = path(body, compensation="program")
    assert p.skipped == {"INSERT": 2, "CSI_SET_FLUTE_LENGTH": 1, "TRNTYP": 1, "CUTCOM": 2}
    with pytest.raises(ProgramError, match=r"CUTCOM is not read: .* give --compensation program"):
        path(body)


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


def test_operations_tools_and_their_stops():
    p = path(
        "TOOL PATH/Rough_1,TOOL,Mill 10\nLOAD/TOOL,2,ADJUST,0\nFEDRAT/MMPM,100\nGOTO/0,0,0,0,1,0\nGOTO/1,0,0\n"
        "END-OF-PATH\nTOOL PATH/Rough_2,TOOL,Mill 10\nGOTO/2,0,0\nEND-OF-PATH\n"
        "TOOL PATH/Drill,TOOL,D8\nFROM/9,0,0\nRAPID\nGOTO/3,0,0\nGOTO/4,0,0"
    )
    assert p.operations == (Operation("Rough_1", "Mill 10"), Operation("Rough_2", "Mill 10"), Operation("Drill", "D8"))
    assert p.operation.tolist() == [0, 0, 1, 2, 2, 2]
    assert p.stop.tolist() == [1, 0, 1, 0, 0, 1]
    assert p.rapid.tolist() == [1, 0, 0, 1, 1, 0]
    assert p.axis[:, 1].tolist() == [1, 1, 0, 0, 0, 0]
    assert "a TOOL PATH that names no tool axis begins with 0,0,1" in p.assumed
    assert "a tool change is a stop; the machine's own motion in it is left out" in p.assumed


@pytest.mark.parametrize("change", ["LOADTL/2", "TOOLNO/2,10.0\nLOADTL/2", "LOAD/TOOL,2,ADJUST,1", "TURRET/2"])
def test_a_tool_change_begins_an_operation_and_is_a_stop(change):
    p = path(f"LOADTL/1\nFEDRAT/100\nGOTO/0,0,0\nGOTO/1,0,0\n{change}\nGOTO/2,0,0\nLOADTL/2\nGOTO/3,0,0")
    assert p.operations == (Operation("", "1"), Operation("", "2"))
    assert p.operation.tolist() == [0, 0, 1, 1] and p.stop.tolist() == [1, 1, 1, 1]
    assert "a tool change is a stop; the machine's own motion in it is left out" in p.assumed


def test_operations_are_named_by_comments_of_catia_and_creo():
    p = path(
        "$$ OPERATION NAME : Tool Change.1\nLOADTL/1\n$$ OPERATION NAME : Pocket.1\nFEDRAT/9\nGOTO/0,0,0\n"
        "GOTO/1,0,0\n$$-> FEATNO / 31\nGOTO/2,0,0"
    )
    assert p.operations == (Operation("Pocket.1", "1"), Operation("FEATNO 31", "1"))


def test_creo_writes_data_in_comments_that_go_on():
    p = path(
        "$$-> MFGNO / PART\nPARTNO / PART\nUNITS / INCHES\n$$-> CUTTER / 10.0\n"
        "$$-> CSYS / 1.0, 0.0, 0.0, 0.0, $\n   0.0, 1.0, 0.0, 0.0, $\n   0.0, 0.0, 1.0, 0.0\n"
        "$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_CENTER\nCUTCOM / LEFT\nFEDRAT / 10.0,  IPM\n"
        "GOTO / 1.0, 0.0, 0.0\nREMARK -> CUTTER / 5\nGOTO / 2.0, $\n 0.0, 0.0\nCUTCOM / OFF\nFINI"
    )
    assert p.tip[:, 0] * 1e3 == pytest.approx([25.4, 50.8])
    assert "CUTCOM offsets nothing: the points are of the tool's centre line" in p.assumed


CATIA_FRAME = "$$*CATIA0\n$$ Part.1\n$$ 1. 0. 0. {}\n$$ 0. 1. 0. 0.\n$$ 0. 0. 1. 0.\n"


@pytest.mark.parametrize(
    "frames",
    [
        ("MSYS/1,2,3,1,0,0,0,1,0", "MSYS/1.0,2.00,3,1,0,0,-0.0,1,0"),
        (CATIA_FRAME.format("0."), CATIA_FRAME.format("0.0")),
        ("$$-> CSYS / 1,0,0,0,0,1,0,0,0,0,1,0", "REMARK -> CSYS / 1,0,0,0,0,1,0,0,0,0,1,0"),
    ],
)
def test_the_same_system_again_says_nothing_and_another_is_refused(frames):
    first, again = frames
    body = "FEDRAT/9\n{}\nGOTO/0,0,0\n{}\nGOTO/1,0,0"
    assert len(path(body.format(first, again))) == 2
    other = again.replace("0.0", "5.5").replace(",0,0,0,1,0,0,", ",7,0,0,1,0,0,").replace("3,1,", "4,1,")
    with pytest.raises(ProgramError, match="it changes the coordinates between points: write one program a system"):
        path(body.format(first, other))


def test_what_shifts_nothing_is_counted():
    p = path("FEDRAT/9\nTRANS/0,0,0\nTRACUT/1,0,0,0,0,1,0,0,0,0,1,0\nORIGIN/0,0,0\nCOPY/NOMORE\nGOTO/0,0,0\nGOTO/1,0,0")
    assert p.skipped == {"TRANS": 1, "TRACUT": 1, "ORIGIN": 1, "COPY": 1}


def test_free_text_holds_anything_and_may_go_on():
    p = path(
        "PPRINT costs 5 $ a piece\nGOTO/0,0,0\nFEDRAT/9\nREMARK a = b, (c) ? $\n more of it\n"
        "INSERT (M30) N10 M8 S500 $\nGOTO/1,0,0\nPARTNO X $$ Y"
    )
    assert p.tip[:, 0] * 1e3 == pytest.approx([0, 1])
    assert p.skipped == {"PPRINT": 1, "REMARK": 1, "INSERT": 1, "PARTNO": 1}


@pytest.mark.parametrize("code", ["G0 X1", "X5.", "M98 P1", "F100", "M198", "R1=5", "G4 P1", "M099"])
def test_insert_that_may_move_is_refused(code):
    with pytest.raises(ProgramError, match="INSERT is not read"):
        path(f"FEDRAT/9\nGOTO/0,0,0\nINSERT/{code}\nGOTO/1,0,0")


def test_sequence_numbers_in_columns_73_to_80_are_no_data():
    lines = ["FEDRAT/9", "GOTO/0,0,0", "GOTO/1,2,$", "3", "GOTO/2,0,0"]
    p = path("\n".join(f"{line:72}{number:08}" for number, line in enumerate(lines, start=10)))
    assert p.tip * 1e3 == pytest.approx(np.array([[0, 0, 0], [1, 2, 3], [2, 0, 0]]))
    assert "columns 73 to 80 are taken for sequence numbers" in p.assumed
    wide = "GOTO/1.0000000000,2.0000000000,3.0000000000,0.0000000000,0.0000000000,1.00000000"
    assert len(wide) == 80 and len(path(f"FEDRAT/9\nGOTO/0,0,0\n{wide}\n{wide[:-8]}")) == 2


@pytest.mark.parametrize(
    ("feed", "unit"), [("FEDRAT/IPM,10", 25.4), ("FEDRAT/MMPM,10", 1.0), ("CYCLE/OFF\nFEDRAT/10", 1.0)]
)
def test_without_units_lengths_are_in_the_unit_of_the_feeds(feed, unit):
    p = path(f"GOTO/0,0,0\n{feed}\nGOTO/1,0,0")
    assert p.tip[1, 0] * 1e3 == pytest.approx(unit)
    assert any(sentence.startswith("without UNITS lengths are taken in") for sentence in p.assumed)


def test_inverse_time_feeds():
    p = path(
        "UNITS/MM\nFEDRAT/100,MMPM,INVERS,AUTO\nGOTO/0,0,0\nGOTO/1,0,0\nFEDRAT/INVERS,OFF\nGOTO/2,0,0\n"
        "FEDRAT/INVERS,30\nGOTO/3,0,0\nCIRCLE/3,1,0,0,0,-1,1,0,0,0,0\nGOTO/3,2,0"
    )
    assert p.feed[1:3] / MM_MIN == pytest.approx([100, 100]) and p.least_time[:3].tolist() == [0, 0, 0]
    assert np.isinf(p.feed[3:]).all() and not p.rapid[3:].any()
    assert p.least_time[3] == pytest.approx(2.0) and p.least_time[4:].sum() == pytest.approx(2.0)
    assert np.ptp(p.least_time[4:]) < 1e-9


def test_gohome_is_a_rapid():
    p = path("FEDRAT/9\nGOTO/0,0,0\nGOTO/1,0,0\nGOHOME/5,0,9\nGOHOME")
    assert p.tip[-1] * 1e3 == pytest.approx([5, 0, 9]) and p.rapid.tolist() == [1, 0, 1]
    assert "GOHOME is taken for a rapid" in p.assumed


def test_tlaxis_holds_and_a_program_of_upright_tools_has_nothing_to_say_of_it():
    p = path(
        "UNITS/MM\nTOOL PATH/A,TOOL,B\nFEDRAT/9,MMPM\nGOTO/0,0,0\nGOTO/1,0,0\nTOOL PATH/C,TOOL,B\nGOTO/2,0,0\n"
        "TLAXIS/0.6,0,0.8\nGOTO/3,0,0"
    )
    assert p.axis == pytest.approx(np.array([[0, 0, 1], [0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]]))
    assert p.assumed == ()


def test_another_tool_ends_a_cycle():
    p = path("UNITS/MM\nLOADTL/1\nFEDRAT/MMPM,9\nCYCLE/DRILL,RAPTO,3,FEDTO,-9\nGOTO/0,0,0\nLOADTL/2\nGOTO/5,0,0")
    assert p.tip[-1] * 1e3 == pytest.approx([5, 0, 0])


@pytest.mark.parametrize(("unit", "length"), [("MM", 1), ("CM", 10), ("INCH", 25.4), ("INCHES", 25.4), ("M", 1000)])
def test_units(unit, length):
    assert path(f"UNITS/{unit}\nFEDRAT/9\nGOTO/0,0,0\nGOTO/1,0,0").tip[1, 0] * 1e3 == pytest.approx(length)


def test_cutcom_off_is_counted_and_one_centre_line_is_of_its_operation():
    assert path("FEDRAT/9\nCUTCOM/OFF\nGOTO/0,0,0\nGOTO/1,0,0").skipped == {"CUTCOM": 1}
    body = "TOOL PATH/A,TOOL,B\n$$ centerline data\nFEDRAT/9\nCUTCOM/LEFT\nGOTO/0,0,0\nGOTO/1,0,0\n"
    assert path(body).skipped == {"CUTCOM": 1}
    with pytest.raises(ProgramError, match="CUTCOM is not read"):
        path(body + "TOOL PATH/C,TOOL,B\nCUTCOM/LEFT\nGOTO/2,0,0")


def test_curves_of_too_many_points_are_refused_before_they_are_laid_out():
    circle = "CIRCLE/900000,0,0,0,0,1,900000,0,0,0,0,TIMES,1000\nGOTO/0,0,0"
    with pytest.raises(ProgramError, match="curves take more than 50000000 points up to here"):
        path("UNITS/MM\nFEDRAT/9\nGOTO/0,0,0\n" + circle)


def test_a_file_that_may_be_cut_off_is_said_to_be_taken_as_whole():
    """The last point of it may have lost digits: what is left is a point."""
    whole = "UNITS/MM\nFEDRAT/MMPM,250\nGOTO/0,0,10\nGOTO/10,0,10.5\n"
    for text in (whole, whole + "FINI", whole + "END-OF-PATH"):
        assert read_text(text, None, "apt").assumed == ()
    (said,) = read_text(whole[:-3], None, "apt").assumed
    assert "FINI" in said and "whole" in said
