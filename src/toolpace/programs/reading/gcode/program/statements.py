"""Flow statements: Custom Macro B of Fanuc, O-words of LinuxCNC; and a file's labels, subprograms and loops."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.flow import Labels, Nesting
from toolpace.programs.reading.gcode.program.expressions import Node, Parser, Reference
from toolpace.programs.reading.source import Source

_KINDS = (
    *("SUB", "ENDSUB", "RETURN", "CALL", "WHILE", "ENDWHILE", "DO", "IF", "ELSEIF", "ELSE", "ENDIF"),
    *("REPEAT", "ENDREPEAT", "BREAK", "CONTINUE"),
)
_KIND = "|".join(r"[ \t]*+".join(kind) for kind in _KINDS)
"""O-words, with blanks anywhere: they mean nothing there ("o100 end if")."""
O_WORD = re.compile(rf"O[ \t]*+(<[^<>]{{1,200}}>|[0-9]{{1,9}})[ \t]*+({_KIND})(?![A-Z])")
_COMPUTED = re.compile(r"O[ \t]*+(?=[\[#])")
_UNKNOWN_O = re.compile(r"O[ \t]*+(?:[0-9]++|<[^<>]*+>)[ \t]*+([A-Z]++)")
_CALL = re.compile(r"[ \t]*+C[ \t]*+A[ \t]*+L[ \t]*+L(?![A-Z])")
_CONDITIONS = ("while", "if", "elseif", "repeat")
_WITH_RESULT = ("return", "endsub")
HEADER = re.compile(r"[O:][ \t]*+(?:[0-9]|<|[A-Z])")
_MACRO = re.compile(r"(IF|WHILE|DO|END|GOTO)(?![A-Z])")
_NAMED = re.compile(r"<[A-Z0-9_.+-]{1,60}>")
"""The name of a program, on controls that name them."""
_OUTPUT = re.compile(r"(?:POPEN|PCLOS|DPRNT|BPRNT|SETVN)(?![A-Z])")
_LOOPS = (1, 2, 3)
_LABEL = re.compile(r"[ \t]*+/?[0-9]?[ \t]*+N[ \t]*+([0-9]{1,9})(?![0-9.])")
_PROGRAM = re.compile(
    r"[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?[O:][ \t]*+([0-9]{1,9})[ \t]*+(?:\(.*|;.*|([A-Z][ \t]*+[-+.0-9#\[].*))?$"
)
_O_NAMED = re.compile(r"[ \t]*+O[ \t]*+<([^<>]{1,200})>[ \t]*+(?:\(.*|;.*)?$")
_O_LINE = re.compile(r"[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?" + O_WORD.pattern)
_DO = re.compile(r"^[^(;]*?\bDO[ \t]*+([1-3])(?![0-9])")
_END = re.compile(r"[ \t]*+/?[0-9]?[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?END[ \t]*+([1-3])(?![0-9])")
_NUMBERS = (1, 2, 3)
"""Of DO and END."""
_OPENS = frozenset(("SUB", "WHILE", "DO", "REPEAT", "IF"))
_CLOSES = {"ENDSUB": "SUB", "ENDWHILE": "WHILE", "ENDREPEAT": "REPEAT", "ENDIF": "IF"}


class Statement(NamedTuple):
    """What a block does to the flow of the program."""

    kind: str
    name: str = ""
    """Of an O-word."""
    value: Node | None = None
    """Condition, label or number of times."""
    arguments: tuple[Node, ...] = ()
    label: Node | None = None
    """Where a condition jumps to."""
    assignments: tuple[tuple[Reference, Node], ...] = ()
    number: Node | None = None
    """Of a subprogram that is called by a number that is reckoned."""


Assignments = Callable[[str], list[tuple[Reference, Node]]]
"""Reads a text of assignments."""


def statement(text: str, parser: Callable[[str, int], Parser], assignments: Assignments) -> Statement | None:
    """The statement that a block is; None where it has words. Raises BlockError."""
    if text[0] in "O:":
        match = O_WORD.match(text)
        if match:
            name = match[1]
            name = "".join(name[1:-1].split()) if name[0] == "<" else str(int(name))
            return _o_word(name, "".join(match[2].split()).lower(), parser(text, match.end()))
        computed = _COMPUTED.match(text)
        if computed:
            return _computed_call(parser(text, computed.end()))
        if HEADER.match(text) and "=" not in text:
            return Statement("header", text[1:].strip())
        raise BlockError("O is followed by neither a number nor a name: write it like O1000")
    if text[0] == "<":
        return Statement("header", text.strip("<> \t")) if _NAMED.fullmatch(text) else None
    match = _MACRO.match(text)
    if match:
        return _macro(match[1], text, parser(text, match.end()), assignments)
    return Statement("output") if _OUTPUT.match(text) else None


def _o_word(name: str, kind: str, parser: Parser) -> Statement:
    values: list[Node] = []
    while parser.symbol == "[":
        values.append(parser.value())
    if kind in _CONDITIONS and len(values) != 1:
        raise BlockError(f"{kind} takes one value in [ ]: write it like o100 {kind} [#1 LT 5]")
    most = len(values) if kind == "call" else 1 if kind in (*_CONDITIONS, *_WITH_RESULT) else 0
    rest = parser.text[parser.at :].strip()
    if rest or len(values) > most:
        raise BlockError(f"'{(rest or '[')[:20]}' has no meaning behind {kind}: write values in [ ], and nothing else")
    if kind == "call":
        return Statement(kind, name, arguments=tuple(values))
    return Statement(kind, name, values[0] if values else None)


def _computed_call(parser: Parser) -> Statement:
    """o[#1*10] call: the only O-word of which the label may be reckoned, since those of a file are found beforehand."""
    number = parser.value()
    match = _CALL.match(parser.text, parser.at)
    if match is None:
        raise BlockError("a label that is reckoned can be called, and nothing else: write a number or a name behind O")
    parser.go_to(match.end())
    return _o_word("", "call", parser)._replace(number=number)


def refuse_unknown_o_word(text: str) -> None:
    """Raise BlockError where a word stands behind an O-number: a misspelt call would be passed over."""
    found = _UNKNOWN_O.match(text)
    if found:
        raise BlockError(f"{found[1][:20]} is no O-word: write sub, call, while, do, if, repeat or one that ends these")


def _macro(kind: str, text: str, parser: Parser, assignments: Assignments) -> Statement:
    if kind == "GOTO":
        return Statement("goto", value=_last(parser))
    if kind == "END" or kind == "DO":
        return Statement(kind.lower(), str(_loop(parser)))
    parser.need("[")
    condition = parser.expression()
    parser.need("]")
    rest = text[parser.at :].lstrip()
    parser.go_to(len(text) - len(rest))
    if kind == "WHILE":
        if not rest.startswith("DO"):
            raise BlockError("DO is missing behind WHILE [ ]: write it like WHILE [#1 LT 5] DO1")
        parser.go_to(parser.at + 2)
        return Statement("while do", str(_loop(parser)), condition)
    if rest.startswith("GOTO"):
        parser.go_to(parser.at + 4)
        return Statement("if goto", value=condition, label=_last(parser))
    if rest.startswith("THEN"):
        return Statement("if then", value=condition, assignments=tuple(assignments(rest[4:].strip())))
    raise BlockError("GOTO or THEN is missing behind IF [ ]: write it like IF [#1 EQ 0] GOTO 100")


def _loop(parser: Parser) -> int:
    number = _last(parser)
    if number not in _LOOPS:
        raise BlockError("DO and END take the numbers 1, 2 and 3: write WHILE [ ] DO1 and END1")
    return int(number)


def _last(parser: Parser) -> Node:
    value = parser.value()
    if parser.text[parser.at :].strip():
        raise BlockError(f"'{parser.text[parser.at :].strip()[:20]}' has no meaning there: write it in another block")
    return value


class Layout:
    """Indices of lines, from 0."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        """to_tape_end: nothing stands behind a second line with % alone."""
        self.labels = Labels()
        """Sequence numbers."""
        self.programs: dict[str, int] = {}
        """Of programs, the line behind which they begin."""
        self.subs: dict[str, int] = {}
        self.nesting = Nesting()
        """Of O-words by their name, of DO and END by their number."""
        self.loop: dict[int, int] = {}
        """Of `break` and `continue` the beginning of their loop."""
        self.do: set[int] = set()
        """Beginnings of `do` loops."""
        self.left: dict[int, list[tuple[int, str]]] = {}
        """Of the beginning of a loop, where `break` and `continue` of it stand."""
        self.crossed: dict[int, int] = {}
        """Of the beginning of a WHILE loop that of another which begins before it, and ends in it."""
        self.taken: dict[int, int] = {}
        """Of what begins with a label that its subprogram has already, the line that has it."""
        self.within: dict[int, int] = {}
        """Of a subprogram that is written within another the line of the latter."""
        self._scope: tuple[str, int] = ("", -1)
        """Name and first line of the subprogram at hand."""
        self._first: dict[tuple[str, str], int] = {}
        """Line with which each O-word begins, by its subprogram and its name."""
        tapes = 0
        for index, text in enumerate(source.lines):
            if to_tape_end and text.strip() == "%":
                tapes += 1
                if tapes > 1:
                    break
            text = text.upper()
            label = _LABEL.match(text) if "N" in text else None
            if label:
                self.labels.add(int(label[1]), index)
            if "O" in text or ":" in text:
                self._programs_and_words(text, index)
            if "DO" in text and (match := _DO.match(text)):
                self.nesting.begin("DO", index, int(match[1]))
            elif "END" in text and (match := _END.match(text)) and self.nesting.innermost(int(match[1])):
                begin = self.nesting.close(index, int(match[1]))
                later = (each.parts[0] for number in _NUMBERS for each in self.nesting.opened[number])
                self.crossed |= {opened: begin for opened in later if opened > begin}

    def _programs_and_words(self, text: str, index: int) -> None:
        word = _O_LINE.match(text)
        if word:
            name = word[1]
            name = "".join(name[1:-1].split()) if name[0] == "<" else str(int(name))
            kind = "".join(word[2].split())
            self._label(name, kind, index)
            self._o_word(name, kind, index)
            return
        program = _PROGRAM.match(text)
        if program:
            # words behind the number are the first block of the program
            self.programs.setdefault(str(int(program[1])), index - 1 if program[2] else index)
            self._scope = (program[1], -1)
        elif named := _O_NAMED.match(text):
            self.programs.setdefault("".join(named[1].split()), index)

    def _label(self, name: str, kind: str, index: int) -> None:
        """Note where a label is taken, and a subprogram that stands within another."""
        if kind == "SUB":
            if self._scope[1] >= 0:
                self.within[index] = self.within[self._scope[1]] = self._scope[1]
            first = self._first.setdefault(("", f"sub {name}"), index)
            self._scope = (name, index)
        elif kind in _OPENS and not (kind == "WHILE" and self._inside(name, "DO")):
            first = self._first.setdefault((self._scope[0], name), index)
        else:
            if kind == "ENDSUB":
                self._scope = ("", -1)
            return
        if first != index:
            self.taken[index] = first

    def _inside(self, name: str, *kinds: str) -> bool:
        """Whether the innermost O-word of a name that is open is of one of these kinds."""
        innermost = self.nesting.innermost(name)
        return innermost is not None and innermost.kind in kinds

    def _o_word(self, name: str, kind: str, index: int) -> None:
        if kind == "SUB":
            self.subs.setdefault(name, index)
        if kind == "WHILE" and self._inside(name, "DO"):
            self.nesting.close(index, name)
        elif kind in _OPENS:
            self.nesting.begin(kind, index, name)
            if kind == "DO":
                self.do.add(index)
        elif kind in ("ELSEIF", "ELSE") and self._inside(name, "IF"):
            self.nesting.branch(index, name)
        elif kind in ("BREAK", "CONTINUE") and self._inside(name, "WHILE", "DO", "REPEAT"):
            begin = self.loop[index] = self.nesting.opened[name][-1].parts[0]
            self.left.setdefault(begin, []).append((index, kind))
        elif kind in _CLOSES and self._inside(name, _CLOSES[kind]):
            self.nesting.close(index, name)

    def partner_of(self, line: int) -> int:
        """The end of a loop or subprogram that begins in a line, or the beginning of one that ends there.

        Raises BlockError where it is not there.
        """
        found = self.nesting.partner.get(line)
        if found is None:
            raise BlockError(
                "a loop or subprogram lacks its beginning or its end: write both, with the same number or name"
            )
        return found

    def label(self, number: int, behind: int) -> int | None:
        """Line of a sequence number: the next behind a line, else the first of the file."""
        found = self.labels.below(number, behind)
        return self.labels.below(number, -1) if found is None else found


class Text:
    """A file of blocks."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        self.source, self.to_tape_end = source, to_tape_end

    @cached_property
    def layout(self) -> Layout:
        """Where its labels and loops are."""
        return Layout(self.source, self.to_tape_end)


class Files:
    """Finds programs by name."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        self.to_tape_end = to_tape_end
        self.main = Text(source, to_tape_end)
        self.beside: dict[str, Text | None] = {}
        """Files that were looked for; None where there is none."""

    def find(self, present: Text, name: str, sub: bool) -> tuple[Text, int] | None:
        """File and first line of a program, or of an O-word's subprogram; None where there is none."""
        for text in (present, self.main):
            found = self._in(text, name, sub)
            if found is not None:
                return found
        beside = self._beside(name)
        if beside is None:
            return None
        return self._in(beside, name, sub) or (beside, 0)

    def lines_beside(self) -> int:
        """Lines of the files that were called."""
        return sum(len(text.source.lines) for text in self.beside.values() if text is not None)

    @staticmethod
    def _in(text: Text, name: str, sub: bool) -> tuple[Text, int] | None:
        line = (text.layout.subs if sub else text.layout.programs).get(name)
        return None if line is None else (text, line + 1)

    def _beside(self, name: str) -> Text | None:
        """A file of that name in the folder of the program."""
        if name not in self.beside:
            self.beside[name] = None
            path = Path(self.main.source.name)
            safe = all(mark.isalnum() or mark in "_-." for mark in name)
            if safe and path.is_file():
                stems = [name.lower(), f"o{name.lower()}", f"o{name.lower():0>4}", f"{name.lower():0>4}"]
                wanted = {stem + suffix for stem in stems for suffix in (path.suffix.lower(), ".ngc", ".nc", "")}
                files = sorted(other for other in path.parent.iterdir() if other.name.lower() in wanted)
                found = next((other for other in files if other.is_file() and other != path), None)
                self.beside[name] = None if found is None else Text(Source.load(found), self.to_tape_end)
        return self.beside[name]
