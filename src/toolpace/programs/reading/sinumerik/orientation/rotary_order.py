"""The first and second rotary axis of a machine, as the control numbers them."""

from __future__ import annotations

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.sinumerik.syntax.values import Unread
from toolpace.programs.reading.sinumerik.word_values import Arguments

_ORDER = "the first rotary axis is the one that carries the other; with a head and a table, that of the head"


def in_order(control: Control) -> list[int]:
    """Columns among the rotary joints, the first axis first: the second stands upon it, and on machines with a head
    and a table the first is that of the head (Commissioning Manual, "CYCLE800 checklist"). Raises Unread.

    Rotary joints are stored from the part to the tool: in a table the one that carries the other comes last.
    """
    poses = control.poses
    if poses.machine is None or len(poses.rotary) != 2:
        raise Unread("rotary axes by their number", "give the machine (--machine NAME), one with two rotary axes")
    return [1, 0] if poses.carried([1.0, 0.0])[0] else [0, 1]


def initial_rotary(control: Control, arguments: Arguments) -> list[float]:
    """Rotary words [rad] of ORIRESET: positions of the machine in the order of its axes, zero where none is told."""
    wanted = [control.datum.zero[3 + k] for k in range(len(control.poses.rotary))]
    if any(arguments.number(place) for place in range(3)):
        order = in_order(control)
        carried = control.poses.carried([1.0, 1.0])
        if arguments.number(2) or carried[0] != carried[1]:
            raise Unread("ORIRESET with positions", "which axis is the first is not told: write A=, B= or C= with G0")
        control.findings.assumed(_ORDER)
        for place, column in enumerate(order):
            wanted[column] += arguments.number(place) * DEGREE
    shift = control.placement.shift or (0.0,) * len(wanted)
    return [a - b for a, b in zip(wanted, shift)]
