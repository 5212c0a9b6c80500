"""HAL files that stop LinuxCNC when a joint command leaves the plan.

A stream wants LinuxCNC's own limits lifted. guard.hal lifts them only while it watches: from an output that the stream
sets until the stream ends, or the machine is off or not in automatic mode. It differentiates the commanded position of
each joint every servo cycle, and takes `motion.enable` away where velocity or acceleration pass those of limits.hal. A
block is two cycles of even speed, so that acceleration is the difference of means of two cycles.

Sources: manual pages motion(9), ddt(9), sum2(9), wcomp(9), logic(9), flipflop(9), mux2(9), constant(9), milltask(1) of
LinuxCNC 2.9.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats

GUARD, LIMITS = "guard.hal", "limits.hal"
ABOVE = (1.03, 1.05)
"""Velocity and acceleration at which it stops, as shares of what the stream uses."""
STILL = 1e-3
"""Share of a joint's limits that a joint may use that does not move."""
NO_LIMIT = (10.0, 1000.0)
"""Taken for STILL where a joint has no limit [mm/s, mm/s^2 or deg]."""
LIFTED = (1e6, 1e9)
"""Velocity and acceleration in place of LinuxCNC's limits while the guard watches [mm, deg]."""
THREAD = "servo-thread"
PLAN, ARMED = "toolpace-plan.value", "toolpace-armed.out"
"""Pins that the stream reads: the number of the plan whose limits are set, and whether the guard watches."""
OF_JOINTS = {
    "sum2": ("before", "mean"), "ddt": ("velocity", "acceleration"), "and2": ("trip",),
    "wcomp": ("velocity-window", "acceleration-window"),
}  # fmt: skip
"""Components, and what each joint has of them."""
MOST_JOINTS = 14
"""The sixteen gates of `logic` less two."""
STAMPS = 2**24
"""Numbers of plans; a float holds each of them."""


@dataclass(frozen=True)
class Guard:
    """What is watched, by number of LinuxCNC's joint."""

    axes: str
    """Axis letter of each joint."""
    velocity: Floats
    """(m,) at which it stops [mm/s, deg/s]."""
    acceleration: Floats
    """(m,) at which it stops [mm/s^2, deg/s^2]."""
    output: int
    """Number of the digital output that switches it on."""
    stamp: int
    """Number of the plan."""

    def hal(self, head: list[str]) -> str:
        """guard.hal: the same for every plan on the machine."""
        return "\n".join([*(f"# {line}" for line in head), "", *self._wiring()]) + "\n"

    def limits(self, head: list[str]) -> str:
        """limits.hal: velocities and accelerations of this plan, its number behind them."""
        lines = [*(f"# {line}" for line in head), "", f"setp {PLAN} 0"]
        lines += [f"setp {pin} {value:.9g}" for pin, value in self._windows()]
        return "\n".join([*lines, f"setp {PLAN} {self.stamp}"]) + "\n"

    def difference(self, text: str) -> float:
        """Largest relative difference of the limits in the text of limits.hal; inf where one is missing or too many."""
        lines = [line.split()[1:] for line in text.splitlines() if line.startswith("setp ")]
        right = [(PLAN, 0.0), *self._windows(), (PLAN, float(self.stamp))]
        if [pin for pin, _ in lines] != [pin for pin, _ in right]:
            return math.inf
        return max(abs(float(value) - due) / max(abs(due), 1e-300) for (_, value), (_, due) in zip(lines, right))

    def _windows(self) -> Iterator[tuple[str, float]]:
        """Pins of the windows, and their values."""
        for n, limits in enumerate(zip(self.velocity.tolist(), self.acceleration.tolist())):
            for kind, most in zip(("velocity", "acceleration"), limits):
                yield f"toolpace-{kind}-window-{n}.min", -most
                yield f"toolpace-{kind}-window-{n}.max", most

    def _wiring(self) -> Iterator[str]:
        joints = range(len(self.axes))
        yield "# refused here where the machine is not in mm"
        yield "newsig toolpace-lengths-in-[TRAJ]LINEAR_UNITS bit"
        yield "sets toolpace-lengths-in-mm 1"
        yield ""
        yield from self._components()
        yield ""
        yield f"net toolpace-switch motion.digital-out-{self.output:02d} => toolpace-disarm.in-00 toolpace-armed.clk"
        yield "net toolpace-on motion.motion-enabled => toolpace-disarm.in-01"
        yield "net toolpace-running motion.coord-mode => toolpace-disarm.in-02"
        yield "net toolpace-off toolpace-disarm.nand => toolpace-armed.reset"
        yield "setp toolpace-armed.data 1"
        yield "net toolpace-watching toolpace-armed.out"
        yield f"addf toolpace-disarm {THREAD}"
        yield f"addf toolpace-armed {THREAD}"
        for n in joints:
            yield from self._joint(n)
        yield ""
        yield f"addf toolpace-allow {THREAD}"
        lifts = list(self._lifts())
        for name, own, lifted, _ in lifts:
            yield f"setp {name}.in0 {own}"
            yield f"setp {name}.in1 {lifted:.0f}"
            yield f"net toolpace-watching => {name}.sel"
            yield f"addf {name} {THREAD}"
        yield "# all have run once before what they say is taken"
        yield "loadusr -w sleep 0.1"
        yield "net toolpace-allowed toolpace-allow.nor => motion.enable"
        for name, _, _, pin in lifts:
            yield f"net {name} {name}.out => {pin}"

    def _components(self) -> Iterator[str]:
        """loadrt of all that is used."""
        joints = range(len(self.axes))
        yield "loadrt constant names=toolpace-plan"
        for component, names in OF_JOINTS.items():
            yield f"loadrt {component} names=" + ",".join(f"toolpace-{name}-{n}" for n in joints for name in names)
        yield "loadrt flipflop names=" + ",".join(["toolpace-armed", *(f"toolpace-passed-{n}" for n in joints)])
        gates = {f"toolpace-outside-{n}": 0x802 for n in joints}
        gates |= {"toolpace-disarm": 0x803, "toolpace-allow": 0x1000 + len(joints)}
        yield f"loadrt logic names={','.join(gates)} personality={','.join(f'0x{gate:x}' for gate in gates.values())}"
        yield f"loadrt mux2 names={','.join(name for name, _, _, _ in self._lifts())}"

    def _joint(self, n: int) -> Iterator[str]:
        """The chain of one joint: position, velocity, mean of two cycles, acceleration, windows, latch."""
        # what stands before velocity hands on the velocity of the cycle before
        names = [
            "before",
            "velocity",
            "mean",
            "acceleration",
            "velocity-window",
            "acceleration-window",
            "outside",
            "trip",
            "passed",
        ]
        before, velocity, mean, acceleration, slow, even, outside, trip, passed = (f"toolpace-{e}-{n}" for e in names)
        yield ""
        yield f"# joint {n}, {self.axes[n]}"
        yield f"net toolpace-position-{n} joint.{n}.pos-cmd => {velocity}.in"
        yield f"net {velocity} {velocity}.out => {before}.in0 {mean}.in0 {slow}.in"
        yield f"net {before} {before}.out => {mean}.in1"
        yield f"setp {mean}.gain0 0.5"
        yield f"setp {mean}.gain1 0.5"
        yield f"net {mean} {mean}.out => {acceleration}.in"
        yield f"net {acceleration} {acceleration}.out => {even}.in"
        yield f"net {slow} {slow}.out => {outside}.in-00"
        yield f"net {even} {even}.out => {outside}.in-01"
        yield f"net {outside} {outside}.nand => {trip}.in0"
        yield f"net {trip} {trip}.out => {passed}.set toolpace-allow.in-{n:02d}"
        yield f"net toolpace-watching => {trip}.in1 {passed}.clk"
        for name in names:
            yield f"addf toolpace-{name}-{n} {THREAD}"

    def _lifts(self) -> Iterator[tuple[str, str, float, str]]:
        """Multiplexers: their name, LinuxCNC's own limit, the lifted one, the pin of milltask that it is given to."""
        for kind, lifted in zip(("velocity", "acceleration"), LIFTED):
            yield f"toolpace-{kind}", f"[TRAJ]MAX_LINEAR_{kind.upper()}", lifted, f"ini.traj_max_{kind}"
            for axis in dict.fromkeys(self.axes):
                own = f"[AXIS_{axis}]MAX_{kind.upper()}"
                yield f"toolpace-{axis}-{kind}", own, lifted, f"ini.{axis.lower()}.max_{kind}"


def stops_at(joints: Floats, sag: Floats, period: float, limits: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Velocity and acceleration (m,) at which to stop, of joint positions (n, m) every `period` [s], in their units.

    sag: (k, m) how far joints are beside the straight line in the middle of blocks, where the tip goes straight.
    limits: velocity and acceleration (m,) of the machine, for joints that do not move.
    """
    found = []
    for order, (limit, above, none) in enumerate(zip(limits, ABOVE, NO_LIMIT), start=1):
        used = np.abs(np.diff(joints, n=order, axis=0)).max(axis=0, initial=0.0) / period**order
        used += 2.0 * np.abs(np.diff(sag, n=order - 1, axis=0)).max(axis=0, initial=0.0) / period**order
        found.append(np.maximum(above * used, STILL * np.where(np.isfinite(limit), limit, none)))
    return found[0], found[1]


def stamp_of(positions: Floats) -> int:
    """A number above zero by which a plan is told from others."""
    return 1 + int.from_bytes(hashlib.sha256(positions.tobytes()).digest()[:8], "big") % (STAMPS - 1)
