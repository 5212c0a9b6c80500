"""Conversion between the units that people write (mm, inch, degree, mm/min) and SI."""

from __future__ import annotations

import math
import re
import warnings

from toolpace.common.errors import UnitWarning, UsageError

MILLIMETRE = 1e-3
INCH = 0.0254
DEGREE = math.pi / 180
MINUTE = 60.0

LENGTHS = {
    "um": 1e-6,
    "µm": 1e-6,
    "μm": 1e-6,
    "mm": MILLIMETRE,
    "cm": 1e-2,
    "m": 1.0,
    "in": INCH,
    "inch": INCH,
}
ANGLES = {"deg": DEGREE, "°": DEGREE, "rad": 1.0, "mrad": 1e-3}
TIMES = {"us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ms": 1e-3, "s": 1.0, "min": MINUTE, "h": 3600.0}
FEEDS = {
    "mm/min": MILLIMETRE / MINUTE,
    "m/min": 1.0 / MINUTE,
    "in/min": INCH / MINUTE,
    "ipm": INCH / MINUTE,
    "mm/s": MILLIMETRE,
    "in/s": INCH,
    "m/s": 1.0,
}
PRESSURES = {"MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6, "N/mm^2": 1e6, "N/mm²": 1e6, "kN/mm2": 1e9, "Pa": 1.0}
EDGE_FORCES = {"N/mm": 1e3, "N/m": 1.0, "kN/m": 1e3}
STIFFNESSES = {"N/um": 1e6, "N/µm": 1e6, "N/μm": 1e6, "N/mm": 1e3, "N/m": 1.0, "kN/mm": 1e6}
SPINDLE_SPEEDS = {"rpm": 1.0 / MINUTE, "1/min": 1.0 / MINUTE, "rev/min": 1.0 / MINUTE, "1/s": 1.0}



def _per_power(lengths: dict[str, float], power: int) -> dict[str, float]:
    """Units over seconds to a power, in the ways in which people write them: mm/s2, mm/s^2, mm/s²."""
    raised = {2: ("2", "^2", "²"), 3: ("3", "^3", "³")}[power]
    return {f"{name}/s{each}": factor for name, factor in lengths.items() for each in raised}


_LONG = {"m": 1.0, "mm": MILLIMETRE, "in": INCH}
_TURN = {"deg": DEGREE, "rad": 1.0, "rev": 2.0 * math.pi}
_OF_LINEAR = {
    "velocity": FEEDS,
    "acceleration": _per_power(_LONG, 2) | {"g": 9.80665},
    "jerk": _per_power(_LONG, 3) | {"g/s": 9.80665},
}
_OF_ROTARY = {
    "velocity": {"rpm": _TURN["rev"] / MINUTE, "rev/min": _TURN["rev"] / MINUTE, "1/min": _TURN["rev"] / MINUTE}
    | {"deg/s": DEGREE, "°/s": DEGREE, "rad/s": 1.0, "rev/s": _TURN["rev"], "deg/min": DEGREE / MINUTE},
    "acceleration": _per_power(_TURN, 2),
    "jerk": _per_power(_TURN, 3),
}
JOINT_LIMITS = {"linear": _OF_LINEAR, "rotary": _OF_ROTARY}
"""Units of the limits of a joint, by its kind."""
_EXAMPLES = {
    "linear": {"velocity": "42 m/min", "acceleration": "6 m/s2", "jerk": "60 m/s3"},
    "rotary": {"velocity": "90 deg/s", "acceleration": "600 deg/s2", "jerk": "6000 deg/s3"},
}

_QUANTITY = re.compile(r"\s*+([-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[eE][-+]?[0-9]++)?)\s*+(\S*+)\s*+")
_SHOWN = 40
"""Most characters of a text that a message shows."""


METRES = "give metres: 120 mm is 0.12"
RADIANS = "give radians: 90 deg is 1.571"
METRES_PER_SECOND = "give m/s: 3000 mm/min is 0.05"
SECONDS = "give seconds: 1 ms is 1e-3"
LONGEST_TOOL = 4.0
"""Of a tool from the spindle nose to its tip [m]: more is a length in mm."""
WIDEST_TOOL = 0.5
"""Diameter of a tool, and depth of a cut [m]."""
FARTHEST_PART = 30.0
"""From the machine's zero [m]: the longest gantries have less."""
FASTEST_FEED = 300.0
"""[m/s]: a hundred times what machine tools cut at; programs ask for as fast as can be by large figures."""


def refuse_other_unit(value: float, most: float, name: str, cure: str) -> None:
    """Raise UsageError for a figure beyond any that there is, which was meant in another unit; nan and inf pass."""
    if most < abs(value) < math.inf:
        raise UsageError(f"{name} is {value:g}, beyond {most:g}; {cure}")


def ask_about_unit(value: float, most: float, name: str, cure: str) -> None:
    """Warn (UnitWarning) of a figure that can hardly be meant."""
    if most < abs(value) < math.inf:
        warnings.warn(f"{name} is {value:g}, more than the usual {most:g}; is it right? Else {cure}", UnitWarning, 3)


def parse_length(text: str) -> float:
    """Length [m] of text such as `0.01mm`, `10um`, `0.5in`; UsageError where it is none, or negative."""
    return _parse(text, LENGTHS, "length", "0.01mm")


def parse_angle(text: str) -> float:
    """Angle [rad] of text such as `0.05deg`, `1e-3rad`; UsageError where it is none, or negative."""
    return _parse(text, ANGLES, "angle", "0.05deg")


def parse_time(text: str) -> float:
    """Time [s] of text such as `1ms`; UsageError where it is none, zero or negative."""
    return _parse(text, TIMES, "time", "1ms", positive=True)


def parse_feed(text: str) -> float:
    """Feed [m/s] of text such as `3000mm/min`, `50mm/s`; UsageError where it is none, zero or negative."""
    return _parse(text, FEEDS, "feed", "3000mm/min", positive=True)


def parse_joint_limit(text: str, kind: str, limit: str) -> float:
    """Velocity, acceleration or jerk of a joint of a kind [m or rad, s] of text such as `42 m/min`, `10 rpm`, `6 m/s2`.

    UsageError where it is none, zero or negative.
    """
    return _parse(text, JOINT_LIMITS[kind][limit], f"{limit} of a {kind} joint", _EXAMPLES[kind][limit], positive=True)


def parse_percent(text: str) -> float:
    """Factor of text such as `120%`; UsageError where it is none, or not above zero."""
    return _parse(text, {"%": 0.01}, "factor", "120%", positive=True)


def parse_pressure(text: str) -> float:
    """Pressure or modulus [Pa] of text such as `1800MPa`, `580GPa`, `1800N/mm2`; UsageError where it is none."""
    return _parse(text, PRESSURES, "pressure", "1800MPa")


def parse_edge_force(text: str) -> float:
    """Force per length of an edge [N/m] of text such as `25N/mm`; UsageError where it is none, or negative."""
    return _parse(text, EDGE_FORCES, "force per length", "25N/mm")


def parse_stiffness(text: str) -> float:
    """Stiffness [N/m] of text such as `12N/um`; UsageError where it is none, zero or negative."""
    return _parse(text, STIFFNESSES, "stiffness", "12N/um", positive=True)


def parse_power(text: str) -> float:
    """Power [W] of text such as `15kW`; UsageError where it is none, zero or negative."""
    return _parse(text, {"kW": 1e3, "W": 1.0}, "power", "15kW", positive=True)


def parse_spindle_speed(text: str) -> float:
    """Turns of a spindle per second [1/s] of text such as `18000rpm`; UsageError where it is none."""
    return _parse(text, SPINDLE_SPEEDS, "spindle speed", "18000rpm", positive=True)


def _parse(text: str, units: dict[str, float], quantity: str, example: str, *, positive: bool = False) -> float:
    match = _QUANTITY.fullmatch(text)
    text = text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
    if match is None:
        raise UsageError(f"'{text}' is not a {quantity}: write a number and a unit, like {example}")
    number, unit = float(match[1]), match[2].lower()
    factors = {name.lower(): factor for name, factor in units.items()}
    names = ", ".join(name for name in units if name.isascii())
    if not unit:
        raise UsageError(f"{quantity} '{text}' has no unit: write it like {example} (units: {names})")
    if unit not in factors:
        raise UsageError(f"'{match[2][:_SHOWN]}' is not a unit of {quantity}: use one of {names}, like {example}")
    value = number * factors[unit]
    if not math.isfinite(value) or value < 0 or (positive and value == 0):
        bound = "above zero" if positive else "zero or more"
        why = "is negative" if value < 0 else "is zero" if value == 0 else "is not finite"
        raise UsageError(f"{quantity} '{text}' {why}, and must be {bound} and finite, like {example}")
    return value


def format_length(metres: float) -> str:
    """Length for people: micrometres below a hundredth of a millimetre, else millimetres."""
    if 0 < abs(metres) < 0.9995e-5:
        return f"{metres * 1e6:.3g} µm"
    return f"{_plain(metres / MILLIMETRE, 4)} mm"


def format_angle(radians: float) -> str:
    """Angle for people, in degrees."""
    return f"{_plain(radians / DEGREE, 4)} deg"


def format_figure(value: float) -> str:
    """A number for people: three figures, and all before the decimal point."""
    return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"


def format_time(seconds: float) -> str:
    """Time for people: `12.3 ms`, `3.61 s`, `17 min 58.7 s`, `1 h 02 min 03 s`."""
    if not math.isfinite(seconds):
        return str(seconds)
    if seconds < 0:
        return "-" + format_time(-seconds)
    if seconds < 0.9995:
        return f"{seconds * 1e3:.3g} ms"
    if seconds < 59.995:
        return f"{seconds:.2f} s"
    if seconds < 3599.95:
        tenths = round(seconds * 10)
        return f"{tenths // 600} min {tenths % 600 / 10:04.1f} s"
    whole = round(seconds)
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min {whole % 60:02d} s"


def _plain(value: float, decimals: int) -> str:
    """Fixed point without trailing zeros; four figures where fixed point would show none of the value."""
    if value != 0 and abs(value) < 10.0**-decimals:
        return f"{value:.3g}"
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
