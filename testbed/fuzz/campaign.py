"""Fuzzes one dialect: keeps every input that takes a branch, or takes one so often, as none before it did."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from testbed.fuzz import coverage
from testbed.fuzz.mutations import Mutator
from testbed.fuzz.oracle import SLOW, Wrong
from testbed.fuzz.targets import Asked, Target

WEIGHED = 400
"""Of so many inputs the memory of one is measured."""
FRESH = 30
"""Inputs kept last, of which a third of all are made."""
MOST_TRIALS = 400
"""To make an input smaller that goes wrong, or that is kept."""


@dataclass
class Found:
    """Something that must not be."""

    kind: str
    told: str
    data: bytes
    asked: Asked
    times: int = 1


@dataclass
class Campaign:
    """What was done and found; `run` goes on with it."""

    target: Target
    seed: int
    executions: int = 0
    seconds: float = 0.0
    kept: list[tuple[bytes, Asked]] = field(default_factory=list)
    seen: set[int] = field(default_factory=set)
    found: dict[str, Found] = field(default_factory=dict)

    def run(self, seconds: float, say: Callable[[str], None], enough: Callable[[], bool] = lambda: False) -> None:
        """Try seeds, then changes of what was kept, for so much CPU time or until it is enough."""
        chance = random.Random(self.seed)
        mutator = Mutator(chance, self.target.words)
        began = time.process_time()
        for data in self.target.seeds():
            for machine_given in (Asked(), Asked(skip_unknown=True), Asked(machine="", skip_unknown=True)):
                self.trial(data, machine_given, say)
        last = 0.0
        while self.seconds < seconds and not enough():
            pool = self.kept[-FRESH:] if chance.random() < 0.33 else self.kept
            data, asked = chance.choice(pool)
            asked = Asked.at_random(chance) if chance.random() < 0.3 else asked
            self.trial(mutator.changed(data, chance.choice(self.kept)[0]), asked, say)
            self.seconds = time.process_time() - began
            if self.seconds > last + 30.0:
                last = self.seconds
                say(self.state())

    def trial(self, data: bytes, asked: Asked, say: Callable[[str], None]) -> None:
        """Try one input; keep it where it is new, note it where it goes wrong."""
        weighed = len(data) if self.executions % WEIGHED == 1 else 0
        wrong = self._wrong(data, asked, weighed)
        new = coverage.features() - self.seen
        if wrong is not None:
            if wrong.kind in self.found:
                self.found[wrong.kind].times += 1
            else:
                trials = 20 if wrong.kind in SLOW else MOST_TRIALS
                data = self._smaller(data, lambda less: self._kind(less, asked, weighed) == wrong.kind, trials)
                self.found[wrong.kind] = Found(wrong.kind, str(wrong), data, asked)
                say(f"WRONG {wrong}\n  {data!r}\n  {asked}")
            coverage.features()
        elif new or not self.kept:
            if self.seconds > 0.0:
                data = self._smaller(data, lambda less: new <= self._features(less, asked), 40)
            self.seen |= new
            self.kept.append((data, asked))

    def state(self) -> str:
        """A line that says how far it has come."""
        covered = len({feature // coverage.MOST_TIMES for feature in self.seen})
        return (
            f"{self.target.name}: {self.seconds:.0f} s, {self.executions} inputs, {len(self.kept)} kept, "
            f"{covered} branches, {len(self.found)} wrong"
        )

    def _wrong(self, data: bytes, asked: Asked, weighed: int = 0) -> Wrong | None:
        self.executions += 1
        try:
            self.target.read(data, asked, weighed)
        except Wrong as wrong:
            return wrong
        return None

    def _kind(self, data: bytes, asked: Asked, weighed: int) -> str:
        wrong = self._wrong(data, asked, weighed)
        return "" if wrong is None else wrong.kind

    def _features(self, data: bytes, asked: Asked) -> frozenset[int]:
        coverage.features()
        self._wrong(data, asked)
        return coverage.features()

    def _smaller(self, data: bytes, holds: Callable[[bytes], bool], trials: int = MOST_TRIALS) -> bytes:
        """The input without the lines, then the bytes, that it does not need (Zeller and Hildebrandt 2002, halved)."""
        for mark in (b"\n", b""):
            parts = data.split(b"\n") if mark else [data[i : i + 1] for i in range(len(data))]
            size = max(1, len(parts) // 2)
            while size and trials > 0:
                at = 0
                while at < len(parts) and trials > 0:
                    less = parts[:at] + parts[at + size :]
                    trials -= 1
                    if holds(mark.join(less)):
                        parts = less
                    else:
                        at += size
                size //= 2
            data = mark.join(parts)
        return data
