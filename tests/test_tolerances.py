"""Tolerances that differ from place to place: which block has which, in the fit and before the judge."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.tool_paths import tilted, toolpath_through
from toolpace.common import units
from toolpace.common.errors import UsageError
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.program_plan import plan_program
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import Operation

AXIS = math.radians(0.05)
WIDE, NARROW = 50e-6, 4e-6


@pytest.fixture(scope="module")
def zigzag():
    """Corners of 60 degrees every 8 mm: the first half roughing, the second finishing with tool 2; N10, N20, ..."""
    n = 13
    x = np.arange(n) * 4e-3
    tip = np.stack([x, 4e-3 * (np.arange(n) % 2), np.full(n, 0.01)], axis=1)
    path = toolpath_through(tip, tilted(0.5, 0.02 * np.arange(n)), feed=np.inf)
    return replace(
        path,
        operation=(np.arange(n) > 6).astype(np.int64),
        operations=(Operation("rough", "1"), Operation("finish", "2")),
        numbered=np.stack([10 * np.arange(1, n + 1), np.arange(1, n + 1)], axis=1),
        source="zigzag.ngc",
    )


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("xyzac-trunnion")


@pytest.mark.parametrize("place", ["finish", "FINISH", "T2", "N80-N130", "8-13"])
def test_a_place_is_an_operation_a_tool_or_blocks(zigzag, place):
    along = Tolerances(WIDE, {place: NARROW}).tip_along(zigzag)
    assert along[:7].tolist() == [WIDE] * 7 and along[7:].tolist() == [NARROW] * 6


def test_of_two_places_the_later_counts(zigzag):
    along = Tolerances(WIDE, {"finish": NARROW, "N100": 1e-6}).tip_along(zigzag)
    assert along[9] == 1e-6 and along[8] == along[10] == NARROW


@pytest.mark.parametrize(
    "place, told",
    [
        ("finsh", "did you mean 'finish'"),
        ("T3", "did you mean 'T2'|known: rough, finish, T1, T2|did you mean 'T1'"),
        ("N85-N90", "no block N85"),
        ("900-950", "moves nothing in these blocks"),
    ],
)
def test_a_place_that_is_not_there_is_an_error(zigzag, place, told):
    with pytest.raises(UsageError, match=told):
        Tolerances(WIDE, {place: NARROW}).tip_along(zigzag)


def test_what_the_program_tells_holds_only_where_it_is_asked_for(zigzag):
    told = np.full(len(zigzag), np.nan)
    told[7:10] = NARROW
    path = replace(zigzag, tip_tolerance=told)
    assert np.all(Tolerances(WIDE).tip_along(path) == WIDE)
    along = Tolerances(WIDE, {"N90": 1e-6}, program=True).tip_along(path)
    assert along[6:11].tolist() == [WIDE, NARROW, 1e-6, NARROW, WIDE]


def test_what_the_program_asks_for_holds_where_it_is_tighter(zigzag):
    programmed = np.full(len(zigzag), np.nan)
    programmed[7:9], programmed[9:11] = NARROW, 2.0 * WIDE
    path, tighter = replace(zigzag, tip_tolerance=programmed), Tolerances(WIDE, {"N90": 1e-6}, tighter=True)
    along = tighter.tip_along(path)
    assert along[6:11].tolist() == [WIDE, NARROW, 1e-6, WIDE, WIDE]
    assert (0.5 * tighter).tip_along(path) == pytest.approx(0.5 * along)
    assert tighter.within(NARROW).tip_along(path) == pytest.approx(np.minimum(along, NARROW))
    assert tighter.text(lambda value: f"{1e6 * value:.12g}um") == f"{1e6 * WIDE:.12g}um,tighter,N90:1um"
    assert Tolerances.parse("tighter", units.parse_length, WIDE) == Tolerances(WIDE, tighter=True)
    # where the program asks for nothing less it is a number
    assert Tolerances(WIDE, tighter=True).of_tip_in(zigzag) == WIDE
    assert Tolerances(WIDE, tighter=True).of_tip_in(path) == Tolerances(WIDE, tighter=True)
    for wrong in ({"program": True, "tighter": True}, {"side": "above", "tighter": True}):
        with pytest.raises(UsageError):
            Tolerances(WIDE, **wrong)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_product_counts_for_what_the_program_asks_too(zigzag, factor):
    path = replace(zigzag, tip_tolerance=np.where(np.arange(len(zigzag)) % 2, NARROW, np.nan))
    asked = Tolerances(WIDE, {"N90": 1e-6}, program=True)
    assert (factor * asked).tip_along(path) == pytest.approx(factor * asked.tip_along(path))


def test_text_is_read_and_written():
    read = Tolerances.parse("20um, finish:5um,T2:8um,N100-N250:5um", units.parse_length, 10e-6)
    assert read.default == pytest.approx(20e-6) and not read.program
    assert dict(read.places) == pytest.approx({"finish": 5e-6, "T2": 8e-6, "N100-N250": 5e-6})
    assert Tolerances.parse("program", units.parse_length, 10e-6) == Tolerances(10e-6, program=True)
    assert read.text(lambda value: f"{1e6 * value:.12g}um") == "20um,finish:5um,T2:8um,N100-N250:5um"
    for wrong in ("20um,5um", ":5um", "finish:5", "finish:-5um", "finish:0um"):
        with pytest.raises(UsageError):
            Tolerances.parse(wrong, units.parse_length, 10e-6)


def largest_by_operation(plan, path):
    """Largest deviations of the tip that the fit found in each operation."""
    largest = np.zeros(2)
    for run in plan.runs:
        breaks, tip, _ = run.deviations()
        middle = 0.5 * (breaks[1:] + breaks[:-1])
        np.maximum.at(largest, path.operation[run.entry[run.block_index(middle)]], tip)
    return largest


def test_each_block_has_its_own_tube(zigzag, machine):
    both = Tolerances(WIDE, {"finish": NARROW})
    path = tp.Path.fit(zigzag, both, AXIS, machine)
    rough, finish = largest_by_operation(path, zigzag)
    assert NARROW < 0.5 * WIDE < rough <= WIDE
    # the cell in which both meet belongs to both
    assert 0.5 * NARROW < finish <= NARROW * 1.0001


def test_the_judge_holds_each_block_against_its_own(zigzag, machine):
    both = Tolerances(WIDE, {"finish": NARROW})
    found = plan_program(zigzag, machine, both, AXIS)
    assert found.trajectory.usage().worst <= PROMISED
    tp.verify(found.trajectory, machine, zigzag, both, AXIS).raise_if_failed()
    wrong = tp.verify(found.trajectory, machine, zigzag, Tolerances(WIDE, {"rough": NARROW}), AXIS)
    assert not wrong.ok
    named = next(check for check in wrong.checks if not check.ok)
    assert named.limit == NARROW and named.block <= 7
    wide, narrow = (plan_program(zigzag, machine, each, AXIS).trajectory.duration for each in (WIDE, NARROW))
    assert wide < found.trajectory.duration < narrow


def test_a_default_that_holds_nowhere_changes_nothing(zigzag, machine):
    """A default that holds nowhere costs nothing."""
    alone = plan_program(zigzag, machine, NARROW, AXIS).trajectory.duration
    almost = plan_program(zigzag, machine, Tolerances(WIDE, {"1-13": NARROW}), AXIS).trajectory.duration
    assert almost == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.sweep), 4, 8])
def test_paths_with_tolerances_at_random_are_within_them(seed, machine):
    """Corners, specks and long blocks, tolerances from 1 to 200 micrometres and 0.01 to 1 degree in any order."""
    r = np.random.default_rng(seed)
    n = int(r.integers(6, 60))
    way = r.normal(size=(n, 3)) * [1.0, 1.0, 0.2]
    way *= 10.0 ** r.uniform(-4.3, -2.0, (n, 1)) / np.linalg.norm(way, axis=1)[:, None]
    turn = np.cumsum(r.normal(size=(n, 2)), axis=0)
    path = toolpath_through(
        np.cumsum(way, axis=0) + np.array([0.0, 0.0, 0.02]), tilted(0.5 + 0.01 * turn[:, 0], 0.02 * turn[:, 1])
    )
    cuts = np.sort(r.integers(2, n + 1, 6)).reshape(3, 2)
    tips = Tolerances(10.0 ** r.uniform(-6, -3.7), {f"{a}-{b}": 10.0 ** r.uniform(-6, -3.7) for a, b in cuts})
    axes = Tolerances(math.radians(10.0 ** r.uniform(-2, 0)), {"2-4": math.radians(10.0 ** r.uniform(-2, 0))})
    found = plan_program(path, machine, tips, axes, effort="low")
    assert found.trajectory.usage().worst <= PROMISED
    tp.verify(found.trajectory, machine, path, tips, axes).raise_if_failed()
