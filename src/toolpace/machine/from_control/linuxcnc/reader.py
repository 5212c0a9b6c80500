"""A record from LinuxCNC's INI and HAL files."""

from __future__ import annotations

from collections.abc import Sequence

from toolpace.machine.from_control.control_file import ControlFile, ControlFileError
from toolpace.machine.from_control.record import MachineRecord
from toolpace.machine.from_control.stand_ins import Answers

CONTROL = "LinuxCNC"
TOLD_BY = "an INI with [KINS] and [TRAJ]"


def recognises(file: ControlFile) -> bool:
    """Whether a text is LinuxCNC's INI, or includes what makes it one."""
    headings = {line.strip().upper() for line in file.lines if line.lstrip().startswith("[")}
    return "[KINS]" in headings or {"[EMC]", "[TRAJ]"} <= headings


def read(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The machine of an INI. Raises ControlFileError."""
    raise ControlFileError("cannot be read yet", file=files[0].name)
