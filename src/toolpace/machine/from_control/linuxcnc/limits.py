"""Limits and travel of an axis, from the sections of the axis and of its joints."""

from __future__ import annotations

from collections.abc import Sequence

from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.linuxcnc.ini import Ini
from toolpace.machine.from_control.linuxcnc.loaded import Module
from toolpace.machine.from_control.record import Figure, Origin, lowest, travel
from toolpace.machine.from_control.stand_ins import Question
from toolpace.machine.from_control.unplaced_axes import TURNING

ENDLESS = 1e9
"""A limit of travel beyond it is none: LinuxCNC's own default is 1e99."""
LEAST_JERK, NO_JERK_LIMIT = 1.0, 1e9
"""A [TRAJ] MAX_LINEAR_JERK below the one counts as none, and from the other on it limits nothing."""
DEFAULT = 1.0
"""LinuxCNC's velocity and acceleration where no section tells them."""


def joint_figures(module: Module, letter: str) -> dict[str, Figure]:
    """Kind, limits and travel of the joints that move an axis together, each the lowest of all sections that tell it.

    Keys are those of a machine file; jerk and travel are left out where nothing tells them. Raises ControlFileError.
    """
    ini, rotary = module.ini, letter in TURNING
    sections = [f"AXIS_{letter}", *(f"JOINT_{joint}" for joint in module.joints(letter))]
    figures = {"kind": _kind(ini, letter, sections[1:])}
    places = f"[{'] nor ['.join(sections)}]"
    if not set(sections) & set(ini.sections()):
        raise ControlFileError(f"neither {places} is there: the file is not whole; add them", file=ini.file.name)
    for key, name in (("velocity", "MAX_VELOCITY"), ("acceleration", "MAX_ACCELERATION")):
        found = [_above_zero(figure) for section in sections if (figure := ini.figure(section, name)) is not None]
        figures[key] = lowest(found) if found else _default(module, letter, key, f"neither {places} has {name}")
    of_sections = (ini.figure(section, "MAX_JERK") for section in sections)
    jerks = [figure for figure in of_sections if figure is not None and figure.number > 0.0]
    of_path = ini.figure("TRAJ", "MAX_LINEAR_JERK")
    if not rotary and of_path is not None and LEAST_JERK <= of_path.number < NO_JERK_LIMIT:
        jerks.append(of_path)
    if jerks:
        figures["jerk"] = lowest(jerks)
    if rotary and ini.word(sections[0], "WRAPPED_ROTARY").lower() in ("1", "true", "yes", "on"):
        wrapped = ini.entry(sections[0], "WRAPPED_ROTARY")
        assert wrapped is not None
        return figures | {"wrap": Figure(True, (wrapped.origin,))}
    return figures | _reach(ini, sections, rotary)


def _default(module: Module, letter: str, key: str, why: str) -> Figure:
    """A limit that no section tells: LinuxCNC takes a default of its own."""
    unit = "deg" if letter in TURNING else module.length
    what = f"{key} of {letter} [{unit}/s{'^2' if key == 'acceleration' else ''}]"
    return module.answers.numbers(Question(what, f"{DEFAULT:g}", f"LinuxCNC's own default, since {why}"), 1)


def _kind(ini: Ini, letter: str, joints: Sequence[str]) -> Figure:
    """Whether an axis turns, by its letter; the type of its joints must agree."""
    kind = "rotary" if letter in TURNING else "linear"
    for section in joints:
        entry = ini.entry(section, "TYPE")
        if entry is not None and entry.word().upper() != ("ANGULAR" if kind == "rotary" else "LINEAR"):
            raise entry.origin.error(
                f"= {entry.word()[:20]}, and the joint moves the axis {letter}, which is {kind}; correct TYPE, or the "
                "order of the letters in [KINS] KINEMATICS"
            )
    return Figure(kind, (Origin(f"axis {letter}"),))


def _above_zero(figure: Figure) -> Figure:
    if not figure.number > 0.0:
        raise figure.origins[0].error(f"= {figure.number:g}; give a number above zero")
    return figure


def _reach(ini: Ini, sections: Sequence[str], rotary: bool) -> dict[str, Figure]:
    """The travel that all sections allow; endless for a turning axis that none limits on either side."""
    lows = [figure for section in sections if (figure := ini.figure(section, "MIN_LIMIT")) is not None]
    highs = [figure for section in sections if (figure := ini.figure(section, "MAX_LIMIT")) is not None]
    lows = [figure for figure in lows if figure.number > -ENDLESS]
    highs = [figure for figure in highs if figure.number < ENDLESS]
    if lows and highs:
        return {"travel": travel(max(lows, key=lambda figure: figure.number), lowest(highs))}
    if rotary and not lows and not highs:
        reason = f"neither [{'] nor ['.join(sections)}] limits its travel"
        return {"wrap": Figure(True, (Origin(reason),))}
    return {}
