"""Arguments of calls, by value or by reference."""

from __future__ import annotations

from toolpace.programs.reading.language.expressions import BlockError
from toolpace.programs.reading.sinumerik.flow.memory import Store, Variable
from toolpace.programs.reading.sinumerik.syntax.blocks import Call
from toolpace.programs.reading.sinumerik.syntax.expressions import Named
from toolpace.programs.reading.sinumerik.syntax.values import Value


def values_of(call: Call, memory: Store, *, arrays: bool) -> list[Value | None]:
    """Values of the arguments of a call, None for each that is left out.

    arrays: whole arrays, which only subprograms take, are None too: they are handed over by name.
    """
    found: list[Value | None] = []
    for argument in call.arguments:
        variable = memory.local.get(argument.name) if arrays and isinstance(argument, Named) else None
        whole_array = variable is not None and bool(variable.sizes)
        found.append(None if argument is None or whole_array else argument(memory))
    return found


def referred(handed: Variable | None, kind: str, name: str) -> Variable:
    """The variable that a parameter of VAR stands for (Programming Manual Job Planning, "Call by reference").

    Raises BlockError where something else is handed over, or one of another type.
    """
    if handed is None:
        raise BlockError(f"{name} is a parameter of VAR: hand over a variable of DEF, and no value or expression")
    if handed.kind != kind:
        raise BlockError(f"{name} is of type {kind} and stands for a variable of type {handed.kind}: correct one")
    return handed
