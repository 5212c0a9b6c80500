"""Rules for new feeds: what may be changed, how far, and by what limits and materials of each tool."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace

from toolpace.common.arrays import number
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.cutting.feeds.learned import Teacher
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.schedule import Steps
from toolpace.machine.cutting_tool import Coefficients
from toolpace.machine.machine import Machine
from toolpace.programs.spindle_figures import SpindleFigures
from toolpace.programs.toolpath import ToolPath

WAYS = ("air", "learned", "limits")
WITHOUT_MATERIAL = frozenset({"chip", "feed_per_tooth", "removal_rate", "feed_marks"})
"""Limits that no force belongs to."""


@dataclass(frozen=True)
class FeedRules:
    """What feeds may be changed, and how far. Raises UsageError for what makes no sense."""

    way: str = "air"
    """One of WAYS."""
    air_feed: float | None = None
    """In air, and the most where something is cut [m/s]; None: that of the machine."""
    machine_feed: float | None = None
    """What its slowest linear joint allows [m/s], see `for_machine`; None: the highest feed of the program."""
    steps: Steps = field(default_factory=Steps)
    raise_at_most: float = math.inf
    """By what factor, where something may be cut."""
    lower: bool = False
    """Whether feeds are lowered where they overload; by limits they always are."""
    finishing: bool = False
    """Whether feeds are raised where the tool makes a surface that stays, too."""
    limits: Mapping[str, CutLimits] = field(default_factory=dict)
    """By tool, as the program calls it; "" for all, where a tool has none of that kind of its own."""
    materials: Mapping[str, Coefficients] = field(default_factory=dict)
    """By tool likewise."""
    spindle: SpindleFigures = field(default_factory=SpindleFigures)
    """What the machine's spindle gives: limits of torque and power of what has a material."""
    left_alone: frozenset[str] = frozenset()
    """Names of operations whose feeds stay."""
    not_teaching: frozenset[str] = frozenset()
    """Names of operations, and numbers of lines, that teach nothing."""
    teachers: tuple[Teacher, ...] = ()
    """Those of other programs of the same shop and material; of a tool with the same figures they teach too."""

    def __post_init__(self) -> None:
        if self.way not in WAYS:
            raise UsageError(f"feeds '{str(self.way)[:40]}' are not known; {did_you_mean(str(self.way), WAYS)}")
        if not self.raise_at_most >= 1.0:
            raise UsageError(f"raise_at_most = {self.raise_at_most:g} is less than 1: give a factor, like 2")
        for name in ("air_feed", "machine_feed"):
            if getattr(self, name) is not None:
                number(getattr(self, name), name, least=0.0, above=True, unit="m/s")

    def for_machine(self, machine: Machine) -> FeedRules:
        """These on a machine: its slowest linear joint may move as fast in any direction."""
        slowest = float(machine.limits.velocity[machine.linear].min())
        return replace(self, machine_feed=slowest) if math.isfinite(slowest) else self

    def limits_of(self, tool: str, turns: float = math.nan) -> CutLimits:
        """Its own, and of each kind that it has none of, that for all; at turns of the spindle per second [1/s] no more
        than that gives. Raises UsageError where one needs a material."""
        tables = [self.limits.get(name, CutLimits()) for name in (tool, "")]
        own, usual = ({each.name: getattr(table, each.name) for each in fields(table)} for table in tables)
        found = CutLimits(**{name: usual[name] if value is None else value for name, value in own.items()})
        forces = [name for name in found.names if name not in WITHOUT_MATERIAL]
        if forces and self.material_of(tool) is None:
            raise UsageError(f"limit of the cut: {forces[0]} needs a force model: give --material, as Al7075-T6")
        return found if math.isnan(turns) or self.material_of(tool) is None else self.within_spindle(found, turns)

    def within_spindle(self, limits: CutLimits, turns: float) -> CutLimits:
        """Limits with no more torque and power than the spindle gives at turns per second [1/s]."""
        for name in ("torque", "power"):
            curve, own = getattr(self.spindle, name), getattr(limits, name)
            if curve is not None:
                limits = replace(limits, **{name: min(curve.at(turns), math.inf if own is None else own)})
        return limits

    def material_of(self, tool: str) -> Coefficients | None:
        """What it cuts; None where it is not told."""
        return self.materials.get(tool, self.materials.get(""))

    def check(self, toolpath: ToolPath) -> None:
        """Raise UsageError for a tool or an operation that a program does not have."""
        _check_names("tool", {*self.limits, *self.materials} - {""}, (each.tool for each in toolpath.operations))
        for named in (self.left_alone, {each for each in self.not_teaching if not each.isdigit()}):
            _check_names("operation", named, (each.name for each in toolpath.operations))


def _check_names(kind: str, named: Iterable[str], there: Iterable[str]) -> None:
    names = sorted({each for each in there if each})
    for name in sorted(named):
        if name not in names:
            cure = did_you_mean(name, names) if names else "it names none"
            raise UsageError(f"feeds: the program has no {kind} '{name[:40]}'; {cure}")
