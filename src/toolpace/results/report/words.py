"""Texts, number formats and colours of the report, and the share below which a limit is not listed."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Mapping, Sequence

from toolpace.machine.limit_curves import CURVE, CurvedLimit
from toolpace.machine.limits import CONTINUOUS, KINDS, MOTORS
from toolpace.machine.machine import Machine

WORTH_A_WORD = 1e-3
"""Gap from which its largest parts are located."""
LEAST_SHARE = 5e-4
"""Share of the time below which a limit is not listed: it would say 0.0 %."""
LEAST_PRICE = 5e-5
"""Share of the time that one percent more of a limit must save for it to be listed."""
BARS = 12
"""Limits that get a bar at most: of more, the least are hardly seen."""
OPERATIONS = 200
"""Operations that are listed: of more, those that take longest, in the order of the program."""
FEED = "#14a37f"
"""Colour of the feed."""
NEUTRAL = "#c3c9d2"
"""Colour of what is no limit."""
_JOINTS = ("#2f6fed", "#f0862b", "#8a4fd8", "#d6336c", "#0c9bb3", "#7a8a1a", "#8c5a3c", "#56657a")
"""Colours of the joints, in turn."""
OF_A_CURVE = 0.16
"""How much white is mixed into the colour of a joint's limit that falls with its speed."""
CONTINUOUSLY = 0.45
"""The same of a motor's continuous rating."""
_LIGHTER = {"velocity": 0.62, "acceleration": 0.32, "jerk": 0.0, "force": 0.16, "torque": 0.16}
"""How much white is mixed into the colour of a joint's limit."""


def joint_colour(joint: int) -> str:
    """The colour of a joint, the same in every chart."""
    return _JOINTS[joint % len(_JOINTS)]


def colours(joints: tuple[str, ...], curves: Sequence[CurvedLimit] = ()) -> dict[str, str]:
    """Name of each limit to its colour: the hue says which joint, the paleness which kind (jerk is the
    strongest)."""
    found = {"feed": FEED}
    for kind in (*KINDS, *MOTORS):
        for j, joint in enumerate(joints):
            found[f"{kind} {joint}"] = _paler(joint_colour(j), _LIGHTER[kind])
            if kind in MOTORS:
                found[f"{CONTINUOUS}{kind} {joint}"] = _paler(joint_colour(j), CONTINUOUSLY)
    for curve in curves:
        found[curve.name] = _paler(joint_colour(joints.index(curve.joint)), OF_A_CURVE)
    return found


def _paler(colour: str, share: float) -> str:
    """A colour mixed with white."""
    hue, light, strong = colorsys.rgb_to_hls(*(int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)))
    rgb = colorsys.hls_to_rgb(hue, light + share * (0.93 - light), strong)
    return "#" + "".join(f"{round(255.0 * value):02x}" for value in rgb)


def limit_words(name: str) -> str:
    """The name of a limit as one says it: "jerk A" is "Jerk of A"."""
    whole = {"feed": "Programmed feed", "nothing": "No limit reached", "dwell": "Dwell"}
    kind, _, joint = name.partition(" ")
    of_cut = name.capitalize()
    if name.startswith(CONTINUOUS):
        kind, _, of = joint.partition(" ")
        return f"{CONTINUOUS.capitalize()}{kind} of {of}"
    if kind in KINDS and joint.startswith(CURVE):
        return f"{kind.capitalize()} of {joint.removeprefix(CURVE)} at its speed"
    return whole.get(name) or (f"{kind.capitalize()} of {joint}" if kind in (*KINDS, *MOTORS) else of_cut)


def savings(prices: Mapping[str, float], duration: float) -> dict[str, tuple[float, float]]:
    """What one and ten percent more of each limit save [s], of prices [s] that are worth a row, the most first.

    Ten percent as if the time went with a power of the limit, which is exact where one limit holds all of the motion,
    and the most otherwise: see docs/design/prices.md.
    """
    dear = {name: gain for name, gain in prices.items() if gain >= LEAST_PRICE * duration}
    return {name: (gain, duration * (1.0 - 1.1 ** (-100.0 * gain / duration))) for name, gain in dear.items()}


def limits_now(machine: Machine | None) -> dict[str, str]:
    """The figures of a machine's limits by their names: of one that falls with the speed its largest and its least
    value, beside the largest alone, which is a limit of its own."""
    if machine is None:
        return {}
    kinds = (*KINDS, *MOTORS)
    now = {f"{kind} {row['joint']}": row[kind] for row in machine.summary() for kind in kinds if kind in row}
    for curve in machine.limits.curves:
        largest = f"{curve.kind} {curve.joint}"
        now[curve.name] = now[largest]
        now[largest] = f"{now[largest].partition(' ')[0]} {now[largest].rpartition(' ')[2]}"
    return now


def percent(share: float) -> str:
    """A share in percent, with as many digits as tell something; what is just above 1 shows that it is."""
    value = 100.0 * share
    if not math.isfinite(value):
        return "unbounded"
    if 99.9 <= value < 100.1:
        return f"{value:.2f} %"
    return f"{value:.3f} %" if value < 0.1 else f"{value:.1f} %"


def at_most(share: float) -> str:
    """An upper bound of a share in percent: two figures, rounded up, so that the text is a bound too: 0.14 %."""
    value = 100.0 * share
    if value <= 0.0 or not math.isfinite(value):
        return "0 %" if value <= 0.0 else "unbounded"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    figure = math.ceil(value / unit * (1.0 - 1e-9)) * unit
    return f"{figure:.2g} %" if figure < 99.5 else f"{math.ceil(value * (1.0 - 1e-9))} %"


def mesh_gap(gap: float) -> str:
    """What the lower bound on the mesh says of a plan."""
    return f"at most {at_most(gap)} slower than the best possible on this path and mesh"


def motion_gap(duration: float, bound: float) -> str:
    """What the lower bound of all motions along a path, on no mesh, says of a plan; both in seconds."""
    return f"at most {at_most(duration / bound - 1.0)} slower than any possible motion on this path"


def four_digits(value: float) -> str:
    """A positive figure with about four digits, thousands set apart by a narrow space: 50 000."""
    return f"{value:.4g}" if value < 1000.0 else f"{round(value):,}".replace(",", "\u202f")
