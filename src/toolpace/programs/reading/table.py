"""Tables of points: CSV with a header of columns and units."""

from __future__ import annotations

import math
import re

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import FeedMissingError, UsageError
from toolpace.common.units import FEEDS, LENGTHS, TIMES
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.points import FARTHEST, ProgramFacts, ProgramPoints, ToolLengths, assemble
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import Operation, ToolPath

EXAMPLE = "x [mm],y [mm],z [mm],i,j,k,feed [mm/min]"
POINT, AXIS, OPTIONAL = ("x", "y", "z"), ("i", "j", "k"), ("feed", "rapid", "stop", "dwell")
# Nothing that was matched is given back: a cell is read once, however long it is.
_COLUMN = re.compile(r"\s*+\"?+\s*+([A-Za-z]++)\s*+(?:[\[(]([^\])]*+)[\])]\s*+)?+\"?+\s*+")


def read_table(source: Source, lengths: ToolLengths, options: ReadOptions) -> ToolPath:
    """ToolPath of a table whose rows are points; `rapid` and `stop` are 0 or 1, `dwell` a time."""
    rows = [(n, text) for n, text in enumerate(source.lines, start=1) if text.strip() and text.lstrip()[0] != "#"]
    if not rows:
        source.fail("the table has no header: begin it with " + EXAMPLE, 0)
    header_line, header = rows[0]
    delimiter = next((mark for mark in (",", ";", "\t") if mark in header), None if options.columns else ",")
    if options.columns:
        scale = _columns(source, options.columns, header_line, ",", options.units)
        begins_with_header = _is_header(source, header, header_line, delimiter)
    else:
        scale = _columns(source, header, header_line, delimiter or ",", options.units)
        begins_with_header = True
    names = list(scale)
    rows = rows[begins_with_header:]
    if not rows:
        source.fail("the table has a header but no points: there is no motion", header_line)
    line: Ints = np.array([n for n, _ in rows])
    values = _numbers(source, rows, delimiter, len(names))
    column = {name: values[:, k] * scale[name] for k, name in enumerate(names)}
    _refuse(
        source,
        line,
        np.asarray(~np.isfinite(values).all(axis=1)),
        "a number in this row is not finite: correct it",
    )
    n = len(values)
    tip = np.column_stack([column[name] for name in POINT])
    _refuse(
        source,
        line,
        np.abs(tip).max(axis=1) > FARTHEST,
        "this point is more than a kilometre away: check the units",
    )
    axis = np.column_stack([column[name] for name in AXIS]) if "i" in column else np.tile([0.0, 0.0, 1.0], (n, 1))
    dwell = column.get("dwell", np.zeros(n))
    _refuse(source, line, (dwell < 0) | (dwell > 86400), "dwell is not between 0 and a day: correct it")
    rapid = column.get("rapid", np.zeros(n)) != 0
    points = ProgramPoints(
        tip,
        axis,
        feed=_feed(source, line, column.get("feed"), rapid, options.default_feed),
        least_time=np.zeros(n),
        block=line,
        stop=(column.get("stop", np.zeros(n)) != 0) | (dwell > 0),
        dwell=dwell,
        rapid=rapid,
        operation=np.zeros(n, dtype=np.int64),
        tool_length=lengths.along((Operation(),), np.zeros(n, dtype=np.int64), line),
    )
    return assemble(source, points, ProgramFacts.of(lengths.findings, n))


def _is_header(source: Source, row: str, line: int, delimiter: str | None) -> bool:
    """Whether a row, the columns of which are given, holds no number; one that names them itself is refused."""
    cells = row.split(delimiter)
    for cell in cells:
        try:
            float(cell)
        except ValueError:
            continue
        return False
    named = [match[1].lower() for cell in cells if (match := _COLUMN.fullmatch(cell))]
    if len(named) == len(cells) and set(named) <= {*POINT, *AXIS, *OPTIONAL}:
        source.fail("the table's header names its columns: leave --columns out (--units tells units)", line)
    return True


def _columns(source: Source, header: str, line: int, delimiter: str, usual: str) -> dict[str, float]:
    """Columns in order, with the factor from their unit to SI; where they name none, the lengths are in one `given`."""
    usual = usual.strip().lower()
    if usual and usual not in LENGTHS:
        raise UsageError(f"--units '{usual[:20]}' is not known: give one of {', '.join(filter(str.isascii, LENGTHS))}")
    scale: dict[str, float] = {}
    for cell in header.split(delimiter):
        match = _COLUMN.fullmatch(cell)
        name, unit = (match[1].lower(), (match[2] or "").strip().lower()) if match else ("", "")
        if name not in (*POINT, *AXIS, *OPTIONAL):
            source.fail(f"column '{cell.strip()[:20]}' is not known: write a header like {EXAMPLE}", line)
        if name in scale:
            source.fail(f"column {name} stands twice in the header: remove one", line)
        units = LENGTHS if name in POINT else FEEDS if name == "feed" else TIMES if name == "dwell" else None
        if usual and unit and name in POINT and LENGTHS[usual] != LENGTHS.get(unit):
            source.fail(f"column {name} is in {unit[:20]}, and --units says {usual}: leave one of both out", line)
        if not unit and usual:
            unit = usual if name in POINT else "s" if name == "dwell" else f"{usual}/min"
        if units is None:
            scale[name] = 1.0
        elif unit not in units:
            allowed = ", ".join(key for key in units if key.isascii())
            what = f"unit '{unit[:20]}' of column {name} is not known" if unit else f"column {name} names no unit"
            source.fail(f"{what}: write one of {allowed} in brackets, like {EXAMPLE}; or give --units mm", line)
        else:
            scale[name] = units[unit]
    missing = [name for name in POINT if name not in scale]
    if any(name in scale for name in AXIS):
        missing += [name for name in AXIS if name not in scale]
    if missing:
        source.fail(f"column {missing[0]} is missing: write a header like {EXAMPLE}", line)
    return scale


def _numbers(source: Source, rows: list[tuple[int, str]], delimiter: str | None, width: int) -> Floats:
    """All cells as an array; on failure, the first row that is wrong."""
    try:
        values = np.loadtxt([text for _, text in rows], delimiter=delimiter, comments=None, ndmin=2)
        if values.shape[1] == width:
            return values
    except ValueError:
        pass
    for line, text in rows:
        cells = text.split(delimiter)
        if len(cells) != width:
            source.fail(f"this row has {len(cells)} cells, the header {width}: complete it", line)
        for cell in cells:
            try:
                plain = math.isfinite(float(cell)) and cell.isascii() and "_" not in cell
            except ValueError:
                plain = False
            if not plain:
                source.fail(f"'{cell.strip()[:20]}' is no number: write it like -12.5", line)
    source.fail("the rows of this table cannot be read: write plain numbers under its header", rows[0][0])


def _feed(source: Source, line: Ints, feed: Floats | None, rapid: Bools, default: float | None) -> Floats:
    """Feed caps [m/s]; nothing leads to the first row, so its feed may be anything."""
    if feed is None:
        if default is None:
            needs = np.flatnonzero(~rapid[1:])
            if len(needs):
                source.fail(
                    "feed missing: the table has no column feed; add one, or give --feed 3000mm/min (feed= in Python)",
                    int(line[1 + needs[0]]),
                    FeedMissingError,
                )
            default = 1.0
        feed = np.full(len(line), default)
    wrong = (feed <= 0) & ~rapid
    wrong[0] = False
    _refuse(source, line, wrong, "feed must be above zero: correct it, or mark the row in a column rapid")
    return np.where(rapid, np.inf, feed)


def _refuse(source: Source, line: Ints, wrong: Bools, message: str) -> None:
    if wrong.any():
        source.fail(message, int(line[np.flatnonzero(wrong)[0]]))
