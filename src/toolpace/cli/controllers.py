"""The command `controllers`: the built-in controllers, or the file of one."""

from __future__ import annotations

from rich.box import SIMPLE
from rich.table import Table
from rich.text import Text

from toolpace.cli.steps import new_console
from toolpace.common.errors import UsageError, printable
from toolpace.programs.reading.controllers.controller import Controller


def run_controllers(name: str | None, toml: bool) -> int:
    """List all, or tell of one; with `toml` its file."""
    if toml:
        if name is None:
            raise UsageError("--toml needs the name of one controller: toolpace controllers fanuc --toml")
        print(Controller.text_of(name), end="")
        return 0
    table = Table(box=SIMPLE, pad_edge=False)
    for heading in ("controller", "language", "note"):
        table.add_column(heading, overflow="fold")
    for each in Controller.names() if name is None else (name,):
        controller = Controller.load(each)
        cells = (controller.name, controller.language, controller.note)
        table.add_row(*(Text(printable(cell)) for cell in cells))
    new_console().print(table)
    return 0
