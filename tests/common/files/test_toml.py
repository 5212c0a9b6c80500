"""Files of tables: every kind is read in one way, and what is wrong is one line that names the file."""

from __future__ import annotations

import pytest

from toolpace.common.errors import ToolpaceError
from toolpace.common.files.toml import TableFile
from toolpace.cutting.tool_file import load_tool
from toolpace.jobs.batch.jobs_file import jobs_of_file
from toolpace.machine.machine import Machine
from toolpace.programs.reading.setup_file import load_setup
from toolpace.setup_search.choices import load_choices

KINDS = {
    "file of jobs": jobs_of_file,
    "tool file": load_tool,
    "file of choices": load_choices,
    "set-up sheet": load_setup,
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_cannot_be_read_is_named_with_its_kind(kind, tmp_path):
    load = KINDS[kind]
    cases = {tmp_path / "gone.toml": "no such file", tmp_path: "is a directory", "a\0b": "no such name"}
    for path, says in cases.items():
        with pytest.raises(ToolpaceError, match=rf"^{kind} .*: cannot be read \({says}.*\); check the path$"):
            load(path)
    file = tmp_path / "binary.toml"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ToolpaceError, match=rf"^{kind} .*binary\.toml: not a text file; save it as UTF-8$"):
        load(file)


@pytest.mark.parametrize("load", [*KINDS.values(), Machine.load])
def test_a_number_of_thousands_of_digits_is_no_matter_of_python(load, tmp_path):
    file = tmp_path / "long.toml"
    file.write_text(f"x = {'1' * 5000}\n", encoding="utf-8")
    with pytest.raises(ToolpaceError, match=r"long\.toml: not a TOML file: Exceeds the limit") as caught:
        load(file)
    assert "sys." not in str(caught.value)


def test_a_file_is_read_no_further_than_it_can_go(tmp_path):
    kind, file = TableFile("list", longest=10), tmp_path / "list.toml"
    file.write_text("x = 'éééé'", encoding="utf-8-sig")
    assert kind.table(kind.text(file), "list.toml") == {"x": "éééé"}
    for text in ("x = 'ééééé'", "é" * 1001):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(ToolpaceError, match=r"list\.toml: has more than 10 characters: this is no list"):
            kind.table(kind.text(file), "list.toml")
