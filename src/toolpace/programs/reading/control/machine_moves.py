"""Moves of the machine itself: in machine coordinates, turns of the tool to an axis, and retracts along the tool."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.programs.reading.arcs import ROUNDING, SAG
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import FEED, JUMP, RAPID, Rate
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.setup import STAND_IN, ZERO_UNSAID
from toolpace.programs.reading.coordinates.work_coordinates import INSIDE

MOST_CHORDS = 10_000
"""Of a turn about a point of the tool: more is a slip of its distance."""
THERE = 1e-6
"""Most distance from a rotary position, or a direction, that counts as being there [rad]."""
ROUNDED = 1.2e-5
"""The same of a position that a post repeats with three decimals of a degree [rad]."""


def straight_in_machine(control: Control, coordinates: dict[str, float], *, rapid: bool = True) -> None:
    """Move to machine coordinates by axis letter [m, rad], without offsets, frames and tool length.

    Without a set-up sheet machine coordinates are stand-ins: what lies beyond travel ends at its end.
    """
    if control.stage is not None:
        control.stage.other_motion("a motion in machine coordinates")
    if control.poses.machine is None or not coordinates:
        control.findings.assumed("without a machine, moves in machine coordinates are passed over")
        return
    control.findings.used.machine_zero = True
    control.need_linear_joints()
    slots = {letter: control.slot(letter) for letter in coordinates}
    control.named |= sum(1 << slot for slot in slots.values() if slot < 3)
    wanted = control.datum.joints_of(coordinates, _joints(control))
    _move(control, _within_travel(control, wanted, slots), rapid=rapid)


def reference(control: Control, number: int, letters: list[str]) -> None:
    """Go to a reference point with the axes of these letters, at rapid; all axes where there is none."""
    control.findings.used.references.setdefault(number)
    wanted = control.datum.reference(number)
    straight_in_machine(control, {letter: wanted[letter] for letter in letters or wanted if letter in wanted})
    control.stop()


def machine_coordinates(control: Control) -> dict[str, float]:
    """Where the machine stands, in machine coordinates by axis letter [m, rad]; empty where that is not known."""
    if control.poses.machine is None or len(control.poses.linear) < 3 or not len(control.moves):
        return {}
    setup, joints = control.setup, _joints(control)
    control.findings.used.machine_zero = True
    if not (setup.machine_zero or setup.references):
        control.findings.assumed(
            f"machine coordinates that the program reads count from {STAND_IN} (--setup FILE tells others)"
        )
    return {letter: joints[slot] - control.datum.zero[slot] for letter, slot in control.poses.slots().items()}


def turn_joints(control: Control, wanted: list[float], *, rapid: bool) -> None:
    """Turn the rotary joints to words (rotary) [rad]; the linear joints stay, also where words are the tip."""
    shift = control.placement.shift or (0.0,) * len(wanted)
    _move(control, [*_joints(control)[:3], *(a + b for a, b in zip(wanted, shift))], rapid=rapid)


def repeats_rotary(control: Control, target: list[float], said: str) -> bool:
    """Whether the rotary words of a target (3 + rotary) repeat where the axes stand; then they become that.

    said: what is taken for granted where they do so with decimals left out.
    """
    off = max((abs(a - b) for a, b in zip(target[3:], control.words[3:])), default=0.0)
    if off > ROUNDED:
        return False
    if off > THERE:
        control.findings.assumed(said)
    target[3:] = control.words[3:]
    return True


def _joints(control: Control) -> list[float]:
    """Where the joints are (3 + rotary) [m, rad]."""
    placement = control.placement
    place = placement.place(control.words if control.stage is None else control.stage.kept)
    return control.poses.to_joints(place, placement.tool_length) if placement.tip_mode else place


def _move(control: Control, joints: list[float], *, rapid: bool) -> None:
    """Move to joints (3 + rotary) [m, rad]; words then speak of the place that is reached."""
    placement, moves, line = control.placement, control.moves, control.line
    if control.stage is not None:
        control.stage.other_motion("a motion in machine coordinates")
    rate = Rate() if rapid else control.feed.rate(None, line)
    if placement.tip_mode and len(moves):
        # the way begins at the joints, and the last row is a tip
        moves.add(_joints(control), Rate(), line, JUMP, False, control.named, placement.tool_length)
    moves.add(joints, rate, line, RAPID if rapid else FEED, False, control.named, placement.tool_length)
    place = joints
    if placement.tip_mode:
        place = control.poses.to_tip(joints, placement.tool_length)
        moves.add(place, Rate(), line, JUMP, True, control.named, placement.tool_length)
    control.words = placement.words(place)


def _within_travel(control: Control, joints: list[float], slots: dict[str, int]) -> list[float]:
    """The joints, with those of these letters inside travel where there is no sheet that tells the machine's zero."""
    machine, setup = control.poses.machine, control.setup
    assert machine is not None
    if setup.machine_zero or setup.references:
        if setup.lacks_zero:
            control.findings.assumed(ZERO_UNSAID)
        return joints
    control.findings.assumed(
        f"machine coordinates and reference points count from {STAND_IN}, 1 mm inside (--setup FILE tells others)"
    )
    columns = [*control.poses.linear, *control.poses.rotary]
    for letter, slot in slots.items():
        low, high = (float(end) for end in machine.travel[columns[slot]])
        if not low <= joints[slot] <= high:
            control.findings.assumed(f"machine coordinates of {letter} beyond its travel end at the end of travel")
        inside = min(INSIDE, 0.5 * (high - low)) if slot < 3 else 0.0
        joints[slot] = min(max(joints[slot], low + inside), high - inside)
    return joints


def rotary_for(
    control: Control,
    axis: list[float],
    sign: int = 0,
    *,
    first: tuple[int, int] | None = None,
    else_other: bool = False,
) -> list[float]:
    """Rotary words that bring the tool to an axis (3,) on the part, the nearest to where the machine is.

    sign: of the two solutions the one with the second rotary joint below (-1) or above (1) zero; 0: either.
    else_other: where that one is out of travel, the other. first: the rotary joints in the order in which each turns as
    little as it can; None: the sum of squares counts. Raises ProgramError.
    """
    placement = control.placement
    present = placement.place(control.words)[3:]
    wanted, fault = control.orientation.rotary(axis, present, sign, first, else_other=else_other)
    if fault:
        control.source.fail(fault, control.line)
    shift = placement.shift or (0.0,) * len(wanted)
    return [a - b for a, b in zip(wanted, shift)]


def plane_axis(control: Control) -> list[float]:
    """The direction (3,) on the part that the tool has when it stands upright on the plane of the frame."""
    return direction_on_part(control, (0.0, 0.0, 1.0))


def direction_on_part(control: Control, direction: Sequence[float]) -> list[float]:
    """A direction (3,) of the program's coordinates as a unit vector on the part; zero stays zero."""
    placement = control.placement if control.placement.tip_mode else control.coordinates.on_part()
    lengths = [math.hypot(*(row[column] for row in placement.matrix)) for column in range(3)]
    if max(lengths) - min(lengths) > ROUNDING * max(lengths):
        control.source.fail(
            "a direction of the tool in coordinates that are scaled unevenly: controls differ in whether it is scaled "
            "too; end the scale before, or scale the path in the CAM system",
            control.line,
        )
    found = affine.direct(placement.matrix, direction)
    length = math.hypot(*found) or 1.0
    return [value / length for value in found]


def turn_to_plane(
    control: Control,
    *,
    follow: bool = False,
    rapid: bool = True,
    sign: int = 0,
    first: tuple[int, int] | None = None,
    else_other: bool = False,
) -> None:
    """Turn the rotary joints until the tool stands upright on the plane of the frame.

    follow: the tip keeps its place on the part; else the linear joints keep theirs.
    """
    wanted = rotary_for(control, plane_axis(control), sign, first=first, else_other=else_other)
    if follow:
        control.straight([*control.words[:3], *wanted], 0, rapid=rapid)
    else:
        turn_joints(control, wanted, rapid=rapid)


def retract(control: Control, distance: float | None, *, rapid: bool) -> None:
    """Move from the part along the tool axis, by a distance [m], or with None until a linear joint is at the end of
    its travel. Raises ProgramError where there is no such end."""
    poses, placement = control.poses, control.placement
    place = placement.place(control.words)
    if poses.machine is None:
        if distance is None:
            control.findings.assumed("without a machine, retracts to the end of travel are passed over")
            return
        way, axis = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    else:
        control.need_linear_joints()
        _, columns, axis = poses.linear_map(place[3:])
        way = np.linalg.solve(columns, axis)
    if distance is None:
        joints = poses.to_joints(place, placement.tool_length) if placement.tip_mode else place
        distance = room(control, joints[:3], way)
    step = axis if placement.tip_mode else way
    moved = [*(np.array(place[:3]) + distance * step).tolist(), *place[3:]]
    named = sum(1 << k for k in range(3) if abs(way[k]) > ROUNDING)
    control.straight(placement.words(moved), named, rapid=rapid)


def room(control: Control, joints: list[float], way: np.ndarray) -> float:
    """How far [m] linear joints (3,) can go along a way (3,) a metre before one is at the end of its travel.

    The end is INSIDE short of it, as for reference points: a smooth path swings about its points ("M140 MB MAX" stops
    before the limit switch by the machine parameter moveBack, TNC 640 "M140").
    """
    machine = control.poses.machine
    assert machine is not None
    travel = np.asarray(machine.travel)[list(control.poses.linear)]
    ends = [
        ((high - INSIDE if way[k] > 0.0 else low + INSIDE) - joints[k]) / way[k]
        for k, (low, high) in enumerate(travel)
        if abs(way[k]) > ROUNDING
    ]
    nearest = min(ends, default=math.inf)
    if not math.isfinite(nearest):
        control.source.fail(
            f"a retract to the end of travel, and machine '{machine.name}' has none along its tool: "
            "write a length, or give the machine its travel",
            control.line,
        )
    return max(float(nearest), 0.0)


def turn_about(control: Control, wanted: list[float], distance: float, *, rapid: bool) -> None:
    """Turn the rotary joints to words (rotary) [rad] while the point of the tool that is `distance` [m] above its tip
    keeps its place on the part."""
    poses, placement = control.poses, control.placement
    if poses.machine is None or not distance:
        control.straight([*control.words[:3], *wanted], 0, rapid=rapid)
        return
    present = control.words[3:]
    shift = placement.shift or (0.0,) * len(wanted)
    place = placement.place(control.words)
    tip = place[:3] if placement.tip_mode else poses.to_tip(place, placement.tool_length)[:3]
    pivot = np.array(tip) + distance * np.array(poses.axis(place[3:]))
    turned = math.dist(wanted, present)
    chords = math.ceil(turned / math.sqrt(8.0 * SAG / (abs(distance) + SAG))) or 1
    if chords > MOST_CHORDS:
        control.source.fail(
            f"a turn about a point {distance * 1e3:g} mm above the tip: check the distance", control.line
        )
    for k in range(1, chords + 1):
        rotary = [a + (b - a) * k / chords for a, b in zip(present, wanted)]
        joints = [a + b for a, b in zip(rotary, shift)]
        at = [*(pivot - distance * np.array(poses.axis(joints))).tolist(), *joints]
        at = at if placement.tip_mode else poses.to_joints(at, placement.tool_length)
        control.straight(placement.words(at), 0, rapid=rapid)
