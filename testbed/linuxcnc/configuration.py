"""The files of a headless LinuxCNC for a machine: ini, HAL, tool table, remaps of M428 and M429."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from testbed.linuxcnc.patterns import Pattern, as_joints, holding_tip
from toolpace.common.arrays import Floats
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.machine import Machine

FAR = 1e6
"""Travel and limits of what nothing limits [mm, mm/s, deg, ...]."""
SLIDE = {"velocity": 1000.0, "acceleration": 10000.0}
"""Of the axis W along the tool, which no program here moves [mm]."""
SAMPLES = 30_000
"""Depth of the queue from the servo thread to the driver, in cycles."""


@dataclass(frozen=True)
class Configuration:
    """A machine as LinuxCNC is to run it: its limits, a servo cycle, tools; travel is not held."""

    machine: Machine
    pattern: Pattern
    cycle: float = 1e-3
    """Servo period [s]."""
    tools: Mapping[int, float] = field(default_factory=lambda: dict.fromkeys(range(1, 21), 0.0))
    """Lengths [m] by number."""
    path_velocity: float = FAR
    """MAX_LINEAR_VELOCITY of [TRAJ] [mm/s]."""
    trajectory: Mapping[str, float] = field(default_factory=dict)
    """More settings of [TRAJ], such as ARC_BLEND_ENABLE."""

    @property
    def letters(self) -> tuple[str, ...]:
        """Axis letters of its joints."""
        return self.pattern.letters

    @classmethod
    def joints(cls, machine: Machine, path_velocity: float = FAR) -> Configuration:
        """Words are joint positions."""
        return cls(machine, as_joints(machine), path_velocity=path_velocity)

    @classmethod
    def tip(cls, machine: Machine, path_velocity: float = FAR) -> Configuration:
        """Words are the tip between M428 and M429. Raises UsageError for a machine of another kind."""
        return cls(machine, holding_tip(machine), path_velocity=path_velocity)

    def units(self) -> Floats:
        """(m,) of each joint: a millimetre or a degree."""
        return np.array([DEGREE if letter in "ABC" else MILLIMETRE for letter in self.letters])

    def limits(self, letter: str) -> tuple[float, float]:
        """Velocity and acceleration [mm or deg]."""
        if letter not in self.machine.joints:
            return SLIDE["velocity"], SLIDE["acceleration"]
        at = self.machine.joints.index(letter)
        unit = DEGREE if letter in "ABC" else MILLIMETRE
        limits = self.machine.limits
        return min(float(limits.velocity[at] / unit), FAR), min(float(limits.acceleration[at] / unit), FAR)

    def write(self, folder: Path) -> None:
        """Everything that `linuxcnc machine.ini` needs, into a folder."""
        (folder / "machine.ini").write_text(self._ini(folder), encoding="utf-8")
        (folder / "machine.hal").write_text(self._hal(), encoding="utf-8")
        table = [f"T{n} P{n} Z{length / MILLIMETRE:.9f} D10\n" for n, length in sorted(self.tools.items())]
        (folder / "tool.tbl").write_text("".join(table), encoding="utf-8")
        for word, kind in (("m428", 1), ("m429", 0)):
            # M66 waits until motion has done what M68 asks for
            body = f"o<{word}> sub\nM68 E3 Q{kind}\nM66 E0 L0\no<{word}> endsub\nM2\n"
            (folder / f"{word}.ngc").write_text(body, encoding="utf-8")
        sampled = {"joints": len(self.letters), "columns": self._columns()}
        (folder / "sampled.json").write_text(json.dumps(sampled), encoding="utf-8")

    def _columns(self) -> str:
        """Of the sampler: line, path velocity, joints."""
        return "sf" + "f" * len(self.letters)

    def _ini(self, folder: Path) -> str:
        remaps = ["REMAP = M428 modalgroup=10 ngc=m428", "REMAP = M429 modalgroup=10 ngc=m429"]
        lines = [
            "[EMC]", "VERSION = 1.1", "MACHINE = toolpace", "DEBUG = 0",
            "[DISPLAY]", f"DISPLAY = {folder / 'driver.py'}",
            "[TASK]", "TASK = milltask", "CYCLE_TIME = 0.001",
            "[RS274NGC]", "PARAMETER_FILE = parameters.var", "SUBROUTINE_PATH = .", "HAL_PIN_VARS = 1",
            "RS274NGC_STARTUP_CODE = G21 G90 G94 G17 G40 G49 G80", *(remaps if self.pattern.holds_tip else []),
            "[EMCMOT]", "EMCMOT = motmod", "COMM_TIMEOUT = 1.0", f"SERVO_PERIOD = {round(self.cycle * 1e9)}",
            "[EMCIO]", "EMCIO = io", "CYCLE_TIME = 0.020", "TOOL_TABLE = tool.tbl",
            "[HAL]", "HALFILE = machine.hal",
            "[KINS]", f"KINEMATICS = {self.pattern.module}", f"JOINTS = {len(self.letters)}",
            "[TRAJ]", f"COORDINATES = {''.join(self.letters)}", "LINEAR_UNITS = mm", "ANGULAR_UNITS = degree",
            f"DEFAULT_LINEAR_VELOCITY = {self.path_velocity}", f"MAX_LINEAR_VELOCITY = {self.path_velocity}",
            f"DEFAULT_LINEAR_ACCELERATION = {FAR}", f"MAX_LINEAR_ACCELERATION = {FAR}", "NO_FORCE_HOMING = 1",
            *(f"{key} = {value:g}" for key, value in self.trajectory.items()),
        ]  # fmt: skip
        for number, letter in enumerate(self.letters):
            velocity, acceleration = self.limits(letter)
            common = [
                f"MIN_LIMIT = {-FAR}", f"MAX_LIMIT = {FAR}",
                f"MAX_VELOCITY = {velocity!r}", f"MAX_ACCELERATION = {acceleration!r}",
            ]  # fmt: skip
            kind = "ANGULAR" if letter in "ABC" else "LINEAR"
            lines += [f"[AXIS_{letter}]", *common, f"[JOINT_{number}]", *common, f"TYPE = {kind}", "HOME = 0"]
            lines += [
                "HOME_SEARCH_VEL = 0",
                "HOME_LATCH_VEL = 0",
                "HOME_SEQUENCE = 0",
                "FERROR = 1000",
                "MIN_FERROR = 1000",
            ]
        return "\n".join(lines) + "\n"

    def _hal(self) -> str:
        lines = [
            "loadrt [KINS]KINEMATICS",
            "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS num_aio=8",
            f"loadrt sampler depth={SAMPLES} cfg={self._columns()}", "setp sampler.0.enable 0",
            "addf motion-command-handler servo-thread", "addf motion-controller servo-thread",
            "addf sampler.0 servo-thread",
            "net on iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
            "net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared",
            "net change iocontrol.0.tool-change => iocontrol.0.tool-changed",
            "setp spindle.0.at-speed 1",
            "net line motion.program-line => sampler.0.pin.0",
            "net speed motion.current-vel => sampler.0.pin.1",
        ]  # fmt: skip
        for number in range(len(self.letters)):
            command, feedback = f"joint.{number}.motor-pos-cmd", f"joint.{number}.motor-pos-fb"
            lines.append(f"net joint{number} {command} => {feedback} sampler.0.pin.{number + 2}")
        if self.pattern.holds_tip:
            lines.append("net kinematics motion.analog-out-03 => motion.switchkins-type")
        if self.pattern.tool_pin:
            lines.append(f"net tool motion.tooloffset.z => {self.pattern.tool_pin}")
        lines += [f"setp {pin} {value!r}" for pin, value in self.pattern.pins.items()]
        return "\n".join(lines) + "\n"
