"""The modal state of a word-address program, and the system variables that tell it."""

from __future__ import annotations

from dataclasses import dataclass, field

from toolpace.common.units import DEGREE, INCH, MILLIMETRE, MINUTE
from toolpace.programs.reading.arcs import PLANE_ACROSS
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import INVERSE, PER_MINUTE, PER_REVOLUTION
from toolpace.programs.reading.control.machine_moves import machine_coordinates
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.variables import Key

ARCS = ("arc clockwise", "arc counter-clockwise")
_FEEDS = {INVERSE: 93.0, PER_MINUTE: 94.0, PER_REVOLUTION: 95.0}
_MOTIONS = {"rapid": 0.0, "feed": 1.0, "arc clockwise": 2.0, "arc counter-clockwise": 3.0}
_AXES = "XYZABCUVW"
_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


FREE = frozenset((5399, 5599, 5600, 5601, *range(5061, 5071)))
"""Variables of LinuxCNC's range that a program may set: results of M66 and of probing, output of messages, the last."""


@dataclass(slots=True)
class Modal:
    """The state of the reader; defaults are millimetres, absolute, XY plane, continuous path."""

    unit_said: bool = False
    """Whether the program has said which unit its lengths have."""
    unit: float = MILLIMETRE
    absolute: bool = True
    arc_absolute: bool = False
    plane: int = 0
    """0: XY, 1: ZX, 2: YZ."""
    motion: str | None = None
    """Meaning of the motion word in force."""
    motion_word: str = ""
    """The word itself, that of a cycle too."""
    turning: str = ""
    """The word by which the spindle turns (M3, M4); "": it is at rest."""
    cycle: str | None = None
    """Meaning of the canned cycle in force, which then rules in place of the motion."""
    exact_stop: bool = False
    stop_here: bool = False
    """Exact stop in this block."""
    cycle_word: bool = False
    """Whether this block has the word of a cycle."""
    arc_here: bool = False
    """Whether this block moves along an arc."""
    drills_here: bool = False
    """Whether this block drills, by its own cycle or that in force, if it names an axis."""
    whole: frozenset[str] = frozenset()
    """Letters of this block whose numbers have no point."""
    reckoned: frozenset[str] = frozenset()
    """Letters of this block whose values are expressions."""
    in_machine: bool = False
    """Machine coordinates in this block."""
    to_initial: bool = True
    """Whether cycles go back to the level at which they began, or to R."""
    polar: bool = False
    pole: dict[str, float] = field(default_factory=dict)
    """Radius and angle that polar words gave last."""
    switched_tip_mode: bool = False
    """By M428, M429."""
    length_tip_mode: bool = False
    """By G43.4, G49."""
    vectors: bool = False
    """Whether I, J, K are the tool axis (G43.5)."""
    stands: bool = False
    """Whether words of tip mode are in coordinates that do not turn with the table."""
    along: float = 0.0
    """Motion along the tool axis by a letter of its own [m]."""
    not_alone: tuple[int, int] | None = None
    """Slots of the axes of which neither may move alone yet: where the other is in turned coordinates is not sure."""
    level_by_machine: bool = False
    """Whether machine coordinates (G28, G30, G53) have told Z last."""
    turned_plane: int | None = None
    """The plane that G68 turns."""
    turned_in_plane: bool = False
    """Whether the program has turned rotary axes since the tilted plane was laid."""
    scaled: bool = False
    """Whether G51 scales the coordinates."""
    next_tool: str = ""
    length_word: str | None = None
    """H in force."""
    radius_number: float | None = None
    """D in force."""
    programmed_radii: set[float] = field(default_factory=set)
    """Numbers D whose radius the program itself has told (G10 L12, L13)."""
    between: list[float] | None = None
    """Words of the place over which the reference point was gone to."""
    ended: bool = False
    in_data: bool = False
    """Whether blocks are parameters of the controller, and no motion."""
    at_home: bool = False
    """Whether the last block went to a reference point."""

    @property
    def tip_mode(self) -> bool:
        return self.switched_tip_mode or self.length_tip_mode

    @property
    def drill_axis(self) -> int:
        """Of X, Y, Z, the normal of the plane."""
        return PLANE_ACROSS[self.plane]


class System:
    """Reads system variables by number (Fanuc, LinuxCNC) or name (LinuxCNC)."""

    def __init__(self, control: Control, state: Modal, *, named: bool, offset_group: int) -> None:
        """named: whether they are those of LinuxCNC; else of Fanuc. offset_group: of G54 among its groups of codes."""
        self.control, self.state, self.named, self.offset_group = control, state, named, offset_group

    def __call__(self, key: Key) -> float | None:
        """The value; None where it is not known."""
        if isinstance(key, str):
            return self._by_name(key) if self.named else None
        if self.named:
            if 5420 <= key <= 5428:
                return self._coordinate(_AXES[key - 5420])
            return self._of_linuxcnc(key)
        return self._of_fanuc(key)

    def _coordinate(self, letter: str) -> float | None:
        slot = self.control.slots.get(letter)
        if slot is None:
            return 0.0
        stage = self.control.stage
        if stage is not None and (stage.compensates or not self.named):
            raise BlockError("the place of the machine is asked for under cutter compensation: write G40 before it")
        return self.control.words[slot] / (self.state.unit if slot < 3 else DEGREE)

    def _of_linuxcnc(self, key: int) -> float | None:
        if key == 5220:
            offset = self.control.coordinates.offset
            return float(_OFFSETS.index(offset) + 1) if offset in _OFFSETS else 1.0
        if key == 5400:
            return float(self.control.tool) if self.control.tool.isdecimal() else 0.0
        return None

    def _of_fanuc(self, key: int) -> float | None:
        """Positions: of the end of the last block, in the machine, and on the part; else what is in force."""
        group, place = divmod(key - 1, 20)
        if group not in (250, 251, 252):
            return self._modal(key)
        letters = sorted(self.control.slots, key=self.control.slots.__getitem__)
        if place >= len(letters):
            return None
        letter = letters[place]
        if group != 251:
            return self._coordinate(letter)
        found = machine_coordinates(self.control).get(letter)
        return None if found is None else found / (self.state.unit if letter in "XYZ" else DEGREE)

    def _modal(self, key: int) -> float | None:
        """Codes in force by their groups (#4001), and other words (#4101): those whose numbers sources agree on."""
        state, control = self.state, self.control
        inch = state.unit == INCH
        offset = control.coordinates.offset
        values: dict[int, float | None] = {
            4001: _MOTIONS.get(state.motion or ""),
            4002: (17.0, 18.0, 19.0)[state.plane],
            4003: 90.0 if state.absolute else 91.0,
            4005: _FEEDS[control.feed.mode],
            4006: 20.0 if inch else 21.0,
            4009: 80.0 if state.cycle is None else None,
            4010: 98.0 if state.to_initial else 99.0,
            4000 + self.offset_group: float(offset[1:3]) if offset[:3] in _OFFSETS[:6] else None,
            4109: self._feed(),
            4111: float(state.length_word) if state.length_word else 0.0,
            4119: round(60.0 * control.feed.spindle, 9),
            4120: float(state.next_tool) if state.next_tool else 0.0,
        }
        return values.get(key)

    def _by_name(self, name: str) -> float | None:
        if len(name) == 2 and name[0] == "_" and name[1] in _AXES:
            return self._coordinate(name[1])
        control, state = self.control, self.state
        inch, feed = state.unit == INCH, control.feed
        offset = control.coordinates.offset
        moves = state.cycle is None
        values = {
            "_METRIC": float(not inch),
            "_IMPERIAL": float(inch),
            "_ABSOLUTE": float(state.absolute),
            "_INCREMENTAL": float(not state.absolute),
            "_IJK_ABSOLUTE_MODE": float(state.arc_absolute),
            "_INVERSE_TIME": float(feed.mode == INVERSE),
            "_UNITS_PER_MINUTE": float(feed.mode == PER_MINUTE),
            "_UNITS_PER_REV": float(feed.mode == PER_REVOLUTION),
            "_RETRACT_R_PLANE": float(not state.to_initial),
            "_RETRACT_OLD_Z": float(state.to_initial),
            "_PLANE": (170.0, 180.0, 190.0)[state.plane],
            "_MOTION_MODE": 10.0 * _MOTIONS.get(state.motion or "", 80.0) if moves else None,
            "_COORD_SYSTEM": round(10.0 * float((offset if offset in _OFFSETS else "G54")[1:]), 6),
            "_TOOL_OFFSET": float(control.coordinates.compensated),
            "_CURRENT_TOOL": float(control.tool) if control.tool.isdecimal() else 0.0,
            "_SELECTED_TOOL": float(state.next_tool or 0.0),
            # the number of F as it was written, also after a change of units
            "_FEED": None if feed.mode == INVERSE else self._feed(feed.unit),
            "_RPM": round(60.0 * feed.spindle, 9),
            "_LINE": float(control.line),
            "_VALUE": 0.0,
            "_VALUE_RETURNED": 0.0,
            "_TASK": 0.0,
        }
        return values.get(name)

    def _feed(self, unit: float | None = None) -> float | None:
        """F in force, in a unit [m], by default that in force."""
        feed = self.control.feed
        if feed.mode == INVERSE:
            return None
        return (feed.value or 0.0) * (MINUTE if feed.mode == PER_MINUTE else 1.0) / (unit or self.state.unit)
