"""Controllers as data: every file that is built in, files that are like another, and programs that only data tell."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import msgspec
import pytest

from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.programs import reading
from toolpace.programs.reading import ReadOptions, Source, read_text
from toolpace.programs.reading.controllers.controller import OPTIONS, Controller
from toolpace.programs.reading.inspection import inspect_source
from toolpace.programs.reading.languages import READERS, recognised

WORD_ADDRESS = [name for name in Controller.names() if Controller.load(name).language == "word-address"]


@pytest.mark.parametrize("name", Controller.names())
def test_a_controller_is_printed_so_that_it_loads_as_the_same(name):
    controller = Controller.load(name)
    assert controller.name == name and controller.note and controller.language in READERS
    again = Controller.from_toml(controller.to_toml(), name)
    assert again == msgspec.structs.replace(controller, like="")
    words = [*controller.meanings, *controller.ignored, *controller.refused]
    assert len(words) == len(set(words)), "a word has one meaning"
    assert all(cure.strip() for cure in controller.refused.values())


@pytest.mark.parametrize("name", WORD_ADDRESS)
def test_every_controller_of_words_reads_the_plainest_program(name):
    path = read_text("G90\nG0 X0. Y0. Z5.\nG1 Z0. F600.\nX10.\nM30\n", None, controller=name)
    assert path.controller == name and path.tip[-1].tolist() == pytest.approx([0.01, 0, 0])


def test_a_machine_may_start_with_kinematics_that_hold_the_tip(tmp_path):
    """What is switched at the start is switched off by M429, and not by G49, as if M428 stood before the program."""
    head = tmp_path / "head.toml"
    head.write_text('name = "head"\nnote = "holds the tip"\nlike = "linuxcnc"\n[options]\ntip_mode_at_start = true\n')
    machine = Machine.load("linuxcnc-xyzbc-bridgemill")
    body = "G49\nG0 X10 Y5 Z-20 B0 C0\nG1 B30 C90 F500\nM429\nB0\nM2\n"
    started = read_text(body, machine, controller=head)
    switched = read_text("M428\n" + body, machine, controller="linuxcnc")
    assert started.tip.tolist() == switched.tip.tolist() and started.rotary.tolist() == switched.rotary.tolist()
    tips = started.tip[started.block == 3]
    assert abs(tips - [0.01, 0.005, -0.02]).max() < 1e-12, "it stays while the head turns"
    assert abs(started.tip[-1] - [0.01, 0.005, -0.02]).max() > 0.1, "it does not once M429 has said so"
    plain = read_text(body, machine, controller="linuxcnc")
    assert abs(plain.tip[plain.block == 3] - [0.01, 0.005, -0.02]).max() > 0.1


OWN = 'name = "own"\nlike = "fanuc"\nnote = "a mill of our own"\n'


def test_a_controller_like_another_says_only_what_differs():
    fanuc = Controller.load("fanuc")
    ignored = fanuc.ignored[0]
    own = Controller.from_toml(
        OWN + f'ignored = ["G31"]\n[meanings]\n"{ignored}" = "continuous path"\n[options]\nrepeats = "L"\n', "own.toml"
    )
    assert own.language == fanuc.language and own.name == "own" and own.signs == fanuc.signs
    assert own.meanings == fanuc.meanings | {ignored: "continuous path"}
    assert "G31" in own.ignored and "G31" not in own.refused and ignored not in own.ignored
    assert own.options == fanuc.options | {"repeats": "L"}


@pytest.mark.parametrize(
    "text, words",
    [
        (OWN.replace("fanuc", "fanucc"), "like = 'fanucc' is no built-in controller; did you mean 'fanuc'"),
        (OWN.replace("own", "fanuc"), "like = 'fanuc' is no built-in controller"),
        (OWN + 'language = "sinumerik"\n', "language 'sinumerik' is not that of fanuc"),
        ('name = "own"\n', "language '' is not known"),
        (f'name = "own"\nlanguage = "{"x" * 3000}"\n', f"language '{'x' * 40}' is not known"),
        (OWN + "meaning = 3\n", "meaning"),
        (OWN + '[[signs]]\npattern = "a{99999999999}"\nreason = "x"\n', "own.toml"),
        (OWN + '[[signs]]\npattern = "("\nreason = "x"\n', "own.toml"),
        (OWN + '[[signs]]\npattern = "[[A]"\nreason = "x"\n', "nested set"),
    ],
)
def test_wrong_files_are_one_line(text, words):
    with pytest.raises(UsageError) as caught:
        Controller.from_toml(text, "own.toml")
    assert words in str(caught.value) and str(caught.value).startswith("own.toml: ")


@pytest.mark.parametrize(
    "text, words",
    [
        ("[options]\nlocal_variables = nan\n", "option local_variables = nan must be from 0 to 10000"),
        ("[options]\nlocal_variables = 1e300\n", "option local_variables = 1e+300 must be from 0 to 10000"),
        ("[options]\nsystem_variables_from = inf\n", "option system_variables_from = inf must be from 0 to 10000"),
        ("[options]\ndwell_whole_s = -1.0\n", "option dwell_whole_s = -1 must be from 0 to 10000"),
        ("[options]\npeck_clearence_mm = 1.0\n", "did you mean 'peck_clearance_mm'?"),
        ("[options]\nbase_unit = true\n", "option base_unit is not known: known: angles_to_360, "),
        ('[options]\nunits = "inches"\n', "option units = 'inches': use one of 'mm', 'inch'"),
        ("[options]\nunits = 1\n", "option units = 1: use one of 'mm', 'inch'"),
        ("[options]\nnested_comments = 1\n", "option nested_comments = 1 must be true or false"),
        ("[options]\ndwell_whole_s = true\n", "option dwell_whole_s = True must be a number"),
        ("[options]\nvariable_letter = 3\n", "option variable_letter = 3 must be a text"),
        ("[option]\nunits = 3\n", "unknown field `option`, did you mean 'options'?"),
        (f'[meanings]\nG1 = "{"z" * 3000}"\n', f"G1 = '{'z' * 40}' is no meaning that is known"),
    ],
)
def test_options_and_meanings_that_cannot_be_are_told_before_a_program_is_read(text, words):
    with pytest.raises(UsageError) as caught:
        read_text("G0 X1\nM30\n", None, "gcode", controller=Controller.from_toml(OWN + text, "own.toml"))
    assert words in str(caught.value) and len(str(caught.value)) < 2000


@pytest.mark.parametrize(
    "language, folder", [("word-address", "gcode"), ("sinumerik", "sinumerik"), ("heidenhain", "heidenhain")]
)
def test_options_that_a_file_may_say_are_those_that_its_language_asks_for(language, folder):
    """A name that no reader asks for would be obeyed by nobody, and one that is not in the table refused."""
    asked = {}
    for path in (Path(reading.__file__).parent / folder).rglob("*.py"):
        for name, default in re.findall(r'\b(?:option|by)\("(\w+)", ([^,()]+)\)', path.read_text()):
            asked[name] = ast.literal_eval(default)
    assert asked.keys() == OPTIONS[language].keys()
    for name, default in asked.items():
        kind = OPTIONS[language][name]
        assert default in kind if isinstance(kind, tuple) else type(default) is type(kind), name


MAZAK = """\
%
O0012 (BRACKET)
G90 G94 G17 G49
G21
G05 P2
T3 M6
G54.1 P1
M46
G0 A30. C45.
M47
G43.4 H3
G0 X0 Y0 Z20.
G1 Z1. F500
G61.1
X10.
X10. Y10.
G4 P500
G49
G05 P0
M30
%
"""


def test_mazak_is_told_by_its_words_and_read_by_data_alone():
    source = Source.from_text(MAZAK, "bracket.nc")
    found = recognised(source, None, ReadOptions())
    assert found.controller is not None and found.controller.name == "mazak"
    assert found.reason == "G05 P2 is the high-speed mode of Mazak"
    told = inspect_source(source, ReadOptions(), [Machine.load("xyzac-trunnion")])
    assert told.refused == () and told.machines == ("xyzac-trunnion",) and told.tools == ("3",)
    path = read_text(MAZAK, Machine.load("xyzac-trunnion"))
    # G61.1 goes on without a stop; G4 P500 is half a second
    assert path.dwell.max() == 0.5 and not path.stop[path.block == 15].any()


def test_on_mazak_k_repeats_no_cycle():
    """K of G83 is a clearance there, not how often the hole is drilled as on Fanuc."""
    body = "G21 G90\nG0 X0 Y0 Z20\nG1 Z10 F500\nG91\nG83 X5. Z-5. R-2. Q2. F500 K3\nG80\nG90\nM30\n"
    ends = {name: read_text(body, None, controller=name).tip[-1, 0] for name in ("mazak", "fanuc")}
    assert ends == {"mazak": pytest.approx(0.005), "fanuc": pytest.approx(0.015)}


def test_a_name_without_end_in_a_file_is_cut_in_the_message():
    with pytest.raises(UsageError) as caught:
        Controller.from_toml(f'name = "x"\n["{"9" * 5000}"]\n')
    assert "unknown field" in str(caught.value) and len(str(caught.value)) < 500
