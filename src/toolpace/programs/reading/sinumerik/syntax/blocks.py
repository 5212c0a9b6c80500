"""Parsed blocks, and those of flow and declaration from their tokens: IF, FOR, GOTOF, CASE, DEF, PROC, CALL."""

from __future__ import annotations

from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.syntax.expressions import Parser, constant
from toolpace.programs.reading.sinumerik.syntax.lexer import END, LETTER, NAME, NUMBER, SIGN, TEXT, WORD
from toolpace.programs.reading.sinumerik.syntax.values import Compiled

ABSOLUTE, INCREMENTAL, SHORTEST, UPWARD, DOWNWARD = "AC", "IC", "DC", "ACP", "ACN"
FORMS = (ABSOLUTE, INCREMENTAL, SHORTEST, UPWARD, DOWNWARD)
"""How the value of one word is meant: X=IC(5); ACP and ACN turn a rotary axis up and down, DC the shortest way."""
ADDRESSES = frozenset(
    {
        *("CR", "AR", "TURN", "AP", "RP", "FP", "RPL", "PW", "SD", "PL", "PO"),
        *("ADIS", "ADISPOS", "CTOL", "OTOL", "ATOL", "ORIPATHS", "DISR", "DISCL", "DISC", "DISRP", "OFFN", "NORM"),
        *("CHF", "CHR", "RND", "RNDM", "ANG", "LEAD", "TILT", "THETA", "XH", "YH", "ZH", "SF"),
        *("SPOS", "SPOSA", "SVC", "SCC", "LIMS", "FGREF", "FD", "FA", "FB", "FZ", "FL", "FRC", "FRCM"),
        *("OVR", "OVRRAP", "OVRA", "ACC", "JERKLIM", "VELOLIM", "POS", "POSA", "POSP", "STW", "SPOSMODE"),
        *("FXS", "FXST", "FXSW", "DITS", "DITE", "G"),
    }
)
"""Names that take a value with `=` and are no variables."""


class Word(NamedTuple):
    """An address with its value: X10, CR=5, X=IC(R1), FGREF[A]=10."""

    address: str
    literal: int
    """Place of its value among the constants of the block; -1 where it is compiled."""
    compiled: Compiled | None = None
    form: str = ""
    indices: tuple[Compiled, ...] = ()
    rest: tuple[Compiled | None, ...] = ()
    """Further values: PO[X]=(a, b, c)."""


class Assignment(NamedTuple):
    """R1=..., NAME=..., NAME[i]=..., $NAME[i]=..."""

    name: str
    indices: tuple[Compiled, ...]
    value: Compiled


class Call(NamedTuple):
    """NAME(arguments), L123, NAME: a cycle, a command or a subprogram."""

    name: str
    arguments: tuple[Compiled | None, ...] = ()
    bracketed: bool = False
    times: Compiled | None = None
    """P of a subprogram: how often."""


class Flow(NamedTuple):
    """A block that says which block is next, or declares."""

    kind: str
    """IF, ELSE, ENDIF, FOR, GOTOF, CASE, DEF, PROC, MCALL, ..."""
    values: tuple[Compiled | None, ...] = ()
    """Condition, or the values of CASE, or start and end of FOR, or start values."""
    names: tuple[str, ...] = ()
    """Labels, or names that are declared."""
    call: Call | None = None


class Block(NamedTuple):
    """What a line says, but for its number, its label and `/`."""

    codes: tuple[str, ...] = ()
    """G1, M6, TRAORI: words without a value, in their order."""
    words: tuple[Word, ...] = ()
    assignments: tuple[Assignment, ...] = ()
    calls: tuple[Call, ...] = ()
    flow: Flow | None = None
    fault: str = ""
    """Why it cannot be understood; an error when it is executed."""
    plain: bool = False
    """Whether it has nothing but codes and words with constant values."""


class Line(NamedTuple):
    """A block with the constants that stand in it."""

    block: Block
    literals: tuple[float, ...] = ()


# Flow and declarations

JUMPS = ("GOTOF", "GOTOB", "GOTO", "GOTOC")
BARE = ("ELSE", "ENDIF", "ENDFOR", "ENDWHILE", "LOOP", "ENDLOOP", "ENDLABEL", "RET", "ENDPROC", "GOTOS")
TYPES = ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS", "FRAME")
SYNCHRONOUS = ("WHEN", "WHENEVER", "FROM", "EVERY", "DO", "ID", "IDS")
"""Beginnings of synchronous actions, which are read by no one here."""
LARGEST = 100_000
"""Most elements of an array."""


def flow_block(parser: Parser) -> Flow | None:
    """The block as one of flow; None where it begins otherwise."""
    token = parser.token
    if token.kind != NAME:
        return None
    kind = token.text
    if kind in SYNCHRONOUS and (kind not in ("ID", "IDS") or parser.tokens[1].text == "="):
        parser.go_to(len(parser.tokens) - 1)
        return Flow("synchronous action")
    reading = _READERS.get(kind)
    if reading is None:
        return None
    parser.take()
    if kind == "RET" and parser.passes("(") and parser.arguments():
        raise BlockError("RET with a block to go on at, or with levels: write RET alone, and a jump behind the call")
    return reading(parser, kind)


def _bare(parser: Parser, kind: str) -> Flow:
    return Flow(kind)


def _if(parser: Parser, kind: str) -> Flow:
    condition = parser.expression()
    token = parser.token
    if token.kind == NAME and token.text in JUMPS:
        parser.take()
        return Flow(token.text, (condition,), (_label(parser),))
    if token.kind == NAME and token.text == "GOTOS":
        parser.take()
        return Flow("GOTOS", (condition,))
    return Flow("IF", (condition,))


def _condition(parser: Parser, kind: str) -> Flow:
    return Flow(kind, (parser.expression(),))


def _for(parser: Parser, kind: str) -> Flow:
    token = parser.take()
    name = token.text
    index: tuple[Compiled, ...] = ()
    if token.kind in (NAME, LETTER) and name != "R":
        pass
    elif token.kind == WORD and token.text[0] == "R" and token.text[1:].isdigit():
        name, index = "R", (constant(token.value),)
    else:
        raise BlockError("FOR needs a variable: write it like FOR I=1 TO 5, or FOR R1=1 TO 5")
    parser.need("=")
    first = parser.expression()
    if parser.take().text != "TO":
        raise BlockError("FOR lacks TO: write it like FOR I=1 TO 5")
    return Flow("FOR", (first, parser.expression(), *index), (name,))


def _label(parser: Parser) -> str:
    token = parser.take()
    if token.kind == NAME:
        return token.text
    if token.kind == WORD and token.text[0] == "N" and token.text[1:].isdigit():
        return f"N{int(token.text[1:][-9:])}"
    if token.kind == SIGN and token.text == ":" and parser.token.kind == NUMBER:
        return f":{int(parser.take().value)}"
    raise BlockError("a jump needs its target as a label or a block number: write it like GOTOF END_OF_PART")


def _jump(parser: Parser, kind: str) -> Flow:
    return Flow(kind, (), (_label(parser),))


def _case(parser: Parser, kind: str) -> Flow:
    values: list[Compiled | None] = [parser.expression()]
    labels: list[str] = []
    if parser.take().text != "OF":
        raise BlockError("CASE lacks OF: write it like CASE(R1) OF 1 GOTOF A DEFAULT GOTOF B")
    while parser.token.kind != END:
        last = parser.token.kind == NAME and parser.token.text == "DEFAULT"
        if last:
            parser.take()
            values.append(None)
        else:
            values.append(parser.expression())
        jump = parser.take().text
        if jump not in JUMPS:
            raise BlockError("each value of CASE needs its jump: write it like 1 GOTOF A")
        labels += [jump, _label(parser)]
        if last:
            break
    return Flow("CASE", tuple(values), tuple(labels))


def _repeat(parser: Parser, kind: str) -> Flow:
    """REPEAT alone opens a loop that UNTIL ends; with labels it runs a part of the program again."""
    if parser.token.kind == END:
        if kind == "REPEATB":
            raise BlockError("REPEATB needs a label: write it like REPEATB PART P=3")
        return Flow("REPEAT")
    labels = [_label(parser)]
    if parser.token.kind in (NAME, WORD) and parser.token.text != "P" and parser.token.text[0] != "P":
        labels.append(_label(parser))
    return Flow(kind + " label", (_times(parser),), tuple(labels))


def _times(parser: Parser) -> Compiled | None:
    token = parser.token
    if token.kind == LETTER and token.text == "P":
        parser.take()
        parser.need("=")
        return parser.expression()
    if token.kind == WORD and token.text[0] == "P":
        parser.take()
        return constant(token.value)
    return None


def _define(parser: Parser, kind: str) -> Flow:
    """DEF [range] type NAME[n]=value, ...: names are written as type, name, sizes."""
    while parser.token.kind == NAME and parser.token.text not in TYPES:
        parser.take()  # CHAN, SYNR, PHU: where it is stored and shown
    token = parser.take()
    if token.text not in TYPES:
        raise BlockError(f"DEF needs a type, one of {', '.join(TYPES)}: write it like DEF REAL DEPTH=5")
    if token.text == "STRING" and parser.passes("["):
        parser.enumerated("]")
    names: list[str] = [token.text]
    values: list[Compiled | None] = []
    while True:
        found = parser.take()
        if found.kind not in (NAME, LETTER):
            raise BlockError("DEF needs names that begin with two letters or _: write it like DEF REAL DEPTH=5")
        names.append(found.text)
        sizes = parser.enumerated("]") if parser.passes("[") else []
        names.append(str(len(sizes)))
        values.extend(sizes)
        values.append(_start_value(parser, bool(sizes)) if parser.passes("=") else None)
        if not parser.passes(","):
            return Flow("DEF", tuple(values), tuple(names))


def _start_value(parser: Parser, of_array: bool) -> Compiled:
    """Behind DEF NAME=, or of an array DEF NAME[3]=SET(1, 2, 3), =(1, 2, 3) or =REP(5) (Job Planning, "DEF")."""
    if of_array and parser.passes("("):
        return parser.row("SET")
    return parser.assigned()


def _procedure(parser: Parser, kind: str) -> Flow:
    """PROC NAME(REAL A, VAR INT B[3]) SAVE: names are the procedure's, then type and name of each parameter.

    The type of a parameter that is handed over by reference begins with `VAR`.
    """
    names = [parser.take().text]
    values: list[Compiled | None] = []
    if parser.passes("(") and not parser.passes(")"):
        while True:
            token = parser.take()
            reference = token.text == "VAR"
            token = parser.take() if reference else token
            if token.text not in TYPES:
                raise BlockError("each parameter of PROC needs its type: write it like PROC POCKET(REAL DEPTH)")
            if token.text == "STRING" and parser.passes("["):
                parser.enumerated("]")
            names += [f"VAR {token.text}" if reference else token.text, parser.take().text]
            _sizes(parser)
            values.append(parser.expression() if parser.passes("=") else None)
            if parser.passes(")"):
                break
            parser.need(",")
    attributes = []
    while parser.token.kind != END:
        attributes.append(parser.take().text)
    return Flow("PROC", tuple(values), (*names, *(["SAVE"] if "SAVE" in attributes else [])))


def _sizes(parser: Parser) -> None:
    """Go past [n] or [,n] of a parameter that is an array: its sizes are those of what is handed over."""
    if parser.passes("["):
        while not parser.passes("]"):
            if parser.take().kind == END:
                raise BlockError("a parameter lacks ] behind its size: write it like PROC SUM(VAR REAL VALUES[3])")


def _passed(parser: Parser, kind: str) -> Flow:
    parser.go_to(len(parser.tokens) - 1)
    return Flow(kind)


def _call(parser: Parser, kind: str) -> Flow:
    """CALL "NAME", EXTCALL("NAME"), CALL BLOCK A TO B, MCALL NAME(...), MCALL alone."""
    bracket = kind == "EXTCALL" and parser.passes("(")
    token = parser.take()
    if token.kind == END and kind == "MCALL":
        return Flow("MCALL")
    if kind == "CALL" and token.kind == NAME and token.text == "BLOCK":
        labels = [_label(parser)]
        if parser.take().text != "TO":
            raise BlockError("CALL BLOCK lacks TO: write it like CALL BLOCK A TO B")
        return Flow("CALL BLOCK", (None,), (*labels, _label(parser)))
    if token.kind == TEXT:
        if bracket:
            parser.need(")")
        return Flow(kind, (), (), Call(token.text.upper()))
    if token.kind == NAME or (token.kind == WORD and token.text[0] == "L"):
        bracketed = parser.passes("(")
        arguments = tuple(parser.arguments()) if bracketed else ()
        return Flow(kind, (), (), Call(token.text, arguments, bracketed, _times(parser)))
    raise BlockError(f"{kind} needs the name of a subprogram: write it")


_READERS = {
    **dict.fromkeys(BARE, _bare),
    **dict.fromkeys(JUMPS, _jump),
    "IF": _if,
    "WHILE": _condition,
    "UNTIL": _condition,
    "FOR": _for,
    "CASE": _case,
    "REPEAT": _repeat,
    "REPEATB": _repeat,
    "DEF": _define,
    "PROC": _procedure,
    "EXTERN": _passed,
    "CALL": _call,
    "MCALL": _call,
    "EXTCALL": _call,
}
