"""The result of a verification: one row a check, with worst value, limit and place."""

from __future__ import annotations

import math
from dataclasses import dataclass

from toolpace.common.errors import VerificationError
from toolpace.common.value_objects import ByValue, counted, one_line

_EDGE = {"m": (1e3, "mm"), "rad": (180.0 / math.pi, "deg")}
"""Units are turned into those of the shop floor only where a text is made."""


@dataclass(frozen=True, eq=False, repr=False)
class Check(ByValue):
    """One thing that was looked at, at the place where it came out worst."""

    what: str
    """What was judged: "velocity", "tip to program", ..."""
    value: float
    """The worst value, in SI."""
    limit: float
    """What is allowed, in SI, without tolerance and noise."""
    unit: str
    """The unit of both: "m/s", "rad", ..."""
    ok: bool
    time: float = math.nan
    """When [s]; nan where no time applies."""
    block: int = 0
    """The line number of the block; 0 where none applies."""
    joint: str = ""
    note: str = ""
    """What else helps to understand it, as a few words."""
    at_least: bool = False
    """Whether `limit` is a lower one."""
    noise: float = 0.0
    """Allowance for rounding and sampling that was granted above the limit, in SI."""
    judged: bool = True
    """Whether it was looked at; else it neither passes nor fails, and `note` says why."""

    @property
    def ratio(self) -> float:
        """How bad: 1 is just at the limit, more is worse; inf where there is no telling."""
        over, under = (self.limit, self.value) if self.at_least else (self.value, self.limit)
        if math.isnan(self.value) or (under <= 0.0 < over):
            return math.inf
        return over / under if over > 0.0 else 0.0

    @property
    def name(self) -> str:
        """The check and the joint: "jerk of A"."""
        return f"{self.what} of {self.joint}" if self.joint else self.what

    @property
    def place(self) -> str:
        """Where: "at 1.234 s, block 17"."""
        parts = [] if math.isnan(self.time) else [f"at {self.time:.4g} s"]
        parts += [f"block {self.block}"] if self.block > 0 else []
        return ", ".join(parts)

    def show(self, value: float) -> str:
        """A value with the unit of the shop floor."""
        length, _, rest = self.unit.partition("/")
        scale, unit = _EDGE.get(length, (1.0, length))
        return f"{value * scale:.6g} {unit}{'/' + rest if rest else ''}".rstrip()

    def __str__(self) -> str:
        if math.isnan(self.value) or not (self.unit or self.limit):
            figures = self.note
        else:
            verb = "at least" if self.at_least else "at most"
            figures = f"{self.show(self.value)}, allowed {verb} {self.show(self.limit)}"
            figures += f" ({self.note})" if self.note else ""
        place = f" {self.place}" if self.place else ""
        return f"{self.name}{place}: {figures}"

    def __repr__(self) -> str:
        return one_line(self, f"{'ok' if self.ok else 'FAILED'}: {self}")


@dataclass(frozen=True, eq=False, repr=False)
class Verification(ByValue):
    """What the judge found. `ok` says whether all is well; `checks` holds every row, good or bad."""

    checks: tuple[Check, ...]
    dt: float
    """Time step of the set-points [s]."""
    set_points: int
    """How many were judged."""
    tip_deviation: float = math.nan
    """Largest distance between tip and program, both ways [m]; nan without a program."""
    axis_deviation: float = math.nan
    """Largest angle between tool axis and program at corresponding places [rad]; nan without a program."""
    bending: float = 0.0
    """The most that the tool bends by what it cuts, as far as a tool was given [m]."""

    def __repr__(self) -> str:
        worst = max(self.checks, key=lambda check: (not check.ok, check.ratio), default=None)
        return one_line(
            self,
            "VERIFIED" if self.ok else f"FAILED in {counted(len(self.findings), 'check')}",
            f"{counted(len(self.checks), 'check')} of {counted(self.set_points, 'set-point')}",
            f"worst {worst.name}{f' {worst.place}' if worst.place else ''}" if worst else "",
        )

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return all(check.ok for check in self.checks)

    @property
    def unjudged(self) -> tuple[str, ...]:
        """What could not be judged, and why: "cut: the tool bends"."""
        return tuple(f"{check.name}: {check.note}" for check in self.checks if not check.judged)

    @property
    def findings(self) -> tuple[Check, ...]:
        """The checks that failed, worst first."""
        return tuple(sorted((c for c in self.checks if not c.ok), key=lambda c: -c.ratio))

    def raise_if_failed(self) -> Verification:
        """Return itself if all is well; else raise VerificationError, one line that names the worst
        finding."""
        found = self.findings
        if found:
            more = len(found) - 1
            others = f"; and {more} more finding{'s' if more > 1 else ''}" if more else ""
            raise VerificationError(f"{found[0]}{others}")
        return self

    def rows(self) -> list[tuple[str, str, str, str, str]]:
        """A summary table: check, worst value, limit, where, "ok", "FAILED" or "not judged"."""
        return [
            (
                check.name,
                check.note if math.isnan(check.value) else check.show(check.value),
                "" if math.isnan(check.value) else check.show(check.limit),
                check.place,
                ("ok" if check.ok else "FAILED") if check.judged else "not judged",
            )
            for check in self.checks
        ]
