"""Moves of the joints themselves: in machine coordinates, and turns."""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import FEED, JUMP, RAPID, Rate
from toolpace.programs.reading.coordinates.placement import INSIDE
from toolpace.programs.reading.coordinates.setup import STAND_IN, ZERO_UNSAID


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
