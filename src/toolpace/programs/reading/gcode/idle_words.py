"""Words that move nothing, and the letters beside them that are theirs."""

from __future__ import annotations

from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError

SHIFTED_BY_TABLES = (
    "it shifts by tables of the control, which no set-up sheet has: let the CAM system shift the path, or remove it "
    "where they are zero"
)


class IdleWords:
    """Counts words that move nothing; what beside them might move is refused."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {"limits": self.limits, "no motion": self.no_motion, "only off": self.only_off}

    def limits(self, numbers: Numbers, word: str) -> None:
        """Fanuc G22: X, Y, Z, I, J, K are corners of a zone that the axes may not enter."""
        numbers.clear()
        self.findings.ignored(word)

    def no_motion(self, numbers: Numbers, word: str) -> None:
        """A word that moves nothing on one control, and with axes moves on another (G8 of Fagor is an arc)."""
        if not numbers.keys().isdisjoint("XYZABCUVW"):
            numbers.clear()
            raise RefusedError(f"{word} beside axes", "some controls move by it otherwise: give --controller NAME")
        numbers.pop("P", None)
        self.findings.ignored(word)

    def only_off(self, numbers: Numbers, word: str) -> None:
        """A word whose P0 (or X0) switches off what is not read."""
        letter = "P" if "P" in numbers else "X"
        number = numbers.pop(letter, 0.0)
        if number:
            raise RefusedError(f"{word} {letter}{number:g}", SHIFTED_BY_TABLES)
        self.findings.ignored(word)
