"""The execution of a block in the control's order: modes, tools, feed, frames, calls, motion, end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.reading.arcs import ArcError
from toolpace.programs.reading.control.corners import CornerError
from toolpace.programs.reading.control.feed import INVERSE, PER_MINUTE, PER_REVOLUTION, PER_TOOTH, SENSES
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.blank import take_blank
from toolpace.programs.reading.sinumerik.circles import set_pole
from toolpace.programs.reading.sinumerik.commands import STILL, Commands
from toolpace.programs.reading.sinumerik.compensation import SUPPRESSION
from toolpace.programs.reading.sinumerik.flow.interpreter import Interpreter, values_of
from toolpace.programs.reading.sinumerik.frames import PROGRAMMED
from toolpace.programs.reading.sinumerik.motion import AXES, OF_ARCS
from toolpace.programs.reading.sinumerik.run import Modal, Run
from toolpace.programs.reading.sinumerik.state import DYNAMICS, MODES, TOLERANCES, apply, fault_of
from toolpace.programs.reading.sinumerik.syntax.blocks import Block, Call
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value, real, shown
from toolpace.programs.reading.sinumerik.word_values import Words, WordValue, bounded, check_settled, number

FEEDS = {"G93": INVERSE, "G94": PER_MINUTE, "G95": PER_REVOLUTION}
IN_MACHINE = ("SUPA", "G53", "G153")
OTHER_PLANES = ("G18", "G19")
FGREF = "FGREF is passed over: where F is the speed of rotary axes, a degree counts as a millimetre (radius 57.3 mm)"
POLES = ("G110", "G111", "G112")
OFFSETS = {"G500": 0, **{f"G{53 + k}": k for k in range(1, 5)}, **{f"G{500 + k}": k for k in range(5, 100)}}
MOST_SHARE = 2.0
"""Of OVR."""


@dataclass
class Now:
    """What lasts for one block."""

    words: Words
    edge_programmed: bool = False
    """Whether D stands in it."""
    in_machine: bool = False
    stop: bool = False
    stop_after: bool = False
    ends: bool = False
    claim: str = ""
    """The word that the axis words of the block belong to: TRANS, G111."""


class Executor:
    """Carries out blocks on the virtual control."""

    def __init__(self, run: Run) -> None:
        self.run, self.control, self.findings = run, run.control, run.findings
        self.state, self.frames, self.motion = run.state, run.frames, run.motion
        self.tooling, self.compensation = run.tooling, run.compensation
        self.vocabulary, self.memory = run.vocabulary, run.memory
        self.commands, self.feed_words = Commands(run), FeedWords(run)
        self.interpreter: Interpreter
        self.meanings: dict[str, Callable[[Now], None]] = {
            "tool change": lambda now: self.tooling.change(edge_programmed=now.edge_programmed),
            "stop": lambda now: setattr(now, "stop_after", True),
            "end": lambda now: setattr(now, "ends", True),
            "spindle or coolant": lambda now: run.control.stop(),
            "tip mode on": lambda now: self.commands.tip_mode(True),
            "tip mode off": lambda now: self.commands.tip_mode(False),
        }
        self.vocabulary.check(tuple(self.meanings))

    @property
    def modal(self) -> Modal | None:
        """What MCALL asked for."""
        return self.run.modal

    @modal.setter
    def modal(self, wanted: Modal | None) -> None:
        self.run.modal = wanted

    def begin(self, line: int) -> None:
        """A block of this line comes next."""
        self.control.begin_block(line)

    def ignored(self, word: str) -> None:
        """Count a word that moves nothing."""
        self.findings.ignored(word)

    def assume(self, sentence: str) -> None:
        """Say what is taken for granted."""
        self.findings.assumed(sentence)

    def refuse(self, word: str, line: int, cure: str) -> None:
        """Note a word that is not read."""
        self.findings.refused(word, line, cure)

    def saved(self) -> Callable[[], None]:
        """What brings modes and frames back as they are, for a subprogram with SAVE."""
        modes, frames = {name: getattr(self.state, name) for name in MODES}, self.frames.saved()

        def restore() -> None:
            for name, value in modes.items():
                setattr(self.state, name, value)
            self.memory.unit = self.state.unit
            self.frames.restore(frames)

        return restore

    def execute(self, block: Block) -> bool:
        """Do what a block says; whether it programmed an axis of the path. Raises Unread, BlockError."""
        if self.motion.splines.points and (block.calls or set(block.codes) - {"BSPLINE"}):
            self.motion.splines.close()
        if len(block.codes) > 1 and (fault := fault_of(block.codes)):
            raise BlockError(fault)
        words = self._words(block)
        if block.assignments:
            self._assign(block)
            check_settled(words, block, self.memory)
        if words and (block.calls or block.codes):
            self._alone(block, words)
        now = Now(words, "D" in words)
        dwells = "G4" in block.codes
        if "G40" in block.codes:  # before D and T of its block, which may not change a radius that is compensated
            self.compensation.take("G40")
        if words and not dwells:
            self.tooling.take(words)
        for code in (*block.codes, *self.tooling.spindle_sense(words)):
            try:
                self._code(code, now)
            except Unread as error:
                self.refuse(error.word, self.control.line, error.cure)
        if dwells:
            self.feed_words.dwell(words)
        elif "F" in words or "FZ" in words:
            self.feed_words.feed(words)
        if "OVR" in words:
            self.feed_words.override(words)
        if now.claim:
            self._claim(now)
        for call in block.calls:
            self._call(call, words)
        if words:
            self._ask(words)
            self.motion.round_from_here(words)
        with self.feed_words.of_block(words):
            moved = self._move(now) if words else False
        if now.stop_after:
            self.control.stop()
        if now.ends:
            self.interpreter.end()
        return moved

    def _alone(self, block: Block, words: Words) -> None:
        """BlockError where a cycle or a command that moves, or changes coordinates, stands beside words of axes."""
        for name in (*(call.name for call in block.calls), *block.codes):
            if name in self.commands.known and name not in STILL and self.motion.has_axes(words):
                address = next((address for address in words if address in AXES), next(iter(words)))
                raise BlockError(f"{name} beside {address}: which of them is first is not told; write two blocks")

    def _words(self, block: Block) -> Words:
        if block.plain:
            literals = self.memory.literals
            return {word.address: WordValue(literals[word.literal]) for word in block.words}
        words: Words = {}
        memory = self.memory
        for word in block.words:
            place, compiled = word.literal, word.compiled
            value = memory.literals[place] if compiled is None else compiled(memory)
            if word.address in memory.local:
                memory.assign(word.address, (), value)
            else:
                words[word.address] = WordValue(value, word.form, tuple(index(memory) for index in word.indices))
        return words

    def _assign(self, block: Block) -> None:
        memory = self.memory
        for name, index, compiled in block.assignments:
            places = tuple(place(memory) for place in index)
            value = compiled(memory)
            if name[0] == "$":
                self.commands.write(name, places, value)
            else:
                memory.assign(name, places, value)

    def _code(self, code: str, now: Now) -> None:
        state = self.state
        if apply(state, code):
            self.memory.unit = state.unit
            if self.control.stage is not None:
                self.compensation.change_rules(code)
            elif code in OTHER_PLANES:
                self.tooling.plane_changed()
            if code == "G64" or code in TOLERANCES:
                self.control.moves.drive(rounded=float(code in TOLERANCES))
            if code in TOLERANCES:
                self.control.findings.ignored(code)
        elif code in IN_MACHINE:
            now.in_machine = True
        elif code == "G9":
            now.stop = True
        elif code in OFFSETS:
            self.frames.select(OFFSETS[code])
        elif code in FEEDS:
            self.feed_words.set_mode(FEEDS[code])
        elif code in ("G40", "G41", "G42"):
            self.compensation.take(code)
        elif code in SUPPRESSION:
            self.compensation.suppress(code)
        elif code in PROGRAMMED or code in POLES or code in ("G58", "G59", "G74", "G75", "G25", "G26"):
            now.claim = code
        elif code != "G4":
            self._named(code, now)

    def _named(self, code: str, now: Now) -> None:
        """A word that the controller's file explains, a command, or a subprogram."""
        vocabulary = self.vocabulary
        meaning = vocabulary.meaning(code)
        if code in SENSES:
            self.control.turn_spindle(word=code)
        if meaning in self.meanings:
            self.meanings[meaning](now)
        elif meaning == "ignored":
            self.findings.ignored(code)
            self.control.moves.drive(**DYNAMICS.get(code, {}))
        elif code in self.commands.known:
            self.commands.perform(code, [])
        elif code[1:].isdigit() and code[0] == "M":
            self.findings.ignored(code)
            self.findings.assumed(f"{code} is a word of the machine's builder: it is taken to move nothing")
        else:
            cure = vocabulary.refusal(code)
            if cure:
                raise Unread(code, cure)
            times = now.words.pop("P", None)
            self._subprogram(Call(code, times=None if times is None else lambda memory: times.value), [])

    def _call(self, call: Call, words: Words) -> None:
        """NAME(...), L123."""
        arguments = values_of(call, self.memory, arrays=call.name not in self.commands.known)
        meaning = self.vocabulary.meaning(call.name)
        if call.name not in self.commands.known and meaning in self.meanings:
            self.meanings[meaning](Now(words))
        elif meaning == "ignored" and call.name == "WORKPIECE":
            take_blank(arguments, self.control, self.state.unit)
        elif meaning == "ignored":
            self.findings.ignored(call.name)
        elif not self.perform(call, arguments):
            self._subprogram(call, arguments)

    def _subprogram(self, call: Call, arguments: list[Value | None]) -> None:
        cure = self.vocabulary.refusal(call.name)
        if cure and self.interpreter.library.find(call.name) is None:
            raise Unread(call.name, cure)
        self.interpreter.call(call, arguments)

    def perform(self, call: Call, arguments: list[Value | None]) -> bool:
        """Do a command or a cycle; False where it is none."""
        if call.name not in self.commands.known:
            return False
        self.commands.perform(call.name, arguments)
        return True

    def _claim(self, now: Now) -> None:
        code, words = now.claim, now.words
        if code in PROGRAMMED:
            self.frames.program(code, words)
        elif code in POLES:
            set_pole(self.state, self.control.words, code, words)
        elif code in ("G58", "G59"):
            self.frames.axis_shift(code, words)
        elif code in ("G25", "G26"):
            self.findings.ignored(code)
            words.clear()
        else:
            with self.motion.placed():
                self.commands.reference(code, words)
        for address in words:
            if address in AXES:
                raise BlockError(f"{code} beside {address}: no motion stands there; write it in another block")

    def _move(self, now: Now) -> bool:
        words, moved = now.words, False
        stop = now.stop or self.state.exact_stop
        try:
            if now.in_machine:
                moved = self.motion.in_machine(words, stop=stop)
            elif self.motion.has_axes(words):
                moved = self.motion.execute(words, stop=stop)
        except (ArcError, CornerError) as error:
            raise BlockError(str(error)) from None
        for address, word in words.items():
            self._left(address, word.value)
        return moved

    def _ask(self, words: Words) -> None:
        """CTOL=, OTOL= and ATOL=: how far the contour and the orientation may stray; below zero as the machine's data
        say."""
        for address, name in (("CTOL", "tip"), ("OTOL", "axis"), ("ATOL", "axis")):
            if address in words:
                unit = self.state.unit if name == "tip" else DEGREE
                self.control.moves.ask(**{name: bounded(words[address], address) * unit})
        if "FGREF" in words:
            self.findings.assumed(FGREF)

    def _left(self, address: str, value: Value) -> None:
        """A word that nothing in its block took: of a spindle by its number it moves nothing, but for M1=6, M1=30."""
        does = self.vocabulary.meaning(f"{address[0]}{shown(value)}")
        of_spindle = address[0] in "SMH" and address.rstrip("=")[1:].isdigit() and does in ("", "spindle or coolant")
        if of_spindle or self.vocabulary.meaning(address) == "ignored":
            self.findings.ignored(address)
            return
        cure = self.vocabulary.refusal(address) or "it might move something: remove it"
        if address in OF_ARCS:
            cure = "it belongs to arcs: remove it, or write G2, G3 or CIP"
        self.refuse(f"{address}=" if len(address) > 1 and address[-1] != "=" else address, self.control.line, cure)


class FeedWords:
    """Reads F and G4."""

    def __init__(self, run: Run) -> None:
        self.control, self.state, self.findings = run.control, run.state, run.findings
        self.share = 1.0
        """OVR: what is made of F."""

    def dwell(self, words: Words) -> None:
        """G4 F2 or G4 S3: seconds, or turns of the spindle; F and S in force stay."""
        seconds, turns = number(words, "F"), number(words, "S")
        if words:
            raise BlockError(f"G4 beside {next(iter(words))}: write G4 in a block of its own (alarm 12120)")
        if seconds is None and turns is None:
            raise BlockError("G4 needs its time: write G4 F2 for seconds, or G4 S3 for turns of the spindle")
        if seconds is None and turns is not None:
            if self.control.feed.spindle <= 0.0:
                raise BlockError("G4 S counts turns of the spindle: write its speed S before it, or G4 F2")
            seconds = turns / self.control.feed.spindle
        self.control.dwell(seconds or 0.0)

    def override(self, words: Words) -> None:
        """OVR: the share of F [percent] that feed motions have from here on. Raises BlockError."""
        share = (number(words, "OVR") or 0.0) / 100.0
        if not 0.0 < share <= MOST_SHARE:
            raise BlockError(f"OVR={share * 100.0:g} is the share of F in percent: write more than 0, 200 at most")
        feed, changed = self.control.feed, share / self.share
        if feed.value is not None:
            feed.value, feed.turn = feed.value * changed, feed.turn * changed
        if self.state.inverse is not None:
            self.state.inverse *= changed
        self.share = share

    @contextmanager
    def of_block(self, words: Words) -> Iterator[None]:
        """FB: the feed of one block, behind which F holds again (NC Programming, 7: non-modal feed)."""
        if "FB" not in words:
            yield
            return
        feed, state = self.control.feed, self.state
        before = feed.mode, feed.value, feed.turn, feed.unit, state.inverse
        words["F"] = words.pop("FB")
        self.feed(words)
        yield
        feed.mode, feed.value, feed.turn, feed.unit, state.inverse = before

    def set_mode(self, mode: str) -> None:
        """G93, G94, G95; behind a G95 that is said again FZ holds on."""
        feed = self.control.feed
        if not (mode == PER_REVOLUTION and feed.mode == PER_TOOTH):
            feed.set_mode(mode)

    def feed(self, words: Words) -> None:
        """F: under G700 and G710 in the unit of lengths, under G70 and G71 in the base unit of the control.

        FZ in its place under G95: F = FZ $TC_DPNT, and FZ is kept where the tool changes (NC Programming, "Tooth
        feedrate (G95 FZ)"). Raises BlockError.
        """
        feed, state = self.control.feed, self.state
        if "FZ" in words:
            if "F" in words:
                raise BlockError("F beside FZ: which of them holds is not told; write one")
            if feed.mode not in (PER_REVOLUTION, PER_TOOTH):
                raise BlockError("FZ is a feed per tooth, which needs G95: write it before FZ")
            feed.set_mode(PER_TOOTH)
            words["F"] = words.pop("FZ")
        elif feed.mode == PER_TOOTH:
            feed.set_mode(PER_REVOLUTION)
        value = real(words.pop("F").value)
        if feed.mode == INVERSE:
            if not 0.0 < value <= 1e9:
                raise BlockError(f"feed F{value:g} must be above zero: correct F")
            state.inverse = value * self.share
            return
        if state.feed_unit is None and state.base_unit is None and state.unit != MILLIMETRE:
            self.findings.assumed("F under G70 is in inches: the base unit of the control is the program's")
        feed.set(value * self.share, state.unit_of_control(), self.control.line)
