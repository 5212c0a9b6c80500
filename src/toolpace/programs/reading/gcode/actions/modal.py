"""The modal state of a word-address program."""

from __future__ import annotations

from dataclasses import dataclass, field

from toolpace.common.units import MILLIMETRE

ARCS = ("arc clockwise", "arc counter-clockwise")


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
    told_radii: set[float] = field(default_factory=set)
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
        return (2, 1, 0)[self.plane]
