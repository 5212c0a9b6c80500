"""The kinematics of a Heidenhain as a walk from the tool's reference point to the workpiece, step by step.

"From this entry onward, movements by the indicated axis change the positions of previously defined axes or objects
relative to subsequent axes or objects. The start of the sequence is always the tool reference point." (Technical
Manual iTNC 530 HSCI, page 722, of MachAxis.) Trans moves the coordinate system along an axis of its own, or turns it
about one.

The TNC 640 has the same walk as objects: CfgKinComposModel names subkinematics, from the tool to the table, and these
name their objects (Technical Manual MANUALplus 620, pages 735 to 742). How these objects call axis, direction and value
(axisRef, dir, val) is an assumption.

CfgKinModel, which is older, has coordinate systems in place of steps (the same manual, pages 748 to 758): from the
machine's base one for each axis of the tool's side, and of the workpiece's, each by its origin and the directions of
its Z and X in the one before. An axis goes along Z of its own, or turns about it: the way in which the tool moves, and
against that in which the workpiece does. The tool's system is behind the last of its side, the table's behind that of
the workpiece; that the tool points along Z of its system is an assumption.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.from_control.heidenhain.texts import KEYS, ConfigurationObject, Entry, Texts
from toolpace.machine.from_control.record import Figure, Origin
from toolpace.machine.from_control.stand_ins import Answers, Question

LINEAR, TURNING = "XYZ", "ABC"
PASSED_OVER = ("toolfile", "cmo")
"""Keys of rows that move no axis: a tool carrier of the tool table, bodies for collisions."""
VECTORS = "CfgKinModel"
ALONG_Z = {"X": ("B", -90.0), "A": ("B", -90.0), "Y": ("A", 90.0), "B": ("A", 90.0)}
"""By the letter of an axis: the turn after which its letter's direction is where Z was [deg]."""
SQUARE = 1e-6
"""Cosine between the directions of Z and X below which they are across."""
UPRIGHT = 1e-12
"""Cosine of the second of three turns below which the first does what the third would."""


@dataclass(frozen=True)
class Step:
    """One step of the walk."""

    kind: str
    """"trans", "machaxis", "machbase" or "toolaxis"."""
    axis: str
    origin: Origin
    value: Figure | None = None
    """Of a transformation [mm or deg]."""
    sense: float = 1.0
    """-1 for an axis that counts against its letter."""


def steps_of(texts: Texts, answers: Answers) -> list[Step]:
    """The walk from the tool to the workpiece; empty without kinematics. Raises ControlFileError."""
    models = [each for each in texts.objects if "subKinList" in each.attributes]
    models = models or [each for each in texts.objects if each.kind == VECTORS]
    if texts.rows and models:
        raise models[0].origin.error(f"is a kinematic model beside the table {texts.table}; give one of both")
    if texts.rows or texts.table:
        return _of_table(texts)
    if not models:
        return []
    model = _chosen(models, answers)
    return list(_of_vectors(texts, model)) if model.kind == VECTORS else _of_model(texts, model)


def _of_table(texts: Texts) -> list[Step]:
    inches = 25.4 if texts.inch_table is not None else 1.0
    steps = []
    for row in texts.rows:
        if row.key in PASSED_OVER:
            continue
        if row.key in ("subfile1", "subfile2"):
            raise row.origin.error("stands for a partial kinematics table; copy its lines to this place")
        value = None
        if row.key == "trans":
            if row.coordinate is None:
                raise row.origin.error("has no COORD; correct the line")
            figure = row.coordinate.figure()
            value = Figure(figure.number * (inches if row.axis in LINEAR else 1.0), figure.origins)
        elif row.key not in KEYS:
            raise row.origin.error("is no key that is read: Trans, MachAxis, MachBase, ToolAxis; correct it")
        steps.append(Step(row.key, row.axis, row.origin, value))
    return steps


def _chosen(models: Sequence[ConfigurationObject], answers: Answers) -> ConfigurationObject:
    """The kinematic model in force, asked for where there are several."""
    if len(models) == 1:
        return models[0]
    keys = [each.key for each in models]
    question = Question(f"kinematic model ({', '.join(keys)})"[:300], keys[0], "the first of the file")
    answer = answers.choice(question, keys)
    return next(each for each in models if each.key == answer.value)


def _of_model(texts: Texts, model: ConfigurationObject) -> list[Step]:
    by_key: dict[str, list[ConfigurationObject]] = {}
    for each in texts.objects:
        by_key.setdefault(each.key, []).append(each)
    steps = []
    for name in model.attributes["subKinList"].elements():
        part = next((each for each in by_key.get(name, ()) if "kinObjects" in each.attributes), None)
        if part is None:
            origin = model.attributes["subKinList"].origin
            raise origin.error(f"names {name[:40]}, which is not there; give its file too")
        listed = part.attributes["kinObjects"]
        for key in listed.elements():
            found = [each for each in by_key.get(key, ()) if each.kind.startswith("CfgKin") and each is not part]
            if not found:
                raise listed.origin.error(f"names {key[:40]}, which is not there; give its file too")
            steps.append(_of_object(found[0]))
    return steps


def _of_object(each: ConfigurationObject) -> Step:
    """A step from an object of a subkinematics."""
    attributes = each.attributes
    direction = attributes["dir"].text.upper() if "dir" in attributes else ""
    sense = -1.0 if direction.startswith("-") else 1.0
    axis = direction.lstrip("+-")
    if "axisRef" in attributes:
        return Step("machaxis", axis or axis_letter(attributes["axisRef"].text), each.origin, sense=sense)
    if "val" in attributes:
        figure = attributes["val"].figure()
        return Step("trans", axis, each.origin, Figure(sense * figure.number, figure.origins))
    if "base" in each.key.lower() or "anchor" in each.kind.lower():
        return Step("machbase", "", each.origin)
    raise each.origin.error("has neither axisRef nor val, and is no fixed base: what it does is not known")


def axis_letter(key: str) -> str:
    """The letter of an axis by the key of its objects, as X, X1, PX or AX_X; empty where none stands by itself."""
    for position, letter in enumerate(key.upper()):
        before, after = key.upper()[:position], key.upper()[position + 1 : position + 2]
        if letter in LINEAR + TURNING + "UVW" and not after.isalpha() and (not before[-1:].isalpha() or before == "P"):
            return letter
    return ""


def _of_vectors(texts: Texts, model: ConfigurationObject) -> Iterator[Step]:
    """The walk of a model of coordinate systems."""
    tool = _systems(texts, model, "Tool")
    yield from _back(_system(texts, model, "toolCoordSys"))
    for letter, system in reversed(tool):
        yield from _along_z(letter, system)
        yield from _back(system.steps)
    yield Step("machbase", "", model.origin)
    for letter, system in _systems(texts, model, "Wp"):
        yield from system.steps
        yield from _along_z(letter, system)
    yield from _system(texts, model, "machineTableSys")


@dataclass(frozen=True)
class _AxisSystem:
    """The coordinate system of an axis."""

    origin: Origin
    steps: list[Step]
    """From the one before."""


def _systems(texts: Texts, model: ConfigurationObject, side: str) -> list[tuple[str, _AxisSystem]]:
    """Letters and coordinate systems of the axes of a side, from the base on."""
    axes, systems = (model.attributes.get(f"{name}{side}Side") for name in ("axes", "trafo"))
    if axes is None or not axes.elements():
        return []
    keys = [] if systems is None else systems.elements()
    if len(keys) != len(axes.elements()):
        raise axes.origin.error(f"names {len(axes.elements())} axes, and trafo{side}Side has {len(keys)} systems")
    return [
        (axis_letter(axis), _AxisSystem(axes.origin, _steps_to(texts, key, axes.origin)))
        for axis, key in zip(axes.elements(), keys)
    ]


def _system(texts: Texts, model: ConfigurationObject, name: str) -> list[Step]:
    """To the system of tool or table; nothing where the model names none."""
    entry = model.attributes.get(name)
    return [] if entry is None or not entry.text else _steps_to(texts, entry.text, entry.origin)


def _steps_to(texts: Texts, key: str, origin: Origin) -> list[Step]:
    """To the coordinate system of a key from the one before it."""
    found = next((each for each in texts.objects if each.key == key and each.kind.startswith("CfgTrafoBy")), None)
    if found is None:
        raise origin.error(f"names {key[:40]}, which is not there; give its file too")
    angles = [found.attributes[name] for name in ("angle1", "angle2", "angle3") if name in found.attributes]
    if any(each.figure().number for each in angles):
        raise found.origin.error("turns by angles, whose order is not known; give it by zDir and xDir (CfgTrafoByDir)")
    steps = []
    if "location" in found.attributes:
        entry = found.attributes["location"]
        for axis, value in zip(LINEAR, _three(entry).tolist()):
            if value:
                steps.append(Step("trans", axis, entry.origin, Figure(value, (entry.origin,))))
    return steps + _turns(found)


def _turns(found: ConfigurationObject) -> list[Step]:
    """Turns about Z, Y and X of a system, each of its own, to one with these directions of Z and X."""
    entries = [found.attributes[name] for name in ("zDir", "xDir") if name in found.attributes]
    if len(entries) < 2:
        if entries:
            raise found.origin.error("needs both zDir and xDir; correct it")
        return []
    z, x = (_unit(entry) for entry in entries)
    if abs(float(z @ x)) > SQUARE:
        raise entries[1].origin.error(f"= {entries[1].text[:40]} is not across {entries[0].origin}; correct one")
    y = np.cross(z, x)
    level = math.hypot(x[0], x[1])
    about_z = math.atan2(x[1], x[0]) if level > UPRIGHT else 0.0
    sine, cosine = math.sin(about_z), math.cos(about_z)
    about_x = math.atan2(sine * z[0] - cosine * z[1], cosine * y[1] - sine * y[0])
    angles = {"C": about_z, "B": math.atan2(-x[2], level), "A": about_x}
    origins = tuple(entry.origin for entry in entries)
    return [
        Step("trans", axis, origins[0], Figure(math.degrees(angle), origins)) for axis, angle in angles.items() if angle
    ]


def _three(entry: Entry) -> Floats:
    """(3,) the numbers of a list. Raises ControlFileError."""
    figures = [replace(entry, text=text).figure().number for text in entry.elements()]
    if len(figures) != len(LINEAR):
        raise entry.origin.error(f"= {entry.text[:40]} has {len(figures)} numbers; it has 3")
    return np.array(figures)


def _unit(entry: Entry) -> Floats:
    """(3,) a direction of length 1. Raises ControlFileError."""
    vector = _three(entry)
    length = float(np.linalg.norm(vector))
    if not length > 0.0:
        raise entry.origin.error(f"= {entry.text[:40]} is no direction; correct it")
    return np.asarray(vector / length)


def _back(steps: Sequence[Step]) -> Iterator[Step]:
    """The way back along transformations."""
    for step in reversed(steps):
        assert step.value is not None
        yield replace(step, value=Figure(-step.value.number, step.value.origins))


def _along_z(letter: str, system: _AxisSystem) -> Iterator[Step]:
    """An axis that goes along Z of its system, or turns about it."""
    turn = ALONG_Z.get(letter)
    if turn is not None:
        yield Step("trans", turn[0], system.origin, Figure(turn[1], ()))
    yield Step("machaxis", letter, system.origin)
    if turn is not None:
        yield Step("trans", turn[0], system.origin, Figure(-turn[1], ()))
