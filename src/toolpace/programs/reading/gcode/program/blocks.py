"""Parsed lines of a program, with variables open."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import partial

from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program import alarms
from toolpace.programs.reading.gcode.program.alarms import Alarm
from toolpace.programs.reading.gcode.program.expressions import Grammar, Node, Parser, Reference
from toolpace.programs.reading.gcode.program.statements import Statement, refuse_unknown_o_word, statement
from toolpace.programs.reading.gcode.program.words import (
    ORDER,
    ROUND_HANDED_OVER,
    Action,
    Vocabulary,
    bounded,
    conflict,
    decimal_comma,
    fault,
    last_of_groups,
    near_whole,
    plain_words,
    without_comments,
    words_behind,
)

_NUMBERED = re.compile(r"N[ \t]*+([0-9]{1,9})[ \t]*+(?![0-9.])")
_NUMBERED_BY_PARTS = re.compile(r"N[ \t]*+[0-9]{1,9}(?:\.[0-9]{1,9})?+[ \t]*+(?![0-9.])")
"""LinuxCNC: "N10.5"."""
_INDEXED = re.compile(r"([A-Z])([0-9]*)[ \t]*+=")
_COMPUTES = re.compile(r"[\[#=<]")
_LATE = re.compile(r"(?<=[0-9.])[ \t]*+/[1-9]?[ \t]*+(?=[A-Z])")
_EQUALS = re.compile(r"[ \t]*+=")
_OPERATION = re.compile(r"\([ \t]*+(?:OPERATION(?:[ \t]NAME)?|PATH)[ \t]*+[:=][ \t]*+([^()]{1,80})\)", re.IGNORECASE)
_SPLIT_NUMBER = re.compile(r"[A-FH-LN-Z][ \t]*+[-+]?[ \t]*+[0-9.]++(?:[ \t]++[0-9.]++)++")
_ABORT = re.compile(r"\([ \t]*+ABORT[ \t]*+,([^()]*+)\)", re.IGNORECASE)
LATE_SLASH = Alarm("/ behind the beginning of a block", "it stands first: write what it skips as a line of its own")
CORNER = "let the CAM system write the corner out as blocks"


@dataclass(slots=True)
class Block:
    """One block. Words that are numbers are `fixed`, those with variables or in brackets `computed`."""

    text: str = ""
    deleted: bool = False
    """Whether it begins with `/`."""
    name: str = ""
    """Of the operation that it begins, from a comment."""
    aborts: str = ""
    """Why the program ends itself here, from a comment (ABORT, ...)."""
    fixed: dict[str, float] = field(default_factory=dict)
    computed: list[tuple[str, Node]] = field(default_factory=list)
    codes: list[tuple[str, Node]] = field(default_factory=list)
    """G and M words with variables."""
    words: list[str] = field(default_factory=list)
    """All G and M words, in order."""
    alarms: list[Alarm] = field(default_factory=list)
    """What the control stops at, though its meaning is certain."""
    whole: frozenset[str] = frozenset()
    """Letters whose number has no point and is not zero."""
    actions: list[Action] = field(default_factory=list)
    """In the order in which they act; the first `before_feed` of them before F."""
    calls_macro: bool = False
    """Whether what stands behind is handed to a macro, M too ("G65 P L <argument>", M is #13)."""
    before_feed: int = 0
    ignored: list[str] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)
    """Words, and the cure of each."""
    assignments: list[tuple[Reference, Node]] = field(default_factory=list)
    arguments: list[tuple[str, Node]] = field(default_factory=list)
    """All words of a macro call, in order."""
    statement: Statement | None = None
    empty: bool = False


class Compiler:
    """Makes blocks of lines, for one controller."""

    def __init__(self, controller: Controller, *, deletes: bool = True) -> None:
        """deletes: whether what stands behind a `/` is left out."""
        self.vocabulary, self.deletes = Vocabulary(controller), deletes
        self.nested, self.closed = controller.option("nested_comments", False), controller.option("fanuc_checks", False)
        self.semicolon_ends = controller.option("semicolon_ends_block", False)
        self.rs274 = controller.option("rs274_checks", False)
        self.blanks = controller.option("blanks_mean_nothing", False)
        self.bits = controller.option("logic_on_bits", False)
        self.letter = controller.option("variable_letter", "#")
        self.parser = partial(
            Parser,
            grammar=Grammar(
                bits=self.bits,
                letter=self.letter,
                strict=self.rs274,
                whole_remainder=controller.option("remainder_of_whole_numbers", False),
                to_360=controller.option("angles_to_360", False),
            ),
        )
        """Makes a parser of values in the controller's manner."""
        self.indexed = controller.option("indexed_words", False)
        self.last_rules = controller.option("last_of_group_rules", False)
        self.corners = controller.option("corner_words", False)
        self.tool_behind = controller.option("second_tool_is_next", False)
        self.last_before_feed = ORDER["inverse time" if controller.option("feed_before_units", False) else "inch"]

    def block(self, line: str) -> Block:
        """Raises BlockError."""
        block = Block()
        if "(" in line:
            found = _OPERATION.search(line)
            block.name = found[1].strip() if found else ""
            aborts = _ABORT.search(line) if self.rs274 else None
            block.aborts = aborts[1].strip() or "no reason is given" if aborts else ""
            if self.rs274:
                alarms.refuse_comment_in_word(line)
        text = without_comments(line, self.nested, self.closed and not line.lstrip().startswith("/"))
        if self.rs274:
            block.alarms += alarms.of_line(line)
        if self.semicolon_ends and ";" in line and words_behind(line):
            block.refused.append((";", "a block stands behind it: write each block on a line of its own"))
        if text.startswith("/"):
            block.deleted, text = True, text.lstrip("/0123456789 \t")
        if text.startswith("N"):
            match = (_NUMBERED_BY_PARTS if self.rs274 else _NUMBERED).match(text)
            text = text[match.end() :] if match else text
            if text.startswith("/"):
                block.deleted, text = True, text.lstrip("/0123456789 \t")
                if self.rs274:
                    block.alarms.append(LATE_SLASH)
        if block.deleted and self.deletes:
            block.text, block.empty = text, not text
            return block  # whatever it says: notes of people stand there too
        if "/" in text and not _COMPUTES.search(text):
            text = self._late(block, text)
        if self.rs274:
            block.alarms += alarms.of_text(text)
        block.text, block.empty = text, not text
        if text and text[0] in "OIWDEGSPB:<":
            block.statement = statement(text, self.parser, self.assignments)
            if self.rs274 and block.statement is not None and block.statement.kind == "header":
                refuse_unknown_o_word(text)
        if text and block.statement is None:
            if self.blanks and (" " in text or "\t" in text):
                block.text = _SPLIT_NUMBER.sub(lambda match: "".join(match[0].split()), text)
            self._words(block)
            self.arrange(block)
        return block

    def _late(self, block: Block, text: str) -> str:
        """The words of a block of which the last stand behind a `/`."""
        found = _LATE.search(text)
        if found is None:
            return text
        if self.rs274:
            block.alarms.append(LATE_SLASH)
        block.ignored.append("/")
        return text[: found.start()] if self.deletes else _LATE.sub(" ", text)

    def arrange(self, block: Block) -> None:
        """Bring the actions into their order. Raises BlockError where two exclude each other."""
        actions = block.actions
        if len(actions) > 1:
            if self.last_rules:
                actions = block.actions = last_of_groups(actions)
            actions.sort(key=lambda action: ORDER[action.meaning])
            problem = conflict(actions)
            if problem:
                raise BlockError(problem)
        if self.rs274 and len(block.words) > 1:
            block.alarms += [alarm for alarm in alarms.of_codes(block.words) if alarm not in block.alarms]
        block.before_feed = sum(ORDER[action.meaning] <= self.last_before_feed for action in actions)

    def assignments(self, text: str) -> list[tuple[Reference, Node]]:
        """What a text of assignments alone sets."""
        block = Block(text)
        self._scan(block)
        if block.fixed or block.computed or block.actions:
            raise BlockError("assignments alone can stand behind THEN: write the block with GOTO around it")
        return block.assignments

    def _words(self, block: Block) -> None:
        found = plain_words(block.text)
        if found is None:
            self._scan(block)
            return
        whole = []
        for letter, text in found:
            if letter == "G" or (letter == "M" and not block.calls_macro):
                self.code(block, letter, bounded(float(text)))
            elif letter in block.fixed:
                self._twice(block, letter)
                block.arguments.append((letter, bounded(float(text))))
            else:
                block.fixed[letter] = value = bounded(float(text))
                block.arguments.append((letter, value))
                if "." not in text and value:
                    whole.append(letter)
        block.whole = frozenset(whole)

    def _twice(self, block: Block, letter: str) -> None:
        if letter == "T" and self.tool_behind:
            block.ignored.append("second T")
            return
        # a macro takes I, J and K several times
        if not block.calls_macro:
            raise BlockError(f"word {letter} stands twice in one block: remove one")

    def code(self, block: Block, letter: str, value: float) -> None:
        """Add a G or M word to a block."""
        if self.rs274:  # its interpreter takes what a post rounds so for the number
            value = near_whole(10 * value, 1e-3) / 10 if letter == "G" else near_whole(value, 1e-4)
        found = self.vocabulary.of(letter, value)
        word = f"{letter}{value:.12g}"
        block.words.append(word)
        if letter == "M" and (value != int(value) or value < 0):
            raise BlockError("M has no whole number")
        if isinstance(found, Action):
            block.actions.append(found)
            block.calls_macro |= found.meaning in ("macro call", "modal macro call")
        elif found is None:
            block.ignored.append(word)
        else:
            block.refused.append((word, found))

    def _scan(self, block: Block) -> None:
        """Words and assignments one by one, with expressions."""
        parser = self.parser(block.text)
        text, end = block.text, len(block.text)
        if comma := decimal_comma(text):
            raise BlockError(comma)
        whole = []
        while True:
            while parser.at < end and text[parser.at] in " \t":
                parser.at += 1
            if parser.at >= end:
                break
            at, letter = parser.at, text[parser.at]
            indexed = _INDEXED.match(text, at) if self.indexed else None
            if letter == "#" or (indexed and letter == self.letter and indexed[2]):
                self._assignment(block, parser)
            elif letter == ",":
                parser.go_to(at + 2)
                self._corner(block, text[at : at + 2], parser.value())
                if text[at + 2 : parser.at].strip().isdigit():
                    whole.append(text[at : at + 2])
            elif not ("A" <= letter <= "Z"):
                raise BlockError(fault(text[at:]))
            else:
                key = letter if indexed is None else indexed[1] + indexed[2]
                parser.go_to(at + 1 if indexed is None else indexed.end())
                if indexed is None and parser.lacks_value():
                    raise BlockError(fault(text[at:]))
                parser.address = "" if (macro := block.calls_macro) else key
                node = parser.value() if indexed is None else parser.expression()
                parser.address, written = "", text[at + 1 : parser.at]
                if macro and self.bits and "ROUND" in written:
                    block.refused.append(ROUND_HANDED_OVER)
                if isinstance(node, float) and node and written.strip().lstrip("+-").isdigit():
                    whole.append(key)
                self._word(block, key, node, reckoned="[" in written)
        block.whole = frozenset(whole)

    def _corner(self, block: Block, word: str, size: Node) -> None:
        """,R and ,C: a corner at the end of the block."""
        if word in (",R", ",C") and self.corners:
            self._word(block, word, size)
        else:
            block.refused.append((word, CORNER))

    def _assignment(self, block: Block, parser: Parser) -> None:
        reference = parser.value()
        if not isinstance(reference, Reference):
            raise BlockError("a variable stands at the left of '=': write it like #100=1.5")
        equals = _EQUALS.match(parser.text, parser.at)
        if equals is None:
            raise BlockError("a variable at the beginning of a block is set: write = and a value behind it")
        parser.go_to(equals.end())
        if not self.rs274:
            block.assignments.append((reference, parser.expression()))
            return
        block.assignments.append((reference, parser.value()))
        if parser.symbol in parser.operators:
            raise BlockError(f"'{parser.text[parser.at :].strip()[:20]}' stands behind a value: write sums in [ ]")

    def _word(self, block: Block, key: str, node: Node, *, reckoned: bool = False) -> None:
        if key == "G" or (key == "M" and not block.calls_macro):
            if isinstance(node, float):
                self.code(block, key, node)
            else:
                block.codes.append((key, node))
            return
        if key in block.fixed or any(letter == key for letter, _ in block.computed):
            self._twice(block, key)
        elif isinstance(node, float) and not reckoned:
            block.fixed[key] = node
        else:
            block.computed.append((key, node))
        block.arguments.append((key, node))
