"""Statements of cutter-location data from its lines, and the cures for those that are not read."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from toolpace.programs.reading.source import Source

_NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[ED][-+]?[0-9]++)?"
NUMBER = re.compile(_NUMBER)
_NAME = r"[A-Z][A-Z0-9_-]*+"
_MAJOR = re.compile(
    rf"(?:[A-Z0-9_]++\)\s*+)?({_NAME}(?:\s*+,\s*+{_NAME})*+(?:(?<=TOOL) PATH)?)\s*+(?:/\s*+(.*))?", re.DOTALL
)
_DEFINITION = re.compile(r"[A-Z][A-Z0-9_]*+(?:\s*+\(.*?\))?\s*+=", re.DOTALL)
_SEPARATOR = re.compile(r"\s*,\s*|\s+")
_NOTE = re.compile(r"\s*+\$\$(.*)")
_COMMENTED = re.compile(r"(?:REMARK\s*+)?->\s*+([A-Z][A-Z0-9_]*+)\s*+/(.*)", re.DOTALL | re.IGNORECASE)
_FREE = re.compile(r"(PARTNO|PPRINT|REMARK|TITLE|LETTER|TPRINT|PPFUN|INSERT)(.*)", re.DOTALL | re.IGNORECASE)
"""Statements whose text follows without a slash, to the end of the line."""
_ALONE = frozenset(("RAPID", "STOP", "OPSTOP", "FINI", "GOHOME", "NURBS", "END-OF-PATH", "AUTOPS", "MULTAX", "END"))
"""Statements that may stand without a slash, and that a line of text does not begin with."""
_CARD = re.compile(r".{72} *[A-Z]{0,4}([0-9]{2,8}) *")
FEWEST_CARDS = 4
"""Lines by which sequence numbers in columns 73 to 80 are told."""
NOTE = "$$"
"""The major word of a comment, whose text some systems hold data in."""
DATA = "->"
"""What the major word of data in a comment of Creo begins with: `$$-> CSYS / ...` is ->CSYS."""
ENDS = frozenset(("FINI",))
STOPS = frozenset(
    ("STOP", "OPSTOP", "SPINDL", "COOLNT", "LOADTL", "LOAD", "UNLOAD", "TURRET", "TOOLNO", "CLAMP", "AUXFUN")
)
"""Statements for which a controller comes to rest."""
TOOLS = frozenset(("LOADTL", "LOAD", "TURRET", "TOOLNO"))
"""Those of them that may name another tool."""
PASSED = frozenset(
    (
        *("AUTOPS", "CLDIST", "CLPRNT", "CLSF", "CSI_SET_EXTENSION_LENGTH", "CSI_SET_FLUTE_LENGTH", "CUTTER", "DISPLY"),
        *("DRAFT", "END", "END-OF-PATH", "HEAD", "INTOL", "LEADER", "LETTER", "LINTOL", "LPRINT", "MACHIN", "MCHFIN"),
        *("MCHTOL", "MODE", "MULTAX", "NOPOST", "OPSKIP", "OPTION", "OUTTOL", "PAINT", "PARTNO", "PPRINT", "PPWORD"),
        *("PREFUN", "PRINT", "PSIS", "REMARK", "REWIND", "SELECT", "SEQNO", "SET", "TITLE", "TLDATA", "TMARK", "TOLER"),
        *("TPRINT", "VTLAXS"),
    )
)
"""Statements without meaning for motion: counted."""
PASSED_BUT_SAID = {
    "OPSKIP": "OPSKIP: optional statements are run",
    "PREFUN": "PREFUN is taken for a function of the control that moves nothing",
    "SET": "SET is taken for a setting that moves nothing",
}
"""What is taken for granted where some of them stand."""
CANCELLED_BY = frozenset(("OFF", "CANCEL", "NOMORE"))
"""Minor words that make a statement of motion end something, such as CYCLE/OFF."""
CANCELLABLE = frozenset(("CUTCOM", "TRACUT", "COPY", "TRANS", "ROTATE", "ROTABL", "INDEX", "MATRIX", "THICK"))
FRAMES = frozenset(("CSYS", "MATRIX", "ORIGIN", "ROTABL", "ROTATE", "TRACUT", "TRANS", "TRNTYP"))
"""Statements that shift or turn the points after them, unless their numbers say nothing."""

_POINTS = "let the CAM system write GOTO points"
_FRAME = "it moves or turns the points after it: write them where they are, in the workpiece frame"
_CONTOUR = "its motion depends on the shape of the part: write CL data (GOTO points), not the source of APT"
_MACHINE = "its motion is the machine's own: write GOTO or GOHOME with the point"
_PROGRAM = "it decides what is run: let the APT processor run it, and give its CL data"
UNKNOWN = f"it is not known here and might move something: remove it, or {_POINTS}"
CURES = {
    **dict.fromkeys((*FRAMES, "COPY", "INDEX"), _FRAME),
    **dict.fromkeys(("GOFWD", "GOLFT", "GORGT", "GOBACK", "GOUP", "GODOWN", "GO", "TLLFT", "TLRGT", "="), _CONTOUR),
    **dict.fromkeys(("CLEARP", "RETRCT", "PROBE", "AIR"), _MACHINE),
    **dict.fromkeys(("CALSUB", "DEFSUB", "ENDSUB", "JUMPTO", "IF", "CALL", "MACRO", "TERMAC"), _PROGRAM),
    **dict.fromkeys(("MOVARC", "ARC", "HELIX", "FNURBS", "THREAD"), f"its form is not known here: {_POINTS}"),
    "CUTCOM": "the control would shift the tool: give --compensation program where the points are of its centre",
    "INSERT": "it holds code of the control that may move something: write it as statements, or remove it",
    "PPFUN": "what it asks of the post-processor is not known here: remove it where it moves nothing",
    "MODE": "the points after it would be increments: write them as they are, without MODE/INCR",
    "SET": "the points after it would be increments: write them as they are, without SET/MODE,INCR",
    "MSYS": "it changes the coordinates between points: write one program a system",
}


class Statement(NamedTuple):
    """A major word and the words after its slash, in capitals, with the line on which it starts."""

    line: int
    major: str
    minors: list[str]
    text: str = ""
    """What follows the major word, as it is written."""


def statements(source: Source, lines: Sequence[str]) -> Iterator[Statement]:
    """Statements of the lines of a program, comments (`NOTE`) too.

    `$` goes on in the next line, what follows it is ignored; `$$` begins a comment, but `$$->` data. Free text is
    not looked through for `$`; where it holds one, a next line that is no statement belongs to it.
    """
    pending, first, loose = "", 0, False
    for line, text in enumerate(lines, start=1):
        if loose and "/" not in text and text.strip().upper() not in _ALONE:
            loose = "$" in text
            continue
        loose = False
        if not pending and (alone := _alone(line, text)) is not None:
            loose = alone.major != NOTE and "$" in text
            yield alone
            continue
        if "$" in text:
            data = _NOTE.match(text) if not pending else None
            text = data[1] if data else text.partition("$$")[0]
            text = text.rstrip()
            if "$" in text:
                first = first or line
                pending += text.partition("$")[0] + " "
                continue
            if pending and not text.strip():
                # A comment between the parts of a statement does not end it.
                continue
        if pending:
            text, line, pending, first = pending + text, first, "", 0
        text = text.strip()
        if text:
            yield _statement(source, text, line)
    if pending:
        source.fail("the program is cut off: '$' says this statement goes on, but the file ends", first)


def without_cards(lines: Sequence[str]) -> tuple[Sequence[str], bool]:
    """The lines up to column 72, and true, where all have rising sequence numbers in columns 73 to 80."""
    found: list[int] = []
    for line in lines:
        if line.strip():
            match = _CARD.fullmatch(line) if 72 < len(line) <= 80 else None
            if match is None or (found and int(match[1]) <= found[-1]):
                return lines, False
            found.append(int(match[1]))
    if len(found) < FEWEST_CARDS:
        return lines, False
    return [line[:72] for line in lines], True


def figure(word: str) -> float:
    """A word that is a number; Fortran's D is an exponent too."""
    return float(word.replace("D", "E"))


def numbers(source: Source, statement: Statement, minors: list[str] | None = None) -> list[float]:
    """The words of a statement as numbers; ProgramError where one is none."""
    words = statement.minors if minors is None else minors
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
        for word in words:
            if not NUMBER.fullmatch(word):
                what = "is empty" if not word else f"'{word[:20]}' is no number"
                source.fail(
                    f"a number of {statement.major} {what}: write numbers like -12.5, between commas",
                    statement.line,
                )
            values.append(figure(word))
    for value in values:
        if not -1e9 < value < 1e9:
            source.fail(
                f"number {value:g} of {statement.major} is not finite or beyond 1e9: correct it",
                statement.line,
            )
    return values


def _alone(line: int, text: str) -> Statement | None:
    """A comment or a statement of free text: what a line is alone, whatever it holds; None for others."""
    note = _NOTE.match(text) if "$$" in text else None
    if note is not None:
        body = note[1].strip()
        return None if _COMMENTED.match(body) else Statement(line, NOTE, [], body)
    free = _FREE.match(text.strip()) if text.lstrip()[:1] in "PRTLIprtli" else None
    if free is None or _COMMENTED.match(text.strip()):
        return None
    return Statement(line, free[1].upper(), [], free[2].strip())


def _statement(source: Source, text: str, line: int) -> Statement:
    capitals = text.upper()
    if capitals.startswith("GOTO/"):
        return Statement(line, "GOTO", _split(capitals[5:]))
    data = _COMMENTED.match(text)
    if data is not None:
        return Statement(line, DATA + data[1].upper(), _split(data[2].upper()), data[2])
    match = _MAJOR.fullmatch(capitals)
    if match is None:
        if _DEFINITION.match(capitals):
            return Statement(line, "=", [], text)
        source.fail("this is no statement of the form WORD or WORD/...: correct or remove it", line)
    major = match[1] if "," not in match[1] else "".join(match[1].split())
    return Statement(line, major, _split(match[2] or ""), text.partition("/")[2].strip())


def _split(text: str) -> list[str]:
    text = text.strip()
    return _SEPARATOR.split(text) if text else []


def cure(word: str) -> str:
    """What to do about a refused word; of a word such as TLLFT,GOFWD the first that is known decides."""
    return next((CURES[part] for part in word.split(",") if part in CURES), UNKNOWN)
