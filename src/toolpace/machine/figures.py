"""What names and figures of a machine may be: within these bounds no sum overflows, and all can be printed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from toolpace.errors import MachineError, printable

FARTHEST = 1e3
"""Most of a coordinate of a machine [m]: a kilometre is a slip of units."""
LARGEST = 1e6
"""Most of a travel that is not endless [m or rad], and of an entry of a direction."""
SLOWEST, FASTEST = 1e-9, 1e12
"""Between which the limits of a joint lie [m or rad per s, s^2, s^3]; or they are infinite."""
LONGEST_NAME, LONGEST_NOTE = 64, 1000
"""Most characters."""


class Chain(Protocol):
    """What is looked at of a chain."""

    @property
    def tool_length(self) -> float: ...


class Joint(Protocol):
    """What is looked at of a joint."""

    @property
    def kind(self) -> str: ...
    @property
    def direction(self) -> tuple[float, float, float]: ...
    @property
    def travel(self) -> tuple[float, float] | None: ...
    @property
    def wrap(self) -> bool: ...


def check_name(name: str, what: str, source: str, longest: int = LONGEST_NAME) -> None:
    """Refuse a name that is empty, too long, or would move a terminal's cursor."""
    if not name.strip():
        raise MachineError(f"{source}: {what} is empty; give it a name")
    check_text(name, what, source, longest)


def check_text(text: str, what: str, source: str, longest: int) -> None:
    """Refuse a text that is too long, or has characters that cannot be printed."""
    if len(text) > longest:
        raise MachineError(f"{source}: {what} '{text[:20]}...' has {len(text)} characters; give at most {longest}")
    if not text.isprintable():
        raise MachineError(f"{source}: {what} '{printable(text)}' has characters that cannot be printed; remove them")


def check_chain(chain: Chain, source: str) -> None:
    """Refuse places that are nowhere near a machine, and directions that are none."""
    for key in ("spindle_nose", "workpiece_origin"):
        check_place(getattr(chain, key), f"[chain] {key}", source)
    for key in ("workpiece_x", "workpiece_z", "tool_axis"):
        check_direction(getattr(chain, key), f"[chain] {key}", source)
    if not abs(chain.tool_length) <= FARTHEST:
        raise MachineError(
            f"{source}: [chain] tool_length is {chain.tool_length:g} m; give a finite number, at most {FARTHEST:g} m"
        )


def check_place(point: Sequence[float], what: str, source: str) -> None:
    """Refuse a point [m] that is not finite, or too far away."""
    if not all(abs(figure) <= FARTHEST for figure in point):
        raise MachineError(
            f"{source}: {what} = {list(point)} m; give three finite numbers, none beyond {FARTHEST:g} m, in the units "
            "of the file"
        )


def check_direction(vector: Sequence[float], what: str, source: str) -> None:
    """Refuse a vector without a direction."""
    if not all(abs(figure) <= LARGEST for figure in vector) or not math.hypot(*vector) > 1e-9:
        raise MachineError(f"{source}: {what} = {list(vector)} is no direction; give e.g. [0, 0, 1]")


def check_joint(joint: Joint, place: str, unit: str, scale: float) -> None:
    """Refuse limits, directions and travel that a joint cannot have; `scale` is from the file's unit to m or rad."""
    for key, suffix in (("velocity", "/s"), ("acceleration", "/s^2"), ("jerk", "/s^3")):
        figure = getattr(joint, key)
        if not figure > 0.0:
            raise MachineError(f"{place}: {key} = {figure:g} {unit}{suffix}; give a number above zero")
        if not (SLOWEST <= figure * scale <= FASTEST or math.isinf(figure)):
            raise MachineError(
                f"{place}: {key} = {figure:g} {unit}{suffix}; give a number between {SLOWEST / scale:.3g} and "
                f"{FASTEST / scale:.3g}, or inf"
            )
    check_direction(joint.direction, "direction", place)
    if joint.wrap and joint.kind == "linear":
        raise MachineError(f"{place}: wrap = true is for rotary joints; give travel = [low, high] in {unit}")
    if joint.wrap and joint.travel is not None:
        raise MachineError(f"{place}: has both travel and wrap = true; keep one (wrap is for endless rotary joints)")
    if joint.travel is None and not joint.wrap:
        cure = "" if joint.kind == "linear" else " or, for an endless rotary joint, wrap = true"
        raise MachineError(f"{place}: travel is missing; give travel = [low, high] in {unit}{cure}")
    if joint.travel is not None:
        if not joint.travel[0] < joint.travel[1]:
            raise MachineError(f"{place}: travel = {list(joint.travel)} {unit} is empty; give the lower end first")
        if not all(abs(end) * scale <= LARGEST or math.isinf(end) for end in joint.travel):
            raise MachineError(
                f"{place}: travel = {list(joint.travel)} {unit}; give ends within {LARGEST / scale:.3g} {unit}"
            )
