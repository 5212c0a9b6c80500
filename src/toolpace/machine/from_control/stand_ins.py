"""What a control's files lack: asked for, or taken as a stand-in that is named in the machine file."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from toolpace.common.errors import did_you_mean
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin, Value
from toolpace.machine.plausibility import USUAL

JERK_PER_ACCELERATION = 10.0
"""[1/s]"""
ATTEMPTS = 3
"""Times that a person is asked, before a wrong answer is an error."""
FAR = {"linear": 1.0, "rotary": 2.0 * math.pi}
"""Travel to either side of zero of a joint without limits [m or rad]."""
ANSWERED = "answered to the question for it"


@dataclass(frozen=True)
class Question:
    """What is missing, what would be taken for it, and why just that."""

    what: str
    """As `jerk of X [mm/s^3]`."""
    stand_in: str
    """As it would be typed: a number, numbers with commas, or a word."""
    reason: str
    """As `ten times the acceleration, per second`."""
    complaint: str = ""
    """What was wrong with the answer before."""


@dataclass
class Answers:
    """Gives what is missing: what a person answers, or the stand-in where nobody is asked or nothing is typed."""

    ask: Callable[[Question], str] | None = None
    taken: list[Question] = field(default_factory=list)
    """Stand-ins that were taken."""

    def text(self, question: Question) -> Figure:
        """Any word."""
        answer = self.ask(question).strip() if self.ask is not None else ""
        if answer:
            return Figure(answer, (Origin(ANSWERED),))
        self.taken.append(question)
        return Figure(question.stand_in, (Origin(f"stand-in: {question.reason}"),))

    def choice(self, question: Question, choices: Sequence[str]) -> Figure:
        """One of several words. Raises ControlFileError for others."""
        return self._read(question, lambda text: text if text in choices else None, did_you_mean("", choices))

    def numbers(self, question: Question, count: int) -> Figure:
        """Several numbers, as `0, 20, 10`; one alone is no tuple. Raises ControlFileError for anything else."""

        def read(text: str) -> float | tuple[float, ...] | None:
            try:
                values = tuple(float(part) for part in text.split(","))
            except ValueError:
                return None
            if len(values) != count or not all(map(math.isfinite, values)):
                return None
            return values[0] if count == 1 else values

        return self._read(question, read, "give a number" if count == 1 else f"give {count} numbers, commas between")

    def _read(self, question: Question, read: Callable[[str], Value | None], cure: str) -> Figure:
        """The answer as a value; a person who mistypes is asked again."""
        for attempt in range(ATTEMPTS):
            figure = self.text(question)
            value = read(str(figure.value))
            if value is not None:
                return Figure(value, figure.origins)
            complaint = f"'{str(figure.value)[:40]}'; {cure}"
            if self.ask is None or attempt + 1 == ATTEMPTS:
                break
            question = replace(question, complaint=complaint)
        raise ControlFileError(f"{question.what}: {complaint}")


def complete(record: MachineRecord, answers: Answers) -> None:
    """Fill in the limits and travel that each joint of a record lacks; its reader sees to the chain itself."""
    for name, joint in record.joints.items():
        kind = str(joint["kind"].value)
        unit = str((record.angle if kind == "rotary" else record.length).value)
        scale = {"mm": 1e-3, "in": 0.0254, "m": 1.0, "deg": math.pi / 180.0, "rad": 1.0}[unit]
        for key, power in (("velocity", ""), ("acceleration", "^2")):
            if key not in joint:
                usual = USUAL[kind][key].typical / scale
                question = Question(
                    f"{key} of {name} [{unit}/s{power}]", f"{usual:.3g}", "what machine tools of middle size have"
                )
                joint[key] = answers.numbers(question, 1)
        if "jerk" not in joint:
            acceleration = joint["acceleration"]
            per = acceleration.unit or f"{unit}/s2"
            jerk = Question(
                f"jerk of {name} [{per.replace('s2', 's^3')}]",
                f"{JERK_PER_ACCELERATION * acceleration.number:.12g}",
                "ten times the acceleration, per second",
            )
            figure = answers.numbers(jerk, 1)
            joint["jerk"] = Figure(figure.value, figure.origins, acceleration.unit.replace("s2", "s3"))
        if "travel" not in joint and "wrap" not in joint:
            end = f"{FAR[kind] / scale:.6g}"
            reach = Question(f"travel of {name} [{unit}]", f"-{end}, {end}", "the control's files limit it nowhere")
            joint["travel"] = answers.numbers(reach, 2)
