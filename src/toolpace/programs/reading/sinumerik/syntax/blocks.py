"""Parsed blocks, compiled once."""

from __future__ import annotations

from typing import NamedTuple

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
