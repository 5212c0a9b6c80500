"""A record from LinuxCNC's INI and HAL files."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from toolpace.machine.from_control.control_file import ControlFile, ControlFileError
from toolpace.machine.from_control.linuxcnc.hal import read_hal
from toolpace.machine.from_control.linuxcnc.ini import Ini, check_is_new, read_ini
from toolpace.machine.from_control.linuxcnc.limits import joint_figures
from toolpace.machine.from_control.linuxcnc.loaded import Module, axis_letters, loaded_module
from toolpace.machine.from_control.linuxcnc.tables_and_heads import CHAINS
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.from_control.unplaced_axes import ALONG, TURNING, Unplaced, place_axes
from toolpace.machine.plausibility import LONGEST_NAME

CONTROL = "LinuxCNC"
TOLD_BY = "an INI with [KINS] or [TRAJ]"
LENGTHS = {"mm": "mm", "metric": "mm", "in": "in", "inch": "in", "imperial": "in"}
ANGLES = {"deg": "deg", "degree": "deg", "degrees": "deg", "rad": "rad", "radian": "rad", "radians": "rad"}
PER_UNIT = {"mm": 1.0, "in": 1.0 / 25.4, "deg": 1.0, "rad": math.pi / 180.0}
"""Units in a millimetre or a degree, as LinuxCNC takes numbers in place of the names."""
SAME = 1e-4
"""By what share such a number may be off."""
HAL_WORDS = ("loadrt", "loadusr", "net", "setp", "sets", "addf", "source")
CONTROL_KEYS = {
    "MAX_LINEAR_VELOCITY": "velocity of the path [{}/s]",
    "MAX_LINEAR_ACCELERATION": "acceleration of the path [{}/s^2]",
    "MAX_LINEAR_JERK": "jerk of the path [{}/s^3]",
    "PLANNER_TYPE": "planner",
    "SCURVE_PEAK_SCALE": "scale of corner speeds of planner 1",
    "ARC_BLEND_ENABLE": "blending with arcs",
}
"""Of [TRAJ]: what the control keeps beside the limits of joints."""


def recognises(file: ControlFile) -> bool:
    """Whether a text is LinuxCNC's INI, by headings of its own; it may include the files that have them."""
    return any(re.match(r"\s*\[(KINS|TRAJ|EMCMOT|EMC)\]|#INCLUDE ", line) for line in file.lines)


def read(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The machine of an INI. Raises ControlFileError."""
    first, beside = _sorted(files)
    ini = read_ini(first, beside)
    check_is_new(ini)
    hal = read_hal(ini, beside)
    length = _unit(ini, "LINEAR_UNITS", LENGTHS)
    module = loaded_module(ini, hal, answers, str(length.value))
    letters = axis_letters(module)
    _check_axes(module, letters)
    turning = sorted(CHAINS[module.name][0] if module.name in CHAINS else set(letters) & set(TURNING))
    angle = _unit(ini, "ANGULAR_UNITS", ANGLES) if turning else Figure("deg", (Origin("nothing turns"),))
    record = MachineRecord(CONTROL, _name(ini), (*ini.files, *hal.files), length, angle)
    for letter in ("X", "Y", "Z", *turning):
        record.joints[letter] = joint_figures(module, letter)
        if letter in "XYZ":
            record.joints[letter]["direction"] = Figure(ALONG[letter], (Origin(f"axis {letter}"),))
    if module.name in CHAINS:
        CHAINS[module.name][1](module, record)
    else:
        place_axes(Unplaced(record, answers, module.name, module.origin, "[TRAJ] COORDINATES"), letters)
    for letter in "XYZ":
        record.machine_zero[letter] = Figure(0.0, (Origin("the display shows positions of the joints"),))
    _add_control(module, record)
    _add_remarks(module, record, letters)
    return record


def _sorted(files: Sequence[ControlFile]) -> tuple[ControlFile, list[ControlFile]]:
    """The INI, and the others, which must be HAL files or parts of it."""
    machines = [file for file in files if recognises(file)]
    whole = [file for file in machines if any(line.strip().startswith("[KINS]") for line in file.lines)]
    first = (whole or machines)[0]
    for other in whole[1:]:
        raise ControlFileError(f"is a second INI beside {first.name}; give one machine at a time", file=other.name)
    others = [file for file in files if file is not first]
    for file in others:
        commands = (line.split(None, 1) for line in file.lines)
        if not any(words and (words[0] in HAL_WORDS or words[0].startswith("[")) for words in commands):
            raise ControlFileError(f"is neither a HAL file nor a part of {first.name}; leave it out", file=file.name)
    return first, others


def _unit(ini: Ini, key: str, units: dict[str, str]) -> Figure:
    """The unit of lengths or angles. Raises ControlFileError where it is missing or none that can be read."""
    entry = ini.entry("TRAJ", key)
    if entry is None:
        raise ControlFileError(f"[TRAJ] {key} is missing; add it, as LinuxCNC needs it too", file=ini.file.name)
    word = entry.word().lower()
    name = units.get(word) or next((name for name in units.values() if _is_number(word, PER_UNIT[name])), None)
    if name is None:
        raise entry.origin.error(f"= '{entry.word()[:20]}'; give one of {', '.join(units)}")
    return Figure(name, (entry.origin,))


def _is_number(word: str, wanted: float) -> bool:
    """Whether a word is a number, and the one that is wanted but for rounding."""
    try:
        return math.isclose(float(word), wanted, rel_tol=SAME)
    except ValueError:
        return False


def _check_axes(module: Module, letters: str) -> None:
    """Refuse machines without X, Y or Z, or without an axis that their kinematics turn."""
    entry = module.ini.entry("TRAJ", "COORDINATES")
    at = module.origin if entry is None else entry.origin
    missing = [letter for letter in "XYZ" if letter not in letters]
    if missing:
        raise at.error(f"has no axis {', '.join(missing)}; a machine here has X, Y and Z (no lathe, no foam cutter)")
    turning = CHAINS[module.name][0] if module.name in CHAINS else ""
    for letter in turning:
        if letter not in letters:
            raise at.error(f"does not name {letter}, which {module.name} turns; add it")


def _name(ini: Ini) -> str:
    """[EMC] MACHINE, or the name of the file."""
    text = ini.word("EMC", "MACHINE") or Path(ini.file.name).stem
    kept = "".join(letter if letter.isprintable() else " " for letter in text).strip()[:LONGEST_NAME].strip()
    return kept or "linuxcnc"


def _add_control(module: Module, record: MachineRecord) -> None:
    """What [TRAJ] limits and chooses, and homes other than zero."""
    for key, words in CONTROL_KEYS.items():
        entry = module.ini.entry("TRAJ", key)
        if entry is not None:
            record.control_figures[words.format(module.length)] = entry.figure()
    for letter in record.joints:
        for joint in module.joints(letter)[:1]:
            home = module.ini.figure(f"JOINT_{joint}", "HOME")
            if home is not None and home.number:
                unit = record.angle.value if letter in TURNING else module.length
                record.control_figures[f"home of {letter} [{unit}]"] = home


def _add_remarks(module: Module, record: MachineRecord, letters: str) -> None:
    """What a person should know: missing sections, gantries, axes that rest, how the tip is held."""
    sections = module.ini.sections()
    for letter in letters:
        joints = module.joints(letter)
        for section in (f"AXIS_{letter}", *(f"JOINT_{joint}" for joint in joints)):
            if letter in record.joints and section not in sections:
                record.remarks.append(f"[{section}] is missing: is the file whole? LinuxCNC takes its own defaults.")
        if len(joints) > 1:
            record.remarks.append(f"{letter} is moved by joints {', '.join(map(str, joints))} together.")
        if letter not in record.joints:
            record.remarks.append(f"The axis {letter} rests at zero: it is no joint of this machine.")
    if module.name == "millturn":
        record.remarks.append("millturn: this is the machine as a mill; as a lathe X and Z change places.")
    if module.starts_holding_tip:
        record.remarks.append(
            f"{module.name} holds the tip when the control starts: its controller file has tip_mode_at_start = true."
        )
    for each in module.hal.not_there:
        record.remarks.append(f"{each} is not there: what it sets is not known.")
