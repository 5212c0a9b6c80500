"""The kinematics module that LinuxCNC loads, which joints move which axis letter, and the values of its pins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.linuxcnc.hal import Hal, PinValue
from toolpace.machine.from_control.linuxcnc.ini import Entry, Ini
from toolpace.machine.from_control.record import Figure, Origin
from toolpace.machine.from_control.stand_ins import Answers, Question

LETTERS = "XYZABCUVW"
USUAL_LETTERS = {
    "trivkins": LETTERS,
    "maxkins": LETTERS,
    "millturn": "XYZA",
    "xyzac-trt-kins": "XYZAC",
    "xyzbc-trt-kins": "XYZBC",
    "xyzab_tdr_kins": "XYZAB",
    "5axiskins": "XYZBCW",
}
"""By module: the axis letters of joints 0, 1, ... where it is not told others. Other modules are refused."""
NEEDED = {"xyzac-trt-kins": "XYZAC", "xyzbc-trt-kins": "XYZBC", "5axiskins": "XYZBCW"}
"""Letters that a module must have among those that it is told."""
REFUSED = {
    "corexykins": "its motors move X and Y together, so that the limits of joints are none of axes",
    "rotatekins": "its joints move X and Y together, so that the limits of joints are none of axes",
    "matrixkins": "its matrix mixes the axes",
    "xyzacb_trsrn": "it has three turning axes, and a machine here has two",
    "xyzbca_trsrn": "it has three turning axes, and a machine here has two",
    "gantrykins": "it is of LinuxCNC 2.7; use trivkins with a letter twice",
    "userkins": "it is a frame for kinematics of one's own",
}
"""Why a module cannot be read; others are of robots, hexapods and deltas, without straight axes."""


@dataclass(frozen=True)
class Module:
    """A module with its arguments."""

    name: str
    letters: str
    """Of joint 0, 1, ..."""
    origin: Origin
    ini: Ini
    hal: Hal
    answers: Answers
    length: str
    """Unit of its pins."""
    arguments: Mapping[str, str]

    def joints(self, letter: str) -> list[int]:
        """The joints that move an axis: several on a gantry."""
        return [joint for joint, each in enumerate(self.letters) if each == letter]

    @property
    def starts_holding_tip(self) -> bool:
        """Whether words are the tip from the start on; else M428 or the like switches to it."""
        identity_first = "identityfirst" in self.arguments.get("sparm", "")
        return self.name not in ("trivkins", "millturn", "xyzab_tdr_kins") and not identity_first

    def pin(self, name: str, default: float) -> Figure:
        """The value of an input, asked for where a program sets it while the control runs. Raises ControlFileError."""
        full = f"{self.name}.{name}"
        value = self.hal.value(full)
        if value is None:
            return Figure(default, (Origin(f"{full}, the module's own default"),))
        if value.unknown:
            question = Question(
                f"{full} [{self.length}]",
                f"{default:g}",
                f"the module's own default; HAL connects it to {value.unknown[0]}, whose value no file tells",
            )
            return self.answers.numbers(question, 1)
        return Figure(value.number, value.origins)

    def value(self, name: str) -> PinValue | None:
        """What HAL gives an input; None where it keeps the module's default."""
        return self.hal.value(f"{self.name}.{name}")


def loaded_module(ini: Ini, hal: Hal, answers: Answers, length: str) -> Module:
    """The module of an INI and its HAL files. Raises ControlFileError where it is none that can be read."""
    entry = _entry(ini, hal)
    name, *more = entry.word().split()
    arguments = dict(part.partition("=")[::2] for part in more)
    if name not in USUAL_LETTERS:
        why = REFUSED.get(name, "it has not three straight and two turning axes")
        readable = ", ".join(USUAL_LETTERS)
        raise entry.origin.error(f"= {name[:40]}: these kinematics cannot be read: {why} (known: {readable})")
    letters = arguments.get("coordinates", "").upper() or USUAL_LETTERS[name]
    module = Module(name, letters, entry.origin, ini, hal, answers, length, arguments)
    _check_letters(module)
    return module


def _entry(ini: Ini, hal: Hal) -> Entry:
    """Where the module is named: in the INI, or by `loadrt` of a HAL file; both must agree."""
    entry = ini.entry("KINS", "KINEMATICS")
    modules = {*USUAL_LETTERS, *REFUSED}
    by_hal = [Entry(text, origin) for text, origin in hal.loaded if text.split()[0] in modules]
    if entry is None and not by_hal:
        raise ControlFileError(
            "[KINS] KINEMATICS is missing, and no HAL file loads kinematics; add it", file=ini.file.name
        )
    if entry is None or not entry.word():
        return by_hal[0] if by_hal else _empty(entry)
    for other in by_hal:
        if other.word().split()[0] != entry.word().split()[0]:
            raise other.origin.error(
                f"loads {other.word().split()[0]}, and {entry.origin} is {entry.word()[:60]}; correct one of both"
            )
    return entry


def _empty(entry: Entry | None) -> Entry:
    assert entry is not None
    raise entry.origin.error("is empty; name the kinematics module")


def _check_letters(module: Module) -> None:
    """Refuse letters that are none, or too few for the module or its number of joints."""
    at = module.origin
    for letter in module.letters:
        if letter not in LETTERS:
            raise at.error(f"names the axis '{letter}', which LinuxCNC does not have; its axes are {LETTERS}")
    for letter in NEEDED.get(module.name, ""):
        if letter not in module.letters:
            raise at.error(f"has coordinates {module.letters} without {letter}, which {module.name} needs; add it")
    count = module.ini.entry("KINS", "JOINTS")
    if count is not None and "coordinates" in module.arguments and count.figure().number < len(module.letters):
        raise count.origin.error(
            f"= {count.word()[:20]} is less than the {len(module.letters)} axes of {at} ({module.letters}); "
            "correct one of both"
        )


def axis_letters(module: Module) -> str:
    """The axes that programs may move: [TRAJ] COORDINATES, each letter once. Raises ControlFileError."""
    entry = module.ini.entry("TRAJ", "COORDINATES")
    if entry is None or not entry.word():
        count = module.ini.figure("KINS", "JOINTS")
        moved = module.letters if count is None else module.letters[: int(min(max(count.number, 0.0), 99.0))]
        return "".join(dict.fromkeys(moved))
    letters = "".join(entry.word().upper().split())
    for letter in letters:
        if letter not in module.letters:
            raise entry.origin.error(
                f"= {entry.word()[:40]} names {letter}, which no joint of {module.origin} moves ({module.letters}); "
                "correct one of both"
            )
    return "".join(dict.fromkeys(letters))
