"""Values of HAL pins, from the HAL files and HAL commands that LinuxCNC's INI names."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from toolpace.machine.from_control.control_file import ControlFile, ControlFileError
from toolpace.machine.from_control.linuxcnc.ini import MOST_LINES, Ini, found_file
from toolpace.machine.from_control.record import Origin

TOOL_LENGTH = ("motion.tooloffset.z", "motion.tooloffset.w")
"""Pins with the length of the tool in force."""
DEEPEST = 8
"""Files that source files, and pins that feed pins."""
_INI_VALUE = re.compile(r"\[(\w+)\]\(?(\w+)\)?|\$::(\w+)\((\w+)\)")
_ARROWS = ("=>", "<=", "<=>")


@dataclass(frozen=True)
class PinValue:
    """What a pin has: a number, perhaps with the length of the tool in force, or with pins set by programs."""

    number: float
    origins: tuple[Origin, ...]
    adds_tool: bool = False
    unknown: tuple[str, ...] = ()
    """Pins whose values the files do not tell."""


@dataclass
class Hal:
    """What the commands set and connect."""

    set_pins: dict[str, tuple[str, Origin]] = field(default_factory=dict)
    set_signals: dict[str, tuple[str, Origin]] = field(default_factory=dict)
    signal_of: dict[str, tuple[str, Origin]] = field(default_factory=dict)
    """By pin."""
    pins_of: dict[str, list[str]] = field(default_factory=dict)
    """By signal."""
    loaded: list[tuple[str, Origin]] = field(default_factory=list)
    """Arguments of `loadrt`."""
    files: list[str] = field(default_factory=list)
    not_there: list[Origin] = field(default_factory=list)
    """HAL files that are named and cannot be found; not those that come with LinuxCNC (LIB:)."""

    def value(self, pin: str, depth: int = 0) -> PinValue | None:
        """What a pin has; None where nothing sets it or connects it, so that it keeps its module's default.

        Raises ControlFileError where it is set to what is no number.
        """
        if pin in self.set_pins:
            return _constant(*self.set_pins[pin])
        if pin in TOOL_LENGTH:
            return PinValue(0.0, (Origin(pin),), adds_tool=True)
        if pin not in self.signal_of:
            return None
        signal, origin = self.signal_of[pin]
        if signal in self.set_signals:
            return _constant(*self.set_signals[signal])
        others = [other for other in self.pins_of[signal] if other != pin]
        for other in others:
            if other in TOOL_LENGTH:
                return PinValue(0.0, (origin,), adds_tool=True)
            block, dot, output = other.rpartition(".")
            fed = f"{block}.in0" in self.signal_of or f"{block}.in0" in self.set_pins
            if dot and output == "out" and fed and depth < DEEPEST:
                return self._sum(block, depth + 1)
        sources = [other for other in others if not other.startswith("pyvcp.")]
        return PinValue(0.0, (origin,), unknown=tuple(sources[:1]) or (pin,))

    def _sum(self, block: str, depth: int) -> PinValue:
        """The output of a block that adds its inputs times their gains (sum2)."""
        number, adds_tool = 0.0, False
        origins: tuple[Origin, ...] = ()
        unknown: tuple[str, ...] = ()
        for name, gain_name in (("in0", "gain0"), ("in1", "gain1"), ("offset", "")):
            value = self.value(f"{block}.{name}", depth)
            if value is None:
                continue
            gain = self.value(f"{block}.{gain_name}", depth) if gain_name else None
            number += value.number * (1.0 if gain is None else gain.number)
            origins, unknown = origins + value.origins, unknown + value.unknown
            adds_tool |= value.adds_tool
        return PinValue(number, origins, adds_tool, unknown)


def _constant(text: str, origin: Origin) -> PinValue:
    word = text.lower()
    try:
        return PinValue({"true": 1.0, "false": 0.0}[word] if word in ("true", "false") else float(text), (origin,))
    except ValueError:
        if text.startswith(("$", "[")):
            return PinValue(0.0, (origin,), unknown=(text,))
        raise origin.error(f"is set to '{text[:40]}', which is no number; correct it") from None


def read_hal(ini: Ini, beside: Sequence[ControlFile]) -> Hal:
    """What the HAL files of an INI set and connect, in the order in which LinuxCNC reads them.

    `beside` are files that were given with it. Raises ControlFileError.
    """
    hal = Hal()
    _read_named(hal, ini, "HALFILE", beside)
    for entry in ini.all("HAL", "HALCMD"):
        _execute(hal, ini, entry.word(), entry.origin)
    _read_named(hal, ini, "POSTGUI_HALFILE", beside)
    for file in beside:
        if file.name not in (*hal.files, *ini.files):
            _read_file(hal, ini, file, beside, 0)
    return hal


def _read_named(hal: Hal, ini: Ini, key: str, beside: Sequence[ControlFile]) -> None:
    """Read the HAL files that a key names, but those that come with LinuxCNC, which place no axis."""
    for entry in ini.all("HAL", key):
        name = (entry.word().split() or [""])[0]
        if name.startswith("LIB:") or not name:
            continue
        file = found_file(name, ini.file, beside)
        if file is None:
            hal.not_there.append(Origin(name, entry.origin.file, entry.origin.line))
        else:
            _read_file(hal, ini, file, beside, 0)


def _read_file(hal: Hal, ini: Ini, file: ControlFile, beside: Sequence[ControlFile], depth: int) -> None:
    if file.name in hal.files:
        return
    hal.files.append(file.name)
    if len(file.lines) > MOST_LINES:
        raise ControlFileError(f"has more than {MOST_LINES} lines: this is no HAL file", file=file.name)
    for number, line in _commands(file):
        words = line.split()
        if words[0] == "source" and len(words) > 1 and depth < DEEPEST:
            inner = found_file(words[1], ini.file, beside)
            if inner is None:
                hal.not_there.append(Origin(words[1], file.name, number))
            else:
                _read_file(hal, ini, inner, beside, depth + 1)
            continue
        _execute(hal, ini, line, Origin("", file.name, number))


def _commands(file: ControlFile) -> Iterator[tuple[int, str]]:
    """Lines with something in them, continued ones as one, without comments."""
    pending, first = "", 0
    for number, line in enumerate(file.lines, 1):
        text = re.sub(r"(^|\s)#.*", "", line).strip()
        first = first or number
        if text.endswith("\\"):
            pending += text[:-1] + " "
            continue
        if whole := (pending + text).strip():
            yield first, whole
        pending, first = "", 0


def _execute(hal: Hal, ini: Ini, command: str, at: Origin) -> None:
    """Keep what one command sets, connects or loads; all others do nothing to the kinematics."""
    words = [word for word in _with_values(ini, command).split() if word not in _ARROWS]
    if len(words) < 2:
        return
    name, origin = words[0], Origin(f"{words[0]} {words[1]}", at.file, at.line)
    if name == "loadrt":
        hal.loaded.append((" ".join(words[1:]), origin))
    elif name == "setp" and len(words) > 2:
        hal.set_pins[words[1]] = (words[2], origin)
    elif name == "sets" and len(words) > 2:
        hal.set_signals[words[1]] = (words[2], origin)
    elif name == "net":
        pins = hal.pins_of.setdefault(words[1], [])
        for pin in words[2:]:
            pins.append(pin)
            hal.signal_of[pin] = (words[1], origin)


def _with_values(ini: Ini, command: str) -> str:
    """A command with `[SECTION]KEY` as the INI has it; what the INI does not have stays as it is written."""

    def value(found: re.Match[str]) -> str:
        section, key = (found[1], found[2]) if found[1] else (found[3], found[4])
        return ini.word(section, key) or found[0]

    return _INI_VALUE.sub(value, command)
