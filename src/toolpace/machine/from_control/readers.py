"""The readers of controls' files, and which of them some files are for: told by what is in them, not by their names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from toolpace.machine.from_control.control_file import ControlFile, ControlFileError
from toolpace.machine.from_control.fanuc import reader as fanuc
from toolpace.machine.from_control.heidenhain import reader as heidenhain
from toolpace.machine.from_control.linuxcnc import reader as linuxcnc
from toolpace.machine.from_control.record import MachineRecord
from toolpace.machine.from_control.sinumerik import reader as sinumerik
from toolpace.machine.from_control.stand_ins import Answers


class Reader(Protocol):
    """A module that reads the files of one control."""

    CONTROL: str
    """As `LinuxCNC`."""
    TOLD_BY: str
    """By what its files are recognised, for messages: `an INI with [KINS] and [TRAJ]`."""

    def recognises(self, file: ControlFile) -> bool:
        """Whether a file alone shows that it is this control's."""
        ...

    def read(self, files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
        """The machine; `files` are all that were given, and `answers` has what they do not tell of the chain.

        Limits and travel may stay away: they are filled in afterwards. Raises ControlFileError.
        """
        ...


READERS: tuple[Reader, ...] = (linuxcnc, sinumerik, fanuc, heidenhain)


def read_record(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The record of some files of one control. Raises ControlFileError."""
    found = [(reader, file) for reader in READERS for file in files if reader.recognises(file)]
    if not found:
        names = ", ".join(file.name for file in files)
        ways = "; ".join(f"{reader.CONTROL}: {reader.TOLD_BY}" for reader in READERS)
        raise ControlFileError(f"no file of a control that is known ({ways})", file=names)
    reader, first = found[0]
    for other, file in found:
        if other is not reader:
            raise ControlFileError(
                f"is of {other.CONTROL}, and {first.name} of {reader.CONTROL}; give the files of one control",
                file=file.name,
            )
    return reader.read(files, answers)
