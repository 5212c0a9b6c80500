"""The figures of a cutting tool that its forces and bending depend on, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from toolpace.common.arrays import Floats, frozen, number, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import METRES, WIDEST_TOOL, refuse_other_unit
from toolpace.common.value_objects import ByValue, one_line

Milling = Literal["up", "down", "slot", "stock"]
MILLINGS: tuple[Milling, ...] = get_args(Milling)
OTHER_WORDS: dict[str, Milling] = {
    "climb": "down", "down-cut": "down", "conventional": "up", "up-cut": "up", "slotting": "slot", "full": "slot",
}  # fmt: skip
"""What else people call them."""
Force = Literal["mean", "peak"]
FORCES: tuple[Force, ...] = get_args(Force)
FASTEST_SPINDLE = 5000.0
"""[1/s]: 300 000 rpm."""
SOFTEST, SOFTEST_EDGE = 1e6, 100.0
"""Least force per area of chip [Pa] and per length of edge [N/m] that is not zero: a hundredth of that of plastics."""
STEEPEST = math.radians(80.0)
"""Most of a helix [rad]."""


@dataclass(frozen=True)
class Cutter:
    """The cutting part of a cylindrical end mill."""

    diameter: float
    """[m]"""
    teeth: int
    """Evenly spaced."""
    helix: float = 0.0
    """[rad]; above zero where the tool is right-handed."""
    runout: float = 0.0
    """How far the tool's axis is from the spindle's: half of what a dial gauge shows [m]."""
    runout_angle: float = 0.0
    """Where, from the first tooth at the tip, in the sense in which the tool turns [rad]."""


@dataclass(frozen=True)
class Coefficients:
    """Force per area of chip, and per length of edge: of one material and one kind of edge."""

    tangential: float
    """Ktc [Pa]"""
    radial: float
    """Krc [Pa]"""
    axial: float = 0.0
    """Kac [Pa]"""
    tangential_edge: float = 0.0
    """Kte [N/m]"""
    radial_edge: float = 0.0
    """Kre [N/m]"""
    axial_edge: float = 0.0
    """Kae [N/m]"""


@dataclass(frozen=True)
class Engagement:
    """What of the tool is in the material."""

    milling: Milling
    """`up`: chips begin at nothing (conventional). `down`: they end at nothing (climb). `slot`: the full width.
    `stock`: what the stock of the set-up sheet makes of it, place by place; then both depths are of no use."""
    axial_depth: float = math.inf
    """[m]"""
    radial_depth: float = math.inf
    """[m]; of a slot it is the diameter."""


@dataclass(frozen=True, eq=False)
class EngagedDeflection:
    """By how much the place of the tool that makes the surface gives way along a program, by what it cuts of a stock.

    At the speed v of the tip it is slope * v + constant, straight between the places.
    """

    way: Floats
    """(k,) ascending way of the tip along the program [m]."""
    slope: Floats
    """(k, 3) along the feed across the tool axis, the normal on its left, and the tool axis [s]."""
    constant: Floats
    """(k, 3) the same at a speed of nothing [m]."""

    def __post_init__(self) -> None:
        way = numbers(self.way, "engaged deflection: way", ("k",), unit="m")
        if not len(way) or (np.diff(way) < 0.0).any():
            raise UsageError("engaged deflection: way must have a place at least, and must ascend")
        for name in ("slope", "constant"):
            value = numbers(getattr(self, name), f"engaged deflection: {name}", (len(way), 3))
            object.__setattr__(self, name, frozen(value))
        object.__setattr__(self, "way", frozen(way))


@dataclass(frozen=True)
class Cut:
    """All that a cutting force depends on but the feed. Raises UsageError for figures that no cut can have."""

    cutter: Cutter
    coefficients: Coefficients
    engagement: Engagement
    spindle_speed: float
    """Turns per second [1/s]."""
    clockwise: bool = True
    """Seen from the spindle, as M3 turns it."""

    def __post_init__(self) -> None:
        cutter, milling = self.cutter, self.engagement.milling
        if milling not in MILLINGS:
            word = str(milling)
            other = OTHER_WORDS.get(word.strip().lower().split(" ")[0])
            hint = f"did you mean '{other}'?" if other else did_you_mean(word, MILLINGS)
            raise UsageError(f"milling '{word[:40]}' is not known; {hint}")
        figures: dict[str, float] = {
            "diameter": cutter.diameter, "teeth": cutter.teeth, "spindle_speed": self.spindle_speed
        }  # fmt: skip
        if milling != "stock":
            figures |= {"axial_depth": self.engagement.axial_depth, "radial_depth": self.width}
        for name, value in figures.items():
            number(value, f"cut: {name}", least=0.0, above=True)
        refuse_other_unit(cutter.diameter, WIDEST_TOOL, "cut: diameter", METRES)
        refuse_other_unit(self.engagement.axial_depth, WIDEST_TOOL, "cut: axial_depth", METRES)
        refuse_other_unit(self.spindle_speed, FASTEST_SPINDLE, "cut: spindle_speed", "give 1/s: 18000 rpm is 300")
        self._refuse_soft()
        if self.width > cutter.diameter:
            raise UsageError(
                f"cut: radial_depth of {self.width * 1e3:g} mm is more than the diameter of "
                f"{cutter.diameter * 1e3:g} mm; give at most that, or milling 'slot'"
            )
        if not abs(cutter.helix) <= STEEPEST:
            raise UsageError(f"cut: helix of {math.degrees(cutter.helix):g} deg; give at most 80 deg")
        if not 0.0 <= cutter.runout <= 0.1 * cutter.diameter:
            raise UsageError(f"cut: runout of {cutter.runout * 1e3:g} mm; give at most a tenth of the diameter")

    def _refuse_soft(self) -> None:
        """Raise UsageError for coefficients that are those of no material, but would be in MPa and N/mm."""
        for name, figure in vars(self.coefficients).items():
            edge = name.endswith("edge")
            least, cure = (SOFTEST_EDGE, "N/m: 25 N/mm is 25e3") if edge else (SOFTEST, "Pa: 800 MPa is 8e8")
            if 0.0 < abs(figure) < least:
                raise UsageError(f"cut: {name} is {figure:g}, less than {least:g}; give {cure}")

    @property
    def width(self) -> float:
        """Radial depth [m]."""
        whole = self.engagement.milling in ("slot", "stock")
        return self.cutter.diameter if whole else self.engagement.radial_depth


@dataclass(frozen=True, eq=False, repr=False)
class CuttingTool(ByValue):
    """A tool in a program: how it gives way, and what it cuts. Raises UsageError for figures that make no sense."""

    compliance: Floats
    """(3, 3) of the tip, in the tool frame [m/N]: see `Bending`."""
    cut: Cut
    """In all operations that are not named."""
    blend: float
    """Length of the tip's way over which bending builds up where a cut begins, and fades where it ends [m]."""
    force: Force = "mean"
    """What of the force over a turn bends the tool."""
    operations: Mapping[str, Cut | None] = field(default_factory=dict)
    """The operations, by name, that have a cut of their own; None: nothing is cut there."""
    only: tuple[str, ...] = ()
    """The tools of the program that this is; all of them where there is none. Others do not bend."""
    youngs_modulus: float | None = None
    """Of a tool that bends as a bar [Pa]; None where its stiffness is told otherwise."""
    engaged: EngagedDeflection | None = None
    """Where the engagement is that of a stock: what comes of it along the program."""
    source: str = field(default="tool", compare=False)
    """The file, for messages."""
    data: bytes = field(default=b"", compare=False)
    """What the file held when it was read: a copy of it is kept with a plan."""

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "compliance", frozen(numbers(self.compliance, f"{self.source}: compliance", (3, 3), unit="m/N"))
        )
        if self.force not in FORCES:
            raise UsageError(f"{self.source}: force '{self.force}' is not known; {did_you_mean(self.force, FORCES)}")
        number(self.blend, f"{self.source}: blend, a length like the diameter,", least=0.0, above=True, unit="m")

    @property
    def from_stock(self) -> bool:
        """Whether its engagement is what a stock makes of it."""
        return self.cut.engagement.milling == "stock"

    def __repr__(self) -> str:
        cutter = self.cut.cutter
        return one_line(
            self,
            f"{cutter.diameter * 1e3:g} mm",
            f"{cutter.teeth} teeth" if cutter.teeth > 1 else "1 tooth",
            self.cut.engagement.milling,
        )
