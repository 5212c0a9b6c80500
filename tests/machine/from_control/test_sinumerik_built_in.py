"""Built-in machines, written as archives of a Sinumerik by the manuals' definitions, are read back."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.read_back import assert_comes_back, sense
from tests.support.sinumerik_archive import BY_LETTERS, GENERIC, Archive, changed
from toolpace.machine.from_control import read_control
from toolpace.machine.machine import Machine

TABLES_THAT_TURN_SLIDES = {"paper-ab"}
"""The part's slides stand on its turning axis: no transformation of the control has that."""
FORMS = (
    "directions", "letters", "letters and swivel data", "swivel data", "swivel data by type 72", "both", "elements",
)  # fmt: skip
WORLD = np.array([0.013, -0.021, 0.034])
"""A point from which kinematic chains are measured [m]."""


def _archive(name: str) -> Archive:
    return Archive(Machine.load(name), "in" if "inch" in name else "mm", slide=(0.0123, -0.0456))


def _lines(archive: Archive, form: str) -> list[str]:
    if form.startswith("letters"):
        # machine zero is where the transformation, which counts, has it: it is written last
        carrier = archive.carrier(1) if form != "letters" else []
        lines = archive.transformation(1, 1, BY_LETTERS[archive.kind][archive.letters()])
        # swivel data alone say how a table of an older type turns
        signs = {"$MC_TRAFO5_ROT_SIGN_IS_PLUS_1[1]": "TRUE"} if carrier and archive.kind != "T" else {}
        return [*changed(lines, signs), *carrier]
    if form == "swivel data":
        return archive.carrier(1)
    if form == "swivel data by type 72":
        return ["$MC_TRAFO_TYPE_1=72", "$MC_TRAFO5_TCARR_NO_1=2", *archive.carrier(2)]
    if form == "elements":
        return archive.elements(WORLD)
    # TRAFO5 data count five-axis transformations: the second TRAFO_TYPE has those of the first
    lines = ["$MC_TRAFO_TYPE_1=512", *archive.transformation(2, 1, GENERIC[archive.kind])]
    return lines + (archive.carrier(1) if form == "both" else [])


def _can_be_told(name: str, form: str) -> bool:
    if name in TABLES_THAT_TURN_SLIDES:
        return False
    archive = _archive(name)
    return not form.startswith("letters") or archive.letters() in BY_LETTERS[archive.kind]


CASES = [(name, form) for name in Machine.names() for form in FORMS if _can_be_told(name, form)]


@pytest.mark.parametrize(("name", "form"), CASES)
def test_a_built_in_machine_comes_back(name, form, tmp_path):
    archive = _archive(name)
    file = tmp_path / "mill.arc"
    file.write_text("\r\n".join([*archive.axes(), *_lines(archive, form)]), newline="")
    draft = read_control([file])
    assert not draft.stand_ins
    senses = np.array([sense(archive.machine, each) for each in archive.machine.joints])
    assert_comes_back(draft.machine, archive.machine, archive.zero, senses)


def test_what_is_not_tried_cannot_be_told():
    tried = {form: {name for name, each in CASES if each == form} for form in FORMS}
    inclined_or_b_about_z = {"xyzbc-nutating", "xyzbc-nutating-large", "xyzab-trunnion-inch"}
    for form in ("letters", "letters and swivel data"):
        assert set(Machine.names()) - tried[form] == TABLES_THAT_TURN_SLIDES | inclined_or_b_about_z
    for form in ("directions", "swivel data", "swivel data by type 72", "both", "elements"):
        assert set(Machine.names()) - tried[form] == TABLES_THAT_TURN_SLIDES


def test_letters_of_linuxcnc_tables_turn_as_the_sign_says(tmp_path):
    """A table that turns by the right-hand rule, other than ISO 841 wants, is read as it is, and told."""
    archive = _archive("linuxcnc-xyzac-trt")
    file = tmp_path / "mill.arc"
    file.write_text("\n".join([*archive.axes(), *archive.transformation(1, 1, 33)]))
    record = read_control([file]).record
    assert record.joints["A"]["direction"].value == (1.0, 0.0, 0.0)
    assert any("+C turns the tool, as the part sees it, against" in remark for remark in record.remarks)
