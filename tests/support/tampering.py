"""Changing the folder of a plan as somebody would who wants another verdict, or by mistake."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np

from toolpace.cli import main
from toolpace.common.files.seal import KEY, write_seal
from toolpace.machine.machine import Machine
from toolpace.motion.set_point_files import read_set_points, write_compact
from toolpace.motion.setpoints import SetPoints


class Tamper:
    def __init__(self, folder):
        self.folder = folder

    def figures(self, change):
        path = self.folder / "plan.json"
        said = json.loads(path.read_text())
        change(said)
        path.write_text(json.dumps(said))
        self.seal()

    def seal(self):
        """Seal the folder anew: whoever changes figures can do that, so no other check may lean on it."""
        path = self.folder / "plan.json"
        said = json.loads(path.read_text())
        said.pop(KEY, None)
        path.write_text(json.dumps(said))
        write_seal(self.folder, path.name)

    def arrays(self, change):
        path = self.folder / "setpoints.npz"
        with np.load(path) as archive:
            arrays = {name: archive[name].copy() for name in archive.files}
        change(arrays)
        np.savez(path, **arrays)
        self.seal()

    def compact_arrays(self, change):
        """The same of a plan with setpoints.compact."""
        machine, points = Machine.load(self.folder / "machine.toml"), read_set_points(self.folder)
        arrays = {each.name: np.array(getattr(points, each.name)) for each in fields(points)}
        change(arrays)
        points = SetPoints(**arrays | {"joints": tuple(map(str, arrays["joints"]))})
        write_compact(self.folder / "setpoints.compact", points, machine)
        self.seal()

    def verdict(self, capsys):
        capsys.readouterr()
        code = main(["verify", str(self.folder)])
        said = capsys.readouterr()
        return code, said.out + said.err


def put(key, value):
    """Change of a figure, by keys with dots between."""

    def change(said):
        *way, last = key.split("/")
        for part in way:
            said = said[int(part) if isinstance(said, list) else part]
        said[last] = value(said[last]) if callable(value) else value

    return change


def column(name, value):
    def change(arrays):
        arrays[name] = value(arrays[name])

    return change


def part_of(array, value):
    """The array with a stretch of it changed."""
    changed = array.copy()
    part = slice(len(array) // 4, len(array) // 2)
    changed[part] = value(changed[part])
    return changed


def times(factor):
    return lambda value: value * factor


def fails(again, capsys, words):
    code, said = again.verdict(capsys)
    assert code in (1, 2)
    failed = [line for line in said.splitlines() if "FAILED" in line or line.startswith("error: ")]
    assert any(word in line for line in failed for word in words.split("|")), failed
    if code == 2:
        assert len(failed) == 1 and failed[0].startswith("error: ")
