"""The modes of a program, the words that set them, and the groups of words that exclude each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.expressions import BlockError

Point = tuple[float, float, float]
GREAT_CIRCLE, ROTARY = "great circle", "rotary"
"""What a tool vector does between two blocks: turn in a plane, or as the rotary axes do in proportion."""
EULER, RPY, RPY2, VIRTUAL = "euler", "rpy", "rpy2", "virtual"
"""What A2, B2 and C2 are: angles about Z, X', Z''; about Z, Y', X''; in the other order of these, whichever that is;
about axes that data of the machine tell."""


@dataclass
class State:
    """All that lasts from block to block, but for frames; at the start of a program (lists of G groups, PF 12.3)."""

    motion: str = "G1"
    plane: int = 0
    """0: XY, 1: ZX, 2: YZ."""
    absolute: bool = True
    unit: float = MILLIMETRE
    """Of lengths [m]."""
    unit_programmed: bool = False
    """Whether the program said it."""
    feed_unit: float | None = None
    """Of F [m]; None: that of the control itself."""
    exact_stop: bool = False
    stop_programmed: bool = False
    """Whether the program said how blocks meet: G60, G64."""
    compensation: str = "G40"
    outside: str = "G450"
    """G450: arcs about outside corners; G451: the ways beside them meet."""
    approach: str = "NORM"
    """How a compensated contour is gone to and left: NORM, KONT, KONTC, KONTT."""
    retract: str = "G460"
    """What is done where that way and the contour do not meet."""
    contour_feed: str = ""
    """What F is the speed of under compensation: CFC, CFTCP, CFIN; "" where the program does not say."""
    overshoot: float = 0.0
    """DISC: how far arcs about outside corners are drawn out [%]."""
    allowance: float = 0.0
    """OFFN: how far beyond the tool's radius a compensated contour is kept away from [m]."""
    watches: bool = False
    """Whether the control looks for places where a compensated way crosses itself (CDON)."""
    in_frame: bool = False
    """Whether the plane of compensation is that of the frame (CUT2DF)."""
    turning: str = GREAT_CIRCLE
    of_frames: str = ""
    of_axes: str = ""
    """The same as ORIWKS or ORIMKS, and as ORIVECT or ORIAXES said it: which group counts is data of the machine."""
    angles: str = EULER
    pole: Point | None = (0.0, 0.0, 0.0)
    """Of AP and RP; None where it was told in other coordinates or in another plane."""
    pole_is_set: bool = False
    """Whether the program told it; else it is the origin of whatever coordinates there are."""
    polar_plane: int = 0
    """The plane of the pole and of AP."""
    polar_radius: float | None = None
    """RP [m]; None before it is told."""
    polar_angle: float | None = None
    """AP [deg]; None where none was told since the pole."""
    rounding: float = 0.0
    """RNDM: radius of every corner [m], 0 for none."""
    base_unit: float | None = None
    """Of F and of $ variables under G70 and G71 [m]; None until the program tells it, where the control does not."""
    inverse: float | None = None
    """F under G93."""
    tangent: Point | None = field(default=None, compare=False)
    """Direction in which the last motion ended, in the program's coordinates."""

    def other_coordinates(self) -> None:
        """X, Y and Z mean other places from here on: no direction or pole of before holds."""
        self.tangent = None
        self.lose_pole()

    def lose_pole(self) -> None:
        """What AP and RP count from is to be told anew, if it was."""
        if self.pole_is_set:
            self.pole = None

    def pole_in_force(self) -> Point:
        """What AP and RP count from. Raises BlockError."""
        if self.pole is None:
            raise BlockError("the pole was told before a change of the plane or of frames: write G111 anew")
        return self.pole

    def unit_of_control(self) -> float:
        """Of F and of $ variables [m]: under G700 and G710 that of lengths, under G70 and G71 the base unit (Function
        Manual Basic Functions, G2, "G functions G700/G710"), which is that of the program where nothing tells it."""
        if self.feed_unit is not None:
            return self.feed_unit
        if self.base_unit is None:
            self.base_unit = self.unit
        return self.base_unit


SETS: dict[str, dict[str, object]] = {
    **{code: {"motion": code} for code in ("G0", "G1", "G2", "G3", "CIP", "CT", "BSPLINE", "G331", "G332")},
    "G17": {"plane": 0},
    "G18": {"plane": 1},
    "G19": {"plane": 2},
    **{code: {"outside": code} for code in ("G450", "G451")},
    **{code: {"approach": code} for code in ("NORM", "KONT", "KONTC", "KONTT")},
    **{code: {"retract": code} for code in ("G460", "G461", "G462")},
    **{code: {"contour_feed": code} for code in ("CFC", "CFTCP", "CFIN")},
    "CDON": {"watches": True},
    **{code: {"watches": False} for code in ("CDOF", "CDOF2")},
    "CUT2D": {"in_frame": False},
    "CUT2DF": {"in_frame": True},
    "G90": {"absolute": True},
    "G91": {"absolute": False},
    "G60": {"exact_stop": True, "stop_programmed": True},
    **{key: {"exact_stop": False, "stop_programmed": True} for key in ("G64", "G641", "G642", "G643", "G644", "G645")},
    "G70": {"unit": INCH, "feed_unit": None, "unit_programmed": True},
    "G71": {"unit": MILLIMETRE, "feed_unit": None, "unit_programmed": True},
    "G700": {"unit": INCH, "feed_unit": INCH, "unit_programmed": True},
    "G710": {"unit": MILLIMETRE, "feed_unit": MILLIMETRE, "unit_programmed": True},
    "ORIWKS": {"turning": GREAT_CIRCLE, "of_frames": GREAT_CIRCLE},
    "ORIMKS": {"turning": ROTARY, "of_frames": ROTARY},
    **{key: {"turning": GREAT_CIRCLE, "of_axes": GREAT_CIRCLE} for key in ("ORIVECT", "ORIPLANE")},
    "ORIAXES": {"turning": ROTARY, "of_axes": ROTARY},
    "ORIEULER": {"angles": EULER},
    "ORIRPY": {"angles": RPY},
    "ORIRPY2": {"angles": RPY2},
    **{key: {"angles": VIRTUAL} for key in ("ORIVIRT1", "ORIVIRT2")},
}
"""What each word sets, and that alone (Programming Manual Fundamentals 12.3; Job Planning 7.2)."""
MODES_OF_LIMITS = ("DYNNORM", "DYNFINISH", "DYNSEMIFIN", "DYNROUGH", "DYNPREC", "DYNPOS")
DYNAMICS = {
    "SOFT": {"brisk": 0.0},
    "BRISK": {"brisk": 1.0},
    # less acceleration at high speeds, and no limit of jerk (B2, 2.18); MD35220 = 1 takes the former away
    "DRIVE": {"brisk": 1.0},
    **{word: {"mode": float(mode)} for mode, word in enumerate(MODES_OF_LIMITS)},
}
"""What words say of the control's acceleration, as `Moves.drive` takes it."""
TOLERANCES = ("G641", "G642", "G643", "G644", "G645")
"""Blending within a tolerance that is set elsewhere."""


MODES = frozenset(name for wanted in SETS.values() for name in wanted)
"""What words of G groups set, and SAVE of a subprogram gives back."""


def apply(state: State, code: str) -> bool:
    """Set the mode of a word; False where it sets none."""
    wanted = SETS.get(code)
    if wanted is None:
        return False
    for name, value in wanted.items():
        setattr(state, name, value)
    return True


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
