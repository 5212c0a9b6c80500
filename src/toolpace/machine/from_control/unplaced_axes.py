"""Turning axes of which a control's files do not tell where they are: what carries them is asked for, or stood in for.

A control without five-axis functions moves each axis by its joint, whatever turns what. A machine with fewer than two
turning axes gets axes in their place that are held at zero, since every machine here has two.
"""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.plausibility import USUAL

ALONG = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0),
         "A": (1.0, 0.0, 0.0), "B": (0.0, 1.0, 0.0), "C": (0.0, 0.0, 1.0)}  # fmt: skip
"""Direction of an axis by its letter (ISO 841)."""
TURNING = "ABC"
HELD = 0.001
"""Travel to either side of zero of an axis that the machine does not have [deg]."""
TABLES = {"AC": "AC/", "BC": "BC/", "AB": "BA/"}
"""Two turning axes as a tilting table that carries another, with the usual one beneath."""
ABSENT = (Origin("the machine has no such axis: it is held at zero"),)


@dataclass(frozen=True)
class Unplaced:
    """What is known of a machine whose turning axes have no place in its files."""

    record: MachineRecord
    answers: Answers
    name: str
    """Of what does not tell the places, as `trivkins`."""
    origin: Origin
    """Where that stands, for errors."""
    axes_list: str
    """Where the control lists its axes, as `[TRAJ] COORDINATES`."""


def place_axes(unplaced: Unplaced, letters: str) -> None:
    """Fill in [chain], direction and point of the turning axes. Raises ControlFileError.

    letters: the machine's axes, of which those in TURNING turn.
    """
    record = unplaced.record
    turning = "".join(sorted(letter for letter in letters if letter in TURNING))
    if len(turning) > 2:
        raise unplaced.origin.error(
            f"has the turning axes {', '.join(turning)}; a machine here has two: take one out of {unplaced.axes_list}"
        )
    arrangement = _arrangement(unplaced, turning) if turning else Figure("/", ABSENT)
    workpiece, _, tool = str(arrangement.value).partition("/")
    for letter in turning:
        _ask_where(unplaced, letter, letter in workpiece)
    workpiece, tool = with_held_axes(record, turning, workpiece, tool)
    record.chain["workpiece"] = Figure(tuple(workpiece), arrangement.origins)
    record.chain["tool"] = Figure(("X", "Y", "Z", *tool), arrangement.origins)
    record.chain["spindle_nose"] = Figure((0.0, 0.0, 0.0), (Origin("the nose is at X, Y, Z"),))
    record.chain["tool_length"] = Figure(0.0, (Origin("tools have their lengths in the set-up sheet"),))


def _arrangement(unplaced: Unplaced, turning: str) -> Figure:
    """Which turning axes carry the workpiece and which the tool, as `AC/` or `C/A`: from the bed on either side."""
    orders = [turning] if len(turning) == 1 else [turning, turning[::-1]]
    choices = [f"{order[:k]}/{order[k:]}" for order in orders for k in range(len(order), -1, -1)]
    usual = TABLES.get(turning, f"{turning}/")
    question = Question(
        f"axes {', '.join(turning)}: those from the bed to the workpiece, a slash, those from the bed to the tool "
        f"({', '.join(dict.fromkeys(choices))})",
        usual,
        f"tables are the most frequent; {unplaced.name} does not tell",
    )
    return unplaced.answers.choice(question, choices)


def _ask_where(unplaced: Unplaced, letter: str, on_table: bool) -> None:
    """Point and sense of a turning axis."""
    point = Question(
        f"a point on the axis of {letter}, where the control displays X, Y, Z there [{unplaced.record.length.value}]",
        "0, 0, 0",
        f"machine zero; {unplaced.name} does not tell",
    )
    sense = Question(
        f"positive {letter} turns the tool, as the part sees it, by the right-hand rule (yes, no)",
        "yes",
        "as ISO 841 wants it",
    )
    joint = unplaced.record.joints[letter]
    joint["point"] = unplaced.answers.numbers(point, 3)
    answer = unplaced.answers.choice(sense, ("yes", "no"))
    sign = (-1.0 if on_table else 1.0) * (1.0 if answer.value == "yes" else -1.0)
    joint["direction"] = Figure(tuple(sign * part + 0.0 for part in ALONG[letter]), answer.origins)


def with_held_axes(record: MachineRecord, turning: str, workpiece: str, tool: str) -> tuple[str, str]:
    """Turning axes from the bed to workpiece and tool, with those held at rest that a machine here needs beside them.

    turning: letters of those that the machine has, none to two.
    """
    held = "C" if turning in ("A", "B") else "A" if turning == "C" else "AC" if not turning else ""
    for letter in held:
        hold_at_rest(record, letter)
    if held == "A":
        return ("A" + workpiece, tool) if "C" in workpiece else (workpiece, tool + "A")
    return workpiece + held, tool


def hold_at_rest(record: MachineRecord, letter: str) -> None:
    """An axis that the machine does not have, at rest."""
    record.held.append(letter)
    record.joints[letter] = {
        "kind": Figure("rotary", ABSENT),
        "direction": Figure(tuple(-part + 0.0 for part in ALONG[letter]), ABSENT),
        "point": Figure((0.0, 0.0, 0.0), ABSENT),
        "travel": Figure((-HELD, HELD), ABSENT),
    } | {key: Figure(usual.typical, ABSENT, f"rad/s{power}") for (key, usual), power in zip(
        USUAL["rotary"].items(), ("", "2", "3"))}  # fmt: skip
