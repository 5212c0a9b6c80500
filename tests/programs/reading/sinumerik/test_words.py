"""Which words are passed over, which are refused, and how programs are recognised."""

from __future__ import annotations

import re

import msgspec
import pytest

from tests.support.sinumerik import SINUMERIK, START, last, read
from toolpace.common.errors import ProgramError, UsageError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp

HARMLESS = """STOPRE
WORKPIECE(,,,"BOX",0,1,-25,-80,0,0,150,100)
GROUP_BEGIN(0,"ROUGH",0,0)
SETMS
FFWON
SOFT
DYNFINISH
COMPCAD
CTOL=0.01
OTOL=0.5
G601
FNORM
G62
G25 X0 Y0 Z0
WALIMON
CFC
G642
G641 ADIS=0.5
M7
M8
M81
S2=500
M3=5
SPOS=0
EXTERN PART(REAL)
TOROTOF
UPATH
H5
"""


def test_harmless_words_are_counted():
    """What moves nothing is passed over and counted: texts, dynamics, exact stop windows, coolant."""
    path = read(HARMLESS + "G1 X5")
    assert path.tip[-1].tolist() == [0.005, 0, 0]
    words = ("STOPRE", "FFWON", "COMPCAD", "CTOL", "G601", "G25", "G642", "M81", "SPOS", "H", "EXTERN")
    assert all(path.skipped[word] == 1 for word in words), path.skipped
    assert any("M81 is a word of the machine's builder" in sentence for sentence in path.assumed)


REFUSED = (
    "TRANSMIT", "TRACYL(20)", "TCARR=1", "CUT3DC", "TRAANG", "G147 X1", "POLY PO[X]=(5,1,2)",
    "ASPLINE X5", "FLIN", "POS[X]=5", "POSA[B]=5", "WHEN $AA_IM[X]>5 DO M8", "MEAS=1 X5", "CYCLE961()",
    "G291", "DIAMON", "A6=1 X1", "ORICURVE", "ORICONTO", "GEOAX(1,X1)", "NOSUCHCYCLE(5)", "NOSUCHWORD",
    "CHR=5 X1", "LEAD=3 X1", 'EXTCALL "FAR"', "$P_IFRAME=CTRANS(X,5)", "TOFRAMEY", "G33 Z-5 K2",
    "ORIPATHS", "TOFFON(Z,25)", 'TCA("MILL")', "G961 S100",
    "SETAL(65000)",
)  # fmt: skip


def test_all_refused_words_are_named_in_one_run():
    """Each with its first line, how often it stands and its cure; nothing stops the reading before the end."""
    with pytest.raises(ProgramError) as caught:
        read("\n".join((*REFUSED, "DIAMON", "G1 X5")))
    said = str(caught.value)
    count = re.match(r"part\.mpf: (\d+) kinds of words are not read: ", said)
    assert count and int(count[1]) >= len(REFUSED), said
    for line, word in enumerate(REFUSED, start=3):
        assert f"(first line {line}" in said, word
    assert "DIAMON (first line 18, 2 times): diameters belong to turning" in said


@pytest.mark.parametrize("text", [*REFUSED, "ID=1 EVERY $A_IN[1]==1 DO M5", "WHENEVER $R1==2 DO $R2=1"])
def test_each_refused_word_stands_alone(text):
    with pytest.raises(ProgramError, match="not read"):
        read(text + "\nG1 X5")


def test_what_is_skipped_is_said():
    path = read("FLIN G1 X5\nDIAMON\nNOSUCHWORD\nX6", skip_unknown=True)
    assert path.tip[-1, 0] == 0.006
    assert [sentence for sentence in path.assumed if sentence.startswith("skipped")] == [
        "skipped FLIN (first line 3, 1 time)",
        "skipped DIAMON (first line 4, 1 time)",
        "skipped NOSUCHWORD (first line 5, 1 time)",
    ]


def test_a_controllers_file_changes_what_words_mean():
    own = msgspec.structs.replace(
        SINUMERIK,
        meanings=dict(SINUMERIK.meanings) | {"M46": "tool change", "HOME5": "stop"},
        ignored=(*SINUMERIK.ignored, "PROBE_ON"),
        refused=dict(SINUMERIK.refused) | {"M99": "it unclamps the part: remove it"},
    )
    path = read("T7 M46\nPROBE_ON\nG1 X1\nHOME5\nX2", controller=own)
    assert path.operations[-1].tool == "7" and path.stop.all()
    with pytest.raises(UsageError, match="M46 = 'change' is no meaning"):
        read("G1 X1", controller=msgspec.structs.replace(own, meanings={"M46": "change"}))
    with pytest.raises(UsageError, match="base_unit = 'yard': use one of 'program', 'mm', 'inch'"):
        Controller.from_toml('name = "own"\nlike = "sinumerik"\n[options]\nbase_unit = "yard"\n')


def test_words_of_other_controls_have_their_cure():
    with pytest.raises(ProgramError, match=r"G20 is not read: .* write G70 or G700"):
        read("G20\nG1 X1")
    with pytest.raises(ProgramError, match="brackets hold what TRAORI is given, comments begin with ;"):
        read("TRAORI (FIVE 5-AXES)\nG1 X1")


def test_a_header_whose_name_has_a_point():
    text = "%_N_part.MPF_MPF\nG0 X0 Y0 Z0\nG1 X5 F100\nM30\n"
    assert read_text(text, None, controller="sinumerik").tip[-1].tolist() == [0.005, 0, 0]


def test_base_unit_of_the_control():
    inch = msgspec.structs.replace(SINUMERIK, options={"base_unit": "mm"})
    path = read("G70 G1 X1 F60", controller=inch)
    assert path.feed[-1] == pytest.approx(0.001)


def test_variables_of_the_set_up_sheet():
    assert last("G1 X=HEIGHT Y=R5", setup=SetUp(variables={"HEIGHT": 7.0, "R5": 3.0})) == [7, 3, 0]


def test_a_program_that_is_cut_off_is_told():
    from toolpace.programs.reading.findings import Findings
    from toolpace.programs.reading.options import ReadOptions
    from toolpace.programs.reading.sinumerik.reader import SinumerikReader
    from toolpace.programs.reading.source import Source

    def run(text: str):
        source = Source.from_text(text, "part.mpf")
        return SinumerikReader(source, None, SINUMERIK, ReadOptions(), Findings()).executed().toolpath()

    with pytest.raises(ProgramError, match="cut off"):
        run(START + "G1 X5")
    assert len(run(START + "G1 X5\n").tip) == 2 and len(run(START + "G1 X5\nM30").tip) == 2


RECOGNISED = (
    "DEF REAL DEPTH", "N10 TRAORI", "SUPA G0 Z0 D0", "MCALL CYCLE81(1,2,3)", 'MSG("A")', "%_N_PART_MPF",
    "X5 CR=10", "X=IC(5)", "GOTOF END", "R1=5", "TRANS X10", "N5 ROT", "G642", "G2 X5 I=AC(3)",
    "CYCLE832(0.01,1)", "$P_UIFR[1]=CTRANS()",
)  # fmt: skip
FOREIGN = (
    "G54 X10 Y20", "G43.4 H1", "#100=5", "L X+10 R0 FMAX", "O1234", "GOTO/1,2,3", "(R1=5)", "G1 X10 F100",
    "M98 P100", "WHILE [#1 LT 5] DO1", "Q1 = 5", "G68.2 X0 Y0 Z0 I10 J20 K30", "T1 M6", "G02 X1 Y2 R5",
)  # fmt: skip


def weight(line: str) -> float:
    return sum(sign.weight for sign in SINUMERIK.signs if re.search(sign.pattern, line.upper()))


@pytest.mark.parametrize("line", RECOGNISED)
def test_signs_of_sinumerik(line):
    assert weight(line) >= 1.0


@pytest.mark.parametrize("line", FOREIGN)
def test_other_languages_have_no_sign_of_it(line):
    assert weight(re.sub(r"\(.*?\)", "", line)) == 0.0


def test_the_radius_of_rotary_axes_for_f_is_said_to_be_passed_over():
    assert any("FGREF is passed over" in said for said in read("FGREF[C]=10\nG1 X5", "xyzac-trunnion").assumed)
    assert not any("FGREF" in said for said in read("G1 X5", "xyzac-trunnion").assumed)
