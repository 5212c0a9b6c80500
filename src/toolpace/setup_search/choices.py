"""The choices of a search, from arguments or a TOML file: fixtures, orientations, positions, tools, forbidden zones.

[units]        length = "mm", angle = "deg"; or m, in, rad
[choose]       turn, tilt, swing, x, y, z, tool_length: one value, a list of those at hand, or {from = 0, to = 45};
               solution: "both", "free", "+", "-", or a list of these
[[forbidden]]  name; joints with the positions between which the machine must not be: X = [100, 300]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.files.toml import TableFile
from toolpace.common.units import DEGREE, FARTHEST_PART, LONGEST_TOOL, METRES, MILLIMETRE, RADIANS, refuse_other_unit
from toolpace.machine.machine import Machine
from toolpace.programs.reading.setup_tables.quantities import ANGLES, LENGTHS, TablesInUnits
from toolpace.setup_search.clamping import WHOLE_TURN, Clamping

NAMES = ("turn", "tilt", "swing", "x", "y", "z", "tool_length", "side")
"""Of all choices, as a file writes them."""
FILE = TableFile("file of choices", longest=100_000)
MOST = 100
"""Values of a list, and zones."""
ANGLED, COORDINATES = ("turn", "tilt", "swing"), ("x", "y", "z")
KEYS = (*ANGLED, *COORDINATES, "tool_length", "solution")
SOLUTIONS = {"free": 0.0, "+": 1.0, "-": -1.0}
MOST_SHIFT, MOST_TOOL_LENGTH, MOST_TURN = 100.0, 10.0, 4.0 * math.pi
"""Most of a shift [m], of a tool [m], of an angle [rad]: more is a slip of units."""


@dataclass(frozen=True)
class Zone:
    """Joint positions between bounds; a joint that is not named may be anywhere."""

    name: str
    bounds: Mapping[str, tuple[float, float]]
    """Lowest and highest position by joint [m or rad], inf where there is no end."""

    def __post_init__(self) -> None:
        for joint, (low, high) in self.bounds.items():
            if not low <= high:
                raise UsageError(f"zone {self.name}: {joint} from {low:g} to {high:g}; give the lower one first")
            if not is_angle(joint):
                for each in (low, high):
                    refuse_other_unit(each, FARTHEST_PART, f"zone {self.name}: {joint}", METRES)

    def entered(self, joints: tuple[str, ...], q: npt.ArrayLike) -> Bools:
        """(n - 1,) which of the straight ways between joint positions q (n, joints) enter it: by slabs."""
        for joint in self.bounds:
            if joint not in joints:
                raise UsageError(f"zone {self.name}: there is no joint {joint[:40]}; {did_you_mean(joint, joints)}")
        q = numbers(q, f"zone {self.name}: q", ("n", len(joints)), unit="m, rad")
        if not len(q):
            return np.zeros(0, dtype=np.bool_)
        first, last = np.zeros(len(q) - 1), np.ones(len(q) - 1)
        for joint, (low, high) in self.bounds.items():
            at, way = q[:-1, joints.index(joint)], np.diff(q[:, joints.index(joint)])
            with np.errstate(divide="ignore", invalid="ignore"):
                ends = np.stack([(low - at) / way, (high - at) / way])
            stands = np.abs(way) < 1e-15
            inside = (at >= low) & (at <= high)
            ends[:, stands] = np.where(inside[stands], [[-math.inf], [math.inf]], [[math.inf], [-math.inf]])
            first, last = np.maximum(first, ends.min(axis=0)), np.minimum(last, ends.max(axis=0))
            # what stands outside of a slab is outside of the box
            last[stands & ~inside] = -math.inf
        return np.asarray(first <= last)


def is_angle(joint: str) -> bool:
    """Whether the positions of a joint are angles, by its name, as a file of choices has them."""
    return joint[:1] in ("A", "B", "C")


@dataclass(frozen=True)
class Choice:
    """Values at hand, or all between two."""

    values: tuple[float, ...] = ()
    """[m] or [rad]; empty where all values between `low` and `high` are at hand."""
    low: float = 0.0
    high: float = 0.0

    @classmethod
    def between(cls, low: float, high: float) -> Choice:
        """All values between two; one where both are the same. UsageError where the first is higher."""
        if low > high:
            raise UsageError(f"choice: from {low:g} to {high:g}; give the lower one first")
        return cls((), low, high) if low < high else cls((low,))

    @property
    def is_free(self) -> bool:
        """Whether there is anything to choose."""
        return len(self.values) != 1

    def __contains__(self, value: float) -> bool:
        return value in self.values if self.values else self.low <= value <= self.high

    @property
    def is_listed(self) -> bool:
        """Whether single values are at hand, and none between."""
        return bool(self.values)

    def at(self, share: float) -> float:
        """The value at a share of the choice, from 0 to 1."""
        if self.values:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        return self.low + (self.high - self.low) * share

    def share_of(self, value: float) -> float:
        """The share at which a value, or the nearest to it, is had."""
        if self.values:
            nearest = min(range(len(self.values)), key=lambda i: abs(self.values[i] - value))
            return (nearest + 0.5) / len(self.values)
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)


ANY_TURN = Choice((), -180.0 * DEGREE, 180.0 * DEGREE)
USUAL_TILTS = Choice(tuple(angle * DEGREE for angle in (0.0, 15.0, 30.0, 45.0)))
ABOUT_HERE = Choice((), -100.0 * MILLIMETRE, 100.0 * MILLIMETRE)
FROM_HERE_UP = Choice((), 0.0, 100.0 * MILLIMETRE)
AS_IT_IS = Choice((0.0,))
EITHER_SIDE = Choice((-1.0, 0.0, 1.0))


@dataclass(frozen=True)
class Choices:
    """What may be chosen of a set-up; see `Clamping` for what each means."""

    turn: Choice = ANY_TURN
    tilt: Choice = USUAL_TILTS
    swing: Choice = AS_IT_IS
    x: Choice = ABOUT_HERE
    y: Choice = ABOUT_HERE
    z: Choice = FROM_HERE_UP
    """How far the part may be moved: not down, where the table is."""
    tool_length: Choice | None = None
    """None: the tool stays as it is."""
    side: Choice = EITHER_SIDE
    """Which solution of the inverse kinematics is taken; 0 leaves it to the least rotary motion."""
    forbidden: tuple[Zone, ...] = ()
    """Where the machine must not be."""
    source: str = field(default="", compare=False)
    """The file, for messages."""

    def __post_init__(self) -> None:
        for names, most, cure in (
            (("turn", "tilt", "swing"), WHOLE_TURN, RADIANS),
            (("x", "y", "z"), FARTHEST_PART, METRES),
            (("tool_length",), LONGEST_TOOL, METRES),
        ):
            for name in names:
                choice = getattr(self, name)
                for value in () if choice is None else (*choice.values, choice.low, choice.high):
                    refuse_other_unit(value, most, f"choices: {name}", cure)

    @property
    def direction(self) -> tuple[str, ...]:
        """Names of what is to be chosen of direction, tool and solution."""
        return self._free("turn", "tilt", "swing", "tool_length", "side")

    @property
    def position(self) -> tuple[str, ...]:
        """Names of the coordinates that are to be chosen."""
        return self._free("x", "y", "z")

    def _free(self, *names: str) -> tuple[str, ...]:
        return tuple(name for name in names if (choice := getattr(self, name)) is not None and choice.is_free)

    def named(self, name: str) -> Choice:
        """The choice of a name that is to be chosen."""
        choice: Choice = getattr(self, name)
        return choice

    def values_of(self, clamping: Clamping) -> dict[str, float]:
        """The values of a clamping by name."""
        tool = clamping.tool_length
        values = (clamping.turn, clamping.tilt, clamping.swing, *clamping.shift, math.nan if tool is None else tool)
        return dict(zip(NAMES, (*values, float(clamping.side)), strict=True))

    def checked(self, machine: Machine) -> Choices:
        """These choices, found to speak of the machine's joints. Raises UsageError."""
        for zone in self.forbidden:
            place = f"{self.source or 'choices'}: forbidden zone {zone.name}"
            for joint in zone.bounds:
                if joint not in machine.joints:
                    hint = did_you_mean(joint, machine.joints)
                    raise UsageError(f"{place}: machine {machine.name} has no joint {joint[:40]}; {hint}")
                if bool(machine.is_rotary[machine.joints.index(joint)]) != is_angle(joint):
                    raise UsageError(
                        f"{place}: joint {joint} of machine {machine.name}: names of rotary joints, and of no others, "
                        "begin with A, B or C, by which angles are told from lengths; rename it in the machine file"
                    )
        return self

    def clamping(self, values: Mapping[str, float]) -> Clamping:
        """The clamping of values by name; what is not named is as given, or as the one value that is at hand."""
        of = {each.name: self._value(each.name, values) for each in fields(self) if each.name in NAMES}
        tool = of["tool_length"]
        return Clamping(
            of["turn"], of["tilt"], of["swing"], (of["x"], of["y"], of["z"]), None if math.isnan(tool) else tool,
            int(of["side"]),
        )  # fmt: skip

    def _value(self, name: str, values: Mapping[str, float]) -> float:
        choice: Choice | None = getattr(self, name)
        if name in values:
            return values[name]
        if choice is None:
            return math.nan
        return choice.values[0] if not choice.is_free else choice.at(choice.share_of(0.0))

    def from_shares(self, names: tuple[str, ...], shares: Floats) -> dict[str, float]:
        """Values of the named choices at shares (k,) of each."""
        return {name: getattr(self, name).at(float(share)) for name, share in zip(names, shares, strict=True)}

    def shares_of(self, names: tuple[str, ...], values: Mapping[str, float]) -> Floats:
        """Shares (k,) of the named choices at which values are had."""
        return np.array([getattr(self, name).share_of(values[name]) for name in names])

    def box(self) -> Floats:
        """(3, 2) lowest and highest coordinates that may be chosen [m]."""
        return np.array([[min(each.values), max(each.values)] if each.values else [each.low, each.high]
                         for each in (self.x, self.y, self.z)])  # fmt: skip


def load_choices(path: str | Path) -> Choices:
    """The choices in a file. Raises UsageError naming file, key, value and cure."""
    return choices_of_text(FILE.text(path), str(path))


def choices_of_text(text: str, source: str = "choices") -> Choices:
    """Choices from the text of a file; `source` names it in messages. Raises UsageError."""
    return _File(source, FILE.table(text, source), "the file", ("units", "choose", "forbidden")).read()


class _File(TablesInUnits):
    """One reading of one file."""

    def read(self) -> Choices:
        choose = self.table("choose")
        self.refuse_unknown_keys("[choose]", choose, KEYS)
        chosen: dict[str, Any] = {key: self.choice(key, value) for key, value in choose.items() if key != "solution"}
        if "solution" in choose:
            chosen["side"] = self.solution(choose["solution"])
        return Choices(**chosen, forbidden=self.zones(), source=self.source)

    def choice(self, key: str, value: object) -> Choice:
        """One value, a list, or a range."""
        place = f"[choose] {key}"
        if isinstance(value, dict):
            self.refuse_unknown_keys(place, value, ("from", "to"))
            if "from" not in value or "to" not in value:
                self.fail(place, f"= {value!r:.40} is no range; write {{from = 0, to = 45}}")
            low, high = self.figure(place, key, value["from"]), self.figure(place, key, value["to"])
            if not low <= high:
                self.fail(place, f"runs from {value['from']} to {value['to']}; write the lower one first")
            return Choice.between(low, high)
        listed = value if isinstance(value, list) else [value]
        if not 0 < len(listed) <= MOST:
            self.fail(place, f"lists {len(listed)} values; write 1 to {MOST}, or a range like {{from = 0, to = 45}}")
        if key in COORDINATES and len(listed) > 1:
            self.fail(
                place, f"= {value!r:.40} is a list; a place is one value or a range, like {{from = -50, to = 50}}"
            )
        return Choice(tuple(dict.fromkeys(self.figure(place, key, each) for each in listed)))

    def figure(self, place: str, key: str, value: object) -> float:
        unit, scale = (self.angle, ANGLES[self.angle]) if key in ANGLED else (self.length, LENGTHS[self.length])
        found = self.number(place, value, unit) * scale
        most = MOST_TURN if key in ANGLED else MOST_TOOL_LENGTH if key == "tool_length" else MOST_SHIFT
        if not abs(found) <= most:
            self.fail(place, f"= {value!r:.40} is more than {most / scale:g} {unit}: check its unit")
        if key == "tool_length" and found < 0.0:
            self.fail(place, f"= {value!r:.40} is below zero; write it from the spindle nose to the tip")
        return found

    def number(self, place: str, value: object, unit: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self.fail(place, f"= {value!r:.40} is not a number; write it in {unit}, like 12.5")
        if value != value:
            self.fail(place, f"= nan is not a number; write it in {unit}, like 12.5")
        return float(value) if abs(value) < 1e300 else math.copysign(math.inf, value)

    def solution(self, value: object) -> Choice:
        """Which solutions may be taken; "both" stands for all three words."""
        words = [*SOLUTIONS] if value == "both" else value if isinstance(value, list) else [value]
        for word in words:
            if not isinstance(word, str) or word not in SOLUTIONS:
                self.fail("[choose] solution", f"= {word!r:.40} is not known; write 'both', 'free', '+' or '-'")
        if not words:
            self.fail("[choose] solution", "= [] leaves none; write 'both', 'free', '+' or '-'")
        return Choice(tuple(sorted({SOLUTIONS[str(word)] for word in words})))

    def zones(self) -> tuple[Zone, ...]:
        tables = self.raw.get("forbidden", [])
        if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
            self.fail("forbidden", "is not a list of tables; write each zone under [[forbidden]]")
        if len(tables) > MOST:
            self.fail("forbidden", f"lists {len(tables)} zones; {MOST} are the most")
        return tuple(self.zone(number, table) for number, table in enumerate(tables, start=1))

    def zone(self, number: int, table: Mapping[str, Any]) -> Zone:
        name = table.get("name", f"{number}")
        if not isinstance(name, str) or not 0 < len(name) <= 100:
            self.fail(f"[[forbidden]] {number}", f"name = {name!r:.40} is no name; write it in quotes")
        bounds = {key: self.bounds(name, key, value) for key, value in table.items() if key != "name"}
        if not bounds:
            self.fail(f"[[forbidden]] {name}", "bounds no joint; write like X = [100, 300], in positions of the joint")
        return Zone(name, bounds)

    def bounds(self, name: str, joint: str, value: object) -> tuple[float, float]:
        """Lowest and highest position of a joint [length or angle of the file: `Choices.checked` tells which]."""
        place = f"[[forbidden]] {name}: {joint[:40]}"
        if not isinstance(value, list) or len(value) != 2:
            self.fail(place, f"= {value!r:.40} is not two positions; write like [100, 300], or [100, inf]")
        unit, scale = (self.angle, ANGLES[self.angle]) if is_angle(joint) else (self.length, LENGTHS[self.length])
        low, high = (self.number(place, each, unit) * scale for each in value)
        if low >= high:
            self.fail(place, f"= {value!r:.40} holds nothing; write the lower position first")
        return low, high
