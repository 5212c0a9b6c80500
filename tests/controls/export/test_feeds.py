"""F in every dialect: programs of a generator, rewritten with random times, read back to their path and these times."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.one_program.generate import generate
from testbed.one_program.run import WRITERS, controller, machine, set_up
from testbed.one_program.writer import CannotWriteError
from tests.support.feed_programs import EXTRAS, MODES, SHEET, feed_program
from toolpace.common.errors import UsageError
from toolpace.controls.export.feed_words import Cldata, Klartext, Sinumerik, WordAddress
from toolpace.controls.export.planned_feeds import Job, largest_change_of_kept, settled, strays
from toolpace.controls.export.rewriting import Passes, ProgramText, figure, rounding
from toolpace.machine.machine import Machine
from toolpace.programs.reading import Controller, ReadOptions, Source, read_source
from toolpace.programs.reading.languages import with_controller
from toolpace.programs.reading.setup_file import setup_of_text

DIALECTS = [name for name in WRITERS if name != "cldata"]


def rewritten(source, on, options, inverse=False, seed=0):
    """Blocks that got a feed, after all was compared."""
    options = with_controller(source, None, options)[0]
    toolpath = read_source(source, on, None, options)
    passes = Passes.of(toolpath)
    asked = passes.asked_times(toolpath)
    factor = np.random.default_rng(seed).uniform(1.0, 3.0, len(asked))
    planned = np.where(np.isfinite(asked) & (asked > 0.0), asked, 0.01) * factor
    job = Job.beside(source, on, None, options, toolpath, planned, inverse)
    feeds = job.feeds({})
    job, new, again = settled(job, lambda job: job.rewriting.write({k: feeds[k] for k in job.lines}, {}))
    assert not strays(job, new, again).any() and largest_change_of_kept(job, new, again) < 1e-9
    feeds, decimals = {line: feeds[line] for line in job.lines}, job.rewriting.words.decimals
    for line, times in new.times(again).items():
        allowed = 1e-9 + 1.001 * rounding(float(feeds[line][0]), decimals)
        assert abs(times[0] / planned[job.lines[line]] - 1.0) <= allowed
    return int(job.rewriting.chosen.sum())


def tried(dialect, seeds):
    """How many blocks of the programs of some seeds got a feed."""
    count = 0
    for seed in seeds:
        program = generate(seed)
        writer = WRITERS[dialect](program)
        try:
            text = writer.write()
        except CannotWriteError:
            continue
        options = ReadOptions(
            controller=controller(dialect, tuple(writer.parameters().items())), setup=set_up(program, dialect)
        )
        source = Source.from_bytes(text.encode(), "one.txt")
        for inverse in (False, True):
            try:
                count += rewritten(source, machine(program.machine), options, inverse, seed)
            except UsageError as error:
                assert inverse and dialect in ("millplus", "heidenhain") and "no inverse times" in str(error)
    return count


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_program_reads_back_with_its_new_feeds(dialect):
    assert tried(dialect, range(2)) > 10


@pytest.mark.thorough
@pytest.mark.parametrize("dialect", DIALECTS)
def test_hundreds_of_programs_read_back(dialect):
    assert tried(dialect, range(1000, 1200)) > 500


MODE_CASES = [(dialect, mode) for dialect, modes in MODES.items() for mode in (*modes, "mixed")]


def tried_mode(dialect, mode, seed):
    """How many blocks of a random program whose feeds have a mode got a feed."""
    text = feed_program(dialect, mode, seed % 2 == 0, seed % 4 < 2, EXTRAS, seed)
    source = Source.from_bytes(text.encode(), "part.apt" if dialect == "cldata" else "part.nc")
    named = None if dialect == "cldata" else Controller.load(dialect)
    return rewritten(source, machine("xyzac-trunnion"), ReadOptions(controller=named, setup=setup_of_text(SHEET)))


@pytest.mark.parametrize("dialect, mode", MODE_CASES)
def test_each_mode_of_feed_reads_back_with_its_new_feeds(dialect, mode):
    assert tried_mode(dialect, mode, MODE_CASES.index((dialect, mode))) >= 5


@pytest.mark.thorough
@pytest.mark.parametrize("dialect, mode", MODE_CASES)
def test_each_mode_of_feed_reads_back_in_many_programs(dialect, mode):
    assert all(tried_mode(dialect, mode, seed) >= 3 for seed in range(1000, 1016))


CLDATA = """\
PARTNO/TEST
UNITS/MM
FEDRAT/500,MMPM
RAPID
GOTO/0,0,10,0,0,1
GOTO/0,0,0
FEDRAT/MMPM,250
GOTO/10,0,0,0.1,0,0.99498743710662
GOTO/20,5,0
RAPID
GOTO/20,5,50
FINI
"""


def test_cutter_location_data_get_fedrat_before_each_motion():
    source = Source.from_bytes(CLDATA.encode(), "part.apt")
    assert rewritten(source, Machine.load("xyzac-trunnion"), ReadOptions()) == 3


WORDS = {
    "replaced": (WordAddress(), "G1 X1 F200 Y2", "G1 X1 F99 Y2"),
    "added before a comment": (WordAddress(), "N5 X1 (F3 is no feed)", "N5 X1 F99 (F3 is no feed)"),
    "added before a semicolon": (WordAddress(), "X1 ; F2", "X1 F99 ; F2"),
    "of an expression": (WordAddress(), "X1 F[#1*[2+3]] Y2", "X1 F99 Y2"),
    "of a variable": (WordAddress(), "X1 F#<feed>Y2", "X1 F99Y2"),
    "of a number's variable": (WordAddress(), "X1 F#12", "X1 F99"),
    "in small letters": (WordAddress(), "g1 x1 f 200.5", "g1 x1 F99."),
    "with its point": (WordAddress(), "G1 X1. F200. Y2.", "G1 X1. F99. Y2."),
    "another F": (WordAddress(), "G141 X1 F2=15000 F200", "G141 X1 F2=15000 F99"),
    "Sinumerik, with brackets": (Sinumerik(), "G1 X=R1*(2) F500 ; (F1)", "G1 X=R1*(2) F99 ; (F1)"),
    "Sinumerik, a parameter": (Sinumerik(), "G1 X1 F=R5 M8", "G1 X1 F99 M8"),
    "Sinumerik, a text": (Sinumerik(), 'MSG("F5;") X1', 'MSG("F5;") X1 F99'),
    "Klartext, before M": (Klartext(), "7 L X+1 R0 M3 ; F1", "7 L X+1 R0 F99 M3 ; F1"),
    "Klartext, of M128": (Klartext(), "L X+1 F AUTO M128 F1000", "L X+1 F99 M128 F1000"),
    "Klartext, a parameter": (Klartext(), "L X+1 FQ5 R0", "L X+1 F99 R0"),
    "Klartext, a tooth": (Klartext(), "L X+1 FZ 0.1", "L X+1 FZ99"),
    "Sinumerik, a tooth": (Sinumerik(), "G1 X1 FZ=0.1 M8", "G1 X1 FZ=99 M8"),
    "Sinumerik, one block": (Sinumerik(), "X1 FB=R5", "X1 FB=99"),
}


@pytest.mark.parametrize("words, line, right", WORDS.values(), ids=WORDS)
def test_an_f_is_put_where_it_belongs(words, line, right):
    assert words.editable([line]) == [True]
    assert words.with_feed(line, "99", False)[-1] == right


def test_inverse_times_bring_their_mode():
    assert WordAddress().with_feed("G94 G1 X1 F200", "5", True) == ["G93 G1 X1 F5"]
    assert WordAddress().with_feed("X1 (c)", "5", True) == ["X1 F5 G93 (c)"]
    assert WordAddress().alone("F200", "", True) == "G94 F200" and WordAddress().alone("F2", "G95", True) == "G95 F2"


ENDS = {
    "sinumerik": ("G90 G94\nTRAORI\nG1 X0 Y0 Z0 A0 C0 F600\nX10\nX10 Y5 F=R5\nG0 Z50\nM30\n", "G94 F=R5"),
    "fanuc": ("%\nO1\nG21 G90 G94\nG43.4 H1\nG1 X0 Y0 Z0 A0 C0 F600\nX10\nY5\nG0 Z50\nM30\n%\n", "G94 F600"),
    "linuxcnc": ("G21 G90\nG1 X0 Y0 Z0 A0 C0 F600\nX10\nY5 F80\nM5\nM2\n", "G94 F80"),
    "iso": ("G90 G95 S1000\nG1 X0 Y0 Z0 A0 C0 F0.5\nX10\nY5\nM30\n", "G95 F0.5"),
}


@pytest.mark.parametrize("dialect", ENDS)
def test_inverse_times_end_behind_the_last_block_and_the_feed_is_as_it_was(dialect):
    """What a program leaves in force its caller, or the next program, moves with."""
    text, back = ENDS[dialect]
    text = "R5=90\n" + text if dialect == "sinumerik" else text
    source = Source.from_bytes(text.encode(), "part.nc")
    on = Machine.load("xyzac-trunnion")
    options = ReadOptions(controller=Controller.load(dialect), skip_unknown=True)
    toolpath = read_source(source, on, None, options)
    passes = Passes.of(toolpath)
    job = Job.beside(source, on, None, options, toolpath, np.ones(len(passes.block)), inverse=True)
    lines = job.rewriting.write(job.feeds({}), {}).data.decode().splitlines()
    at = max(k for k, line in enumerate(lines) if "G93" in line)
    assert lines[at + 1] == back and lines.count(back) == 1
    assert lines[at + 2 :] == text.splitlines()[-len(lines[at + 2 :]) :]
    assert rewritten(source, on, options, inverse=True) >= 2


@pytest.mark.parametrize(
    "words, lines",
    [
        (
            WordAddress(),
            ["G81 Z-1 F100", "X2", "G84 Z-3 F1.5", "o5 repeat [2]", "G33 Z-1 K1", "IF [#1 EQ 2] GOTO 3"],
        ),
        (Sinumerik(), ["MCALL CYCLE81(1,2)", "CYCLE84(1)", "G331 Z-1 K1", "G1 X1 F=R1*2", "IF R1==2 GOTOF A"]),
        (Klartext(), ["CYCL DEF 200 DRILLING", "TOOL CALL 5 Z S3000 F350", "CALL LBL 1", "CC X+1 Y+2", "L X+1 ~"]),
        (Cldata(), ["FEDRAT/100", "CYCLE/DRILL,1", "GOTO/1,2,3", "RAPID"]),
    ],
)
def test_what_is_no_single_motion_gets_none(words, lines):
    assert not any(words.editable(lines))


@pytest.mark.parametrize(
    "data", [b"a\r\nb\nc", b"a\n", b"\xef\xbb\xbfa\r\n\r\nb\r\n", b"(\xe4\xf6)\nX1\n", "(µ)\r\n".encode()]
)
def test_a_text_is_written_as_it_was(data):
    text = ProgramText.of(data)
    assert text.with_lines([[line] for line in text.lines]) == data
    longer = text.with_lines([["x", line] for line in text.lines])
    assert len(longer.splitlines()) == 2 * len(text.lines)


@pytest.mark.parametrize(
    "value, decimals, right",
    [
        (1234.5678, 4, "1234.57"), (0.000012, 4, "0.000012"), (0.0123456, 3, "0.0123"), (900.0, 3, "900"),
        (1e6, 4, "1000000"), (123456.7, 4, "123457"),
    ],
)  # fmt: skip
def test_feeds_have_six_figures(value, decimals, right):
    assert figure(value, decimals) == right


def test_passes_are_at_rapid_at_feed_or_of_both():
    """A cycle has both; a rapid has no feeds, and a feed no rapids."""
    text = "G21 G90 G94 F100\nG0 X0 Y0 Z5\nG0 X1\nG1 X2\nG99 G81 X3 Z-1 R2\nG80\nG0 Z9\nM2\n"
    passes = Passes.of(read_source(Source.from_bytes(text.encode(), "part.ngc"), None, None, ReadOptions()))
    kinds = dict(zip(passes.block.tolist(), zip(passes.rapid.tolist(), passes.mixed.tolist()), strict=True))
    assert kinds == {3: (True, False), 4: (False, False), 5: (False, True), 7: (True, False)}


def test_blanks_within_a_number_belong_to_it():
    from toolpace.controls.export.feed_words import _VALUE

    for text, value in (("8 0 0 Y2", "8 0 0"), ("800Y2", "800"), ("-1 2 . 5 (F7)", "-1 2 . 5"), (".5 ;", ".5")):
        found = _VALUE.match(text)
        assert found is not None and found.group() == value
