"""Tools (T, D) and the compensation of their radius: G40, G41, G42, the rules in force, and its suppression."""

from __future__ import annotations

import numpy as np

from toolpace.common.units import DEGREE, INCH, MINUTE
from toolpace.programs.reading.compensation.stage import (
    ACROSS,
    ARC,
    CENTRE,
    CONTOUR,
    INSIDE,
    MEETING,
    TOUCHING,
    OffsetStage,
    Rules,
)
from toolpace.programs.reading.compensation.tool_centre_path import Departing, Follower, Suppressed, follow, leave
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import SENSES
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.options import PROGRAM, ReadOptions
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Axis, shown
from toolpace.programs.reading.sinumerik.word_values import Words, number

LENGTH_STAYS = (
    "the length of the tool stays along Z under G18 and G19, as posts count on it (SD42940 = 17; else it is along Y, X)"
)
_CURE = (
    "the tool's radius is not known: write it on the set-up sheet ([tools.N] radius), or give --compensation program "
    "where the CAM system wrote the path of the tool's centre (the radius of D is then that of wear, or zero)"
)
SLIGHT, MOST_MET = 10.0 * DEGREE, 100.0 * DEGREE
"""MD20230 and MD20210 as they are delivered: turn of an outside corner up to which there is no arc under G450, and from
which on there is one under G451."""
SAID = "outside corners that turn by up to 10 degrees are met, from 100 degrees on there is an arc (MD20230, MD20210)"
SAID_OF_FEED = "F is of the contour on arcs of a compensated contour: CFC is in force where the program does not say"
FEEDS = {"": CONTOUR, "CFC": CONTOUR, "CFTCP": CENTRE, "CFIN": INSIDE}
LOOKED_AT = 999
"""Elements that CDON looks at here: MD20240 tells how many, which we do not know."""
SIDES = {"G41": 1, "G42": -1}
SUPPRESSION = ("CUTCONON", "CUTCONOF")


class Tooling:
    """The tool that is selected, the one in the spindle, and what of them counts."""

    def __init__(self, control: Control, state: State, options: ReadOptions) -> None:
        self.control, self.state = control, state
        self.as_programmed = options.compensation == PROGRAM
        self.selected = ""
        self.at_once = False
        """Whether T changes the tool, since the program has no M6."""
        self.edge = 1
        self.master_spindle = 1
        """Its S may stand without a number: 1 (MD20090 as it is delivered) unless SETMS tells another."""
        control.set_length("")

    def spindle_sense(self, words: Words) -> list[str]:
        """M3 for M1=3 of the master spindle, which is taken out of the words; those of other spindles turn no tool."""
        address = f"M{self.master_spindle}="
        code = f"M{shown(words[address].value)}" if address in words else ""
        if code not in SENSES:
            return []
        del words[address]
        return [code]

    def take(self, words: Words) -> None:
        """T, D and S of a block."""
        word = words.pop("T", None)
        if word is not None:
            value = word.value
            if isinstance(value, (tuple, bool, Axis)):
                raise BlockError(f'T is the number or the name of a tool, not {shown(value)}: write T5 or T="MILL"')
            self.selected = value.strip() if isinstance(value, str) else f"{value:g}"
            if self.at_once:
                self.change()
        edge = number(words, "D")
        if edge is not None:
            if edge != round(edge) or edge < 0.0:
                raise BlockError(f"D{edge:g} is no number of a cutting edge (alarm 14090): write D1, or D0 for none")
            self._refuse_within(f"D{edge:g}")
            self.edge = round(edge)
            if self.edge > 1 and self.control.setup.tells_lengths:
                self.control.findings.assumed(f"D{self.edge} has the length that the sheet tells of the tool")
            self.control.set_length(None if self.edge == 0 else "")
        overshoot = number(words, "DISC")
        if overshoot is not None:
            self._refuse_within("DISC")
            self.state.overshoot = overshoot
        allowance = number(words, "OFFN")
        if allowance is not None:
            self._refuse_within("OFFN")
            if allowance and self.state.unit == INCH and self.state.feed_unit is None:
                raise BlockError("OFFN under G70: whether it is in inches is not told; write G700 or G71")
            self.state.allowance = allowance * self.state.unit
        spindle = number(words, f"S{self.master_spindle}", number(words, "S"))
        if spindle is not None:
            self.control.turn_spindle(spindle / MINUTE)

    def change(self, *, edge_programmed: bool = False) -> None:
        """Put the selected tool into the spindle; its first edge counts then, unless D stands in the block."""
        self._refuse_within("a change of the tool")
        self.control.change_tool(self.selected)
        if self.edge == 0 and not edge_programmed:
            self.edge = 1
            self.control.set_length("")

    def _refuse_within(self, what: str) -> None:
        if isinstance(self.control.stage, OffsetStage):
            raise BlockError(f"{what} while the radius is compensated is not read: write G40 before it")

    @property
    def radius(self) -> float | None:
        """Of the tool in the spindle [m], zero where its contour is the programmed one; None: unknown."""
        if self.as_programmed or self.edge == 0:
            return 0.0
        found = self.control.setup.tools.get(self.control.tool)
        return None if found is None else found.radius

    def plane_changed(self) -> None:
        """Say where the length of the tool lies under G18 and G19."""
        if self.state.plane and self.edge and not self.control.coordinates.tip_mode:
            self.control.findings.assumed(LENGTH_STAYS)


class Compensation:
    """Begins and ends it, and changes its rules."""

    def __init__(self, control: Control, state: State, tooling: Tooling) -> None:
        self.control, self.state, self.tooling = control, state, tooling

    def take(self, code: str) -> None:
        """G40, G41, G42. Raises BlockError."""
        control, state, stage = self.control, self.state, self.control.stage
        if isinstance(stage, Suppressed):
            raise BlockError(f"{code} while CUTCONON suppresses the compensation is not read: write CUTCONOF before it")
        follower = stage if isinstance(stage, Follower) else None
        state.compensation = code
        if code == "G40":
            if follower is not None:
                leave(follower)
            return
        radius = self.tooling.radius
        if radius is None:
            control.refuse(code, _CURE)
        elif self.tooling.as_programmed:
            control.findings.assumed("G41 and G42: the tool follows the programmed contour")
        elif follower is None:
            self._begin(code, radius + state.allowance)
        elif follower.side != SIDES[code]:
            raise BlockError(f"{code} changes the side of the tool while it compensates: write G40 before it")

    def _begin(self, code: str, distance: float) -> None:
        """Follow the contour at a distance [m]: radius and allowance."""
        if distance < 0.0:
            raise BlockError(f"radius and OFFN come to {distance * 1e3:.6g} mm: correct them")
        if distance:
            self._refuse_unread(code)
            follow(self.control, SIDES[code], distance, self.state.plane, self.rules())

    def rules(self) -> Rules:
        """How contours are followed now."""
        state = self.state
        return Rules(
            ARC if state.outside == "G450" else MEETING,
            TOUCHING if state.approach == "KONT" else ACROSS,
            FEEDS[state.contour_feed],
            most_met=MOST_MET,
            slight=SLIGHT,
            said_of_limits=SAID,
            most_idle=3,
            looks_ahead=LOOKED_AT if state.watches else 0,
            gouge="the control stops with an alarm (10750, 10751), or leaves elements out",
            assumed="" if state.contour_feed else SAID_OF_FEED,
        )

    def change_rules(self, code: str) -> None:
        """G450, G451, CFC and their kin may stand within a contour, and beside G40; the plane may not.

        "The approach/retraction behavior is determined by the state of the G command in the approach/retraction block"
        (Function Manual W1, 11/2006). Raises ProgramError.
        """
        stage = self.control.stage
        if isinstance(stage, (Follower, Suppressed)) and stage.plane != self.state.plane:
            stage.other_motion(f"a change of the plane ({code})")
        if isinstance(stage, Follower):
            self._refuse_unread(self.state.compensation)
            stage.rules = self.rules()
        elif isinstance(stage, (Suppressed, Departing)):
            stage.follower.rules = self.rules()

    def suppress(self, code: str) -> None:
        """CUTCONON and CUTCONOF. Raises BlockError."""
        stage = self.control.stage
        if code == "CUTCONOF":
            if isinstance(stage, Suppressed):
                self._refuse_bypass()
                stage.resume()
            else:
                self.control.findings.ignored(code)
        elif isinstance(stage, Follower):
            self.control.stage = Suppressed(stage)
        elif self.state.compensation == "G40" or self.tooling.as_programmed:
            raise BlockError("CUTCONON stands where no radius is compensated: write it behind G41 or G42")

    def _refuse_bypass(self) -> None:
        if self.state.approach != "NORM":
            raise BlockError(f"CUTCONOF under {self.state.approach} goes round the contour: write NORM before it")

    def _refuse_unread(self, code: str) -> None:
        control, state = self.control, self.state
        if state.approach not in ("NORM", "KONT"):
            control.refuse(f"{code} with {state.approach}", "NORM and KONT are read: write one of them in its place")
        if state.overshoot and state.outside == "G450":  # "DISC only applies with call of G450"
            control.refuse(f"{code} with DISC", "arcs are read without it: write DISC=0")
        if not state.in_frame and not self._in_machine_plane():
            control.refuse(f"{code} in a tilted frame", "its plane is that of the machine: write CUT2DF")

    def _in_machine_plane(self) -> bool:
        """Whether the plane of the program is parallel to that of the axes, as the rotary axes stand.

        So it is where a table has turned the part to the tool: CUT2D and CUT2DF are one then.
        """
        control = self.control
        placement = control.placement
        normal = 2 if self.state.plane == 0 else 2 - self.state.plane
        columns = np.eye(3)
        if control.coordinates.tilted and control.poses.machine is not None:
            _, columns, _ = control.poses.linear_map(placement.place(control.words)[3:])
        across = np.cross(columns[:, normal - 2], columns[:, normal - 1])
        of_program = np.array(placement.matrix)[:3, normal]
        return bool(abs(abs(across @ of_program) - np.linalg.norm(across) * np.linalg.norm(of_program)) < 1e-9)
