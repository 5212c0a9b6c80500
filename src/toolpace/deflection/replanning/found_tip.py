"""The position at which the tip was found, from what a caller gives: a position, or a vector from the motion's own tip.

Both are three numbers in metres, and either may be given for the other by mistake. So each has its own name, and what
is further from the motion than a deflection can be is refused.
"""

from __future__ import annotations

import warnings

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import format_length
from toolpace.deflection.replanning.motion_state import MotionState
from toolpace.machine.machine import Machine

MOST = 5e-3
"""Deflection beyond which a figure is taken for a mistake: fifty times what bends in a finishing cut, and far less than
a part's coordinates [m]."""
CURE = "tip= is the position in the workpiece's frame [m], deflection= the vector from the motion's tip to it [m]"


def found_tip(
    motion_state: MotionState,
    machine: Machine | None,
    time: float,
    tip: npt.ArrayLike | None,
    deflection: npt.ArrayLike | None,
    most: float,
) -> Floats:
    """(3,) position of the tip in the workpiece's frame [m]; without a machine (m,) joints [m or rad].

    tip: that position itself. deflection: the vector from where the motion has the tip to it. Exactly one of both.
    most: of the distance between them [m]; without a machine of each joint [m or rad].

    Raises UsageError for none or both, for what is no such array, and for what is further off than `most`.
    """
    if (tip is None) == (deflection is None):
        both = "neither tip nor deflection" if tip is None else "both tip and deflection"
        raise UsageError(f"replan: {both} given; give one: {CURE}")
    most = number(most, "replan: most", least=0.0, above=True, endless=True, unit="m")
    q = motion_state.state()[0]
    own = q if machine is None else machine.forward(q[None])[0][0]
    unit = "m or rad, of the joints" if machine is None else "m"
    if tip is not None:
        position = numbers(tip, "tip", (len(own),), unit=unit)
    else:
        position = own + numbers(deflection, "deflection", (len(own),), unit=unit)
        position = _as_it_was(position, own, most, machine)
    off = _size(position - own, machine)
    if off > most:
        raise UsageError(_too_far(position, own, off, most, time, tip is not None, machine))
    return position


def _as_it_was(position: Floats, own: Floats, most: float, machine: Machine | None) -> Floats:
    """The position, of a `deflection` that may be meant as it was until now: as the position itself."""
    given = position - own
    before, now = _size(given - own, machine), _size(given, machine)
    if before > most:
        return position
    # both make sense only where the tip is near the origin; the name then decides
    taken = "the vector" if now <= most else "the position, as until now,"
    warnings.warn(
        f"replan: deflection= is the vector from the motion's tip; {taken} is taken; give tip= for the position",
        DeprecationWarning,
        stacklevel=4,
    )
    return position if now <= most else given


def _too_far(
    position: Floats, own: Floats, off: float, most: float, time: float, is_tip: bool, machine: Machine | None
) -> str:
    """One line that names what was probably meant."""
    given = position if is_tip else position - own
    name, other = ("tip", "deflection") if is_tip else ("deflection", "tip")
    as_other = _size(given if is_tip else given - own, machine)
    in_metres = position * 1e-3 - own if is_tip else given * 1e-3
    if as_other <= most:
        meant = f"that is {'a vector' if is_tip else 'a position'}: give it as {other}="
    elif _size(in_metres, machine) <= most:
        meant = "that is in mm: give metres"
    else:
        meant = CURE
    if machine is None:
        far, bound = f"{off:.4g} (m or rad) in one joint", f"{most:g}"
    else:
        far, bound = format_length(off), format_length(most)
    return (
        f"replan: {name} is {far} from the motion at {time:.6g} s, more than the {bound} of most: {meant};"
        " of a deflection that is so large raise most="
    )


def _size(offset: Floats, machine: Machine | None) -> float:
    """Of an offset of the tip [m], or the largest of the joints."""
    return float(np.abs(offset).max() if machine is None else np.linalg.norm(offset))
