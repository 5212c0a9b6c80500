"""Plausibility bounds on the names and figures of a machine, and the errors and questions beyond them.

Limits of joints outside those of machine tools are asked about: a figure in another unit than the file's is planned
with, and verified, as any other. The ranges are wide: the slowest is a simulated desktop machine, the fastest a linear
motor or a torque motor.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from toolpace.common.errors import MachineError, UnitWarning, printable
from toolpace.common.units import JOINT_LIMITS

HEAVIEST = 1e6
"""Most of a mass [kg]."""
FARTHEST = 1e3
"""Most of a coordinate of a machine [m]: a kilometre is a slip of units."""
LARGEST = 1e6
"""Most of a travel that is not endless [m or rad], and of an entry of a direction."""
STRONGEST = 20.0
"""Most of gravity [m/s^2]: twice that of the earth. 9806.65 is in mm."""
LEAST_REACHED = 0.01
"""Least share of a joint's velocity to which its motor can overcome viscous friction."""
SLOWEST = 1e-9
"""Least that a limit of a joint is [m or rad per s, s^2, s^3]."""


@dataclass(frozen=True)
class Usual:
    """What limits of a kind the joints of machine tools have, in m or rad and s."""

    low: float
    typical: float
    high: float
    """Outside of `low` and `high` a figure is asked about."""
    most: float
    """Above which no joint can be."""


USUAL = {
    "linear": {
        "velocity": Usual(1e-3, 0.5, 5.0, 100.0),
        "acceleration": Usual(0.05, 4.0, 50.0, 1e4),
        "jerk": Usual(0.25, 40.0, 2e4, 1e8),
    },
    "rotary": {
        "velocity": Usual(0.01, 2.5, 35.0, 1e4),
        "acceleration": Usual(0.2, 10.0, 200.0, 1e6),
        "jerk": Usual(1.0, 100.0, 2e4, 1e10),
    },
}
"""By kind of joint."""
WITHIN = 1.0 - 1e-9
"""Rounding of units at the ends of a range."""
TYPED = ("mm/min", "m/min", "mm/s", "m/s", "in/s", "mm/s2", "m/s2", "in/s2", "mm/s3", "m/s3", "in/s3",
         "deg/s", "rad/s", "rpm", "deg/s2", "rad/s2", "deg/s3", "rad/s3")  # fmt: skip
"""Units in which figures stand in data sheets and programs: one of these was meant."""
LONGEST_NAME, LONGEST_NOTE = 64, 1000
"""Most characters."""


class Chain(Protocol):
    """What is looked at of a chain."""

    @property
    def tool_length(self) -> float: ...
    @property
    def gravity(self) -> tuple[float, float, float]: ...


class Body(Protocol):
    """What is looked at of a body."""

    @property
    def mass(self) -> float: ...
    @property
    def centre(self) -> tuple[float, float, float]: ...
    @property
    def inertia(self) -> tuple[float, ...]: ...


class DrivenJoint(Body, Protocol):
    """What is looked at of a joint's drive; its torque, force and friction, too."""

    @property
    def kind(self) -> str: ...
    @property
    def balance(self) -> float: ...
    @property
    def thermal_window(self) -> float: ...


class Motor(Protocol):
    """What is looked at of a motor."""

    @property
    def largest(self) -> float: ...


class Joint(Protocol):
    """What is looked at of a joint; its limits, velocity, acceleration and jerk, too."""

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
    if not math.hypot(*chain.gravity) <= STRONGEST:
        raise MachineError(
            f"{source}: [chain] gravity = {list(chain.gravity)} m/s^2; give three finite numbers, at most "
            f"{STRONGEST:g} together, whatever the units of the file"
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
        most = USUAL[joint.kind][key].most
        if not (SLOWEST <= figure * scale <= most or math.isinf(figure)):
            question = meant(joint.kind, key, figure, scale)
            raise MachineError(
                f"{place}: {key} = {figure:g} {unit}{suffix} is beyond any joint{question}; "
                f"give a number between {SLOWEST / scale:.3g} and {most / scale:.3g}, or inf"
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


def check_mass(body: Body, place: str) -> None:
    """Refuse a mass and an inertia that no body has."""
    if not 0.0 <= body.mass <= HEAVIEST:
        raise MachineError(f"{place}: mass = {body.mass:g} kg; give a number from 0 to {HEAVIEST:g}")
    check_place(body.centre, "centre", place)
    if not all(abs(figure) <= LARGEST for figure in body.inertia):
        raise MachineError(f"{place}: inertia = {list(body.inertia)} kg m^2; give finite numbers")
    check_inertia(body.inertia, place)


def check_inertia(inertia: Sequence[float], place: str) -> None:
    """Refuse the inertia of no body: no principal moment is negative, or above the sum of the others."""
    if len(inertia) not in (3, 6):
        raise MachineError(f"{place}: inertia has {len(inertia)} figures; give xx, yy, zz, or xx, yy, zz, xy, xz, yz")
    xx, yy, zz, xy, xz, yz = (*inertia, 0.0, 0.0, 0.0)[:6]
    least, middle, most = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])).tolist()
    if least < -1e-9 * abs(most) or most > (least + middle) * (1.0 + 1e-6):
        raise MachineError(
            f"{place}: inertia = {list(inertia)} is that of no body, its principal moments being {least:.4g}, "
            f"{middle:.4g} and {most:.4g} kg m^2: none may be negative, or above the sum of the others"
        )


def check_body(joint: DrivenJoint, place: str) -> None:
    """Refuse masses, friction and torques that a joint cannot have."""
    check_mass(joint, place)
    for key in ("rotor_inertia", "viscous_friction", "dry_friction"):
        figure = getattr(joint, key)
        if not 0.0 <= figure <= LARGEST:
            raise MachineError(f"{place}: {key} = {figure:g}; give a number of zero or more, in kg, m, rad and N")
    if not abs(joint.balance) <= LARGEST:
        raise MachineError(f"{place}: balance = {joint.balance:g}; give a finite torque or force")
    mine, other, unit = ("force", "torque", "N") if joint.kind == "linear" else ("torque", "force", "N m")
    if getattr(joint, other) is not None:
        raise MachineError(f"{place}: {other} is not that of a {joint.kind} joint; write {mine} = ... in {unit}")
    limit = getattr(joint, mine)
    if limit is not None and not limit > 0.0:
        raise MachineError(f"{place}: {mine} = {limit:g} {unit}; give a number above zero, or leave it out")


def check_rating(joint: DrivenJoint, motor: Motor | None, place: str) -> None:
    """Refuse a continuous rating that a motor cannot have."""
    mine, other, unit = ("force", "torque", "N") if joint.kind == "linear" else ("torque", "force", "N m")
    if getattr(joint, f"{other}_continuous") is not None:
        raise MachineError(f"{place}: {other}_continuous is not that of a {joint.kind} joint; write {mine}_continuous")
    rating, window = getattr(joint, f"{mine}_continuous"), joint.thermal_window
    if not window > 0.0:
        raise MachineError(f"{place}: thermal_window = {window:g} s; give a time above zero, or leave it out")
    if rating is None:
        if math.isfinite(window):
            raise MachineError(f"{place}: thermal_window without {mine}_continuous; give that too, in {unit}")
        return
    if not 0.0 < rating < math.inf:
        raise MachineError(f"{place}: {mine}_continuous = {rating:g} {unit}; give a number above zero, or leave it out")
    if motor is None or rating > motor.largest:
        most = "without a limit" if motor is None else f"above {mine} = {motor.largest:g} {unit}"
        raise MachineError(f"{place}: {mine}_continuous = {rating:g} {unit} {most}; give the motor's largest as {mine}")


def check_viscous_friction(friction: float, motor: Motor | None, velocity: float, place: str) -> None:
    """Refuse friction [N s/m, N m s/rad] with which a motor comes to next to nothing of its joint's velocity [m/s,
    rad/s]: a slip of units."""
    if motor is None or not math.isfinite(velocity) or friction * velocity * LEAST_REACHED <= motor.largest:
        return
    raise MachineError(
        f"{place}: viscous_friction = {friction:g} takes all of {motor.largest:g} of the motor at "
        f"{motor.largest / friction / velocity:.2g} of its velocity; give it in N s/m, or N m s/rad"
    )


def is_usual(kind: str, key: str, figure: float) -> bool:
    """Whether a limit of a joint [m or rad, s] is one of a machine tool's, or infinite."""
    usual = USUAL[kind][key]
    return usual.low * WITHIN <= figure <= usual.high / WITHIN or math.isinf(figure)


def ask_about(joint: Joint, place: str, unit: str, scale: float) -> None:
    """Warn of limits of a joint that those of machine tools do not have, with the unit that was likely meant."""
    for key, suffix in (("velocity", "/s"), ("acceleration", "/s^2"), ("jerk", "/s^3")):
        figure, usual = getattr(joint, key), USUAL[joint.kind][key]
        if is_usual(joint.kind, key, figure * scale):
            continue
        side = "less" if figure * scale < usual.low else "more"
        warnings.warn(
            f"{place}: {key} = {figure:g} {unit}{suffix} is {side} than {joint.kind} joints of machine tools have "
            f"({_short(usual.low / scale)} to {_short(usual.high / scale)} {unit}{suffix})"
            f"{meant(joint.kind, key, figure, scale) or '; is it right?'}",
            UnitWarning,
            stacklevel=2,
        )


def meant(kind: str, key: str, figure: float, scale: float) -> str:
    """The unit in which a figure would be an ordinary limit, in a question that goes on a message; empty for none."""
    usual, units = USUAL[kind][key], JOINT_LIMITS[kind][key]
    likely = [
        (abs(math.log(figure * units[name] / usual.typical)), name)
        for name in TYPED
        if name in units and usual.low <= figure * units[name] <= usual.high and units[name] != scale
    ]
    if not likely:
        return ""
    name = min(likely)[1]
    return f'; is it {figure:g} {name}? Then write {key} = "{figure:g} {name}"'


def _short(figure: float) -> str:
    """Three digits of a figure, without an exponent where it is ordinary."""
    return f"{float(f'{figure:.3g}'):.12g}"
