"""Random programs of O-words: loops, conditions and calls within each other, each motion to a place of its own."""

from __future__ import annotations

import random

from testbed.linuxcnc.job import Job

MOST_DEEP = 4
CONDITIONS = ("0", "1", "1", "#100 gt 3", "#100 mod 2", "[#100 mod 3] eq 1")
"""#100 counts the rounds of all loops; from 40 on none begins another."""


class Nested:
    """The program while it is written."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.labels, self.places = 10, 0
        self.subs: list[str] = []
        self.names: list[str] = []

    def label(self) -> str:
        self.labels += 1
        return f"o{self.labels}" if self.random.random() < 0.6 else f"o<n{self.labels}>"

    def motion(self) -> list[str]:
        self.places += 1
        return [f"G1 X{self.places}"]

    def body(self, deep: int, loops: list[str], sub: str) -> list[str]:
        """Lines within the loops and the subprogram of these names."""
        kinds = [self.motion] * 4
        if deep < MOST_DEEP:
            kinds += [lambda: self.loop(deep, loops, sub)] * 3 + [lambda: self.condition(deep, loops, sub)] * 2
        if loops:
            kinds += [lambda: self.guarded(f"{self.random.choice(loops)} {self.random.choice(('break', 'continue'))}")]
        if sub:
            kinds += [lambda: self.guarded(f"{sub} return [#100]")]
        elif self.names:
            kinds += [lambda: [f"{self.random.choice(self.names)} call [#100]"]]
        return [line for _ in range(self.random.randint(1, 3)) for line in self.random.choice(kinds)()]

    def guarded(self, line: str) -> list[str]:
        label = self.label()
        return [f"{label} if [{self.random.choice(CONDITIONS)}]", line, f"{label} endif"]

    def condition(self, deep: int, loops: list[str], sub: str) -> list[str]:
        label = self.label()
        lines = []
        for branch in ["if", *["elseif"] * self.random.randint(0, 2)]:
            lines += [f"{label} {branch} [{self.random.choice(CONDITIONS)}]", *self.body(deep + 1, loops, sub)]
        if self.random.random() < 0.5:
            lines += [f"{label} else", *self.body(deep + 1, loops, sub)]
        return [*lines, f"{label} endif"]

    def loop(self, deep: int, loops: list[str], sub: str) -> list[str]:
        label, count = self.label(), f"#{self.random.randint(20, 27)}"
        kind, rounds = self.random.choice(("while", "do", "repeat")), self.random.randint(0, 3)
        if kind == "repeat":
            inside = ["#100=[#100+1]", *self.body(deep + 1, loops, sub)]
            return [f"{label} repeat [{rounds}]", *inside, f"{label} endrepeat"]
        test = f"{label} while [[{count} lt {rounds}] and [#100 lt 40]]"
        first, last = (test, f"{label} endwhile") if kind == "while" else (f"{label} do", test)
        inside = self.body(deep + 1, [*loops, label], sub)
        return [f"{count}=0", first, f"{count}=[{count}+1]", "#100=[#100+1]", *inside, last]


def nested_job(seed: int) -> Job:
    """A program of O-words."""
    writer = Nested(seed)
    for _ in range(writer.random.randint(0, 2)):
        label = writer.label()
        writer.subs += [f"{label} sub", *writer.body(1, [], label), f"{label} endsub"]
        writer.names.append(label)
    lines = ["G21 F100", "#100=0", *writer.subs, *writer.body(0, [], ""), *writer.body(0, [], ""), "M2"]
    return Job("\n".join(lines) + "\n", numbered=False)
