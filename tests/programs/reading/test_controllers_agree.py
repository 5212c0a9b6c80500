"""One program, written for each controller, is one motion: judged by a model that knows no G-code."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.controllers import read_for

NUMBER = st.integers(-4000, 4000).map(lambda n: n / 100)
PLACE = st.tuples(NUMBER, NUMBER, st.integers(500, 3000).map(lambda n: n / 100))
OPERATIONS = st.one_of(
    st.tuples(st.just("line"), PLACE),
    st.tuples(st.just("rapid"), PLACE),
    st.tuples(st.just("by"), PLACE),
    st.tuples(st.just("inch"), st.booleans()),
    st.tuples(st.just("circle"), st.integers(100, 3000).map(lambda n: n / 100)),
    st.tuples(st.just("hole"), PLACE, st.booleans()),
    st.tuples(st.just("dwell"), st.integers(1, 40).map(lambda n: n / 10)),
    st.tuples(st.just("datum"), PLACE),
    st.tuples(st.just("loop"), st.integers(1, 4)),
)


class Model:
    """Where the tool goes [mm], for how long it waits, and the text that says so to a controller."""

    def __init__(self, controller: str) -> None:
        self.controller = controller
        self.points, self.wait = [np.array([0.0, 0.0, 100.0])], 0.0
        self.unit, self.datum = 1.0, np.zeros(3)
        self.text = ["G90 G21 G94 G17", "G0 X0. Y0. Z100.", "G1 F600."]

    def words(self, place: np.ndarray) -> str:
        return " ".join(f"{letter}{value / self.unit:.9f}" for letter, value in zip("XYZ", place))

    def go(self, place: np.ndarray) -> None:
        self.points.append(np.array(place, dtype=float))

    def line(self, place, word: str = "G1") -> None:
        self.text.append(f"{word} {self.words(np.array(place))}")
        self.go(np.array(place) + self.datum)

    def rapid(self, place) -> None:
        self.line(place, "G0")

    def by(self, way) -> None:
        self.text += [f"G91 G1 {self.words(np.array(way))}", "G90"]
        self.go(self.points[-1] + way)

    def inch(self, on: bool) -> None:
        self.unit = 25.4 if on else 1.0
        self.text += ["G20" if on else "G21", f"F{600 / self.unit:.6f}"]

    def circle(self, radius: float) -> None:
        self.text.append(f"G2 I{radius / self.unit:.9f} J0.")
        self.go(self.points[-1])

    def hole(self, place, to_r: bool) -> None:
        x, y, depth = place
        level = self.points[-1][2]
        top, bottom = 60.0, 60.0 - depth
        at = np.array([x, y, 0.0]) + self.datum * [1, 1, 0]
        up = np.array([0.0, 0.0, 1.0])
        self.text += [
            f"{'G99' if to_r else 'G98'} G81 X{x / self.unit:.9f} Y{y / self.unit:.9f} "
            f"Z{(bottom - self.datum[2]) / self.unit:.9f} R{(top - self.datum[2]) / self.unit:.9f}",
            "G80",
        ]
        if level < top:
            self.go([*self.points[-1][:2], top])
        for z in (max(level, top), top, bottom, top if to_r else max(level, top)):
            self.go(at + z * up)

    def dwell(self, seconds: float) -> None:
        self.text.append(f"G4 P{1000 * seconds:.0f}" if self.controller in ("fanuc", "haas") else f"G4 P{seconds}")
        self.wait += seconds

    def datum_(self, place) -> None:
        self.datum = np.array(place)
        self.text.append(f"G52 {self.words(self.datum)}")

    def loop(self, times: int) -> None:
        step = 1 / self.unit
        if self.controller in ("linuxcnc", "iso"):
            self.text += ["#1=0", f"o1 while [#1 LT {times}]", f"G91 G1 X{step:.9f}", "G90", "#1=[#1+1]", "o1 endwhile"]
        else:
            self.text += ["#1=0", f"WHILE [#1 LT {times}] DO1", f"G91 G1 X{step:.9f}", "G90", "#1=#1+1", "END1"]
        for _ in range(times):
            self.go(self.points[-1] + [1, 0, 0])


def distinct(points):
    return [a for a, b in zip(points, [None, *points]) if b is None or np.abs(a - b).max() > 1e-5]


@pytest.mark.parametrize("controller", ["linuxcnc", "fanuc", "haas", "iso"])
@settings(max_examples=60, deadline=None, derandomize=True)
@given(operations=st.lists(OPERATIONS, min_size=2, max_size=14))
def test_what_a_controller_is_told_is_what_is_read(controller, operations):
    model = Model(controller)
    for number, (name, *values) in enumerate(operations):
        if name == "loop" and any(earlier[0] == "loop" for earlier in operations[:number]):
            continue  # O-numbers are used once
        getattr(model, "datum_" if name == "datum" else name)(*values)
    model.line([1.0, 2.0, 3.0])
    path = read_for(controller, "\n".join([*model.text, "M30"]))
    assert path.dwell.sum() == pytest.approx(model.wait)
    tips = path.tip * 1e3
    at = 0
    for wanted in model.points:
        # every place of the model comes in turn; between them lie points of arcs alone
        near = np.flatnonzero(np.abs(tips[at:] - wanted).max(axis=1) < 1e-5)
        assert len(near), (wanted, model.text)
        at += int(near[0])
    assert np.abs(tips[-1] - model.points[-1]).max() < 1e-5
    if not any(name == "circle" for name, *_ in operations):
        # the words of inches are rounded: what they say again is the same place
        kept, read = distinct(model.points), distinct(tips)
        assert len(read) == len(kept) and np.abs(np.array(read) - kept).max() < 1e-5
