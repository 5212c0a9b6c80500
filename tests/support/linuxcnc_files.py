"""INI and HAL files of machines with LinuxCNC, as a person writes them, in a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

LIMITS = {"MIN_LIMIT": -300.0, "MAX_LIMIT": 250.0, "MAX_VELOCITY": 200.0, "MAX_ACCELERATION": 900.0}
"""Of each axis and joint unless others are given [mm, deg]."""


def ini_text(
    kinematics: str,
    letters: str,
    *,
    coordinates: str = "",
    units: str = "mm",
    sections: Mapping[str, Mapping[str, object]] | None = None,
    lines: Sequence[str] = (),
) -> str:
    """The text of an INI.

    letters: axis letters of joints 0, 1, ... coordinates: those of [TRAJ], unless they are these. sections: keys of a
    section in place of LIMITS, or beside those of others; None leaves a key out. lines: of the section [HAL].
    """
    changed = dict(sections or {})
    of_axes = {f"AXIS_{letter}": dict(LIMITS) for letter in dict.fromkeys(letters)}
    of_joints = {
        f"JOINT_{joint}": {"TYPE": "ANGULAR" if letter in "ABC" else "LINEAR", "HOME": 0.0, **LIMITS}
        for joint, letter in enumerate(letters)
    }
    tables: dict[str, dict[str, object]] = {
        "EMC": {"VERSION": 1.1, "MACHINE": "test mill"},
        "KINS": {"KINEMATICS": kinematics, "JOINTS": len(letters)},
        "TRAJ": {"COORDINATES": coordinates or letters, "LINEAR_UNITS": units, "ANGULAR_UNITS": "degree"},
        **of_axes,
        **of_joints,
    }
    for name, values in changed.items():
        tables.setdefault(name, {}).update(values)
    text = ["# a machine with LinuxCNC", "[HAL]", *lines]
    for name, values in tables.items():
        text += ["", f"[{name}]", *(f"{key} = {value}" for key, value in values.items() if value is not None)]
    return "\n".join(text) + "\n"


def written(folder: Path, **files: str) -> Path:
    """Write files by their names with _ for the dot (mill_ini is mill.ini); the path of the first."""
    paths = []
    for name, text in files.items():
        paths.append(folder / ".".join(name.rsplit("_", 1)))
        paths[-1].write_text(text, encoding="utf-8")
    return paths[0]
