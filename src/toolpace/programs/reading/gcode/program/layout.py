"""The labels, subprograms and loops of a file."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections import defaultdict

from toolpace.programs.reading.gcode.program.statements import O_WORD
from toolpace.programs.reading.language.expressions import BlockError
from toolpace.programs.reading.source import Source

_LABEL = re.compile(r"[ \t]*+/?[0-9]?[ \t]*+N[ \t]*+([0-9]{1,9})(?![0-9.])")
_PROGRAM = re.compile(
    r"[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?[O:][ \t]*+([0-9]{1,9})[ \t]*+(?:\(.*|;.*|([A-Z][ \t]*+[-+.0-9#\[].*))?$"
)
_NAMED = re.compile(r"[ \t]*+O[ \t]*+<([^<>]{1,200})>[ \t]*+(?:\(.*|;.*)?$")
_O_LINE = re.compile(r"[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?" + O_WORD.pattern)
_DO = re.compile(r"^[^(;]*?\bDO[ \t]*+([1-3])(?![0-9])")
_END = re.compile(r"[ \t]*+/?[0-9]?[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?END[ \t]*+([1-3])(?![0-9])")
_OPENS = frozenset(("SUB", "WHILE", "DO", "REPEAT", "IF"))
_CLOSES = {"ENDSUB": "SUB", "ENDWHILE": "WHILE", "ENDREPEAT": "REPEAT", "ENDIF": "IF"}


class Layout:
    """Indices of lines, from 0."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        """to_tape_end: nothing stands behind a second line with % alone."""
        self.labels: dict[int, list[int]] = defaultdict(list)
        self.programs: dict[str, int] = {}
        """Of programs, the line behind which they begin."""
        self.subs: dict[str, int] = {}
        self.partner: dict[int, int] = {}
        """Of the beginning of a loop or subprogram its end, and of the end its beginning."""
        self.branch: dict[int, int] = {}
        """Of `if`, `elseif` and `else` the next of them, or `endif`."""
        self.end: dict[int, int] = {}
        """Of `elseif` and `else` their `endif`; of `break` and `continue` the beginning of their loop."""
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
        self._labels: dict[tuple[str, str], int] = {}
        self._open: dict[str, list[list[int | str]]] = defaultdict(list)
        dos: dict[str, list[int]] = defaultdict(list)
        tapes = 0
        for index, text in enumerate(source.lines):
            if to_tape_end and text.strip() == "%":
                tapes += 1
                if tapes > 1:
                    break
            text = text.upper()
            label = _LABEL.match(text) if "N" in text else None
            if label:
                self.labels[int(label[1])].append(index)
            if "O" in text or ":" in text:
                self._programs_and_words(text, index)
            if "DO" in text and (match := _DO.match(text)):
                dos[match[1]].append(index)
            elif "END" in text and (match := _END.match(text)) and dos[match[1]]:
                begin = dos[match[1]].pop()
                self.partner[begin], self.partner[index] = index, begin
                self.crossed |= {open_: begin for number in dos.values() for open_ in number if open_ > begin}

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
        elif named := _NAMED.match(text):
            self.programs.setdefault("".join(named[1].split()), index)

    def _label(self, name: str, kind: str, index: int) -> None:
        """Note where a label is taken, and a subprogram that stands within another."""
        if kind == "SUB":
            if self._scope[1] >= 0:
                self.within[index] = self.within[self._scope[1]] = self._scope[1]
            first = self._labels.setdefault(("", f"sub {name}"), index)
            self._scope = (name, index)
        elif kind in _OPENS and not (kind == "WHILE" and self._open[name] and self._open[name][-1][0] == "DO"):
            first = self._labels.setdefault((self._scope[0], name), index)
        else:
            if kind == "ENDSUB":
                self._scope = ("", -1)
            return
        if first != index:
            self.taken[index] = first

    def _o_word(self, name: str, kind: str, index: int) -> None:
        stack = self._open[name]
        if kind == "SUB":
            self.subs.setdefault(name, index)
        if kind == "WHILE" and stack and stack[-1][0] == "DO":
            self._close(stack, index)
        elif kind in _OPENS:
            stack.append([kind, index, index])
            if kind == "DO":
                self.do.add(index)
        elif kind in ("ELSEIF", "ELSE") and stack and stack[-1][0] == "IF":
            last = stack[-1]
            self.branch[int(last[-1])] = index
            last.append(index)
        elif kind in ("BREAK", "CONTINUE"):
            if stack and stack[-1][0] in ("WHILE", "DO", "REPEAT"):
                begin = self.end[index] = int(stack[-1][1])
                self.left.setdefault(begin, []).append((index, kind))
        elif _CLOSES.get(kind) and stack and stack[-1][0] == _CLOSES[kind]:
            self._close(stack, index)

    def _close(self, stack: list[list[int | str]], index: int) -> None:
        entry = stack.pop()
        begin = int(entry[1])
        self.partner[begin], self.partner[index] = index, begin
        if entry[0] == "IF":
            self.branch[int(entry[-1])] = index
            for branch in entry[3:]:
                self.end[int(branch)] = index

    def partner_of(self, line: int) -> int:
        """The end of a loop or subprogram that begins in a line, or the beginning of one that ends there.

        Raises BlockError where it is not there.
        """
        found = self.partner.get(line)
        if found is None:
            raise BlockError(
                "a loop or subprogram lacks its beginning or its end: write both, with the same number or name"
            )
        return found

    def label(self, number: int, behind: int) -> int | None:
        """Line of a sequence number: the next behind a line, else the first of the file."""
        found = self.labels.get(number)
        if not found:
            return None
        place = bisect_right(found, behind)
        return found[place] if place < len(found) else found[0]
