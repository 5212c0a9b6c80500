from __future__ import annotations

import numpy as np
import pytest

from toolpace.common.errors import ProgramError, ToolpaceError, UsageError
from toolpace.programs.reading import read_text

HEADER = "x [mm],y [mm],z [mm],i,j,k,feed [mm/min]\n"
MM_MIN = 1e-3 / 60


def table(text: str, **options):
    return read_text(text, None, "csv", **options)


def test_points_axes_and_feeds_in_the_units_of_the_header():
    p = table("# a comment\n" + HEADER + "1,2,3,0,0,1,0\n\n4,5,6,0,0.6,0.8,300\n")
    assert p.tip.tolist() == [[1e-3, 2e-3, 3e-3], [4e-3, 5e-3, 6e-3]]
    assert p.axis == pytest.approx(np.array([[0, 0, 1], [0, 0.6, 0.8]]))
    assert p.feed[1] / MM_MIN == pytest.approx(300) and p.block.tolist() == [3, 5]


@pytest.mark.parametrize(
    ("header", "row", "x", "feed"),
    [
        ("x [m],y [m],z [m],feed [m/min]", "1,0,0,3", 1.0, 0.05),
        ("X (in); Y (in); Z (in); feed (in/min)", "1;0;0;60", 0.0254, 0.0254),
        ("feed [mm/s]\tx [mm]\ty [mm]\tz [mm]", "50\t1\t0\t0", 1e-3, 0.05),
    ],
)
def test_units_order_and_delimiters(header, row, x, feed):
    mark = next(m for m in ",;\t" if m in row)
    p = table(f"{header}\n{mark.join('0' * 4)}\n{row}\n")
    assert p.tip[1, 0] == pytest.approx(x) and p.feed[1] == pytest.approx(feed)
    assert p.axis.tolist() == [[0, 0, 1]] * 2


@pytest.mark.parametrize(
    ("text", "columns", "units", "tip", "feed"),
    [
        ("0,0,0\n1,2,3\n", "x,y,z", "mm", [1e-3, 2e-3, 3e-3], None),
        ("0;0;0;0;0;1\n1;2;3;0;0.6;0.8\n", "x,y,z,i,j,k", "in", [0.0254, 0.0508, 0.0762], None),
        ("0 0 0  60\n 1\t2 3 60\n", "z,y,x,feed", "in", [0.0762, 0.0508, 0.0254], 0.0254),
        ("P_x,P_y,P_z,v\n0,0,0,600\n1,2,3,600\n", "x,y,z,feed", "mm", [1e-3, 2e-3, 3e-3], 0.01),
        ("x,y,z,feed\n0,0,0,6\n1,2,3,6\n", "", "m", [1.0, 2.0, 3.0], 0.1),
        ("x [mm],y,z,feed [mm/s]\n0,0,0,6\n1,2,3,6\n", "", "mm", [1e-3, 2e-3, 3e-3], 6e-3),
        ("0,0,0,6\n1,2,3,6\n", "x [mm],y [mm],z [mm],feed [mm/s]", "", [1e-3, 2e-3, 3e-3], 6e-3),
    ],
)
def test_columns_and_units_that_no_header_tells(text, columns, units, tip, feed):
    p = read_text(text, None, feed="3000mm/min" if feed is None else None, columns=columns, units=units)
    assert p.tip[1] == pytest.approx(tip) and len(p.tip) == 2
    assert p.feed[1] == pytest.approx(0.05 if feed is None else feed)


@pytest.mark.parametrize(
    ("text", "columns", "units", "says"),
    [
        ("1,2,3\n4,5,6\n", "x,y,z", "", "column x names no unit: .*give --units mm"),
        ("1,2,3\n4,5,6\n", "x,y", "mm", "column z is missing"),
        ("1,2,3\n4,5,6\n", "x,y,z,feed", "mm", "this row has 3 cells, the header 4"),
        ("1,2,3\n4,5,6\n", "x,y,z", "furlong", "--units 'furlong' is not known: give one of um, mm"),
        ("x [in],z [in],y [in]\n1,2,3\n4,5,6\n", "x,y,z", "mm", "names its columns: leave --columns out"),
        ("x [in],y [in],z [in]\n1,2,3\n4,5,6\n", "", "mm", "column x is in in, and --units says mm"),
        ("1,2,3,4\n4,5,6,4\n", "x,y,z,feed", "um", "unit 'um/min' of column feed is not known"),
    ],
)
def test_what_columns_and_units_leave_open_is_asked(text, columns, units, says):
    with pytest.raises(ToolpaceError, match=says):
        table(text, columns=columns, units=units, feed="3000mm/min")


@pytest.mark.parametrize("options", [{"columns": "x,y,z"}, {"units": "mm"}])
def test_columns_and_units_are_of_tables_alone(options):
    with pytest.raises(UsageError, match="is of a table"):
        read_text("G21 G90\nG1 X1 F100\nX2\nM2\n", None, "gcode", **options)
    with pytest.raises(UsageError, match="is for fanuc: leave it out"):
        read_text("1,2,3\n4,5,6\n", None, "csv", controller="fanuc", **options)


def test_rapid_stop_and_dwell_columns():
    p = table(
        "x [mm],y [mm],z [mm],feed [mm/s],rapid,stop,dwell [s]\n"
        "0,0,0,0,0,0,0\n1,0,0,5,0,1,0\n2,0,0,0,1,0,0\n3,0,0,5,0,0,0.5\n4,0,0,5,0,0,0\n"
    )
    assert p.stop.tolist() == [1, 1, 0, 1, 1] and p.dwell.tolist() == [0, 0, 0, 0.5, 0]
    assert np.isinf(p.feed[2])


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("1,2,3\n4,5,6\n", 1, "column '1' is not known: write a header like x \\[mm\\]"),
        ("x,y,z,feed [mm/min]\n0,0,0,1\n", 1, "column x names no unit"),
        ("x [mm],y [mm],z [furlong]\n", 1, "unit 'furlong' of column z is not known"),
        ("x [mm],y [mm]\n0,0\n", 1, "column z is missing"),
        ("x [mm],y [mm],z [mm],i\n0,0,0,1\n", 1, "column j is missing"),
        ("x [mm],x [mm],y [mm],z [mm]\n", 1, "column x stands twice"),
        (HEADER, 1, "no points"),
        (HEADER + "0,0,0,0,0,1,9\n1,0,0,0,0,1\n", 3, "has 6 cells, the header 7"),
        (HEADER + "0,0,0,0,0,1,9\n1,0,0,0,0,1,fast\n", 3, "'fast' is no number"),
        (HEADER + "0,0,0,0,0,1,9\n1,nan,0,0,0,1,9\n", 3, "not finite"),
        (HEADER + "0,0,0,0,0,1,9\n1,0,0,0,0,1,0\n", 3, "feed must be above zero"),
        (HEADER + "0,0,0,0,0,1,9\n1,0,0,0,0,0,9\n", 3, "tool axis i, j, k is zero"),
        (HEADER + "0,0,0,0,0,1,9\n1e9,0,0,0,0,1,9\n", 3, "more than a kilometre"),
        ("x [mm],y [mm],z [mm]\n0,0,0\n1,0,0\n", 3, "feed missing.*--feed"),
    ],
)
def test_refuses_with_line_and_cure(text, line, says):
    with pytest.raises(ProgramError, match=f"^program:{line}: .*{says}") as caught:
        table(text)
    assert "\n" not in str(caught.value)


def test_a_row_cut_off_says_so():
    with pytest.raises(ProgramError, match="cut off"):
        table(HEADER + "0,0,0,0,0,1,9\n1,0")


def test_feed_option_stands_in_for_the_column():
    assert table("x [mm],y [mm],z [mm]\n0,0,0\n1,0,0\n", feed="50mm/s").feed[1] == pytest.approx(0.05)
