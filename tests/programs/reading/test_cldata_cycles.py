"""CYCLE of NX, of Creo and with fixed places, against a model of a drilling machine that is written here."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.toolpath import ToolPath

MM_MIN = 1e-3 / 60
GAP = 0.254
"""Of pecks that a program leaves to the control [mm]: LinuxCNC's 0.010 inch."""


def path(body: str, **options) -> ToolPath:
    return read_text(body + "\n", None, "apt", **options)


def heights(cycle: str, start: float = 50.0) -> list[tuple[float, bool]]:
    """Heights over the point [mm] of one hole of a cycle, and whether each is fed to."""
    p = path(f"UNITS/MM\nSPINDL/1000,RPM\nGOTO/0,0,{start}\n{cycle}\nGOTO/0,0,0\nCYCLE/OFF")
    return [(round(float(z) * 1e3, 6), not rapid) for z, rapid in zip(p.tip[1:, 2], p.rapid[1:])]


@pytest.mark.parametrize(
    ("cycle", "steps"),
    [
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,250", [(3, 0), (-10, 1), (3, 0)]),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,RTRCTO,AUTO,MMPM,250", [(3, 0), (-10, 1), (3, 0)]),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,RTRCTO,20,MMPR,0.1", [(20, 0), (3, 0), (-10, 1), (20, 0)]),
        ("CYCLE/DRILL,DEEP,RAPTO,3,FEDTO,0,MMPM,250", [(3, 0), (0, 1), (3, 0)]),
        ("CYCLE/DRILL,DEEP,STEP,0,RAPTO,3,FEDTO,-9,MMPM,250", [(3, 0), (-9, 1), (3, 0)]),
        ("CYCLE/BORE,RAPTO,3,FEDTO,-10,MMPM,9", [(3, 0), (-10, 1), (3, 1)]),
        ("CYCLE/TAP,RAPTO,3,FEDTO,-10,RTRCTO,9,MMPR,1", [(9, 0), (3, 0), (-10, 1), (3, 1), (9, 0)]),
        ("CYCLE/BORE,DRAG,RAPTO,3,FEDTO,-10,MMPM,9", [(3, 0), (-10, 1), (3, 0)]),
        (
            "CYCLE/DRILL,DEEP,RAPTO,2,FEDTO,-9,STEP,5,MMPM,250",
            [(2, 0), (-3, 1), (2, 0), (-3 + GAP, 0), (-8, 1), (2, 0), (-8 + GAP, 0), (-9, 1), (2, 0)],
        ),
        (
            "CYCLE/DRILL,BRKCHP,RAPTO,2,FEDTO,-9,STEP,6,4,MMPM,250",
            [(2, 0), (-4, 1), (-4 + GAP, 0), (-8, 1), (-8 + GAP, 0), (-9, 1), (2, 0)],
        ),
        ("CYCLE/DRILL,DEPTH,10,MMPM,250,CLEAR,5", [(5, 0), (-10, 1), (5, 0)]),
        ("CYCLE/DRILL,DEPTH,10,MMPM,250,CLEAR,5,RAPTO,4", [(5, 0), (1, 0), (-10, 1), (5, 0)]),
        ("CYCLE/DRILL,DEPTH,10,MMPM,250,CLEAR,5,RETURN,8", [(8, 0), (5, 0), (-10, 1), (8, 0)]),
        ("CYCLE/DRILL,DEPTH,10,MMPM,250,CLEAR,5,RETURN,0", [(5, 0), (-10, 1), (50, 0)]),
        (
            "CYCLE/BRKCHP,DEPTH,10,STEP,8,MMPM,250,CLEAR,5,BACK,1,TIMES,2",
            [(5, 0), (-3, 1), (-2, 0), (-10, 1), (5, 0)],
        ),
        ("CYCLE/DRILL,10,250,MMPM,5", [(5, 0), (-10, 1), (5, 0)]),
        ("CYCLE/TAP,10,250,MMPM,20,5", [(5, 0), (-10, 1), (5, 1)]),
        ("CYCLE/DEEP,10,250,MMPM,5,10", [(5, 0), (-5, 1), (5, 0), (-5 + GAP, 0), (-10, 1), (5, 0)]),
    ],
)
def test_steps_of_a_hole(cycle, steps):
    assert heights(cycle) == [(height, bool(feeds)) for height, feeds in steps]


def test_cycles_of_solidworks_cam():
    """CYCLE/INIT before each cycle: FEDTO is the depth; 1STPECK and SUBPECK are the pecks of DEEP2."""
    drill = "CYCLE/INIT\nCYCLE/DRILL,FEDTO,5.,MMPM,1712.6,RAPTO,3.,RTRCTO,25.,DWELL,0"
    assert heights(drill) == [(25, False), (3, False), (-5, True), (25, False)]
    deep = "CYCLE/INIT\nCYCLE/DEEP2,FEDTO,9.,1STPECK,5.,SUBPECK,4.,MMPM,800,RAPTO,3.,RTRCTO,25."
    down = [height for height, feeds in heights(deep) if feeds]
    assert down == [-2, -6, -9]


def test_a_cycle_that_returns_to_the_plane_comes_and_goes_at_its_height():
    p = path(
        "UNITS/MM\nGOTO/0,0,50\nCYCLE/DRILL,DEPTH,10,MMPM,250,CLEAR,5,RETURN,0\nGOTO/0,0,0\nGOTO/9,0,20\nCYCLE/OFF"
    )
    assert (p.tip[:, 2] * 1e3).tolist() == pytest.approx([50, 5, -10, 50, 50, 25, 10, 50])


def test_waits_are_at_the_bottom_in_seconds_or_revolutions_and_break_chips():
    start = "UNITS/MM\nSPINDL/120,RPM\nGOTO/0,0,9\n"
    face = path(start + "CYCLE/FACE,RAPTO,3,FEDTO,-10,MMPM,9,DWELL,0.5\nGOTO/0,0,0")
    assert face.dwell.tolist() == [0, 0, 0.5, 0] and face.stop[2]
    turns = path(start + "CYCLE/FACE,RAPTO,3,FEDTO,-10,MMPM,9,DWELL,REV,3\nGOTO/0,0,0")
    assert turns.dwell.tolist() == pytest.approx([0, 0, 1.5, 0])
    chips = path(start + "CYCLE/BRKCHP,DEPTH,10,STEP,8,MMPM,250,CLEAR,5,DWELL,0.25\nGOTO/0,0,0")
    assert chips.dwell.tolist() == [0, 0, 0.25, 0, 0.25, 0]


def test_where_the_spindle_turns_back_the_motion_rests():
    tapped = path("GOTO/0,0,50\nCYCLE/TAP,RAPTO,3,FEDTO,-10,MMPM,250\nGOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/9,0,50")
    assert (tapped.tip[tapped.stop, 2] * 1e3).tolist() == pytest.approx([50, -10, 50])


@pytest.mark.parametrize(
    ("feed", "mm_min"),
    [("MMPM,250", 250), ("IPM,10", 254), ("MMPR,0.1", 200), ("IPR,0.01", 508), ("PERMIN,30", 30)],
)
def test_the_feed_of_a_cycle_is_its_own(feed, mm_min):
    body = (
        f"UNITS/MM\nSPINDL/2000,RPM\nFEDRAT/77\nCYCLE/DRILL,RAPTO,3,FEDTO,-10,{feed}\nGOTO/0,0,0\nCYCLE/OFF\nGOTO/1,1,1"
    )
    assert path(body).feed / MM_MIN == pytest.approx([np.inf, mm_min, np.inf, 77])


def test_a_cycle_without_a_feed_takes_fedrat_and_cycle_on_the_last_cycle():
    p = path(
        "UNITS/MM\nFEDRAT/60\nCYCLE/DRILL,RAPTO,3,FEDTO,-10\nGOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/5,0,9\nCYCLE/ON\nGOTO/9,0,0"
    )
    assert (p.tip[:, 2] * 1e3).tolist() == pytest.approx([3, -10, 3, 9, 3, -10, 3])
    assert np.isfinite(p.feed).tolist() == [0, 1, 0, 0, 0, 1, 0]


def test_a_cycle_ends_with_its_operation():
    p = path(
        "TOOL PATH/A,TOOL,B\nCYCLE/DRILL,RAPTO,3,FEDTO,-9,MMPM,9\nGOTO/0,0,0\nEND-OF-PATH\nTOOL PATH/C,TOOL,B\n"
        "FEDRAT/MMPM,60\nGOTO/0,0,7"
    )
    assert (p.tip[:, 2] * 1e3).tolist() == pytest.approx([3, -9, 3, 7])
    assert "a CYCLE without CYCLE/OFF ends with its operation" in p.assumed


@pytest.mark.parametrize(
    ("cycle", "said"),
    [
        ("DRILL,RAPTO,3,FEDTO,-10", []),
        ("DRILL,RAPTO,3,FEDTO,0", ["CYCLE with FEDTO,0 has no depth: it feeds to the point itself"]),
        ("DRILL,RAPTO,3,FEDTO,-9,OPTION,1", ["OPTION of CYCLE is taken to move nothing"]),
        ("DEEP,RAPTO,3,FEDTO,-9", ["CYCLE with DEEP or BRKCHP but no STEP is taken to go down in one way"]),
        ("DEEP,RAPTO,3,FEDTO,-9,STEP,1", ["pecks of CYCLE step back by, or stay off the last one by, 0.254 mm"]),
        ("BRKCHP,RAPTO,3,FEDTO,-9,STEP,1,BACK,1", []),
        ("BORE,RAPTO,3,FEDTO,-9", ["CYCLE with BORE or REAM is taken to feed out as it feeds in"]),
        ("TAP,RAPTO,3,FEDTO,-9", []),
    ],
)
def test_what_a_cycle_leaves_open_is_said(cycle, said):
    assert path(f"UNITS/MM\nCYCLE/{cycle},MMPM,9\nGOTO/0,0,0\nCYCLE/OFF").assumed == tuple(said)


@pytest.mark.parametrize(
    ("cycle", "word"),
    [
        ("CYCLE/THRU,RAPTO,3,FEDTO,-10,MMPM,9", "CYCLE/THRU"),
        ("CYCLE/BORE,ORIENT,RAPTO,3,FEDTO,-10,MMPM,9", "CYCLE/ORIENT"),
        ("CYCLE/BORE,NODRAG,RAPTO,3,FEDTO,-10,MMPM,9", "CYCLE/NODRAG"),
        ("CYCLE/CSINK,12,RAPTO,3,FEDTO,-10,MMPM,9", "CYCLE/CSINK"),
        ("CYCLE/DRILL,126,85,1,MMPR", "CYCLE/DRILL"),
        ("CYCLE/DRILL,5", "CYCLE/DRILL"),
        ("CYCLE/", "CYCLE/"),
        ("CYCLE/RAPTO,5,DRILL", "CYCLE/RAPTO"),
        ("CYCLE/ON", "CYCLE/ON"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,9\nGODLTA/0,0,1\nCYCLE/OFF", "GODLTA within CYCLE"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,9\nCIRCLE/0,0,0,0,0,1,5\nCYCLE/OFF", "CIRCLE within CYCLE"),
    ],
)
def test_cycles_that_are_not_read_are_refused(cycle, word):
    body = f"UNITS/MM\nFEDRAT/9\nGOTO/0,0,9\n{cycle}\nGOTO/5,0,0\nCYCLE/OFF\nGOTO/1,0,9"
    with pytest.raises(ProgramError, match=rf"{word} is not read: "):
        path(body)


@pytest.mark.parametrize(
    ("cycle", "says"),
    [
        ("CYCLE/DRILL,RAPTO,3,FEDTO,10,MMPM,9", r"from 3 mm to 10 mm over the point, which is up"),
        ("CYCLE/DRILL,DEPTH,-10,CLEAR,3,MMPM,9", r"from 3 mm to 10 mm over the point"),
        ("CYCLE/DRILL,RAPTO,FEDTO,10,MMPM,9", "RAPTO of CYCLE takes one number"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM", "MMPM of CYCLE takes a number"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,0", "must be above zero"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPR,1", "needs the spindle speed"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10", "feed missing"),
        ("CYCLE/DRILL,DEEP,RAPTO,3,FEDTO,-10,MMPM,9,STEP,1e-5", "more than 10000 pecks"),
        ("CYCLE/DRILL,DEEP,RAPTO,3,FEDTO,-10,MMPM,9,STEP,-1", "must not be negative"),
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,9,DWELL,1e8", "between 0 and a day"),
    ],
)
def test_cycles_that_cannot_be(cycle, says):
    with pytest.raises(ProgramError, match=says):
        path(f"UNITS/MM\nGOTO/0,0,9\n{cycle}\nGOTO/5,0,0\nCYCLE/OFF")


class Drill:
    """A drilling machine in millimetres: where the tip went, how fast (None: rapid), and how long it waited there."""

    def __init__(self) -> None:
        self.moves: list[tuple[np.ndarray, float | None, float]] = []

    def go(self, point, axis, height, feed=None, wait=0.0):
        place = np.asarray(point, dtype=float) + height * np.asarray(axis)
        if self.moves and np.abs(place - self.moves[-1][0]).max() <= 1e-9:
            last = self.moves[-1]
            self.moves[-1] = (last[0], last[1], last[2] + wait)
        else:
            self.moves.append((place, feed, wait))

    def hole(self, point, axis, *, high, rapid_to, bottom, leave, feed, peck, short, wait, out):
        self.go(point, axis, high)
        self.go(point, axis, rapid_to)
        level = rapid_to
        while peck > 0 and level - peck > bottom + 1e-6:
            level -= peck
            self.go(point, axis, level, feed, wait if short else 0.0)
            if not short:
                self.go(point, axis, rapid_to)
            self.go(point, axis, min(rapid_to, level + GAP))
        self.go(point, axis, bottom, feed, wait)
        if out:
            self.go(point, axis, rapid_to, feed)
        self.go(point, axis, leave)


def lengths(low, high):
    """Millimetres with few digits: a program that a person could have written."""
    return st.integers(low * 4, high * 4).map(lambda n: n / 4)


points = st.tuples(lengths(-100, 100), lengths(-100, 100), lengths(-20, 20))
angles = st.tuples(st.integers(-80, 80), st.integers(-180, 180))
cycles = st.fixed_dictionaries(
    {
        "form": st.sampled_from(["nx", "creo", "places"]),
        "type": st.sampled_from(["DRILL", "DEEP", "BRKCHP", "TAP", "BORE", "REAM"]),
        "rapid_to": lengths(1, 10),
        "above": lengths(0, 30),
        "depth": lengths(0, 40),
        "feed": st.integers(1, 900),
        "step": lengths(0, 15),
        "wait": st.sampled_from([0.0, 0.5, 2.0]),
        "holes": st.lists(st.tuples(points, angles), min_size=1, max_size=4),
    }
)


def written(c: dict) -> str:
    """The cycle in its form."""
    pecks = c["type"] in ("DEEP", "BRKCHP")
    if c["form"] == "places":
        extra = {"TAP": f"16,{c['rapid_to']}", "DEEP": f"{c['rapid_to']},{c['step']}"}
        extra["BRKCHP"] = extra["DEEP"]
        return f"CYCLE/{c['type']},{c['depth']},{c['feed']},MMPM,{extra.get(c['type'], c['rapid_to'])}"
    step = f",STEP,{c['step']}" if pecks else ""
    wait = f",DWELL,{c['wait']}" if c["wait"] else ""
    if c["form"] == "nx":
        kind = f"DRILL,{c['type']}" if pecks else c["type"]
        leave = f",RTRCTO,{c['rapid_to'] + c['above']}"
        return f"CYCLE/{kind},RAPTO,{c['rapid_to']},FEDTO,{-c['depth']}{leave},MMPM,{c['feed']}{step}{wait}"
    clear = c["rapid_to"] + c["above"]
    return f"CYCLE/{c['type']},DEPTH,{c['depth']}{step},MMPM,{c['feed']},CLEAR,{clear},RAPTO,{c['above']}{wait}"


@pytest.mark.sweep
@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(cycles, min_size=1, max_size=4))
def test_programs_of_cycles_are_drilled_as_the_model_drills(program):
    lines, drill = ["UNITS/MM", "FROM/0,0,200"], Drill()
    drill.go((0, 0, 200), (0, 0, 1), 0.0)
    for c in program:
        lines.append(written(c))
        places, pecks = c["form"] == "places", c["type"] in ("DEEP", "BRKCHP")
        high = c["rapid_to"] + (0 if places else c["above"])
        for (x, y, z), (tilt, turn) in c["holes"]:
            a, b = math.radians(tilt), math.radians(turn)
            axis = (math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a))
            lines.append(f"GOTO/{x},{y},{z},{axis[0]!r},{axis[1]!r},{axis[2]!r}")
            drill.hole(
                (x, y, z),
                axis,
                high=high,
                rapid_to=c["rapid_to"],
                bottom=-c["depth"],
                leave=high,
                feed=c["feed"],
                peck=c["step"] if pecks else 0.0,
                short=c["type"] == "BRKCHP",
                wait=0.0 if places else c["wait"],
                out=c["type"] in ("TAP", "BORE", "REAM"),
            )
        lines.append("CYCLE/OFF")
    p = path("\n".join(lines))
    assert len(p) == len(drill.moves)
    assert p.tip * 1e3 == pytest.approx(np.array([place for place, _, _ in drill.moves]), abs=1e-9)
    assert p.rapid.tolist() == [feed is None for _, feed, _ in drill.moves]
    fed = ~p.rapid
    assert p.feed[fed] / MM_MIN == pytest.approx([feed for _, feed, _ in drill.moves if feed is not None])
    assert np.isinf(p.feed[p.rapid]).all()
    assert p.dwell == pytest.approx([wait for _, _, wait in drill.moves])
