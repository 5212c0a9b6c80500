"""Drilling cycles and patterns: TNC 640 manual "Cycle programming", fixed cycles: drilling, tapping, patterns."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import findings, read, tips
from toolpace.common.errors import ProgramError

LEVELS = "Q200=+2 ~\nQ201=-20 ~\nQ206=+150 ~\nQ203=+10 ~\nQ204=+50 ~\n"
"""Clearance 2, surface at 10, depth 20, second clearance 50: from 12 to -10, back at 60."""
ABOVE = "L Z+100 FMAX\n"


def levels(text, **options):
    """Heights [mm] of the ends of all motions in the hole, without the way there."""
    path = read(ABOVE + text, **options)
    return [float(z) for z in np.round(path.tip[:, 2] * 1e3, 6)][2:], path


def cycle(number, rest=""):
    return f"CYCL DEF {number} HOLE ~\n{LEVELS}{rest}\nL X+30 Y+40 FMAX M99"


def test_drilling_pecks_out_of_the_hole():
    """200: FMAX to the clearance; to the first infeed Q202, which counts from the surface; out at FMAX, back to the
    clearance above the last depth; at the depth Q211; out to the second clearance."""
    heights, path = levels(cycle(200, "Q202=+8 ~\nQ210=+0.5 ~\nQ211=+0.25"))
    assert heights == [100, 12, 2, 12, 4, -6, 12, -4, -10, 60]
    assert path.feed[np.isfinite(path.feed)] == pytest.approx(0.0025)
    assert path.dwell[path.dwell > 0].tolist() == [0.5, 0.5, 0.25]
    assert np.allclose(path.tip[3:, :2], (0.03, 0.04))


def test_feeds_of_cycles_as_controls_write_them():
    """iTNC 530, cycles: "Q206: 0 to 99999.999, alternatively FAUTO, FU"; exported programs say AUTO and MAX."""
    hole = LEVELS.replace("Q206=+150", "Q206= AUTO ;FEED")
    text = f"TOOL CALL 2 Z S1000 F120\nCYCL DEF 201 REAMING ~\n{hole}Q208= MAX ;BACK\nL X+1 FMAX M99"
    path = read(ABOVE + text)
    down = int(path.tip[:, 2].argmin())
    assert path.feed[down] * 6e4 == pytest.approx(120) and path.rapid[down + 1]
    with pytest.raises(ProgramError, match=r"Q206 takes the F of TOOL CALL \(FAUTO\), which has none"):
        read(ABOVE + text.replace(" F120", ""))


def test_a_hole_in_one_stroke():
    assert levels(cycle(200, "Q202=+50"))[0] == [100, 12, -10, 60]


def test_reaming_goes_out_at_feed():
    """201: out at Q208; with Q208=0 at the feed of reaming."""
    heights, path = levels(cycle(201, "Q211=+0.5 ~\nQ208=+300"))
    assert heights == [100, 12, -10, 12, 60]
    assert path.feed[-3:] == pytest.approx([0.0025, 0.005, np.inf])
    assert levels(cycle(201, "Q208=+0"))[1].feed[-2] == pytest.approx(0.0025)


def test_boring_stops_the_spindle_below():
    path = levels(cycle(202, "Q208=+0 ~\nQ214=+0"))[1]
    assert path.stop[path.tip[:, 2] < -0.0099].all()
    assert [found.word for found in findings(ABOVE + cycle(202, "Q214=+1")).refusals] == [
        "CYCL DEF 202 with Q214 of 1 to 4"
    ]


def test_universal_drilling_breaks_chips_and_drills_less_each_time():
    """203: each infeed is less by Q212, at least Q205; Q213 chips are broken by Q256 before a way out; Q208 out."""
    rest = "Q202=+8 ~\nQ212=+2 ~\nQ205=+3 ~\nQ213=+1 ~\nQ256=+0.5 ~\nQ208=+0"
    assert levels(cycle(203, rest))[0] == [100, 12, 2, 2.5, -4, 12, -2, -8, -7.5, -10, 12, 60]


def test_deep_drilling():
    """205: out to the clearance, FMAX to Q258 above the last depth."""
    rest = "Q202=+12 ~\nQ212=+0 ~\nQ205=+0 ~\nQ258=+1 ~\nQ259=+1 ~\nQ257=+0"
    assert levels(cycle(205, rest))[0] == [100, 12, -2, 12, -1, -10, 60]


def test_single_lip_drilling_begins_in_the_hole_that_is_there():
    """241 ("Single-lip deep-hole drilling"): at Q253 to a fifth of Q379 above the starting point, at most Q200; to the
    depth at Q206; out at Q208."""
    heights, path = levels(cycle(241, "Q379=+15 ~\nQ253=+600 ~\nQ208=+300 ~\nQ427=+50 ~\nQ429=+7 ~\nQ435=+0"))
    assert heights == [100, 12, -3, -10, 12, 60]
    assert path.feed[-4:] == pytest.approx([0.01, 0.0025, 0.005, np.inf])
    near = cycle(241, "Q379=+5 ~\nQ253=FMAX ~\nQ208=+0")
    heights, path = levels(near)
    assert heights == [100, 12, 6, -10, 12, 60] and path.rapid[-4]
    assert "0.2 * Q379" in " ".join(findings(ABOVE + near).assumptions)
    assert levels(cycle(241, "Q379=+0 ~\nQ208=+300"))[0] == [100, 12, -10, 12, 60]


@pytest.mark.parametrize(("rest", "word"), [("Q202=+5", "Q202"), ("Q435=-8", "Q435")])
def test_strokes_and_stays_of_single_lip_drilling_are_refused(rest, word):
    (refusal,) = findings(ABOVE + cycle(241, rest)).refusals
    assert refusal.word == f"CYCL DEF 241 with {word}" and word in refusal.cure


def test_a_builders_cycle_that_tunes_drives_moves_nothing():
    """Cycles 300 to 399 are the builder's; 392 is DMG's "Application Tuning Control"."""
    found = findings("CYCL DEF 392 ATC ~\nQ240=+0 ;MODE ~\nQ241=+1 ;WEIGHT\nL X+1 F100")
    assert not found.refusals and found.skipped["CYCL DEF 392"] == 1


@pytest.mark.parametrize(
    ("number", "rest", "feed"), [(206, "Q211=+0", 150), (207, "Q239=+1.5", 1500), (209, "Q239=-1 ~\nQ257=+0", 1000)]
)
def test_tapping_reverses_below(number, rest, feed):
    """206: Q206 in and out; 207 and 209: spindle speed times pitch."""
    heights, path = levels(cycle(number, rest))
    assert heights == [100, 12, -10, 12, 60]
    assert path.feed[-3:-1] == pytest.approx([feed / 60e3] * 2) and path.stop[-3]


def test_deep_drilling_breaks_chips_within_its_strokes():
    """205: every Q257 the chip is broken by Q256; every Q202 the tool leaves the hole."""
    rest = "Q202=+12 ~\nQ258=+1 ~\nQ257=+6 ~\nQ256=+0.5"
    assert levels(cycle(205, rest))[0] == [100, 12, 4, 4.5, -2, 12, -1, -8, -7.5, -10, 60]


@pytest.mark.parametrize(("back", "broken"), [("+2", [0, 3, -10, -7]), ("+0", [0, 12, -10, 12])])
def test_tapping_with_chip_breaking(back, broken):
    """209: every Q257 back by Q256 pitches, with zero out of the hole; the spindle reverses each time."""
    heights, path = levels(cycle(209, f"Q239=+1.5 ~\nQ257=+10 ~\nQ256={back}").replace("Q201=-20", "Q201=-25"))
    assert heights == [100, 12, *broken, -15, 12, 60]
    inside = (path.tip[:, 2] < 0.0121) & np.isfinite(path.feed)
    assert path.feed[inside] == pytest.approx(0.025) and path.stop[inside][:-1].all()


def test_centring():
    assert levels(cycle(240, "Q343=+0 ~\nQ344=+0"))[0] == [100, 12, -10, 60]


def test_the_old_pecking_cycle_counts_from_where_the_tool_is():
    """Cycle 1: set-up clearance, depth, peck with signs."""
    text = (
        "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP -2\nCYCL DEF 1.2 DEPTH -20\nCYCL DEF 1.3 PECKG -30\n"
        "CYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F150\nL Z+12 FMAX\nL X+3 FMAX\nCYCL CALL"
    )
    heights, path = levels(text)
    assert heights == [12, 12, -10, 12] and path.feed[-2] == pytest.approx(0.0025)


def test_second_clearance_below_the_first_does_not_count():
    assert levels(cycle(200, "Q202=+50").replace("Q204=+50", "Q204=+1"))[0] == [100, 12, -10, 12]


def test_the_feed_of_the_program_is_in_force_behind_a_hole():
    path = read(ABOVE + "L X+1 F600\n" + cycle(200, "Q202=+50") + "\nL X+50")
    assert path.feed[-1] == pytest.approx(0.01)


def test_cycle_parameters_are_q_parameters_too_and_may_be_written_with_them():
    text = "Q1 = 7\n" + cycle(200, "Q202=+50").replace("Q203=+10", "Q203=+Q1")
    assert levels(text)[0] == [100, 9, -13, 57]
    assert tips(ABOVE + cycle(200, "Q202=+50") + "\nL X+Q203 F100")[-1, 0] == pytest.approx(10)


GENERAL = "GLOBAL DEF 100 GENERAL ~\nQ200=+2 ~\nQ204=+50 ~\nQ253=+750 ~\nQ208=+999\n"
TAKEN = cycle(201, "Q211=+0 ~\nQ208=PREDEF").replace("Q200=+2", "Q200=PREDEF").replace("Q204=+50", "Q204= PREDEF")


def test_values_that_cycles_take_from_global_def():
    """TNC 640 Cycle Programming, "Program defaults for cycles": PREDEF takes the value of GLOBAL DEF."""
    written = cycle(201, "Q211=+0 ~\nQ208=+999")
    (heights, path), (expected, other) = levels(GENERAL + TAKEN), levels(written)
    assert heights == expected and path.feed.tolist() == other.feed.tolist()
    with pytest.raises(ProgramError, match="Q200=PREDEF takes the value of GLOBAL DEF, which tells none"):
        read(ABOVE + TAKEN)
    (late,) = findings(ABOVE + GENERAL + TAKEN + "\n" + GENERAL).refusals
    assert late.word == "GLOBAL DEF behind a cycle with PREDEF"


POLAR = "CYCL DEF 220 POLAR ~\nQ216=+0 ~\nQ217=+0 ~\nQ244=+20 ~\nQ245=+0 ~\nQ246=+360 ~\nQ247=+0 ~\nQ241=+4"
CALLS = {
    "L X+1 Y+2 FMAX M99\nL X+3 Y+4 FMAX M99": [(1, 2), (3, 4)],
    "L X+1 Y+2 FMAX\nCYCL CALL\nL X+3 FMAX": [(1, 2)],
    "L X+1 Y+2 FMAX M89\nL X+3 FMAX\nL Y+4 FMAX M99\nL X+9 FMAX": [(1, 2), (3, 2), (3, 4)],
    "CYCL CALL POS X+1 Y+2 Z+0 FMAX\nCYCL CALL POS X+3 Y+2 Z+0 FMAX": [(1, 2), (3, 2)],
    "PATTERN DEF ~\nPOS1 (X+1 Y+2 Z+0) ~\nPOS2 (X+5 Y-2 Z+0)\nCYCL CALL PAT FMAX": [(1, 2), (5, -2)],
    "PATTERN DEF ROW1 (X+1 Y+2 D+3 NUM3 ROT+90 Z+0)\nCYCL CALL PAT FMAX": [(1, 2), (1, 5), (1, 8)],
    "PATTERN DEF PAT1 (X+0 Y+1 DX+2 DY+3 NUMX3 NUMY2 ROT+0 ROTX+0 ROTY+0 Z+0)\nCYCL CALL PAT FMAX": [
        (0, 1), (2, 1), (4, 1), (4, 4), (2, 4), (0, 4),
    ],
    "PATTERN DEF FRAME1 (X+0 Y+1 DX+2 DY+3 NUMX3 NUMY3 ROT+0 ROTX+0 ROTY+0 Z+0)\nCYCL CALL PAT FMAX": [
        (0, 1), (2, 1), (4, 1), (4, 4), (0, 4), (0, 7), (2, 7), (4, 7),
    ],
    "PATTERN DEF CIRC1 (X+0 Y+0 D+20 START+90 NUM4 Z+0)\nCYCL CALL PAT FMAX": [(0, 10), (-10, 0), (0, -10), (10, 0)],
    "PATTERN DEF PITCHCIRC1 (X+0 Y+0 D+20 START+0 STEP+90 NUM2 Z+0)\nCYCL CALL PAT FMAX": [(10, 0), (0, 10)],
    POLAR: [(10, 0), (0, 10), (-10, 0), (0, -10)],
    "CYCL DEF 220 POLAR ~\nQ216=+0 ~\nQ217=+0 ~\nQ244=+20 ~\nQ245=+0 ~\nQ246=+90 ~\nQ247=+0 ~\nQ241=+2": [
        (10, 0), (0, 10),
    ],
    "CYCL DEF 221 LINES ~\nQ225=+1 ~\nQ226=+2 ~\nQ237=+10 ~\nQ238=+5 ~\nQ242=+2 ~\nQ243=+2 ~\nQ224=+0": [
        (1, 2), (11, 2), (11, 7), (1, 7),
    ],
}  # fmt: skip


@pytest.mark.parametrize("calls", CALLS)
def test_where_a_cycle_is_called(calls):
    points = tips(ABOVE + "CYCL DEF 200 DRILLING ~\n" + LEVELS + "Q202=+50\n" + calls)
    holes = points[np.isclose(points[:, 2], -10)][:, :2]
    assert np.round(holes, 6).tolist() == [list(map(float, place)) for place in CALLS[calls]]


def test_the_height_of_a_call_moves_the_surface():
    """CYCL CALL POS and PATTERN DEF: the coordinate along the tool axis is a shift of the surface."""
    head = ABOVE + "CYCL DEF 200 DRILLING ~\n" + LEVELS + "Q202=+50\n"
    assert tips(head + "CYCL CALL POS X+1 Y+2 Z+5 FMAX")[:, 2].min() == pytest.approx(-5)
    assert tips(head + "PATTERN DEF POS1 (X+1 Y+2 Z-5)\nCYCL CALL PAT FMAX")[:, 2].min() == pytest.approx(-15)


def test_between_holes_at_the_first_clearance_where_q301_says_so():
    """221, Q301: 0 stays at the set-up clearance, 1 rises to the second one."""
    grid = "CYCL DEF 221 LINES ~\nQ225=+1 ~\nQ226=+2 ~\nQ237=+10 ~\nQ238=+5 ~\nQ242=+2 ~\nQ243=+1 ~\nQ224=+0 ~\nQ301={}"
    for choice, top in ((0, 12), (1, 60)):
        points = tips(ABOVE + "CYCL DEF 200 DRILLING ~\n" + LEVELS + "Q202=+50\n" + grid.format(choice))
        assert points[-1, 2] == pytest.approx(top)


def test_between_the_places_of_a_pattern_at_the_height_of_the_call_where_it_is_higher():
    """CYCL CALL PAT: "depending on which is greater", the height at the call or the second clearance; 60 here."""
    for height, between in ((100, 100), (30, 60)):
        head = f"L Z+{height} FMAX\nCYCL DEF 200 DRILLING ~\n{LEVELS}Q202=+50\n"
        for feed in ("FMAX", "F500"):
            points = tips(f"{head}PATTERN DEF POS1 (X+10 Y+0 Z+0) POS2 (X+20 Y+0 Z+0)\nCYCL CALL PAT {feed}")
            aside = np.flatnonzero(np.diff(points[:, 0]) > 5.0)
            assert points[aside[-1], 2] == pytest.approx(between) and points[-1, 2] == pytest.approx(60)


def test_the_feed_of_a_call_holds_for_its_way_only():
    """CYCL CALL POS: "applies only for traverse to the start position programmed in this block"."""
    head = f"L Z+100 F300\nCYCL DEF 200 DRILLING ~\n{LEVELS}Q202=+50\n"
    path = read(f"{head}CYCL CALL POS X+30 Y+0 Z+0 F500\nL Y+50")
    aside = np.flatnonzero(np.diff(path.tip[:, 0]) > 0.02)[0] + 1
    assert path.feed[[aside, -1]] * 6e4 == pytest.approx([500, 300])


@pytest.mark.parametrize("feed", ["FMAX", "F500"])
def test_a_call_from_below_goes_up_before_it_goes_aside(feed):
    """CYCL CALL POS: from below the surface along the tool axis first, then in the plane."""
    head = f"L Z-50 FMAX\nCYCL DEF 200 DRILLING ~\n{LEVELS}Q202=+50\n"
    points = tips(f"{head}CYCL CALL POS X+30 Y+0 Z+5 {feed}")
    assert points[(points[:, 0] > 0.0) & (points[:, 0] < 30.0)].size == 0
    assert points[np.flatnonzero(points[:, 0] > 0.0)[0] - 1].tolist() == pytest.approx([0, 0, 17])


def test_the_tool_axis_is_the_axis_of_holes():
    points = tips("TOOL CALL 2 X S100\nL X+100 FMAX\n" + cycle(200, "Q202=+50").replace("L X+30", "L Z+30"))
    assert points[:, 0].min() == pytest.approx(-10) and np.allclose(points[-1], (60, 40, 30))


def test_holes_in_a_tilted_plane():
    points = tips("PLANE SPATIAL SPA+90 SPB+0 SPC+0 STAY\nL X+0 Y+0 Z+100 F100\n" + cycle(200, "Q202=+50"))
    assert np.allclose(points[-1], (30, -60, 40), atol=1e-9) and points[:, 1].max() == pytest.approx(10)


def test_a_cycle_of_depth_zero_is_not_executed():
    assert levels(cycle(200, "Q202=+50").replace("Q201=-20", "Q201=+0"))[0] == [100]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("CYCL DEF 251 POCKET ~\nQ200=+2\nL X+1 F100 M99\nCYCL CALL", ["CYCL DEF 251"]),
        ("CYCL DEF 208 BORE MILLING ~\nQ200=+2\nL X+1 F100 M99", ["CYCL DEF 208"]),
        (cycle(205, "Q202=+12 ~\nQ257=+5"), ["CYCL DEF 205 with Q257 that does not divide Q202"]),
        (f"CYCL DEF 200 DRILLING ~\n{LEVELS}Q202=+50\n{POLAR} ~\nQ365=+1", ["CYCL DEF 220 with Q365=1"]),
        (cycle(240, "Q343=+1"), ["CYCL DEF 240 with Q343=1"]),
        (cycle(200, "Q202=+5 ~\nQ395=+1"), ["CYCL DEF 200 with Q395=1"]),
        (cycle(200, "Q202=+5").replace("Q201=-20", "Q201=+20"), ["CYCL DEF 200 with Q201 above zero"]),
    ],
)
def test_what_is_refused(text, words):
    assert [found.word for found in findings(ABOVE + text).refusals] == words


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CYCL CALL", "no cycle is defined"),
        (cycle(200, "Q202=+5").replace("Q200=+2", "Q200=-2"), "Q200 of CYCL DEF 200 is -2, and its least is zero"),
        ("TOOL CALL 1 Z S9\n" + cycle(207, "Q239=+0"), "Q239 of CYCL DEF 207, the pitch, is zero"),
        (cycle(200, "Q202=-5"), "Q202 of CYCL DEF 200 is -5"),
        (cycle(203, "Q202=+5 ~\nQ208=0 ~\nQ256=-1 ~\nQ213=1"), "Q256 of CYCL DEF 203 is -1"),
        ("CYCL DEF 200 DRILLING ~\nQ200=+2\nCYCL CALL", "lacks Q202"),
        (cycle(200, "Q202=+5").replace("Q206=+150", "Q206=+0"), "Q206 of CYCL DEF 200 is a feed"),
        (cycle(200, "Q202=+0.0001"), "strokes"),
        ("CYCL CALL PAT", "no pattern is defined"),
        ("PATTERN DEF\nCYCL CALL PAT", "PATTERN DEF has no"),
        ("CYCL DEF HOLE", "needs the number"),
        ("CYCL DEF 200 DRILLING ~\nQ200=+2 ~\nL X+1 FMAX M99", "a ~ stand in front"),
    ],
)
def test_faults(text, message):
    with pytest.raises(ProgramError, match=message):
        read(ABOVE + text)
