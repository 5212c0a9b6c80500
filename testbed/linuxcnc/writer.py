"""Writes programs for LinuxCNC: words, numbers and positions as the modes in force want them."""

from __future__ import annotations

from random import Random

PLANES = {"G17": ("X", "Y", "Z", "I", "J"), "G18": ("Z", "X", "Y", "K", "I"), "G19": ("Y", "Z", "X", "J", "K")}
"""First and second axis, the normal, and the words of the centre."""


class Writer:
    """Lines of one program, and the modes that are in force behind them."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.lines: list[str] = []
        self.inch, self.absolute, self.plane, self.mode = False, True, "G17", "G94"
        self.labels = 100
        self.subs: list[list[str]] = []
        self.behind: list[str] = []
        """Programs that stand behind the end of the main one."""
        self.length_in_inch = False
        """Unit in which a tool offset was put in force."""
        self.told_tool = False
        """Whether there was M61 or T0: the stand-alone interpreter then does not know the length of the tool."""
        self.named: list[str] = []
        """Variables that have a value."""

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def put(self, *words: str) -> None:
        text = " ".join(word for word in words if word)
        if not text:
            return
        if self.chance(0.04):
            text += self.random.choice([" (said)", " ; said", " (MSG, said)"])
        if self.chance(0.05):
            text = text.lower()
        elif self.chance(0.03):
            text = text.replace(" ", "")
        elif self.chance(0.06) and not any(mark in text for mark in "#[(;/"):
            text = " ".join(self.random.sample(text.split(), len(text.split())))
        self.lines.append(text)

    def number(self, low: float, high: float) -> str:
        """A number in the unit in force, sometimes as an expression."""
        scale = 25.4 if self.inch else 1.0
        value = self.random.uniform(low, high) / scale
        text = f"{value:.4f}" if self.inch else f"{value:.3f}"
        if self.chance(0.3):
            text = f"{value:.1f}"
        elif self.chance(0.05):
            text = f"{value:.0f}"
        elif self.chance(0.05):
            text = text.replace("0.", ".", 1) if abs(value) < 1 else f"{value:.0f}."
        elif self.chance(0.03) and value > 0:
            text = f"+{text}"
        return self.wrapped(text) if self.chance(0.15) else text

    def wrapped(self, text: str) -> str:
        """An expression that comes to a number, nearly."""
        ways = [
            f"[{text}]", f"[{text}*2/2]", f"[{text}+SIN[30]-.5]", f"[ABS[{text}]]", f"[[{text}] + 7 MOD 3]",
            f"[ROUND[{text}]]", f"[FIX[{text}]]", f"[FUP[{text}]]", f"[{text} - ATAN[1]/[1] + 45]", f"-[{text}]",
            f"[{text}+2**2-4]", f"[{text}*[1 LT 2]]", f"[{text}+[3 GT 4 OR 1 EQ 2]]", f"[SQRT[[{text}]**2]]",
            f"[{text}+ACOS[0]-90]", f"[{text}+LN[EXP[1]]]", f"[{text}+[-7.5 MOD 4]]", f"[{text}-TAN[45]*COS[60]]",
            f"[{text}+[2 AND 0]+[1 XOR 0]]", f"[[{text}]+EXISTS[#<never>]]", "-" + f"[-[{text}]]",
            f"[{text} + ASIN[.5] - 30 + 1 - 2 * 3 / 4]",
        ]  # fmt: skip
        if self.named:
            name = self.random.choice(self.named)
            ways += [f"[{text}+{name}]", name, f"[{name}/2]", f"[{text}*[{name} LE 3]]"]
        return self.random.choice(ways)

    def axes(self, share: float, letters: str = "XYZ", *, turning: float = 0.12) -> str:
        """Some axis words, at least one."""
        reach = 60.0 if self.absolute else 15.0
        chosen = [letter for letter in letters if self.chance(share)] or [self.random.choice(letters)]
        words = [letter + self.number(-reach, reach) for letter in chosen]
        for letter in "AC":
            if self.chance(turning):
                words.append(f"{letter}{self.random.uniform(-2 * reach, 2 * reach):.2f}")
        return " ".join(words)

    def to_machine(self) -> None:
        """Before machine coordinates: the interpreter of 2.9 mistakes the unit of an offset after G20 and G21."""
        if self.inch != self.length_in_inch:
            self.put("G49")

    def f(self) -> str:
        """F as the mode of feed wants it."""
        if self.mode == "G93":
            return f"F{self.random.uniform(2, 60):.1f}"
        if self.mode == "G95":
            return f"F{self.random.uniform(0.05, 0.3) / (25.4 if self.inch else 1):.3f}"
        return f"F{self.random.uniform(100, 3000) / (25.4 if self.inch else 1):.1f}"

    def to(self, reach: float = 40.0) -> dict[str, float]:
        """Position X, Y, Z under G90; where the machine then is, in the unit in force."""
        digits = 4 if self.inch else 3
        place = {a: round(self.random.uniform(-reach, reach) / (25.4 if self.inch else 1.0), digits) for a in "XYZ"}
        self.put("G90 G0", *(f"{letter}{value}" for letter, value in place.items()))
        if not self.absolute:
            self.put("G91")
        return place

    def place(self, share: float) -> dict[str, float]:
        reach = {"X": 300, "Y": 200, "Z": 150, "A": 40, "C": 90}
        return {
            letter: round(self.random.uniform(-most, most), 2) for letter, most in reach.items() if self.chance(share)
        }
