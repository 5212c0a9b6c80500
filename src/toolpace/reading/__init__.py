"""Programs in, ToolPath out: G-code, cutter-location data (APT, CLSF) and tables of points."""

from __future__ import annotations

from pathlib import Path

from toolpace.errors import UsageError
from toolpace.reading.cldata.reader import ClReader
from toolpace.reading.control.kinematics import Kinematics
from toolpace.reading.controllers.recognise import recognise
from toolpace.reading.dialect import dialect_of
from toolpace.reading.feeds import FeedChange, apply_feed
from toolpace.reading.findings import Findings
from toolpace.reading.gcode.reader import WordAddressReader
from toolpace.reading.options import ReadOptions
from toolpace.reading.source import Source
from toolpace.reading.table import read_table
from toolpace.toolpath import ToolPath

__all__ = ["Kinematics", "Source", "apply_feed", "read", "read_source", "read_text"]


def read(
    path: str | Path,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    *,
    feed: str | None = None,
    block_delete: bool = True,
) -> ToolPath:
    """Read a program.

    path: a file, a pipe, or `-` for standard input; it is read once, from its beginning to its end.
    machine: needed by G-code with rotary words. Outside tool-centre-point mode axis words are joint positions;
        without a machine they are the tip, under the tool axis +z.
    dialect: `gcode`, `apt` or `csv`; None tells it by the file's name and content.
    feed: `none`, a factor such as `120%`, or a value such as `3000mm/min` in place of the program's feeds.
    block_delete: whether G-code blocks that begin with `/` are passed over.

    The path starts where the program first has every axis positioned: where the machine stands before is
    unknown. Rotary joints that are not named by then are at zero. Raises ProgramError with file, line, text and cure.
    """
    return read_source(Source.load(path), machine, dialect, feed=feed, block_delete=block_delete)


def read_text(
    text: str,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    *,
    feed: str | None = None,
    block_delete: bool = True,
    name: str = "program",
) -> ToolPath:
    """Read a program from its text; as `read`, with `name` in messages."""
    return read_source(Source.from_text(text, name), machine, dialect, feed=feed, block_delete=block_delete)


def read_source(
    source: Source,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    *,
    feed: str | None = None,
    block_delete: bool = True,
) -> ToolPath:
    """Read a program that was loaded before: its bytes can be kept as they were read; as `read`."""
    change = None if feed is None else FeedChange.parse(feed)
    default_feed = None if change is None else change.speed
    found = dialect_of(source, dialect)
    if found == "gcode":
        controller, _ = recognise(source)
        options = ReadOptions(block_delete=block_delete, default_feed=default_feed)
        toolpath = WordAddressReader(source, machine, controller, options, Findings()).run()
    elif found == "cldata":
        toolpath = ClReader(source, default_feed=default_feed).run()
    elif found == "csv":
        toolpath = read_table(source, default_feed=default_feed)
    else:
        raise UsageError(f"dialect '{found}' is not known: use gcode, apt or csv")
    return toolpath if change is None else change.apply(toolpath)
