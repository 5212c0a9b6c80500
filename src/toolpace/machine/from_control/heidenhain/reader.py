"""A record from the machine parameters, configuration objects and kinematics of a Heidenhain control.

Numbers of the iTNC (Technical Manual iTNC 530 HSCI): MP100 letters of the axes, MP810 and MP812 counting of rotary
axes, MP910 and MP920 software limits, MP1010 rapid traverse, MP1060 acceleration, MP1085 and MP1086 jerk of an axis,
MP1090 of the path, MP1092 feed from which the second of both holds (page 815). The TNC 640 has them as attributes of
objects with the axis as their key. Feeds are in mm/min and deg/min, accelerations and jerks in m/s^2 and m/s^3, and of
rotary axes in 1000 deg (assumption): with these the manuals' guide value of the jerk, acceleration^2 * 60000 / rapid
traverse, is one formula for both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from toolpace.machine.from_control.control_file import ControlFile, ControlFileError, machine_name
from toolpace.machine.from_control.heidenhain.chain import place_by_steps
from toolpace.machine.from_control.heidenhain.texts import Entry, Texts, kind_of, read_texts
from toolpace.machine.from_control.heidenhain.walk import TURNING, axis_letter, steps_of
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin, lowest, travel
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.from_control.unplaced_axes import ALONG, Unplaced, place_axes

CONTROL = "Heidenhain"
TOLD_BY = "machine parameters as MP1010.0 : 30000, configuration objects as CfgFeedLimits( ... ), a kinematics table"
OF_AXIS = {
    "rapidFeed": 1010,
    "maxAcceleration": 1060,
    "axPathJerk": 1085,
    "axPathJerkHi": 1086,
    "swLimitSwitchPos": 910,
    "swLimitSwitchNeg": 920,
}
"""Attributes of an axis, and the machine parameters of the iTNC that they were."""
OF_PATH = {"maxPathJerk": (1090, 0), "maxPathJerkHi": (1090, 1), "maxG1Feed": (1092, 0),
           "minPathFeed": (-1, 0), "minCornerFeed": (-1, 0)}  # fmt: skip
FARTHEST = 99_999.0
"""A software limit that is no nearer is none [mm or deg]."""


def recognises(file: ControlFile) -> bool:
    """Whether a text is one of a Heidenhain control."""
    return bool(kind_of(file))


def read(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The machine of a control. Raises ControlFileError."""
    texts = Texts()
    for file in files:
        read_texts(texts, file)
    length = Figure("mm", (Origin("machine parameters are in mm"),))
    angle = Figure("deg", (Origin("machine parameters are in degrees"),))
    record = MachineRecord(CONTROL, machine_name(files[0], CONTROL), tuple(file.name for file in files), length, angle)
    steps = steps_of(texts, answers)
    if not steps and not _axis_keys(texts) and not any(number in OF_AXIS.values() for number, _ in texts.parameters):
        raise ControlFileError("tells nothing of axes; give their machine parameters or objects", file=files[0].name)
    moved = "".join(step.axis for step in steps if step.kind == "machaxis" and step.axis in ALONG)
    letters = _letters(texts, moved, answers)
    turning = [letter for letter in letters if letter in TURNING and (letter in moved or not steps)]
    for letter in (*"XYZ", *turning):
        record.joints[letter] = _joint(texts, letters, letter, answers)
    if steps:
        place_by_steps(steps, record)
    else:
        for letter in "XYZ":
            record.joints[letter]["direction"] = Figure(ALONG[letter], (Origin(f"axis {letter}"),))
        entry = _first_entry(texts)
        place_axes(Unplaced(record, answers, "no kinematics table", entry.origin, "the axes"), "".join(record.joints))
    for letter in "XYZ":
        record.machine_zero[letter] = Figure(0.0, (Origin("the REF display shows positions of the joints"),))
    record.controller = "heidenhain"
    record.timing |= dict(_timing(texts, letters, list(record.joints)))
    _add_remarks(texts, record, letters, bool(steps))
    return record


def _first_entry(texts: Texts) -> Entry:
    """Any value, as a place for errors about all of them."""
    entries = [*texts.parameters.values(), *(e for each in texts.objects for e in each.attributes.values())]
    return entries[0]


def _letters(texts: Texts, moved: str, answers: Answers) -> dict[str, int]:
    """Axis letters with their index in machine parameters; 0 to n in the order of the objects where these tell them.

    Raises ControlFileError for a letter twice, and without X, Y or Z.
    """
    if (entry := texts.parameters.get((100, 0))) is not None:
        # characters count from the right, "-" is an axis that is not there
        names = entry.text.upper()[::-1]
        letters = {letter: index for index, letter in enumerate(names) if letter.isalpha()}
        for letter in letters:
            if names.count(letter) > 1:
                raise entry.origin.error(f"= {entry.text[:40]} has the letter {letter} twice; correct it")
        missing = [letter for letter in "XYZ" if letter not in letters]
        if missing:
            raise entry.origin.error(f"= {entry.text[:40]} has no {', '.join(missing)}; a machine here has X, Y and Z")
        return letters
    named = _axis_keys(texts)
    if not named:
        usual = "XYZ" + "".join(sorted(letter for letter in moved if letter in TURNING))
        question = Question(
            "letters of the axes 1, 2, ... (MP100 is not there)", usual, "X, Y, Z first, as most machines have them"
        )
        named = list(str(answers.text(question).value).upper())
    letters = {letter: index for index, letter in enumerate(dict.fromkeys(named)) if letter}
    missing = [letter for letter in "XYZ" if letter not in letters]
    if missing:
        found = ", ".join(letters) or "none"
        raise ControlFileError(
            f"no axis {', '.join(missing)} among those that are told ({found}); a machine here has X, Y and Z",
            file=_first_file(texts),
        )
    return letters


def _axis_keys(texts: Texts) -> list[str]:
    """Letters of the axes whose objects have figures that are read."""
    return [axis_letter(each.key) for each in texts.objects if set(each.attributes) & set(OF_AXIS)]


def _first_file(texts: Texts) -> str:
    return texts.table or _first_entry(texts).origin.file


def _of_axis(texts: Texts, letters: dict[str, int], letter: str, name: str) -> Figure | None:
    """A figure of an axis. Raises ControlFileError where two sets of an axis tell it unlike."""
    found = [
        each.attributes[name]
        for each in texts.objects
        if name in each.attributes and axis_letter(each.key) == letter
    ]
    parameter = texts.parameters.get((OF_AXIS[name], letters[letter]))
    found += [] if parameter is None else [parameter]
    for other in found[1:]:
        if other.figure().number != found[0].figure().number:
            raise other.origin.error(
                f"= {other.text[:40]} contradicts {found[0].origin} = {found[0].text[:40]} of the same axis; leave out "
                "the set of parameters that is not in use"
            )
    return found[0].figure() if found else None


def _above_zero(texts: Texts, letters: dict[str, int], letter: str, name: str) -> Figure | None:
    """A limit of an axis; zero is one that is not set."""
    figure = _of_axis(texts, letters, letter, name)
    if figure is not None and figure.number < 0.0:
        raise figure.origins[0].error(f"= {figure.number:g}; give a number above zero")
    return figure if figure is not None and figure.number > 0.0 else None


def _of_path(texts: Texts, name: str) -> Figure | None:
    """A figure of the path; zero is one that is not set."""
    entries = [each.attributes[name] for each in texts.objects if name in each.attributes]
    if (parameter := texts.parameters.get(OF_PATH[name])) is not None:
        entries.append(parameter)
    figure = entries[0].figure() if entries else None
    return figure if figure is not None and figure.number > 0.0 else None


def _joint(texts: Texts, letters: dict[str, int], letter: str, answers: Answers) -> dict[str, Figure]:
    """Kind, limits and travel of an axis; keys are those of a machine file."""
    rotary = letter in TURNING
    scale, unit = (1000.0, "deg") if rotary else (1.0, "m")
    figures = {"kind": Figure("rotary" if rotary else "linear", (Origin(f"axis {letter}"),))}
    rapid = _above_zero(texts, letters, letter, "rapidFeed")
    if rapid is not None:
        figures["velocity"] = Figure(rapid.value, rapid.origins, "deg/min" if rotary else "mm/min")
    acceleration = _above_zero(texts, letters, letter, "maxAcceleration")
    if acceleration is not None:
        figures["acceleration"] = Figure(acceleration.number * scale, acceleration.origins, f"{unit}/s2")
    jerk = _above_zero(texts, letters, letter, "axPathJerk") or _of_path(texts, "maxPathJerk")
    if jerk is None and acceleration is not None and rapid is not None:
        guide = acceleration.number**2 * 60_000.0 / rapid.number
        question = Question(f"jerk of {letter} [{'1000 deg' if rotary else 'm'}/s^3]", f"{guide:.6g}",
                            "Heidenhain's guide value: acceleration^2 * 60000 / rapid traverse")  # fmt: skip
        jerk = answers.numbers(question, 1)
    if jerk is not None:
        figures["jerk"] = Figure(jerk.number * scale, jerk.origins, f"{unit}/s3")
    return figures | _reach(texts, letters, letter)


def _reach(texts: Texts, letters: dict[str, int], letter: str) -> dict[str, Figure]:
    """The travel between the software limits, or none for a rotary axis that counts modulo without them."""
    high = _of_axis(texts, letters, letter, "swLimitSwitchPos")
    low = _of_axis(texts, letters, letter, "swLimitSwitchNeg")
    modulo = _modulo(texts, letters, letter) if letter in TURNING else None
    if modulo is not None:
        return {"wrap": Figure(True, (modulo,))}
    if high is None or low is None:
        return {}
    unset = high.number == low.number == 0.0 or (high.number >= FARTHEST and low.number <= -FARTHEST)
    if unset:
        return {"wrap": Figure(True, high.origins + low.origins)} if letter in TURNING else {}
    return {"travel": travel(low, high)}


def _modulo(texts: Texts, letters: dict[str, int], letter: str) -> Origin | None:
    """Where it stands that a rotary axis counts modulo 360 degrees, and its limits are not watched (assumption)."""
    for each in texts.objects:
        entry = each.attributes.get("isModulo")
        if entry is not None and axis_letter(each.key) == letter and entry.is_true:
            return entry.origin
    display = texts.parameters.get((810, letters[letter]))
    if display is None or display.figure().number == 0.0:
        return None
    watched = texts.parameters.get((812, 0))
    bits = "" if watched is None else watched.text.lstrip("%")[::-1]
    return None if bits[letters[letter] : letters[letter] + 1] == "1" else display.origin


def _timing(texts: Texts, letters: dict[str, int], joints: Sequence[str]) -> Iterator[tuple[str, Figure]]:
    """Figures of the model `heidenhain` (controls/timing/figures.py)."""
    for name, key in (("maxPathJerk", "path_jerk"), ("maxPathJerkHi", "path_jerk_rapid"),
                      ("minCornerFeed", "least_corner_feed"), ("minPathFeed", "least_path_feed")):  # fmt: skip
        figure = _of_path(texts, name)
        if figure is not None:
            yield f"heidenhain.{key}", figure
    shares = []
    for letter in joints:
        if letter in letters:
            own = _above_zero(texts, letters, letter, "axPathJerk")
            rapid = _above_zero(texts, letters, letter, "axPathJerkHi")
            if own is not None and rapid is not None:
                shares.append(Figure(rapid.number / own.number, rapid.origins + own.origins))
    if shares:
        yield "heidenhain.axis_jerk_rapid", lowest(shares)


def _add_remarks(texts: Texts, record: MachineRecord, letters: dict[str, int], placed: bool) -> None:
    """What a person should know who compares the machine with the files."""
    if any(letter in TURNING for letter in letters):
        record.remarks.append("Accelerations and jerks of rotary axes count in 1000 deg (assumption).")
    if (100, 0) in texts.parameters:
        record.remarks.append("MP100 names axis 1 by its last letter (assumption).")
    if any("subKinList" in each.attributes for each in texts.objects):
        record.remarks.append("axisRef, dir, val of kinematic objects are axis, direction and value (assumption).")
    if texts.strange:
        record.remarks.append(
            f"Lines that begin as a parameter and have no value: {len(texts.strange)}, the first is {texts.strange[0]}."
        )
    if texts.inch_table is not None:
        record.remarks.append(f"{texts.inch_table}: lengths of the kinematics table are inches.")
    if not texts.table_ends:
        record.remarks.append(f"{texts.table} does not end with [END]: is it whole?")
    first = texts.parameters.get((7510, 0))
    if not placed and first is not None and first.text.strip("%0"):
        record.remarks.append(f"{first.origin} and following, the old kinematics, are not read: give a table.")
    for letter in letters:
        if letter not in record.joints:
            record.remarks.append(f"The axis {letter} rests: it is no joint of this machine.")
    if (feed := _of_path(texts, "maxG1Feed")) is not None:
        record.control_figures["feed from which the jerk of rapid traverse holds [mm/min]"] = feed
