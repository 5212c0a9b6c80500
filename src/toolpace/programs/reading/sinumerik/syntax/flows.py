"""Blocks of flow and declaration: IF, FOR, GOTOF, CASE, REPEAT, DEF, PROC, CALL, MCALL."""

from __future__ import annotations

from toolpace.programs.reading.sinumerik.syntax.blocks import Call, Flow
from toolpace.programs.reading.sinumerik.syntax.expressions import Parser, constant
from toolpace.programs.reading.sinumerik.syntax.lexer import END, LETTER, NAME, NUMBER, SIGN, TEXT, WORD, SyntaxFault
from toolpace.programs.reading.sinumerik.syntax.values import Compiled

JUMPS = ("GOTOF", "GOTOB", "GOTO", "GOTOC")
BARE = ("ELSE", "ENDIF", "ENDFOR", "ENDWHILE", "LOOP", "ENDLOOP", "ENDLABEL", "RET", "ENDPROC", "GOTOS")
TYPES = ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS", "FRAME")
SYNCHRONOUS = ("WHEN", "WHENEVER", "FROM", "EVERY", "DO", "ID", "IDS")
"""Beginnings of synchronous actions, which are read by no one here."""
LARGEST = 100_000
"""Most elements of an array."""


def read(parser: Parser) -> Flow | None:
    """The block as one of flow; None where it begins otherwise."""
    token = parser.token
    if token.kind != NAME:
        return None
    kind = token.text
    if kind in SYNCHRONOUS and (kind not in ("ID", "IDS") or parser.tokens[1].text == "="):
        parser.at = len(parser.tokens) - 1
        return Flow("synchronous action")
    reading = _READERS.get(kind)
    if reading is None:
        return None
    parser.take()
    if kind == "RET" and parser.sign("(") and parser.arguments():
        raise SyntaxFault("RET with a block to go on at, or with levels: write RET alone, and a jump behind the call")
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
        raise SyntaxFault("FOR needs a variable: write it like FOR I=1 TO 5, or FOR R1=1 TO 5")
    parser.need("=")
    first = parser.expression()
    if parser.take().text != "TO":
        raise SyntaxFault("FOR lacks TO: write it like FOR I=1 TO 5")
    return Flow("FOR", (first, parser.expression(), *index), (name,))


def _label(parser: Parser) -> str:
    token = parser.take()
    if token.kind == NAME:
        return token.text
    if token.kind == WORD and token.text[0] == "N" and token.text[1:].isdigit():
        return f"N{int(token.text[1:][-9:])}"
    if token.kind == SIGN and token.text == ":" and parser.token.kind == NUMBER:
        return f":{int(parser.take().value)}"
    raise SyntaxFault("a jump needs its target as a label or a block number: write it like GOTOF END_OF_PART")


def _jump(parser: Parser, kind: str) -> Flow:
    return Flow(kind, (), (_label(parser),))


def _case(parser: Parser, kind: str) -> Flow:
    values: list[Compiled | None] = [parser.expression()]
    labels: list[str] = []
    if parser.take().text != "OF":
        raise SyntaxFault("CASE lacks OF: write it like CASE(R1) OF 1 GOTOF A DEFAULT GOTOF B")
    while parser.token.kind != END:
        last = parser.token.kind == NAME and parser.token.text == "DEFAULT"
        if last:
            parser.take()
            values.append(None)
        else:
            values.append(parser.expression())
        jump = parser.take().text
        if jump not in JUMPS:
            raise SyntaxFault("each value of CASE needs its jump: write it like 1 GOTOF A")
        labels += [jump, _label(parser)]
        if last:
            break
    return Flow("CASE", tuple(values), tuple(labels))


def _repeat(parser: Parser, kind: str) -> Flow:
    """REPEAT alone opens a loop that UNTIL ends; with labels it runs a part of the program again."""
    if parser.token.kind == END:
        if kind == "REPEATB":
            raise SyntaxFault("REPEATB needs a label: write it like REPEATB PART P=3")
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
        raise SyntaxFault(f"DEF needs a type, one of {', '.join(TYPES)}: write it like DEF REAL DEPTH=5")
    if token.text == "STRING" and parser.sign("["):
        parser.index()
    names: list[str] = [token.text]
    values: list[Compiled | None] = []
    while True:
        found = parser.take()
        if found.kind not in (NAME, LETTER):
            raise SyntaxFault("DEF needs names that begin with two letters or _: write it like DEF REAL DEPTH=5")
        names.append(found.text)
        sizes = parser.index() if parser.sign("[") else []
        names.append(str(len(sizes)))
        values.extend(sizes)
        values.append(_start_value(parser, bool(sizes)) if parser.sign("=") else None)
        if not parser.sign(","):
            return Flow("DEF", tuple(values), tuple(names))


def _start_value(parser: Parser, of_array: bool) -> Compiled:
    """Behind DEF NAME=, or of an array DEF NAME[3]=SET(1, 2, 3), =(1, 2, 3) or =REP(5) (Job Planning, "DEF")."""
    if of_array and parser.sign("("):
        return parser.row("SET")
    return parser.assigned()


def _procedure(parser: Parser, kind: str) -> Flow:
    """PROC NAME(REAL A, VAR INT B[3]) SAVE: names are the procedure's, then type and name of each parameter.

    The type of a parameter that is handed over by reference begins with `VAR`.
    """
    names = [parser.take().text]
    values: list[Compiled | None] = []
    if parser.sign("(") and not parser.sign(")"):
        while True:
            token = parser.take()
            reference = token.text == "VAR"
            token = parser.take() if reference else token
            if token.text not in TYPES:
                raise SyntaxFault("each parameter of PROC needs its type: write it like PROC POCKET(REAL DEPTH)")
            if token.text == "STRING" and parser.sign("["):
                parser.index()
            names += [f"VAR {token.text}" if reference else token.text, parser.take().text]
            _sizes(parser)
            values.append(parser.expression() if parser.sign("=") else None)
            if parser.sign(")"):
                break
            parser.need(",")
    attributes = []
    while parser.token.kind != END:
        attributes.append(parser.take().text)
    return Flow("PROC", tuple(values), (*names, *(["SAVE"] if "SAVE" in attributes else [])))


def _sizes(parser: Parser) -> None:
    """Go past [n] or [,n] of a parameter that is an array: its sizes are those of what is handed over."""
    if parser.sign("["):
        while not parser.sign("]"):
            if parser.take().kind == END:
                raise SyntaxFault("a parameter lacks ] behind its size: write it like PROC SUM(VAR REAL VALUES[3])")


def _passed(parser: Parser, kind: str) -> Flow:
    parser.at = len(parser.tokens) - 1
    return Flow(kind)


def _call(parser: Parser, kind: str) -> Flow:
    """CALL "NAME", EXTCALL("NAME"), CALL BLOCK A TO B, MCALL NAME(...), MCALL alone."""
    bracket = kind == "EXTCALL" and parser.sign("(")
    token = parser.take()
    if token.kind == END and kind == "MCALL":
        return Flow("MCALL")
    if kind == "CALL" and token.kind == NAME and token.text == "BLOCK":
        labels = [_label(parser)]
        if parser.take().text != "TO":
            raise SyntaxFault("CALL BLOCK lacks TO: write it like CALL BLOCK A TO B")
        return Flow("CALL BLOCK", (None,), (*labels, _label(parser)))
    if token.kind == TEXT:
        if bracket:
            parser.need(")")
        return Flow(kind, (), (), Call(token.text.upper()))
    if token.kind == NAME or (token.kind == WORD and token.text[0] == "L"):
        bracketed = parser.sign("(")
        arguments = tuple(parser.arguments()) if bracketed else ()
        return Flow(kind, (), (), Call(token.text, arguments, bracketed, _times(parser)))
    raise SyntaxFault(f"{kind} needs the name of a subprogram: write it")


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
