"""Run a program on a real LinuxCNC, and log where every joint is commanded to, each servo cycle."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.instance import SPEED, LinuxCNCError, execute, folder, last_words
from toolpace.common.arrays import Floats, Ints

_END = re.compile(r"^[ \t]*(?:N\d+[ \t]*)?(M0*(?:2|30))(?![\d.])", re.IGNORECASE | re.MULTILINE)


@dataclass(frozen=True)
class Log:
    """What LinuxCNC commanded, one row a servo cycle; t = 0 is the last cycle before anything moves."""

    t: Floats
    """(n,) [s]"""
    line: Ints
    """(n,) of the block that is run; 0 before the first."""
    speed: Floats
    """(n,) of the path [m/s, or rad/s where only rotary axes move]."""
    joints: Floats
    """(n, m) [m or rad], in the order of `letters`."""
    letters: tuple[str, ...]
    ended: bool
    """Whether the program was read to its end, and no error was reported."""
    messages: tuple[str, ...]

    @property
    def duration(self) -> float:
        """From the first cycle that moves a joint to the last [s]."""
        moved = np.flatnonzero(np.any(np.diff(self.joints, axis=0) != 0.0, axis=1))
        return float(self.t[moved[-1] + 1] - self.t[moved[0]]) if len(moved) else 0.0

    def of(self, names: tuple[str, ...]) -> Floats:
        """(n, len(names)) joints by name."""
        return self.joints[:, [self.letters.index(name) for name in names]]


def run_program(
    text: str,
    configuration: Configuration,
    *,
    seconds: float = 600.0,
    speed: int = SPEED,
    hal: tuple[str, ...] = (),
    to_the_end: bool = True,
) -> Log:
    """The log of a program that ends with M2 or M30.

    seconds: most real time. hal: texts of HAL files that are loaded one after the other once LinuxCNC runs, the machine
    off. to_the_end: whether a program that is stopped is an error; if not, its log says so. Raises LinuxCNCError where
    LinuxCNC is missing, does not start, takes too long, lost samples, or did not get to the program's last line.
    """
    marked = _marked(text)
    with folder() as place:
        configuration.write(place)
        (place / "program.ngc").write_text(marked, encoding="utf-8")
        for number, each in enumerate(hal):
            (place / f"more_{number}.hal").write_text(each, encoding="utf-8")
        driver = shutil.copy(Path(__file__).with_name("driver.py"), place / "driver.py")
        driver.chmod(0o755)
        printed = execute(["linuxcnc", "-r", "machine.ini"], place, seconds, speed)
        try:
            ended = json.loads((place / "ended.json").read_text())
            log = place / "log.bin"
            rows = np.fromfile(log, dtype=float) if log.exists() else np.zeros(0)
        except OSError:
            raise LinuxCNCError(f"LinuxCNC did not start: {last_words(printed)}") from None
    said = "; ".join([*filter(None, [ended["problem"]]), *ended["messages"]])
    whole = ended["to_the_end"] and not ended["failed"]
    if not whole and (to_the_end or ended["problem"]):
        raise LinuxCNCError(f"LinuxCNC stopped behind line {ended['line']}: {said or 'no message'}")
    if ended["lost"]:
        raise LinuxCNCError(f"{ended['lost']} cycles were not sampled: the driver was too slow; lower the speed")
    return _log(rows.reshape(-1, 2 + len(configuration.letters)), configuration, tuple(ended["messages"]), whole)


def _marked(text: str) -> str:
    """The program with an output that its last block sets; lines keep their numbers.

    LinuxCNC loses the number of the line it read in subroutines, and its exit code is zero when it stops early.
    """
    ends = list(_END.finditer(text))
    if not ends:
        raise LinuxCNCError("the program has no M2 or M30: where it ends is not known")
    return text[: ends[-1].start(1)] + "M64 P0 " + text[ends[-1].start(1) :]


def _log(rows: Floats, configuration: Configuration, messages: tuple[str, ...], ended: bool) -> Log:
    units = configuration.units()
    joints = rows[:, 2:] * units
    moved = np.flatnonzero(np.any(np.diff(joints, axis=0) != 0.0, axis=1))
    first = int(moved[0]) if len(moved) else 0
    joints = joints[first:]
    return Log(
        t=np.arange(len(joints)) * configuration.cycle,
        line=rows[first:, 0].astype(np.int64),
        speed=rows[first:, 1] * units[0],
        joints=joints,
        letters=configuration.letters,
        ended=ended,
        messages=messages,
    )
