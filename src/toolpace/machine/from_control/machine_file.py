"""A machine file and a controller file from a record: TOML text in which each figure says where it is from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpace.common.errors import printable
from toolpace.common.files.toml import toml_key, toml_value
from toolpace.common.units import JOINT_LIMITS
from toolpace.machine.from_control.control_file import load
from toolpace.machine.from_control.readers import read_record
from toolpace.machine.from_control.record import Figure, MachineRecord, Value
from toolpace.machine.from_control.stand_ins import Answers, Question, complete
from toolpace.machine.from_control.unplaced_axes import ALONG
from toolpace.machine.machine import Machine
from toolpace.machine.plausibility import LONGEST_NAME

CHAIN = ("workpiece", "workpiece_origin", "workpiece_x", "workpiece_z", "tool", "spindle_nose", "tool_axis",
         "tool_length")  # fmt: skip
JOINT = ("kind", "direction", "point", "travel", "wrap", "velocity", "acceleration", "jerk")
"""Order of the keys."""
UNITS = {"travel": "", "velocity": "/s", "acceleration": "/s^2", "jerk": "/s^3"}
ACROSS = 1e-3
"""Cosine below which two directions are across each other."""
COLUMN = 34
"""At which comments begin."""


@dataclass(frozen=True)
class MachineDraft:
    """A machine that a control's files tell, with what has to be compared with the real one."""

    record: MachineRecord
    text: str
    """Of the machine file."""
    machine: Machine
    stand_ins: tuple[Question, ...]
    """What was taken for what the files lack."""
    controller: str
    """Text of the controller file; empty where the files tell no figures of how the control moves."""


def read_control(paths: Sequence[str | Path], answers: Answers | None = None) -> MachineDraft:
    """The machine that the files of its control tell. Raises ControlFileError, MachineError.

    Without `answers` all that the files lack is taken as a stand-in.
    """
    answers = Answers() if answers is None else answers
    record = read_record([load(Path(path)) for path in paths], answers)
    complete(record, answers)
    record.remarks += _across_letters(record)
    source = record.files[0]
    machine = Machine.from_toml(machine_text(record, answers.taken, {}), source)
    both = zip(machine.geometry.rotary_joints, machine.geometry.leanings)
    leanings = {name: words for name, words in both if name not in record.held}
    text = machine_text(record, answers.taken, leanings)
    return MachineDraft(record, text, machine, tuple(answers.taken), controller_text(record))


def _across_letters(record: MachineRecord) -> Iterator[str]:
    """Remarks on turning axes across the direction of their letter: the two of a machine are easily changed over."""
    for name, joint in record.joints.items():
        if joint["kind"].value != "rotary" or name not in ALONG:
            continue
        along = sum(one * other for one, other in zip(joint["direction"].vector, ALONG[name]))
        if abs(along) < ACROSS * math.hypot(*joint["direction"].vector):
            yield (
                f"{name} turns across the direction of its letter ({joint['direction'].origin}), other than ISO 841 "
                "has it: are two axes changed over?"
            )


def machine_text(record: MachineRecord, stand_ins: Sequence[Question], leanings: Mapping[str, str]) -> str:
    """The text of a machine file; `leanings` says by joint what 30 degrees of it do to the tool axis."""
    shown = record.named(_short_names(record.files))
    return "\n".join([*_heading(shown, stand_ins), *_tables(shown, leanings)]) + "\n"


def controller_text(record: MachineRecord) -> str:
    """The text of a controller file with the figures of a control; empty where there are none."""
    if not record.timing:
        return ""
    shown = record.named(_short_names(record.files))
    lines = [
        f"# From the files of a {record.control} control: {', '.join(map(printable, record.files))}.",
        f"name = {toml_value(f'{record.name} control'[:LONGEST_NAME])}",
        f"like = {toml_value(record.controller)}",
    ]
    table = ""
    for key, figure in sorted(shown.timing.items(), key=lambda item: item[0].rpartition(".")[0]):
        *of_model, name = key.split(".")
        if (heading := ".".join(["time", *of_model])) != table:
            lines += ["", f"[{heading}]"]
            table = heading
        lines.append(_line(name, figure))
    return "\n".join(lines) + "\n"


def _short_names(files: Sequence[str]) -> dict[str, str]:
    """Names of files without their folders, as far as these are distinct."""
    last = {name: Path(name).name for name in files}
    return {name: short for name, short in last.items() if list(last.values()).count(short) == 1}


def _heading(record: MachineRecord, stand_ins: Sequence[Question]) -> Iterator[str]:
    yield f"# From the files of a {record.control} control: {', '.join(map(printable, record.files))}."
    yield "# Behind each figure stands where it is from. Compare poses with the real machine (machines --poses)."
    for each in stand_ins:
        yield printable(f"# NOT in these files: {each.what}; {each.stand_in} is a stand-in, {each.reason}.")
    for remark in record.remarks:
        yield printable(f"# {remark}")
    for name, figure in record.control_figures.items():
        yield printable(f"# The control: {name} = {_value(figure.value)} ({figure.origin}).")


def _tables(record: MachineRecord, leanings: Mapping[str, str]) -> Iterator[str]:
    yield f"name = {toml_value(record.name)}"
    yield f"note = {toml_value(f'from the files of its {record.control} control')}"
    yield ""
    yield "[units]"
    yield _line("length", record.length)
    yield _line("angle", record.angle)
    yield ""
    yield "[chain]"
    yield from (_line(key, record.chain[key]) for key in CHAIN if key in record.chain)
    for name, joint in record.joints.items():
        unit = str((record.angle if joint["kind"].value == "rotary" else record.length).value)
        yield ""
        yield f"[joints.{toml_key(name)}]"
        for key in JOINT:
            if key in joint and joint[key].falls:
                yield _curve_line(key, joint, unit)
            elif key in joint:
                words = leanings.get(name, "") if key == "direction" else ""
                yield _line(key, joint[key], words or (unit + UNITS[key] if key in UNITS else ""))
    if record.machine_zero:
        yield ""
        yield "[setup.machine_zero]"
        yield from (_line(letter, figure) for letter, figure in record.machine_zero.items())


def _curve_line(key: str, joint: Mapping[str, Figure], unit: str) -> str:
    """A key with a limit that falls with the speed, as corners in the units of the file."""
    units, figure, velocity = JOINT_LIMITS[str(joint["kind"].value)], joint[key], joint["velocity"]
    most, top = (
        each.number * (units[name][each.unit] / units[name][unit + own.replace("^", "")] if each.unit else 1.0)
        for name, each, own in (("velocity", velocity, UNITS["velocity"]), (key, figure, UNITS[key]))
    )
    corners = tuple((f"{speed * most:.12g}", f"{share * top:.12g}") for speed, share in figure.falls)
    value = "[" + ", ".join(f"[{speed}, {limit}]" for speed, limit in corners) + "]"
    return f"{key} = {value}  # {printable(f'{unit}{UNITS[key]} at {unit}/s; {figure.origin}')}"


def _line(key: str, figure: Figure, meaning: str = "") -> str:
    """A key with its value, and behind it what it means and where it is from."""
    value = toml_value(f"{_value(figure.value)} {figure.unit}") if figure.unit else _value(figure.value)
    comment = f"{meaning}; {figure.origin}" if meaning and not figure.unit else figure.origin
    return f"{f'{key} = {value}':<{COLUMN}}  # {printable(comment)}"


def _value(value: Value) -> str:
    """A value as TOML, numbers without a needless point and without the rounding of sums."""
    if isinstance(value, tuple):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    if isinstance(value, (bool, str)):
        return toml_value(value)
    return f"{value:.15g}"
