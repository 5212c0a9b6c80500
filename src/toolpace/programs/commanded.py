"""The commanded moves of a program, as a control plans its motion from them."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.value_objects import ByValue, counted, one_line
from toolpace.programs.toolpath import Operation

BLENDED, EXACT_PATH, EXACT_STOP = 0, 1, 2
"""How a move meets the next: rounded off, on the path, or at rest (G64, G61, G61.1 of RS274/NGC)."""


@dataclass(frozen=True, eq=False, repr=False)
class Commanded(ByValue):
    """The moves of a program as its control sees them, in the words of its axes; entry i is the way from i - 1 to i.

    Entry 0 is the place where the path starts. A move is straight in X, Y, Z, or an arc with its rise in proportion;
    rotary words move in proportion. X, Y, Z are the tip in the workpiece frame in tool-centre-point mode, else joint
    positions. Splines are straight pieces.
    """

    words: Floats
    """(n, 3 + rotary) X, Y, Z [m] and rotary words [rad] at the end of each move."""
    way: Floats
    """(n, 3 + rotary) change of the words over each move [m, rad]; not their difference where the mode changed."""
    rotary_joints: tuple[str, ...]
    """Names of the rotary words."""
    tip_mode: Bools
    """(n,) whether X, Y, Z are the tip."""
    tool_length: Floats
    """(n,) of the tool whose tip that is [m]; nan: of the machine's own."""
    rapid: Bools
    """(n,) whether the move is a rapid."""
    speed: Floats
    """(n,) most speed of X, Y, Z [m/s]; inf for rapids and where `time` rules."""
    turn: Floats
    """(n,) most speed of a move in which only rotary words change [rad/s]."""
    time: Floats
    """(n,) time that the program gives the move [s]: inverse-time feed; 0 elsewhere."""
    length: Floats
    """(n,) way of X, Y, Z [m], along the arc."""
    begin: Floats
    """(n, 3) unit direction of X, Y, Z at the start of the move; zero where they stand."""
    end: Floats
    """(n, 3) the same at its end."""
    radius: Floats
    """(n,) of the arc [m]; inf for straight moves."""
    centre: Floats
    """(n, 3) of the arc, at the height of its start [m]; nan for straight moves."""
    normal: Floats
    """(n, 3) unit vector about which the arc turns, by the right-hand rule; zero for straight moves."""
    sweep: Floats
    """(n,) angle of the arc [rad], above zero; 0 for straight moves."""
    line: Ints
    """(n,) line of the program, from 1."""
    stop: Bools
    """(n,) whether the control comes to rest at the end of the move: dwells, stops, tools, words that switch."""
    joining: Ints
    """(n,) BLENDED, EXACT_PATH or EXACT_STOP: how the move meets the next."""
    tolerance: Floats
    """(n,) how far blending may leave the path [m] (P of G64, CYCLE832, cycle 32); inf where the program asks for no
    tolerance (G64), nan before it has asked for anything."""
    axis_tolerance: Floats
    """(n,) how far rotary axes may leave theirs [rad] (TA of cycle 32, OTOL, CYCLE832); nan where the program does not
    say."""
    cam_tolerance: Floats
    """(n,) within which straight moves may be taken as one [m] (Q of G64); nan where the program does not say."""
    dynamics: Floats
    """(n, 4) what the program says of acceleration and corners, nan where it says nothing: 1 without and 0 with a limit
    of jerk (BRISK, SOFT); 1 with and 0 without roundings (G641 to G645 and CYCLE832, G64); the set of limits in force
    (0 DYNNORM, 1 DYNFINISH, 2 DYNSEMIFIN, 3 DYNROUGH, 4 DYNPREC, 5 DYNPOS); R of LinuxCNC's G64 (0 its planner without
    limit of jerk, 0.1 to 1 that with one)."""
    dwell: Floats
    """(n,) time to wait at the end of the move [s]."""
    operation: Ints
    """(n,) which of `operations` the move belongs to."""
    operations: tuple[Operation, ...]
    blocks: int = 0
    """Blocks that were executed."""
    source: str = ""
    controller: str = ""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if hasattr(value, "flags"):
                value.flags.writeable = False

    def __len__(self) -> int:
        return len(self.words)

    def __repr__(self) -> str:
        return one_line(self, self.source, counted(len(self), "move"), counted(self.blocks, "block"))
