"""What a control's files tell of a machine: figures as they stand there, each with its unit, file and line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from toolpace.machine.from_control.control_file import SHOWN, ControlFileError

Value = bool | float | str | tuple[float, ...] | tuple[str, ...]
"""As in a machine file: a number, a word, a vector, the names of joints."""


@dataclass(frozen=True)
class Origin:
    """Where a figure is from: a line of a file, or a reason in words (`file` is empty)."""

    name: str
    """What the figure is called there, as `[JOINT_3] MAX_VELOCITY`; or the reason."""
    file: str = ""
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line} {self.name}" if self.file else self.name

    def error(self, message: str) -> ControlFileError:
        """What is wrong with the figure, at its line."""
        return ControlFileError(f"{self.name} {message}", file=self.file, line=self.line)

    def no_number(self, text: str) -> ControlFileError:
        """That what stands there is none."""
        return self.error(f"= '{text[:SHOWN]}' is not a number; correct it")


@dataclass(frozen=True)
class Figure:
    """A value with its origins: several where it was made of several, as a travel of its two ends."""

    value: Value
    origins: tuple[Origin, ...]
    unit: str = ""
    """Of a limit of a joint (`common/units.py: JOINT_LIMITS`), as `m/s2`; empty: in the units of the record."""
    falls: tuple[tuple[float, float], ...] = ()
    """Of an acceleration that falls with the speed: corners, each a share of the velocity limit and of the value."""

    @property
    def number(self) -> float:
        """Of a figure that is one number."""
        assert isinstance(self.value, (int, float))
        return float(self.value)

    @property
    def vector(self) -> tuple[float, float, float]:
        """Of a figure that is a vector."""
        assert isinstance(self.value, tuple)
        x, y, z = map(float, self.value)
        return x, y, z

    @property
    def words(self) -> str:
        """The value for people, numbers in six digits."""
        values = self.value if isinstance(self.value, tuple) else (self.value,)
        return ", ".join(f"{each:g}" if isinstance(each, float) else str(each) for each in values)

    @property
    def origin(self) -> str:
        """Where it is from, in words; figures of one line are named together: `axes.txt:7 N01320 A1, A2`."""
        places: dict[str, str] = {}
        for each in dict.fromkeys(self.origins):
            place = f"{each.file}:{each.line}" if each.file else each.name
            first, _, last = each.name.rpartition(" ")
            if place not in places:
                places[place] = str(each)
            else:
                known = first and f"{first} " in places[place]
                places[place] += f", {last if known else each.name}"
        return " and ".join(places.values())

    def named(self, names: Mapping[str, str]) -> Figure:
        """The figure with other names of the files that it is from."""
        origins = tuple(replace(each, file=names.get(each.file, each.file)) for each in self.origins)
        return replace(self, origins=origins)


@dataclass
class MachineRecord:
    """A machine as far as its control's files tell it. Keys are those of a machine file (docs/tutorial/machine.md)."""

    control: str
    """As `LinuxCNC`."""
    name: str
    files: tuple[str, ...]
    """Names of those that were read."""
    length: Figure
    """"mm", "in" or "m": the unit of lengths, linear joints and their limits unless a figure has its own."""
    angle: Figure
    """"deg" or "rad"."""
    chain: dict[str, Figure] = field(default_factory=dict)
    """Keys of the table [chain]."""
    joints: dict[str, dict[str, Figure]] = field(default_factory=dict)
    """Keys of the table [joints.NAME], by name."""
    machine_zero: dict[str, Figure] = field(default_factory=dict)
    """By axis letter: the joint's position at which the control displays zero, for the set-up sheet."""
    control_figures: dict[str, Figure] = field(default_factory=dict)
    """What the control limits beside the joints, as the path's velocity; by a name with its unit."""
    controller: str = ""
    """The built-in controller that its controller file is `like`; empty where there is none."""
    timing: dict[str, Figure] = field(default_factory=dict)
    """Keys of the table [time] of its controller file, as `tolerance` and `sinumerik.overload` (docs/commands.md)."""
    held: list[str] = field(default_factory=list)
    """Turning joints that the machine does not have: at rest, since every machine here has two."""
    remarks: list[str] = field(default_factory=list)
    """What a person should know who compares the machine with the files."""

    def named(self, names: Mapping[str, str]) -> MachineRecord:
        """The record with other names of the files that its figures are from."""

        def each(figures: Mapping[str, Figure]) -> dict[str, Figure]:
            return {key: figure.named(names) for key, figure in figures.items()}

        return replace(
            self,
            length=self.length.named(names),
            angle=self.angle.named(names),
            chain=each(self.chain),
            joints={joint: each(figures) for joint, figures in self.joints.items()},
            machine_zero=each(self.machine_zero),
            control_figures=each(self.control_figures),
            timing=each(self.timing),
        )


def moved(point: Figure, vector: Figure, factor: float = 1.0) -> Figure:
    """A point (3,) moved by a multiple of a vector (3,)."""
    parts = tuple(one + factor * two + 0.0 for one, two in zip(point.vector, vector.vector))
    return Figure(parts, point.origins + vector.origins)


def travel(low: Figure, high: Figure) -> Figure:
    """The travel of a joint from its two ends. Raises ControlFileError with both lines where it is empty."""
    if not low.number < high.number:
        raise low.origins[0].error(
            f"= {low.number:g} is not below {high.origin} = {high.number:g}; correct one of both on the control"
        )
    return Figure((low.number, high.number), low.origins + high.origins)


def lowest(figures: Iterable[Figure]) -> Figure:
    """The lowest of limits that all hold, as of an axis and its joint."""
    return min(figures, key=lambda figure: figure.number)
