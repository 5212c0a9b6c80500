"""A machine file from the files of a machine's own control.

    files --recognised--> reader --> MachineRecord --completed--> TOML text --> Machine

A reader is a module with three names, entered in `readers.READERS`: `CONTROL`, what people call the control;
`recognises`, whether a text is of it; `read`, a record from its files. The record holds figures with their unit, file
and line (`record.py`). What a file lacks is asked for, or taken as a stand-in, in one place (`stand_ins.py`), and the
record becomes text in one place (`machine_file.py`).
"""

from toolpace.machine.from_control.machine_file import MachineDraft, read_control

__all__ = ["MachineDraft", "read_control"]
