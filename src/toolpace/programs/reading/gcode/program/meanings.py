"""The possible meanings of G and M words, their order of execution, and their groups."""

from __future__ import annotations

from typing import NamedTuple

from toolpace.common.errors import UsageError
from toolpace.programs.reading.controllers.controller import Controller

GROUPS: dict[str, tuple[str, ...]] = {
    "saved modes": ("save modes", "save modes for return", "forget modes", "restore modes"),
    "feed mode": ("inverse time", "feed per minute", "feed per revolution"),
    "unit": ("inch", "millimetre"),
    "function": (
        "stop", "turn spindle", "orient spindle", "wait for input", "unknown function", "tool change", "tool at hand",
        "tip mode on", "tip mode off",
    ),
    "plane": ("plane XY", "plane ZX", "plane YZ"),
    "distance": ("absolute", "incremental"),
    "arc centre": ("arc centre absolute", "arc centre incremental"),
    "path": ("exact stop mode", "continuous path"),
    "compensation": ("compensation", "compensation by diameter", "compensation off"),
    "offset": ("work offset", "numbered offset", "no offset"),
    "length": (
        "tool length", "told offset", "added offset", "tip mode", "tip mode that stands", "tool vector mode",
        "length off", "tip mode ends",
    ),
    "retract": ("to initial level", "to R level"),
    "polar": ("polar", "cartesian"),
    "scale": ("scale", "scale off"),
    "mirror": ("mirror", "mirror off"),
    "rotation": (
        "rotate", "tilt plane", "tilt plane upon plane", "plane of tool", "tilt plane by order", "carried frame",
        "rotation off",
    ),
    "action": (
        "dwell", "reference", "second reference", "from reference", "set offset", "local shift", "set position",
        "clear position", "suspend position", "restore position", "turn to plane", "turn to plane about tip",
        "macro call", "hole circle", "hole arc", "modal macro call", "modal macro off", "only off",
        "datum", "datum added", "tilt by axes", "machine rapid", "run cycle",
        "end of data", "limits", "settings", "no motion",
        "define drill", "define peck", "define tap", "define bore", "define bore and stop",
    ),
    "machine coordinates": ("machine coordinates",),
    "exact stop": ("exact stop",),
    "end of cycle": ("end cycle",),
    "motion": (
        "rapid", "feed", "arc clockwise", "arc counter-clockwise", "drill", "drill and dwell", "peck",
        "break chips", "tap", "bore", "bore and dwell", "bore and stop", "bore and orient", "bore backwards",
        "bore by hand", "cubic spline", "quadratic spline", "nurbs", "nurbs by knots", "end of nurbs",
    ),
    "call": ("call program", "call here", "return"),
    "ends": ("program stop", "end"),
}  # fmt: skip
"""Groups in the order in which a controller acts on them; words of one exclude each other in a block."""
ORDER = {meaning: order for order, group in enumerate(GROUPS.values()) for meaning in group}
GROUP_OF = {meaning: group for group, meanings in GROUPS.items() for meaning in meanings}
UNKNOWN_G = "it is not known here and might move something: remove it, or let the CAM system write plain G0 to G3"
UNKNOWN_M = "it is not known here and might move something: remove it, or write what it does as plain blocks"
_TAKEN_TOGETHER = ("function", "action", "call", "ends")
"""Groups whose words do something once, in place of setting a mode."""
_TOGETHER = (("M3", "M4", "M5", "M19"), ("M7", "M9"), ("M8", "M9"))
"""Functions of which one block has one, beside those that end or call."""


class Action(NamedTuple):
    """A G or M word in a block, and what it means."""

    meaning: str
    word: str


class Vocabulary:
    """The words of one controller."""

    def __init__(self, controller: Controller) -> None:
        """Raises UsageError where the controller's file names a meaning that there is not."""
        self.meanings = controller.meanings
        self.ignored = frozenset(controller.ignored)
        self.refused = controller.refused
        self.unknown_stops = controller.option("unknown_m_stops", False)
        for word, meaning in self.meanings.items():
            if meaning not in GROUP_OF:
                raise UsageError(
                    f"{controller.source or controller.name}: {word[:40]} = '{meaning[:40]}' is no meaning that is "
                    f"known: use one of {', '.join(GROUP_OF)}"
                )

    def of(self, letter: str, value: float) -> Action | str | None:
        """What a word does; the cure where it is refused; None where it moves nothing."""
        word = f"{letter}{value:.12g}"
        meaning = self.meanings.get(word)
        if meaning is not None:
            return Action(meaning, word)
        if word in self.ignored:
            return None
        cure = self.refused.get(word)
        if cure is not None:
            return cure
        if letter == "G":
            return UNKNOWN_G
        if self.unknown_stops and value == int(value) and 0 <= value < 1000:
            return Action("unknown function", word)
        return UNKNOWN_M


def last_of_groups(actions: list[Action]) -> list[Action]:
    """The words of a block where, of those that set one mode, the last rules."""
    last = {GROUP_OF[meaning]: k for k, (meaning, _) in enumerate(actions)}
    return [
        action for k, action in enumerate(actions)
        if GROUP_OF[action.meaning] in _TAKEN_TOGETHER or last[GROUP_OF[action.meaning]] == k
    ]  # fmt: skip


def conflict(actions: list[Action]) -> str:
    """Why words cannot stand in one block; empty where they can."""
    seen: dict[str, str] = {}
    words = {action.word for action in actions}
    for meaning, word in actions:
        group = GROUP_OF[meaning]
        if group != "function" and seen.setdefault(group, word) != word:
            return f"{seen[group]} and {word} exclude each other in one block: write two blocks"
    for group_of_words in _TOGETHER:
        both = [word for word in group_of_words if word in words]
        if len(both) > 1:
            return f"{both[0]} and {both[1]} exclude each other in one block: write two blocks"
    return ""
