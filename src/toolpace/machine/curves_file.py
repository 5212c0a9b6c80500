"""Limits over speed in a machine file: what is written in place of a number, and how.

    acceleration = [[0, 5000], [300, 5000], [500, 2000]]                              for all motion
    acceleration = { speeding_up = [[0, 5000], [500, 2000]], braking = 6000 }         with the motion, and against it
    acceleration = { upwards = [[0, 4000], [500, 1000]], downwards = 5000 }           with a weight
    jerk = [[0, 50000], [500, 20000]]
    torque = [[0, 60], [300, 60], [500, 20]]                                          a motor's, in N m over speed
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.limit_curves import SIDES, CurvedLimit, LimitCurve
from toolpace.machine.limits import MOTORS

KEYS = {keys: sides for sides, keys in SIDES.items() if len(keys) > 1}
"""What the keys of a table are for."""
EXAMPLE = "give a number, or corners like [[0, 5000], [300, 5000], [500, 2000]]"


def curved_limits(
    raw: object, joint: str, scales: tuple[float, float], place: str
) -> tuple[object, list[CurvedLimit]]:
    """The table of a joint with a number in place of each curve, its least value, and the curves [m or rad, s].

    `scales` are the file's units of length and angle [m, rad]; `place` begins a message. Raises MachineError.
    """
    if not isinstance(raw, dict):
        return raw, []
    scale, curves, plain = scales[1 if raw.get("kind") == "rotary" else 0], [], dict(raw)
    for kind in ("acceleration", "jerk"):
        value = raw.get(kind)
        if not isinstance(value, list | dict):
            continue
        try:
            curves.append(_curved(value, joint, kind, scale))
        except UsageError as error:
            raise MachineError(f"{place}: {error}") from None
        plain[kind] = curves[-1].least / scale
    return plain, curves


def motor_curve(raw: object, scales: tuple[float, float], place: str) -> tuple[object, LimitCurve | None]:
    """The table of a joint with the least value in place of a motor's curve, and the curve [m/s and N, rad/s and N m].

    As `curved_limits`; None where the motor's limit is a number, or there is none. Raises MachineError.
    """
    if not isinstance(raw, dict):
        return raw, None
    rotary = raw.get("kind") == "rotary"
    key = MOTORS[rotary]
    if not isinstance(raw.get(key), list | dict):
        return raw, None
    try:
        curve = _curve(raw[key], key, scales[rotary], 1.0)
    except UsageError as error:
        raise MachineError(f"{place}: {error}") from None
    return {**raw, key: curve.least}, curve if len(curve.speed) > 1 else None


def _curved(value: list[object] | dict[str, object], joint: str, kind: str, scale: float) -> CurvedLimit:
    if isinstance(value, list):
        return CurvedLimit(joint, kind, (_curve(value, kind, scale),))
    for keys, sides in KEYS.items():
        if set(value) == set(keys):
            if kind == "jerk":
                raise UsageError("jerk has one curve for all motion; " + EXAMPLE)
            return CurvedLimit(joint, kind, tuple(_curve(value[key], f"{kind} {key}", scale) for key in keys), sides)
    pairs = ", or ".join(f"both {first} and {last}" for first, last in KEYS)
    raise UsageError(f"{kind} has the keys {', '.join(map(repr, value))}; give {pairs}"[:300])


def _curve(value: object, name: str, scale: float, of_limit: float | None = None) -> LimitCurve:
    """A curve of corners in the units of the file, or of one number; `of_limit` where the limit has another unit than
    the speed."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        raise UsageError(f"{name} is {value!r:.40}; {EXAMPLE}")
    corners = value if isinstance(value, list) else [[0.0, value]]
    if not all(isinstance(each, list) and len(each) == 2 for each in corners) or not corners:
        raise UsageError(f"{name} = {value!r:.60} has no corners of [speed, limit]; {EXAMPLE}")
    figures = [figure for corner in corners for figure in corner]
    if not all(isinstance(figure, int | float) and not isinstance(figure, bool) for figure in figures):
        raise UsageError(f"{name} = {value!r:.60} has something else than numbers in it; {EXAMPLE}")
    LimitCurve(corners, name)  # told in the units of the file
    of_limit = scale if of_limit is None else of_limit
    return LimitCurve([[speed * scale, limit * of_limit] for speed, limit in corners], name)


def check_speeds(curves: Sequence[CurvedLimit], velocity: float, place: str, unit: tuple[str, float]) -> None:
    """Refuse corners beyond the velocity limit of the joint [m/s or rad/s]; `unit` is the file's, and its size."""
    for limit in curves:
        for curve in limit.curves:
            if curve.speed[-1] > velocity * (1.0 + 1e-9):
                name, size = unit
                raise MachineError(
                    f"{place}: {limit.kind} goes on to speed {curve.speed[-1] / size:g} {name}/s, beyond velocity = "
                    f"{velocity / size:g}; end it there"
                )


def curve_text(limit: CurvedLimit, figure: Callable[[float], str]) -> str:
    """What is written for a curve, as it is read above; `figure` writes one in the file's unit."""
    sides = [corners_text(curve, figure, figure) for curve in limit.curves]
    if len(sides) == 1:
        return sides[0]
    return "{ " + ", ".join(f"{key} = {text}" for key, text in zip(SIDES[limit.sides], sides)) + " }"


def corners_text(curve: LimitCurve, speed_text: Callable[[float], str], limit_text: Callable[[float], str]) -> str:
    """What is written for one curve; the functions write a speed and a limit in the file's units."""
    if len(curve.speed) == 1:
        return limit_text(curve.least)
    corners = zip(curve.speed.tolist(), curve.limit.tolist())
    return "[" + ", ".join(f"[{speed_text(speed)}, {limit_text(limit)}]" for speed, limit in corners) + "]"


def figures_of(curves: Sequence[CurvedLimit]) -> Iterator[float]:
    """Every speed and limit of curves."""
    for limit in curves:
        for curve in limit.curves:
            yield from curve.speed.tolist()
            yield from curve.limit.tolist()
