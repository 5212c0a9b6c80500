"""Tools: T, D, the change, the length and the radius of the one in the spindle."""

from __future__ import annotations

from toolpace.reading.compensation.ends import follow, leave
from toolpace.reading.compensation.following import Follower
from toolpace.reading.compensation.rules import ACROSS, ARC, CENTRE, CONTOUR, INSIDE, MEETING, TOUCHING, Rules
from toolpace.reading.control.control import Control
from toolpace.reading.options import PROGRAM, ReadOptions
from toolpace.reading.sinumerik.given import Words, number
from toolpace.reading.sinumerik.state import State
from toolpace.reading.sinumerik.syntax.values import Axis, ValueFault, shown
from toolpace.units import DEGREE, MINUTE

_CURE = (
    "the tool's radius is not known: write it on the set-up sheet ([tools.N] radius), or give --compensation program "
    "where the CAM system wrote the path of the tool's centre (the radius of D is then that of wear, or zero)"
)
SLIGHT, MOST_MET = 10.0 * DEGREE, 100.0 * DEGREE
"""MD20230 and MD20210 as they are delivered: turn of an outside corner up to which there is no arc under G450, and from
which on there is one under G451."""
SAID = "outside corners that turn by up to 10 degrees are met, from 100 degrees on there is an arc (MD20230, MD20210)"
SAID_OF_FEED = "F is of the contour on arcs of a compensated contour: CFC is in force where the program does not say"
LENGTH_STAYS = (
    "the length of the tool stays along Z under G18 and G19, as posts count on it (SD42940 = 17; else it is along Y, X)"
)
FEEDS = {"": CONTOUR, "CFC": CONTOUR, "CFTCP": CENTRE, "CFIN": INSIDE}


class Tooling:
    """The tool that is selected, the one in the spindle, and what of them counts."""

    def __init__(self, control: Control, state: State, options: ReadOptions) -> None:
        self.control, self.state = control, state
        self.as_programmed = options.compensation == PROGRAM
        self.selected = ""
        self.at_once = False
        """Whether T changes the tool, since the program has no M6."""
        self.edge = 1
        control.set_length("")

    def take(self, words: Words) -> None:
        """T, D and S of a block."""
        given = words.pop("T", None)
        if given is not None:
            value = given.value
            if isinstance(value, (tuple, bool, Axis)):
                raise ValueFault(f'T is the number or the name of a tool, not {shown(value)}: write T5 or T="MILL"')
            self.selected = value.strip() if isinstance(value, str) else f"{value:g}"
            if self.at_once:
                self.change()
        edge = number(words, "D")
        if edge is not None:
            if edge != round(edge) or edge < 0.0:
                raise ValueFault(f"D{edge:g} is no number of a cutting edge (alarm 14090): write D1, or D0 for none")
            self._refuse_within(f"D{edge:g}")
            self.edge = round(edge)
            if self.edge > 1 and self.control.setup.tools:
                self.control.findings.assumed(f"D{self.edge} has the length that the sheet tells of the tool")
            self.control.set_length(None if self.edge == 0 else "")
        overshoot = number(words, "DISC")
        if overshoot is not None:
            self._refuse_within("DISC")
            self.state.overshoot = overshoot
        spindle = number(words, "S")
        if spindle is not None:
            self.control.feed.spindle = spindle / MINUTE

    def change(self, *, edge_told: bool = False) -> None:
        """Put the selected tool into the spindle; its first edge counts then, unless D stands in the block."""
        self._refuse_within("a change of the tool")
        self.control.change_tool(self.selected)
        if self.edge == 0 and not edge_told:
            self.edge = 1
            self.control.set_length("")

    def _refuse_within(self, what: str) -> None:
        if isinstance(self.control.stage, Follower):
            raise ValueFault(f"{what} while the radius is compensated is not read: write G40 before it")

    @property
    def radius(self) -> float | None:
        """Of the tool in the spindle [m], zero where its contour is the programmed one; None: unknown."""
        if self.as_programmed or self.edge == 0:
            return 0.0
        found = self.control.setup.tools.get(self.control.tool)
        return None if found is None else found.radius

    def compensate(self, code: str) -> None:
        """G40, G41, G42."""
        control, state = self.control, self.state
        stage = control.stage if isinstance(control.stage, Follower) else None
        state.compensation = code
        if code == "G40":
            if stage is not None:
                leave(stage)
            return
        radius = self.radius
        if radius is None:
            control.findings.refused(code, control.line, _CURE)
        elif self.as_programmed:
            control.findings.assumed("G41 and G42: the tool follows the programmed contour")
        elif radius and stage is None:
            self._refuse_unread(code)
            follow(control, 1 if code == "G41" else -1, radius, state.plane, self.rules())
        elif stage is not None and stage.side != (1 if code == "G41" else -1):
            raise ValueFault(f"{code} changes the side of the tool while it compensates: write G40 before it")

    def rules(self) -> Rules:
        """How contours are followed now."""
        state = self.state
        outside = ARC if state.outside == "G450" else MEETING
        return Rules(
            outside,
            TOUCHING if state.approach == "KONT" else ACROSS,
            FEEDS[state.contour_feed],
            most_met=MOST_MET,
            slight=SLIGHT,
            said_of_limits=SAID,
            most_idle=3,
            gouge="the control stops with an alarm (10750, 10751), or leaves elements out",
            assumed="" if state.contour_feed else SAID_OF_FEED,
        )

    def mode_changed(self, code: str) -> None:
        """G450, G451, CFC and their kin may stand within a contour; the plane may not. Raises ProgramError."""
        stage = self.control.stage
        if isinstance(stage, Follower):
            if stage.plane != self.state.plane:
                stage.other_motion(f"a change of the plane ({code})")
            self._refuse_unread(self.state.compensation)
            stage.rules = self.rules()
        elif self.state.plane and self.edge and not self.control.coordinates.tip_mode:
            self.control.findings.assumed(LENGTH_STAYS)

    def _refuse_unread(self, code: str) -> None:
        state = self.state
        for word, cure in (
            (state.approach, "NORM and KONT are read: write one of them in its place"),
            (state.retract, "G460 is read: write it in its place"),
        ):
            if word not in ("NORM", "KONT", "G460"):
                self.control.findings.refused(f"{code} with {word}", self.control.line, cure)
        if state.overshoot:
            self.control.findings.refused(f"{code} with DISC", self.control.line, "arcs are read without it")
        matrix = self.control.placement.matrix
        normal = 2 if state.plane == 0 else 2 - state.plane
        if not state.in_frame and abs(abs(matrix[normal][normal]) - 1.0) > 1e-9:
            self.control.findings.refused(
                f"{code} in a tilted frame", self.control.line, "its plane is that of the machine: write CUT2DF"
            )
