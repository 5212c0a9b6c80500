"""A Klartext program: blocks, labels, compiled steps; and programs beside it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from toolpace.common.errors import ProgramError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.klartext.blocks import blocks_of
from toolpace.programs.reading.source import Source

_LABEL = re.compile(r"LBL\s*(?:\"([^\"]*)\"|([0-9]+))")
SUFFIXES = ("", ".h", ".H")
MOST_NAMES = 10_000
"""Files of a folder among which a called program is looked for."""


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


__all__ = ["Program", "ProgramError", "beside", "label_of"]
