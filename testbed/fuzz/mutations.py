"""Changes a text by bytes, words, lines, numbers and nesting."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

LONGEST = 6000
"""Bytes of an input: longer than a number that Python makes whole."""
NUMBERS = [
    b"0", b"-0", b"1", b"-1", b"2", b".", b"-", b"", b"0.0001", b"1e300", b"1e-300", b"nan", b"inf", b"9" * 20,
    b"9" * 400, b"9" * 4400, b"-9999999", b"99999", b"1.5", b"3.", b".5", b"2147483648", b"9223372036854775808", b"360",
    b"90", b"-90", b"1000000", b"0x1F", b"1_0", b"\xd9\xa3",
]  # fmt: skip
SCRAPS = [
    b"(", b")", b"[", b"]", b"<", b">", b"#", b"=", b"+", b"-", b"*", b"/", b",", b".", b":", b";", b'"', b"'", b"$",
    b"%", b"~", b"@", b"&", b"!", b"_", b" ", b"\t", b"\n", b"\r", b"\r\n", b"\f", b"\v", b"\x00", b"\x1a", b"\x1b[2J",
    b"\x7f", b"\xff", b"\xef\xbb\xbf", b"\xc3\xa9", b"\xe2\x80\xa8", b"\xc2\x85", b"\xd9\xa0", b"\xc4\xb1", b"\xc3\x9f",
    b"**", b"<>", b"==", b"[[[[[[[[", b"((((((((", b"#[#[#[", b"]]]]", b"- - -", b" " * 200,
]  # fmt: skip
_NUMBER = re.compile(rb"\d+\.?\d*|\.\d+")
_WORD = re.compile(rb"[A-Za-z_$#<>]+[0-9.]*|\S")
_OPEN = {b"(": b")", b"[": b"]", b'"': b'"', b"<": b">"}


class Mutator:
    """Random changes; `words` are those of the dialect."""

    def __init__(self, chance: random.Random, words: Sequence[bytes]) -> None:
        self.chance, self.words = chance, words
        self.kinds: list[Callable[[bytes, bytes], bytes]] = [
            self.byte, self.word, self.word, self.word, self.line, self.line, self.splice, self.splice, self.number,
            self.number, self.nest, self.piece,
        ]  # fmt: skip

    def changed(self, data: bytes, other: bytes) -> bytes:
        """The input with one to eight changes; `other` is another input to take lines from."""
        for _ in range(1 << self.chance.randrange(4)):
            data = self.chance.choice(self.kinds)(data, other)
        return data[:LONGEST]

    def byte(self, data: bytes, _: bytes) -> bytes:
        """One byte is put in, taken out or replaced, or a scrap is put in."""
        at = self.chance.randrange(len(data) + 1)
        new = self.chance.choice(SCRAPS) if self.chance.random() < 0.7 else bytes([self.chance.randrange(256)])
        return data[:at] + self.chance.choice([new, b""]) + data[at + self.chance.randrange(2) :]

    def word(self, data: bytes, _: bytes) -> bytes:
        """A word of the dialect before another, or in its place."""
        places = [m.span() for m in _WORD.finditer(data)] or [(0, 0)]
        begin, end = self.chance.choice(places)
        new = self.chance.choice(self.words)
        kind = self.chance.randrange(4)
        if kind == 0:
            return data[:begin] + new + data[end:]
        if kind == 1:
            return data[:begin] + new + self.chance.choice(NUMBERS) + b" " + data[begin:]
        if kind == 2:
            return data[:begin] + data[end:]
        return data[:begin] + new + self.chance.choice([b" ", b"", b"\n", b"="]) + data[begin:]

    def line(self, data: bytes, _: bytes) -> bytes:
        """A line is taken out, doubled, swapped, joined with the next, or some are shuffled."""
        lines = data.split(b"\n")
        at, to = self.chance.randrange(len(lines)), self.chance.randrange(len(lines))
        kind = self.chance.randrange(5)
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(to, lines[at])
        elif kind == 2:
            lines[at], lines[to] = lines[to], lines[at]
        elif kind == 3:
            lines[at : at + 2] = [b" ".join(lines[at : at + 2])]
        else:
            some = lines[at : at + 4]
            self.chance.shuffle(some)
            lines[at : at + 4] = some
        return b"\n".join(lines)

    def splice(self, data: bytes, other: bytes) -> bytes:
        """Lines of another input are put in, or take the place of the rest."""
        lines, others = data.split(b"\n"), other.split(b"\n")
        at, begin = self.chance.randrange(len(lines) + 1), self.chance.randrange(len(others))
        some = others[begin : begin + self.chance.choice([1, 1, 2, 4, 100])]
        return b"\n".join([*lines[:at], *some, *(lines[at:] if self.chance.random() < 0.8 else [])])

    def number(self, data: bytes, _: bytes) -> bytes:
        """One number becomes another: an extreme, none, or one a little beside."""
        places = [m.span() for m in _NUMBER.finditer(data)]
        if not places:
            return data
        begin, end = self.chance.choice(places)
        old = data[begin:end]
        beside = b"%d" % self.chance.randrange(12)
        new = self.chance.choice([self.chance.choice(NUMBERS), beside, old + beside, b"-" + old])
        return data[:begin] + new + data[end:]

    def nest(self, data: bytes, _: bytes) -> bytes:
        """A piece is put into brackets, once or a thousand times."""
        begin = self.chance.randrange(len(data) + 1)
        end = min(len(data), begin + self.chance.choice([0, 1, 3, 10]))
        times = self.chance.choice([1, 1, 2, 5, 60, 1000])
        opening, closing = self.chance.choice(list(_OPEN.items()))
        return data[:begin] + opening * times + data[begin:end] + closing * times + data[end:]

    def piece(self, data: bytes, _: bytes) -> bytes:
        """A piece is taken out, doubled, repeated, or put elsewhere."""
        begin = self.chance.randrange(len(data) + 1)
        end = min(len(data), begin + self.chance.choice([1, 2, 4, 8, 16, 64]))
        some, to = data[begin:end], self.chance.randrange(len(data) + 1)
        kind = self.chance.randrange(3)
        if kind == 0:
            return data[:begin] + data[end:]
        return data[:to] + some * (1 if kind == 1 else self.chance.choice([2, 3, 20])) + data[to:]
