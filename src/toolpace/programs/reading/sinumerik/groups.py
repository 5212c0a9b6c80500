"""Groups of G functions that exclude each other in a block (alarm 12060)."""

from __future__ import annotations

from functools import lru_cache

from toolpace.programs.reading.sinumerik.state import TOLERANCES

_FRAMES = ("TRANS", "ROT", "ROTS", "SCALE", "MIRROR", "ATRANS", "AROT", "AROTS", "ASCALE", "AMIRROR")
GROUPS: dict[str, tuple[str, ...]] = {
    "1": ("G0", "G1", "G2", "G3", "CIP", "CT", "ASPLINE", "BSPLINE", "CSPLINE", "POLY", "G33", "G331", "G332"),
    "2": ("G4", "G63", "G74", "G75", "G147", "G148", "G247", "G248", "G347", "G348"),
    "3": (*_FRAMES, "G25", "G26", "G58", "G59", "G110", "G111", "G112"),
    "6": ("G17", "G18", "G19"),
    "7": ("G40", "G41", "G42"),
    "8": ("G500", *(f"G{k}" for k in range(54, 58)), *(f"G{k}" for k in range(505, 600))),
    "9": ("G53", "G153", "SUPA"),
    "10": ("G60", "G64", *TOLERANCES),
    "12": ("G601", "G602", "G603"),
    "13": ("G70", "G71", "G700", "G710"),
    "14": ("G90", "G91"),
    "15": ("G93", "G94", "G95", "G96", "G97", "G961", "G971"),
    "25": ("ORIWKS", "ORIMKS"),
    "50": ("ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2"),
    "51": ("ORIVECT", "ORIPLANE", "ORIAXES", "ORIPATH"),
    "53": ("TOROT", "TOROTOF", "TOROTZ"),
    "that of M0, alarm 14760": ("M0", "M1", "M2", "M17", "M30"),
    "that of M3, alarm 14760": ("M3", "M4", "M5", "M19", "M70"),
}
OF = {word: group for group, words in GROUPS.items() for word in words}
MOST_M = 5
"""M words of a block (alarm 12010)."""


@lru_cache(maxsize=1 << 12)
def fault_of(codes: tuple[str, ...]) -> str:
    """Which words of a block exclude each other, and the cure; empty where none do."""
    found: dict[str, str] = {}
    for code in codes:
        group = OF.get(code, "")
        first = found.setdefault(group, code) if group else code
        if first != code:
            said = group if "alarm" in group else f"number {group}, alarm 12060"
            return f"{first} and {code} are of one group ({said}): write one of them, or a block of its own for each"
    # "frame statements must be programmed in a separate NC block" (NC Programming 12/2019, "Frame instructions")
    alone, other = found.get("3"), found.get("1") or found.get("2")
    if alone and other:
        return f"{alone} beside {other}: write {alone} in a block of its own (alarm 12120)"
    if sum(code[0] == "M" and code[1:].isdigit() for code in codes) > MOST_M:
        return f"more than {MOST_M} M words in a block (alarm 12010): write another block"
    return ""
