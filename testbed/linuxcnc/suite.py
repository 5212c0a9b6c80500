"""A folder of LinuxCNC's programs (its tests, its examples), read by us and by `rs274`, in one table.

    python -m testbed.linuxcnc.suite FOLDER [--list KIND]

Every file `.ngc` below the folder is read by both, with the files beside it that it calls, and with the lengths and
diameters of the one tool table (`.tbl`) that lies there. Its INI files and Python are not looked at: a remapped word is
an unknown one to both. Nothing is kept of the programs.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from pathlib import Path

from testbed.against_rs274 import BOTH, DIFFERENT, OURS, THEIRS, UNTOLD, Verdict, compared
from testbed.linuxcnc.canon import INCH
from testbed.linuxcnc.job import Job

REASONS = (
    ("cutter compensation", r"[Cc]utter|compensat|concave corner|G4[12]"),
    ("time follows the spindle (G33, G76)", r"spindle-synchronised|threading|G33|G76"),
    ("taps outside XY", r"G(?:74|84) outside the plane"),
    ("probing: where it ends is not known", r"probing|G38|probe"),
    ("lathes (G7, G70 to G72)", r"G7[012]? |diameter|G7[012]"),
    ("radii of an arc that differ", r"Radius to end of arc|off its circle"),
    ("an axis that the compared machine has not", r"has no axis|word [UVWB] |letter W|Bad character '[uvwb]'"),
    ("a variable that nothing has set, or HAL", r"#<?[^ ]*>? (?:\(first|is not read)|Named parameter .* not defined"),
    ("a remapped word", r"not known here|might move something|Unknown [gm] code|M-code greater"),
    ("polar words (@, ^)", r"'[@^]'"),
    ("settings of the controller's own variables", r"belongs to the controller"),
    ("stored reference points (G28.1, G30.1)", r"G28\.1|G30\.1"),
    ("a file that is called and is not there", r"not in this file|nor in a file|EOF in file|Failed to find sub"),
    ("a tool or its table that is not at hand", r"[Tt]ool|G10 L1"),
    ("points of a spline", r"Control Points"),
)
"""Why one refuses, by what its message says; the first that fits counts. Where both do, it is rs274's message."""
OTHER = "another error"
NUMBERS = range(1, 100)
"""Tools without length, for programs that come without a table."""
_TOOL = re.compile(r"^\s*T(\d+)\b([^;\n]*)", re.MULTILINE)
_FIGURE = re.compile(r"\b([ZD])([-+]?[0-9.]+)")


def tools(folder: Path) -> dict[int, dict[str, float]]:
    """Length Z and diameter D [mm] by number, of the one tool table in a folder, which is in inches; else zero."""
    tables = sorted(folder.glob("*.tbl"))
    if len(tables) != 1:
        return {number: {} for number in NUMBERS}
    text = tables[0].read_text(encoding="utf-8", errors="replace")
    return {
        int(number): {letter: float(value) * INCH for letter, value in _FIGURE.findall(figures)}
        for number, figures in _TOOL.findall(text)
        if int(number)
    }


def verdict(path: Path) -> Verdict:
    """What came of one program."""
    text = path.read_bytes().decode("utf-8", errors="replace")
    try:
        found = tools(path.parent)
        lengths = {number: figures.get("Z", 0.0) for number, figures in found.items()}
        radii = {number: figures.get("D", 0.0) / 2.0 for number, figures in found.items()}
        return compared(Job(text, tools=lengths, radii=radii, numbered=False, beside=path.parent))
    except RuntimeError as error:
        return Verdict(UNTOLD, f"{type(error).__name__}: {error}")


def reason(said: str) -> str:
    """The kind of a refusal."""
    return next((name for name, pattern in REASONS if re.search(pattern, said)), OTHER)


def table(found: dict[Path, Verdict]) -> str:
    """How many programs there are of each kind, those that are refused by reason (Markdown)."""
    rows: Counter[tuple[str, str]] = Counter()
    of: dict[tuple[str, str], list[str]] = defaultdict(list)
    for path, (kind, said) in found.items():
        row = (kind, reason(said) if kind in (BOTH, OURS, THEIRS) else "")
        rows[row] += 1
        of[row].append(path.name)
    lines = ["| | why | programs | such as |", "|---|---|---|---|"]
    for (kind, why), count in sorted(rows.items(), key=lambda item: (item[0][0], -item[1])):
        lines.append(f"| {kind} | {why} | {count} | {of[kind, why][0]} |")
    return "\n".join(lines)


def main(arguments: Iterable[str]) -> int:
    """Compare a folder, print the table and what differs; end with 1 where something moves elsewhere in silence."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--list", action="append", default=[DIFFERENT], help="kinds of which each program is printed")
    given = parser.parse_args(list(arguments))
    paths = sorted(path for path in given.folder.rglob("*.ngc") if path.is_file())
    found: dict[Path, Verdict] = {}
    for path in paths:
        found[path] = verdict(path)
        if found[path].kind in given.list:
            print(f"{path.relative_to(given.folder)}: {found[path].kind}: {found[path].said[:300]}", flush=True)
    print(table(found))
    return int(any(kind == DIFFERENT for kind, _ in found.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
