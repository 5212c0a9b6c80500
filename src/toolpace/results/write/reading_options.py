"""The controller, set-up sheet and options with which a program was read, beside its plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import load_setup, setup_text
from toolpace.results.write.plan_json import PLAN, ReadingRecord

CONTROLLER = "controller.toml"
SETUP = "setup.toml"
"""Names of the files beside plan.json."""


def reading_record(options: ReadOptions) -> ReadingRecord:
    """What plan.json says of the options."""
    return ReadingRecord(
        controller_file=CONTROLLER if options.controller is not None else "",
        setup_file=SETUP if has_setup(options.setup) else "",
        skip_unknown=options.skip_unknown,
        lenient=options.lenient,
        compensation=options.compensation,
        max_blocks=options.most_blocks,
        columns=options.columns,
        units=options.units,
        others=tuple(other.name for other in options.others),
    )


def has_setup(setup: SetUp) -> bool:
    """Whether a sheet says anything."""
    return any(value for name, value in vars(setup).items() if name != "source")


def write_how_read(folder: Path, options: ReadOptions) -> None:
    """Put controller and set-up sheet beside the plan, with every figure exact."""
    if options.controller is not None:
        (folder / CONTROLLER).write_text(options.controller.to_toml(), encoding="utf-8")
    if has_setup(options.setup):
        (folder / SETUP).write_text(setup_text(options.setup), encoding="utf-8")


def read_again(folder: Path, record: ReadingRecord) -> ReadOptions:
    """The options from the files of a plan; UsageError where plan.json and the files of the folder differ."""
    for key, said, name in (
        ("controller_file", record.controller_file, CONTROLLER), ("setup_file", record.setup_file, SETUP)
    ):  # fmt: skip
        there = (folder / name).exists()
        if said not in ("", name) or bool(said) != there:
            raise UsageError(
                f"{folder / PLAN}: {key} of reading is {said!r}, and {name} is {'' if there else 'not '}there; "
                "plan again to write it anew"
            )
    options = ReadOptions.of(
        None,
        Controller.load(folder / CONTROLLER) if record.controller_file else None,
        load_setup(folder / SETUP) if record.setup_file else None,
        record.skip_unknown,
        True,
        record.compensation,
        record.max_blocks,
        record.lenient,
        record.columns,
        record.units,
    )
    if unknown := set(record.others) - set(Controller.names()):
        raise UsageError(f"{folder / PLAN}: others of reading names '{min(unknown)[:40]}'; plan again to write it anew")
    return replace(options, others=tuple(map(Controller.load, record.others)))
