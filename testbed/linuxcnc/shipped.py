"""Read every INI in a folder of LinuxCNC configurations, and tell by a table what came of each.

    python -m testbed.linuxcnc.shipped FOLDER > table.md

FOLDER is `configs` of LinuxCNC's repository, or /usr/share/doc/linuxcnc/examples/sample-configs. Machines of four and
five axes have a row each, those of three a row for each folder; refused files stand together by their reason.
"""

from __future__ import annotations

import argparse
import re
import warnings
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from toolpace.common.errors import ToolpaceError
from toolpace.machine.from_control import MachineDraft, read_control

INSTALLED = Path("/usr/share/doc/linuxcnc/examples/sample-configs")
"""Where Debian has them."""
_PLACE = re.compile(r"^.*?\.(?:ini|inc|hal)(?::\d+)?: ")


@dataclass(frozen=True)
class Row:
    """One file: a machine, or why there is none."""

    name: str
    axes: str = ""
    """Letters of the axes that it has."""
    kind: str = ""
    """As `table-table`; where the control does not place the turning axes, with (stand-in) behind."""
    missing: str = ""
    refused: str = ""


def rows(folder: Path) -> Iterator[Row]:
    """One for each INI in a folder, or deeper."""
    for path in sorted(folder.rglob("*.ini")):
        name = str(path.relative_to(folder).with_suffix(""))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                yield _read(name, read_control([path]))
        except ToolpaceError as error:
            why = re.sub(r"\S*\.(ini|inc|hal):\d+", "another line", _PLACE.sub("", str(error)))
            yield Row(name, refused=why.split(";")[0].split(" (known")[0])


def _read(name: str, draft: MachineDraft) -> Row:
    held = draft.record.held
    axes = "".join(letter for letter in draft.machine.joints if letter not in held)
    placed = not any("slash" in question.what for question in draft.stand_ins)
    kind = "no turning axis" if len(held) == 2 else draft.machine.kind + ("" if placed else " (stand-in)")
    return Row(name, axes, kind, _missing([question.what for question in draft.stand_ins]))


def _missing(questions: list[str]) -> str:
    """What was asked for, the joints of each limit together."""
    joints: dict[str, list[str]] = defaultdict(list)
    for what in questions:
        words = what.split(" [")[0]
        if "slash" in words:
            joints["what turns what, where and in which sense"].append("")
        elif not words.startswith(("a point", "positive")):
            limit, _, joint = words.rpartition(" of ")
            joints[limit or words].append(joint if limit else "")
    return "; ".join(f"{words} of {', '.join(names)}" if names[0] else words for words, names in joints.items())


def table(found: list[Row]) -> str:
    """Markdown: machines by their number of axes, then what was refused."""
    read = [row for row in found if not row.refused]
    lines = [f"{len(read)} of {len(found)} files are read.", ""]
    lines += ["| file | axes | class | not in the files |", "|---|---|---|---|"]
    for row in sorted((row for row in read if len(row.axes) > 3), key=lambda row: (-len(row.axes), row.name)):
        lines.append(f"| `{row.name}` | {row.axes} | {row.kind} | {row.missing or 'nothing'} |")
    three: dict[tuple[str, str], list[str]] = defaultdict(list)
    for row in read:
        if len(row.axes) == 3:
            parts = row.name.split("/")
            three["/".join(parts[:-1][:2]), row.missing].append(parts[-1])
    for (folder, missing), names in sorted(three.items()):
        lines.append(f"| `{folder}`: {', '.join(names)} | XYZ | no turning axis | {missing or 'nothing'} |")
    lines += ["", "| refused | because |", "|---|---|"]
    reasons: dict[str, list[str]] = defaultdict(list)
    for row in found:
        if row.refused:
            reasons[row.refused].append(row.name.rpartition("/")[2])
    by_count = sorted(reasons.items(), key=lambda each: -len(each[1]))
    lines += [f"| {', '.join(names)} | {why} |" for why, names in by_count]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    print(table(list(rows(parser.parse_args().folder))), end="")


if __name__ == "__main__":
    main()
