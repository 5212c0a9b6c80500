"""Limits over speed in a machine file: what is written in place of a number, and how.

    acceleration = [[0, 5000], [300, 5000], [500, 2000]]                              for all motion
    acceleration = { speeding_up = [[0, 5000], [500, 2000]], braking = 6000 }         with the motion, and against it
    acceleration = { upwards = [[0, 4000], [500, 1000]], downwards = 5000 }           with a weight
    jerk = [[0, 50000], [500, 20000]]
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.limit_curves import SIDES, CurvedLimit, LimitCurve

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


def _curve(value: object, name: str, scale: float) -> LimitCurve:
    """A curve of corners in the units of the file, or of one number."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        raise UsageError(f"{name} is {value!r:.40}; {EXAMPLE}")
    corners = value if isinstance(value, list) else [[0.0, value]]
    if not all(isinstance(each, list) and len(each) == 2 for each in corners) or not corners:
        raise UsageError(f"{name} = {value!r:.60} has no corners of [speed, limit]; {EXAMPLE}")
    figures = [figure for corner in corners for figure in corner]
    if not all(isinstance(figure, int | float) and not isinstance(figure, bool) for figure in figures):
        raise UsageError(f"{name} = {value!r:.60} has something else than numbers in it; {EXAMPLE}")
    LimitCurve(corners, name)  # told in the units of the file
    return LimitCurve([[speed * scale, limit * scale] for speed, limit in corners], name)


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
    sides = [_corners_text(curve, figure) for curve in limit.curves]
    if len(sides) == 1:
        return sides[0]
    return "{ " + ", ".join(f"{key} = {text}" for key, text in zip(SIDES[limit.sides], sides)) + " }"


def _corners_text(curve: LimitCurve, figure: Callable[[float], str]) -> str:
    if len(curve.speed) == 1:
        return figure(curve.least)
    corners = zip(curve.speed.tolist(), curve.limit.tolist())
    return "[" + ", ".join(f"[{figure(speed)}, {figure(limit)}]" for speed, limit in corners) + "]"


def figures_of(curves: Sequence[CurvedLimit]) -> Iterator[float]:
    """Every speed and limit of curves."""
    for limit in curves:
        for curve in limit.curves:
            yield from curve.speed.tolist()
            yield from curve.limit.tolist()
