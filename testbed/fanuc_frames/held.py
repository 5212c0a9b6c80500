"""A random program as the reader has it, held against the truth."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

import toolpace as tp
from testbed.fanuc_frames.draw import Program
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.setup_file import setup_of_text


@dataclass
class Held:
    """What came of one program."""

    off: float = 0.0
    """Largest distance of a joint X, Y, Z from where it must be [m]."""
    turned: float = 0.0
    """Largest distance of a rotary joint [rad]."""
    length: float = 0.0
    """Largest error of the length of the tool in the spindle [m]."""
    other: int = 0
    """Turns to a plane that take another position of the rotary joints than the rule chooses."""
    places: int = 0
    refused: str = ""
    line: int = 0
    """At which it is farthest off."""
    words: Counter = field(default_factory=Counter)


def held(seed):
    """Read a program and compare the joints behind every motion."""
    program = Program(seed)
    found = Held(words=Counter(line.split()[0] for line in program.lines))
    machine = tp.Machine.load(program.machine)
    try:
        setup = setup_of_text(program.sheet.text())
        path = tp.read_text(program.text(), machine, setup=setup, controller=program.by.name, name="frames.nc")
    except ToolpaceError as error:
        found.refused = str(error)
        return found, program
    chain = program.truth.chain
    own = chain.own_length
    lengths = path.tool_length if len(path.tool_length) else np.full(len(path.tip), np.nan)
    lengths = np.where(np.isnan(lengths), own, lengths)
    columns = [list(path.rotary_joints).index(name) for name in chain.rotary]
    before = None
    for place in program.places:
        rows = np.flatnonzero(path.block == place.line)
        stays, before = before is not None and np.abs(place.q - before).max() < 1e-9, place.q
        if not len(rows) and (stays or place is program.places[0]):
            continue  # a motion to where the machine is, or the place where the path starts with another tool
        row = rows[-1]
        rotary = path.rotary[row, columns]
        named = {name: rotary[k : k + 1] for k, name in enumerate(chain.rotary)}
        q = chain.joints(path.tip[row][None], named, lengths[row])[0]
        wanted = place.q
        found.length = max(found.length, abs(lengths[row] - place.length * 1e-3))
        if place.normal is not None:
            found.turned = max(found.turned, float(np.abs(chain.forward(q, 0.0)[1][0] - place.normal).max()))
            if place.nearest is None:
                break  # the rule does not decide: what follows depends on it
            if np.abs(np.degrees(rotary) - place.nearest).max() > 1e-4:
                found.other += 1
                break
            found.places += 1
            continue
        off = float(np.abs(q - wanted)[[chain.names.index(x) for x in "XYZ"]].max())
        around = float(np.abs(rotary - [wanted[chain.names.index(n)] for n in chain.rotary]).max())
        if max(off, around) > max(found.off, found.turned, 1e-6) and not found.line:
            found.line = place.line
        found.off, found.turned = max(found.off, off), max(found.turned, around)
        found.places += 1
    return found, program
