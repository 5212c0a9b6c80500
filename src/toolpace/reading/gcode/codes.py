"""What the G and M codes mean to reading: known, passed over, or refused with the reason.

G codes are ten times their number, so that G43.4 is 434. Meanings after RS274/NGC (Kramer, Proctor and Messina
2000) and LinuxCNC; tool-centre-point mode after Fanuc (G43.4) and LinuxCNC's switchable kinematics (M428, M429).
"""

from __future__ import annotations

GROUPS: dict[str, tuple[int, ...]] = {
    "motion": (0, 10, 20, 30, 800),
    "plane": (170, 180, 190),
    "units": (200, 210),
    "distance": (900, 910),
    "arc distance": (901, 911),
    "feed": (930, 940),
    "path control": (610, 611, 640),
    "tool length": (430, 434, 490),
    "dwell": (40,),
    "exact stop": (90,),
    "passed over": (150, 400, 500, 540, 690, 970, 980, 990),
}
"""Codes of one group exclude each other in a block; codes passed over have no meaning for motion here."""

GROUP_OF = {code: group for group, codes in GROUPS.items() for code in codes}

_OFFSETS = "its offset is known to the controller only: write the program in the coordinates of G54"
_CYCLE = "canned cycles are not read: let the CAM system write them out as G0 and G1"
_REFERENCE = "it moves to a place known to the controller only: write the position out with G0"
_COMPENSATION = "cutter compensation is not read: let the CAM system compensate, and write G40"

REFUSED: dict[int, str] = {
    50: "splines are not read: let the CAM system write lines and arcs",
    51: "splines are not read: let the CAM system write lines and arcs",
    52: "splines are not read: let the CAM system write lines and arcs",
    70: "lathe diameter mode is not read: write the program in radius, without G7",
    100: "it sets data in the controller that may shift positions: " + _OFFSETS,
    280: _REFERENCE,
    281: _REFERENCE,
    300: _REFERENCE,
    301: _REFERENCE,
    330: "spindle-synchronised motion is not read: time would follow the spindle",
    331: "spindle-synchronised motion is not read: time would follow the spindle",
    410: _COMPENSATION,
    411: _COMPENSATION,
    420: _COMPENSATION,
    421: _COMPENSATION,
    431: "its offset is known to the controller only: write G43, and set tool_length of the machine",
    435: "tool vectors in the program (I, J, K) are not read: write rotary positions under G43.4",
    510: "scaling and mirroring are not read: let the CAM system apply it",
    520: _OFFSETS,
    530: "it speaks of machine coordinates, known to the controller only: write G54 coordinates",
    **dict.fromkeys((550, 560, 570, 580, 590, 591, 592, 593), _OFFSETS),
    680: "rotated coordinates are not read: let the CAM system apply them",
    682: "tilted planes are not read: let the CAM system write five-axis points under G43.4",
    700: "it means inch on some controllers and a cycle on others: write G20 for inch",
    710: "it means millimetre on some controllers and a cycle on others: write G21 for millimetre",
    730: _CYCLE,
    760: _CYCLE,
    **dict.fromkeys((810, 820, 830, 840, 850, 860, 870, 880, 890), _CYCLE),
    920: _OFFSETS,
    **dict.fromkeys((921, 922, 923), _OFFSETS),
    950: "feed per revolution is not read: let the CAM system write feeds per minute (G94)",
}

UNKNOWN_G = "it is not known here and might move something: remove it, or let the CAM system write plain G0 to G3"

STOPS_BEFORE = frozenset((3, 4, 5, 6, 7, 8, 9, 10, 11, 19, 66))
"""M codes that bring the motion to rest before that of their block: spindle, tool, coolant, clamps."""
STOPS_AFTER = frozenset((0, 1, 60))
"""M codes at which it comes to rest after the motion."""
ENDS = frozenset((2, 30))
TIP_MODE = {428: True, 429: False}
PASSED_M = frozenset((48, 49, 50, 51, 52, 53, 62, 63, 64, 65, 67, 68))
"""Overrides, and outputs that are switched in the middle of motion."""
REFUSED_M: dict[int, str] = dict.fromkeys((97, 98, 99), "subprograms are not read: write every block out, in one file")
UNKNOWN_M = "it is not known here and might move something: remove it, or write what it does as plain blocks"

WORD_USES = {
    "P": "G4 (dwell), G64 or arcs (turns)",
    "Q": "G64",
    "I": "arcs (G2, G3)",
    "J": "arcs (G2, G3)",
    "K": "arcs (G2, G3)",
    "R": "arcs (G2, G3)",
}
"""Words that change a motion; one that nothing in its block uses is a mistake."""
PASSED_WORDS = ("S", "T", "H", "D")
"""Spindle speed, tool numbers: counted, since nothing moves by them."""


def code_text(code: int) -> str:
    """A G code as written: 434 as G43.4."""
    return f"G{code // 10}" + (f".{code % 10}" if code % 10 else "")
