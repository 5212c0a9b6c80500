"""Operators and functions of expressions, with their binding powers."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from toolpace.programs.reading.gcode.program.words import WordError

_COMPARED: dict[str, Callable[[float, float], float]] = {
    "EQ": lambda a, b: float(a == b),
    "NE": lambda a, b: float(a != b),
    "GT": lambda a, b: float(a > b),
    "GE": lambda a, b: float(a >= b),
    "LT": lambda a, b: float(a < b),
    "LE": lambda a, b: float(a <= b),
}


def _bits(operation: Callable[[int, int], int]) -> Callable[[float, float], float]:
    return lambda a, b: float(operation(round(a), round(b)))


def _divided(a: float, b: float) -> float:
    if b == 0.0:
        raise WordError("division by zero: check the expression and its variables")
    return a / b


def _power(a: float, b: float) -> float:
    try:
        result = math.pow(a, b)
    except (ValueError, OverflowError):
        raise WordError(f"{a:g} to the power of {b:g} is no number: check the expression") from None
    return result


def _modulo(a: float, b: float) -> float:
    return a - b * math.floor(_divided(a, b))


OPERATIONS: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "**": (6, _power),
    "*": (5, lambda a, b: a * b),
    "/": (5, _divided),
    "MOD": (5, _modulo),
    "+": (4, lambda a, b: a + b),
    "-": (4, lambda a, b: a - b),
    **{name: (3, function) for name, function in _COMPARED.items()},
}


def _never_negative(a: float, b: float) -> float:
    if b == 0.0:
        raise WordError("a remainder of a division by zero: check the expression and its variables")
    rest = math.fmod(a, b)
    return rest if rest >= 0.0 else rest + abs(b)


TRUTH: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "MOD": (5, _never_negative),
    "AND": (2, lambda a, b: float(a != 0.0 and b != 0.0)),
    "OR": (2, lambda a, b: float(a != 0.0 or b != 0.0)),
    "XOR": (2, lambda a, b: float((a != 0.0) != (b != 0.0))),
}


def _sure_remainder(a: float, b: float) -> float:
    if a < 0.0 or b <= 0.0 or a != int(a) or b != int(b):
        raise WordError(
            f"{a:g} MOD {b:g}: controls differ in the remainder of what is below zero or not whole; write the value out"
        )
    return math.fmod(a, b)


def _remainder_of_whole(a: float, b: float) -> float:
    """Of both rounded to whole numbers, with the sign of the first (B-64304EN, "Arithmetic and logic operation")."""
    whole = _half_away(b)
    if whole == 0.0:
        raise WordError("a remainder of a division by zero: check the expression and its variables")
    return math.fmod(_half_away(a), whole)


WHOLE_REMAINDER = {"MOD": (5, _remainder_of_whole)}
BITS: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "MOD": (5, _sure_remainder),
    "AND": (5, _bits(lambda a, b: a & b)),
    "OR": (4, _bits(lambda a, b: a | b)),
    "XOR": (4, _bits(lambda a, b: a ^ b)),
}


def _checked(name: str, function: Callable[[float], float]) -> Callable[[float], float]:
    def applied(value: float) -> float:
        try:
            return function(value)
        except (ValueError, OverflowError):
            raise WordError(f"{name} of {value:g} is no number: check the expression and its variables") from None

    return applied


def _absolute(value: float) -> float:
    return abs(value)


def _half_away(value: float) -> float:
    return math.copysign(math.floor(abs(value) + 0.5), value)


_PLAIN: dict[str, Callable[[float], float]] = {
    "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)),
    "TAN": lambda a: math.tan(math.radians(a)),
    "ASIN": lambda a: math.degrees(math.asin(a)),
    "ACOS": lambda a: math.degrees(math.acos(a)),
    "SQRT": math.sqrt,
    "SQR": math.sqrt,
    "ABS": _absolute,
    "LN": math.log,
    "EXP": math.exp,
    "FIX": math.floor,
    "FUP": math.ceil,
    "ROUND": _half_away,
}
FUNCTIONS = {name: _checked(name, function) for name, function in _PLAIN.items()}
"""Of angles in degrees."""
_PI = np.longdouble("3.14159265358979323846264338327950288")


def _of_degrees(function: Callable[[np.longdouble], np.longdouble]) -> Callable[[float], float]:
    return lambda value: float(function(np.longdouble(value) * _PI / 180))


def long_degrees(angle: float) -> float:
    """An angle [rad] in degrees, as LinuxCNC's interpreter reckons it."""
    return float(np.longdouble(angle * 180.0) / _PI)


def _round_of_integers(value: float) -> float:
    if abs(value) >= 2.0**31:
        raise WordError(f"ROUND of {value:g} is beyond what LinuxCNC's interpreter can round: check the expression")
    return _half_away(value)


LONG: dict[str, Callable[[float], float]] = {
    "SIN": _checked("SIN", _of_degrees(np.sin)),
    "COS": _checked("COS", _of_degrees(np.cos)),
    "TAN": _checked("TAN", _of_degrees(np.tan)),
    "ASIN": _checked("ASIN", lambda a: long_degrees(math.asin(a))),
    "ROUND": _round_of_integers,
    "ACOS": _checked("ACOS", lambda a: long_degrees(math.acos(a))),
}
"""As LinuxCNC's interpreter reckons them, with its long number pi: the cosine of 90 degrees has another sign."""
TOWARDS_ZERO: dict[str, Callable[[float], float]] = {
    "FIX": _checked("FIX", math.trunc),
    "FUP": _checked("FUP", lambda a: math.copysign(math.ceil(abs(a)), a)),
}
"""Fanuc cuts towards zero and away from it; LinuxCNC goes down and up."""
