"""What reading promises, each held by a case that a small change of code would break (docs/notebook/mutation.md)."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError, UsageError
from toolpace.programs.reading import apply_feed, feeds, read_text
from toolpace.programs.reading.points import AXIS_ROUNDING

START = "G21 G90 G94\nG0 X0 Y0 Z0\n"


def gcode(body, **given):
    return read_text(START + body + "M30\n", None, "gcode", **given)


@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("G1 X10 F600\nG93 G1 X20 F10\nG94 G1 X30\n", 5),
        ("G1 X10 F600\nG93 G1 X20\n", 4),
        ("G93 G1 X10 F10\nX20\n", 4),
        ("G93 G1 X10 F10\nG94 X20\n", 4),
        ("G1 X10 F600\nG93\nG94\nG1 X20\n", 6),
    ],
)
def test_f_of_one_feed_mode_says_nothing_in_the_other(body, line):
    with pytest.raises(ProgramError, match=f":{line}: feed missing"):
        gcode(body)


def test_the_feed_mode_that_is_in_force_keeps_its_f():
    p = gcode("G1 X10 F600\nG94 X20\nG93 X30 F10\nG94 X40 F300\nG94 X50\n")
    assert p.feed[1:] * 6e4 == pytest.approx([600, 600, np.inf, 300, 300])
    assert p.least_time[1:] == pytest.approx([0, 0, 6, 0, 0])


def test_f_is_taken_in_the_units_in_force_and_of_its_own_block():
    p = gcode("G1 X10 F600\nX20 F300\nX30\nG20\nX2\nX3 F10\n")
    assert p.feed[1:] * 6e4 == pytest.approx([600, 300, 300, 300, 254])
    assert p.tip[:, 0] * 1e3 == pytest.approx([0, 10, 20, 30, 50.8, 76.2])


def test_dwells_at_one_place_add_up():
    p = gcode("G1 X10 F600\nG4 P1\nG4 P2\nG1 X10\nG4 P4\nG1 X20\nG4 P0.5\nG1 X20 Y0\nG4 P0.25\nG1 X30\n")
    assert p.dwell.tolist() == [0, 7, 0.75, 0] and p.stop.tolist() == [True, True, True, True]
    cl = "FEDRAT/100\nGOTO/0,0,0\nGOTO/1,0,0\nDELAY/1\nDELAY/2\nGOTO/1,0,0\nDELAY/4\nGOTO/2,0,0\n"
    q = read_text(cl, None, "apt")
    assert q.dwell.tolist() == [0, 7, 0]
    rows = "0,0,0,100,0\n1,0,0,100,1\n1,0,0,100,2\n2,0,0,100,0\n"
    table = read_text("x [mm],y [mm],z [mm],feed [mm/min],dwell [s]\n" + rows, None, "csv")
    assert table.dwell.tolist() == [0, 3, 0] and table.stop.tolist() == [True, True, True]


def test_a_stop_of_a_point_that_is_dropped_moves_onto_the_one_that_stays():
    p = gcode("G1 X10 F600\nG9 G1 X10\nG1 X20\nG1 X30\n")
    assert p.stop.tolist() == [True, True, False, True]


def test_points_a_picometre_apart_are_one_and_two_picometres_are_two():
    def points(gap):
        return len(read_text(f"x [m],y [m],z [m],feed [m/s]\n0,0,0,1\n{gap},0,0,1\n1,0,0,1\n", None, "csv"))

    assert points(0.9e-12) == 2 and points(1.1e-12) == 3


@pytest.mark.parametrize(("length", "fine"), [(0.979, False), (0.981, True), (1.019, True), (1.021, False)])
def test_a_tool_axis_is_a_unit_vector_within_two_percent(length, fine):
    assert AXIS_ROUNDING == 0.02
    text = f"FEDRAT/100\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,{length}\n"
    if fine:
        assert read_text(text, None, "apt").axis[1].tolist() == [0, 0, 1]
        return
    with pytest.raises(ProgramError, match=":3: the tool axis i, j, k has length"):
        read_text(text, None, "apt")


def test_feeds_are_bounded_below_and_above_wherever_they_come_from():
    slow, fast = feeds.SLOWEST * 6e4, feeds.FASTEST * 6e4
    assert (slow, fast) == pytest.approx((1e-6, 1e9))
    for change in (f"{1.01 * slow}mm/min", f"{0.99 * fast}mm/min"):
        assert feeds.FeedChange.parse(change).speed is not None
    for change in (f"{0.99 * slow}mm/min", f"{1.01 * fast}mm/min", "0.000099%", "101000000%"):
        with pytest.raises(UsageError, match=r"correct it|between"):
            feeds.FeedChange.parse(change)
    assert [feeds.FeedChange.parse(text).factor for text in ("0.0001%", "100000000%")] == pytest.approx([1e-6, 1e6])
    for text, dialect in (
        (START + "G1 X10 F0.0000009\nM30\n", "gcode"), ("FEDRAT/9E-7\nGOTO/0,0,0\nGOTO/1,0,0\n", "apt"),
        ("x [mm],y [mm],z [mm],feed [mm/min]\n0,0,0,1\n1,0,0,9e-7\n", "csv"),
    ):  # fmt: skip
        with pytest.raises(ProgramError, match=r":3: feed 9e-07 mm/min is below 1e-06 mm/min"):
            read_text(text, None, dialect)
    with pytest.raises(UsageError, match=r"with --feed 0\.01%: feed 5e-07"):
        apply_feed(gcode("G1 X10 F0.005\n"), "0.01%")
    with pytest.raises(ProgramError, match=r":3: this block takes .* more than a year"):
        gcode("G93 G1 X10 F0.0000018\n")
    assert gcode("G93 G1 X10 F0.00000191\n").least_time[1] < feeds.LONGEST


def test_a_feed_value_leaves_rotations_in_place_and_rapids_as_they_are():
    body = "M428\nG0 X0 Y0 Z0 A0\nG1 X10 F600\nA30 F60\nG0 X20\nG93 G1 X30 F10\nM2\n"
    before = read_text(body, MACHINE, "gcode")
    after = apply_feed(before, "1200mm/min")
    for block, feed, time in ((3, 0.02, 0.0), (4, np.inf, 30.0), (5, np.inf, 0.0), (6, 0.02, 0.0)):
        of = after.block == block
        assert after.feed[of] == pytest.approx(feed) and after.least_time[of].sum() == pytest.approx(time)
    doubled = apply_feed(before, "200%")
    assert doubled.feed == pytest.approx(2.0 * before.feed)
    assert doubled.least_time == pytest.approx(0.5 * before.least_time)


def test_the_path_starts_where_every_axis_has_been_positioned():
    """Rapids that position one axis after the other are no motion of the path, whichever of them comes last."""
    for order in ("XYZ", "ZYX", "YZX", "YXZ"):
        rapids = "".join(f"G0 {letter}5\n" for letter in order)
        p = read_text(f"{rapids}G1 X10 F600\nM30\n", None, "gcode")
        assert (p.tip * 1e3).tolist() == [[5, 5, 5], [10, 5, 5]] and p.block.tolist() == [3, 4]


def test_a_feed_value_replaces_inverse_times_however_short():
    p = apply_feed(gcode("G93 G1 X10 F600\nX20 F6000000\n"), "1200mm/min")
    assert p.feed[1:] == pytest.approx(0.02) and not p.least_time.any()
