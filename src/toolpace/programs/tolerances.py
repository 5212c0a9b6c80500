"""Tolerances of a program by block, from an option, a file, or the program's own words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import METRES, RADIANS, ask_about_unit
from toolpace.programs.toolpath import ToolPath

SIDES = ("both", "outside", "above")
"""On which the tip may leave the program: both; out of the part, by the normals that the program tells; up along the
tool."""
WIDE_TIP, WIDE_AXIS = 2e-3, 0.04
"""Tolerances [m], [rad] from which on it is asked whether they are meant: 10 um is 1e-5."""
LEAST_LEFT = 0.5
"""Share of a tolerance that is left at least where the program's way bows: of 1 um and less."""
PROGRAM, TIGHTER = "program", "tighter"
"""What says that the tolerances hold that the program tells itself: all of them, or those below the default."""
_BLOCKS = re.compile(r"(N?)(\d{1,9})(?:-(N?)(\d{1,9}))?", re.IGNORECASE)


@dataclass(frozen=True, init=False)
class Tolerances:
    """A tolerance of the tip [m] or of the tool axis [rad] that differs from place to place.

    `Tolerances(20e-6, {"finish": 5e-6, "T2": 8e-6, "N100-N250": 5e-6})`: a place is the name of an operation, a tool
    (T and its number or name), the blocks from one N word to another, or lines as messages count them ("120-250").
    Of two places that hold the same block the later one counts. With `program=True` what the program asks for itself
    (`ToolPath.tip_tolerance`, `axis_tolerance`) holds in place of the default; with `tighter=True` where it is less.

    `side` says where the tip may leave the program: "both", the default, is a ball about it. "outside" is the half of
    it out of the part, by the normals of the surface that the program tells (`ToolPath.normal`; the tool axis where it
    tells none), "above" the half towards the spindle, along the tool axis. One side goes with one tolerance everywhere.
    """

    default: float
    places: tuple[tuple[str, float], ...]
    """Place and tolerance, in order."""
    program: bool
    """Whether the tolerances hold that the program tells."""
    tighter: bool = False
    """Whether they hold where they are below the default."""
    side: str = "both"
    """Of the program on which the tip may be: see SIDES."""
    most: float = math.inf
    """None is wider than this: see `within`."""
    factor: float = 1.0
    """By which those of the program count: see the product."""

    def __init__(
        self,
        default: float,
        places: Mapping[str, float] | Iterable[tuple[str, float]] = (),
        program: bool = False,
        side: str = "both",
        tighter: bool = False,
    ) -> None:
        """Raises UsageError where a tolerance is not above zero and finite, or there is no such side."""
        pairs = tuple(places.items() if isinstance(places, Mapping) else places)
        for place, value in (("", default), *pairs):
            if not (isinstance(value, int | float | np.number) and 0.0 < value < math.inf):
                where = f" of {place[:40]!r}" if place else ""
                raise UsageError(
                    f"tolerance{where} is {str(value)[:40]!r}; give a number above zero, "
                    "in metres or radians: 10e-6 is 10 um, 1e-3 rad is 0.057 deg"
                )
        if side not in SIDES:
            raise UsageError(f"side is {str(side)[:40]!r}; {did_you_mean(str(side), SIDES)}")
        if side != SIDES[0] and (pairs or program or tighter):
            raise UsageError(
                f"side {side} goes with one tolerance of the tip for all: leave out places, '{PROGRAM}' and '{TIGHTER}'"
            )
        if program and tighter:
            raise UsageError(f"a tolerance is as the program asks everywhere, '{PROGRAM}', or where it asks for less,"
                             f" '{TIGHTER}': name one of them")
        object.__setattr__(self, "default", float(default))
        object.__setattr__(self, "side", side)
        object.__setattr__(self, "places", tuple((place, float(value)) for place, value in pairs))
        object.__setattr__(self, "program", program)
        object.__setattr__(self, "tighter", tighter)
        object.__setattr__(self, "most", math.inf)
        object.__setattr__(self, "factor", 1.0)

    @classmethod
    def of(cls, tolerance: float | Tolerances, name: str) -> Tolerances:
        """A number as one that is the same everywhere. Raises UsageError, which says its name."""
        try:
            made = tolerance if isinstance(tolerance, Tolerances) else cls(tolerance)
        except UsageError as error:
            raise UsageError(str(error).replace("tolerance is", f"{name} is", 1)) from None
        most, cure = (WIDE_AXIS, RADIANS) if name.startswith("axis") else (WIDE_TIP, METRES)
        ask_about_unit(made.default, most, name, cure)
        return made

    @classmethod
    def parse(cls, text: str, quantity: Callable[[str], float], default: float) -> Tolerances:
        """From text such as "20um,finish:5um": the default, and places with their own; "program" or "tighter".

        `quantity` makes a number of "20um", `default` holds where none is told. Raises UsageError.
        """
        of_all: float | None = None
        places, program, tighter, side = [], False, False, SIDES[0]
        for part in (part.strip() for part in text.split(",")):
            place, colon, value = part.rpartition(":")
            if colon:
                if not place.strip():
                    raise UsageError(f"'{part[:40]}' names no operation, tool or block before its colon")
                places.append((place.strip(), quantity(value)))
            elif part.lower() == PROGRAM:
                program = True
            elif part.lower() == TIGHTER:
                tighter = True
            elif part.lower() in SIDES:
                side = part.lower()
            elif of_all is None:
                of_all = quantity(part)
            else:
                raise UsageError(f"'{text[:60]}' has two tolerances for all: name the place of one, like finish:{part}")
        return cls(default if of_all is None else of_all, places, program, side, tighter)

    def text(self, quantity: Callable[[float], str]) -> str:
        """The text that `parse` makes it from."""
        places = [f"{place}:{quantity(value)}" for place, value in self.places]
        words = [PROGRAM] * self.program + [TIGHTER] * self.tighter + [self.side] * self.one_sided
        return ",".join([quantity(self.default), *words, *places])

    @property
    def everywhere(self) -> bool:
        """Whether it is the same at all places, and on both sides."""
        return not self.places and not self.program and not self.tighter and not self.one_sided

    @property
    def one_sided(self) -> bool:
        """Whether the tip must stay on one side of the program."""
        return self.side != SIDES[0]

    @property
    def least(self) -> float:
        """The narrowest that is told here; a program may tell less."""
        return min([self.default, *(value for _, value in self.places)])

    def __mul__(self, factor: float) -> Tolerances:
        """All of them, those of the program too, as many times as wide."""
        places = [(place, factor * value) for place, value in self.places]
        found = Tolerances(factor * self.default, places, self.program, self.side, self.tighter)
        object.__setattr__(found, "most", factor * self.most)
        object.__setattr__(found, "factor", factor * self.factor)
        return found

    __rmul__ = __mul__

    def within(self, most: float) -> Tolerances:
        """All of them, none wider than `most`."""
        found = 1.0 * self
        object.__setattr__(found, "most", min(self.most, most))
        return found

    def of_tip_in(self, toolpath: ToolPath) -> float | Tolerances:
        """These of the tip; the default alone where they are that all along a tool path that asks for nothing less."""
        return self._if_asked_in(toolpath.tip_tolerance)

    def of_axis_in(self, toolpath: ToolPath) -> float | Tolerances:
        """The same of the tool axis."""
        return self._if_asked_in(toolpath.axis_tolerance)

    def _if_asked_in(self, programmed: Floats) -> float | Tolerances:
        if not self.tighter or np.any(programmed < self.default):
            return self
        return Tolerances(self.default, self.places) if self.places else self.default

    def tip_along(self, toolpath: ToolPath) -> Floats:
        """(n,) of the tip on the way to each point [m]. Raises UsageError where there is no such place."""
        return self._along(toolpath, toolpath.tip_tolerance)

    def tip_beside_chords(self, toolpath: ToolPath) -> Floats:
        """(n,) how far the tip may be from the straight way to each point [m], to be within the tolerance of the
        program's own way, which bows away from it (`ToolPath.bow`). Raises UsageError."""
        along, bow = self.tip_along(toolpath), toolpath.bow
        if self.one_sided and len(bow):
            bow = bow.max()  # a side goes with one tolerance
        left: Floats = np.maximum(along - bow, LEAST_LEFT * along)
        return left

    def axis_along(self, toolpath: ToolPath) -> Floats:
        """(n,) of the tool axis on the way to each point [rad]. Raises UsageError where there is no such place."""
        if self.one_sided:
            raise UsageError(f"side {self.side} is one of the tip's tolerance; the tool axis has none")
        return self._along(toolpath, toolpath.axis_tolerance)

    def outward_along(self, toolpath: ToolPath) -> Floats | None:
        """(n, 3) unit vectors at each point to the side on which the tip must be; None where it may be on both.

        Raises UsageError where the program does not tell which side the part is on.
        """
        if not self.one_sided:
            return None
        has_normal = ~np.isnan(toolpath.normal[:, 0])
        if self.side == "above":
            return toolpath.axis
        if not has_normal.any():
            raise UsageError(
                f"side outside: {toolpath.source or 'the program'} tells no normals of the surface (NX NY NZ of"
                " Klartext's LN), so nobody knows on which side the part is; 'above' keeps the tip from going below"
                " its program along the tool axis"
            )
        return np.where(has_normal[:, None], toolpath.normal, toolpath.axis)

    def _along(self, toolpath: ToolPath, programmed: Floats) -> Floats:
        found = np.full(len(toolpath), self.default)
        if self.program:
            found = np.where(np.isnan(programmed), found, self.factor * programmed)
        elif self.tighter:
            found = np.fmin(found, self.factor * programmed)
        for place, value in self.places:
            found[points_of(place, toolpath)] = value
        # no way leads to the first point
        found[:1] = found[1:2]
        along: Floats = np.minimum(found, self.most)
        return along


def points_of(place: str, toolpath: ToolPath) -> Bools:
    """(n,) whether the way to each point belongs to an operation, a tool or blocks. Raises UsageError."""
    named = [operation.name.casefold() == place.casefold() for operation in toolpath.operations]
    if not any(named):
        named = [f"t{operation.tool}".casefold() == place.casefold() for operation in toolpath.operations]
    if any(named) and place:
        found: Bools = np.array(named)[toolpath.operation]
        return found
    blocks = _BLOCKS.fullmatch(place)
    if blocks is None:
        raise UsageError(f"tolerance of '{place[:40]}': {unknown(place, toolpath)}")
    mark, first, second_mark, last = blocks.groups()
    ends = [int(first), int(last or first)]
    if mark or second_mark:
        ends = [line_of(number, toolpath, last=k > 0) for k, number in enumerate(ends)]
    inside: Bools = (toolpath.block >= ends[0]) & (toolpath.block <= ends[1])
    if not inside[1:].any():
        raise UsageError(
            f"tolerance of '{place[:40]}': {toolpath.source or 'the program'} moves nothing in these blocks"
        )
    return inside


def unknown(place: str, toolpath: ToolPath) -> str:
    """What to say of a place that there is not."""
    names = dict.fromkeys(operation.name for operation in toolpath.operations if operation.name)
    tools = dict.fromkeys(f"T{operation.tool}" for operation in toolpath.operations if operation.tool)
    candidates = [*names, *tools]
    if not candidates:
        return "the program names no operation and no tool; give blocks, like N100-N250, or lines, like 120-250"
    return f"no such operation, tool or block in {toolpath.source or 'the program'}; {did_you_mean(place, candidates)}"


def line_of(number: int, toolpath: ToolPath, *, last: bool) -> int:
    """The line of the first or last block with an N word. Raises UsageError where there is none."""
    lines = toolpath.numbered[toolpath.numbered[:, 0] == number, 1]
    if not len(lines):
        hint = "" if len(toolpath.numbered) else ": its blocks have no numbers; give lines, like 120-250"
        raise UsageError(f"{toolpath.source or 'the program'} has no block N{number}{hint}")
    return int(lines[-1 if last else 0])
