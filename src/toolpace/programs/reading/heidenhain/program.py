"""A Klartext program: its blocks from its lines, its labels and compiled steps; and programs beside it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

_NUMBER = re.compile(r"[Nn]?[0-9]+(?=[\s/;*]|$)")
_BEGIN = re.compile(r"\s*(?:N?[0-9]+\s+)?BEGIN\s+PGM\b", re.IGNORECASE)
_ITEM = re.compile(r"Q[0-9]{3,4}\s*=\s*(?:[-+]?(?:[0-9.,]+|Q[LR]?[0-9]+)|(?:F\s*)?(?:MAX|AUTO)|PREDEF)")
_IN_LINES = re.compile(r"CYCL DEF\s*[0-9]+\.[0-9]")
_QUOTED = re.compile(r"(?:[^\";]++|\"[^\"]*+(?:\"|$))*+")
"""All up to the first semicolon that stands in no text."""
_OPERATION = re.compile(r"(?:TOOL NAME|OPERATION)\b[\s:=]*(\S.*)")
_LABEL = re.compile(r"LBL\s*(?:\"([^\"]*)\"|([0-9]+))")
SUFFIXES = ("", ".h", ".H")
MOST_NAMES = 10_000
"""Files of a folder among which a called program is looked for."""


class Block(NamedTuple):
    """A block, which may have been written in several lines."""

    line: int
    """Of its beginning, from 1."""
    text: str
    """In capitals, with single lines joined by a blank."""


def blocks_of(source: Source, findings: Findings, block_delete: bool) -> list[Block]:
    """The blocks of a program in order, empty ones left out; headings and comments that name a tool begin with `*`."""
    found: list[tuple[int, list[str]]] = []
    goes_on = remarks = False
    sheet = _sheet(source.lines)
    if sheet:
        findings.ignored("( before BEGIN PGM")
    for line, raw in enumerate(source.lines[sheet:], start=sheet + 1):
        text = raw.strip()
        number = _NUMBER.match(text)
        if number:
            text = text[number.end() :].lstrip()
        # a remark that is too long for its line goes on in lines without numbers ("~" ends all but the last)
        remarks = not number and remarks and _ITEM.match(text.upper()) is None
        if remarks:
            remarks = text.endswith("~")
            continue
        text, comment = without_comment(text.upper())
        remarks = bool(number) and not text and comment.endswith("~") and not comment.endswith("~~")
        if text.startswith("/"):
            text = text[1:].lstrip()
            hidden = _NUMBER.match(text)
            text = text[hidden.end() :].lstrip() if hidden else text
            if block_delete:
                findings.ignored("/")
                text = ""
        marked = text.endswith("~")
        text = text.rstrip("~ \t")
        joined = not number and (goes_on or (bool(found) and _continues(found[-1][1][0], text)))
        if text and joined and found:
            found[-1][1].append(text)
        elif text:
            found.append((line, [text]))
        elif operation := _OPERATION.match(comment):
            found.append((line, ["* " + operation[1]]))
        goes_on = marked or (goes_on and not text and not number)
    return [Block(line, " ".join(texts)) for line, texts in found]


def _sheet(lines: Sequence[str]) -> int:
    """Lines of a set-up sheet, each behind an open bracket, with which simulators for training open the file."""
    for count, line in enumerate(lines):
        if _BEGIN.match(line):
            return count
        if line.strip() and not line.lstrip().startswith("("):
            break
    return 0


def _continues(first: str, text: str) -> bool:
    """Whether a line without number is part of the cycle above: some posts leave the mark `~` out. Cycles in lines
    (7.1, 10.1) have no such parameters."""
    has_items = first.startswith(("CYCL DEF", "GLOBAL DEF")) and not _IN_LINES.match(first)
    return has_items and _ITEM.fullmatch(text) is not None


def without_comment(text: str) -> tuple[str, str]:
    """What stands before the semicolon, and behind it; one within quotation marks is text."""
    at = text.find(";")
    if at >= 0 and '"' in text[:at]:
        quoted = _QUOTED.match(text)
        at = quoted.end() if quoted and quoted.end() < len(text) else -1
    return (text.strip(), "") if at < 0 else (text[:at].strip(), text[at + 1 :].strip())


class Program:
    """One file."""

    def __init__(self, source: Source, findings: Findings, block_delete: bool) -> None:
        self.source = source
        self.blocks = blocks_of(source, findings, block_delete)
        self.steps: dict[int, Callable[[], None]] = {}
        """Blocks that were executed more than once, compiled."""
        self.seen = bytearray(len(self.blocks))
        self.labels: dict[str, int] = {}
        """Index of the block behind each label."""
        for index, block in enumerate(self.blocks):
            found = _LABEL.match(block.text)
            name = label_of(found) if found else "0"
            if name == "0":
                continue
            if name in self.labels:
                source.fail(f"LBL {name} stands twice: name one of both otherwise", block.line)
            self.labels[name] = index + 1

    def step(self, at: int, compiler: Callable[[str], Callable[[], None]]) -> Callable[[], None]:
        """The step of a block; kept from the second time on, since most blocks are executed once."""
        found = self.steps.get(at)
        if found is None:
            found = compiler(self.blocks[at].text)
            if self.seen[at]:
                self.steps[at] = found
            self.seen[at] = 1
        return found


def label_of(found: re.Match[str]) -> str:
    """Name of a label, with numbers without leading zeros."""
    return found[1] if found[1] is not None else found[2].lstrip("0") or "0"


def beside(source: Source, name: str) -> Source | None:
    """The program of a CALL PGM in the folder of the program that calls it; None where there is none.

    Raises ProgramError where the file is no text.
    """
    wanted = re.split(r"[\\/:]", name.strip().strip('"'))[-1].strip()
    folder = Path(source.name).parent
    try:
        if not wanted or not source.data or not Path(source.name).is_file():
            return None
        names = {path.name.lower(): path for path, _ in zip(folder.iterdir(), range(MOST_NAMES))}
    except (OSError, ValueError):
        return None
    for suffix in SUFFIXES:
        path = names.get((wanted + suffix).lower())
        if path is not None:
            return Source.load(path)
    return None
