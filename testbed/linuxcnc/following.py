"""A law followed by the real LinuxCNC: `toolpace follow` beside it, the joints logged each servo cycle.

The machine's joints are "extra joints" of LinuxCNC's motion module (motion(9)): it homes them, enables them and watches
them, and its motor-pos-cmd of each follows what HAL gives it. What HAL gives is what streamer hands out.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from testbed.linuxcnc.instance import LinuxCNCError, beside, execute, folder, last_words
from toolpace.common.arrays import Floats

JOINTS = 5
SHOWN = (*(f"joint{j}" for j in range(JOINTS)), *(f"deflection-{axis}" for axis in "xyz"))
"""Signals that are sampled."""
DEPTH = 30_000
FAR = 1e6
PATIENCE = 60.0
"""Longest wait for LinuxCNC to be ready, and for the component to stop [s]."""


@dataclass(frozen=True)
class Followed:
    """What LinuxCNC commanded, and what the component says that it gave."""

    joints: Floats
    """(n, 5) of the motors, each servo cycle from enable on [mm, deg]."""
    deflection: Floats
    """(n, 3) what the pin showed [mm]."""
    given: np.ndarray
    """The component's record, a row a set-point, with its columns as names."""
    messages: tuple[str, ...]
    """LinuxCNC's own."""


def follow_law(
    law: Path,
    *,
    backlog: str,
    orders: Sequence[tuple[float, str, float]] = (),
    most: float = 0.2,
    seed: int = 1,
    cycle: float = 1e-3,
    seconds: float = 300.0,
) -> Followed:
    """Follow a law in real time while the sensor shows up to `most` [mm] and the operator sets pins (time [s], pin,
    value). Raises LinuxCNCError where LinuxCNC or the component did not do what it should, or takes longer."""
    with folder() as place, ThreadPoolExecutor(1) as aside:
        _write(place, cycle)
        asked = {"joints": JOINTS + 1, "columns": "f" * len(SHOWN), "orders": list(orders), "most": most, "seed": seed}
        (place / "follow.json").write_text(json.dumps(asked), encoding="utf-8")
        running = aside.submit(execute, ["linuxcnc", "-r", "machine.ini"], place, seconds, 1)
        said = _component(place, running, [str(law), "--backlog", backlog])
        printed = running.result()
        try:
            ended = json.loads((place / "ended.json").read_text())
            log = np.fromfile(place / "log.bin", dtype=float).reshape(-1, len(SHOWN))
        except (OSError, ValueError):
            raise LinuxCNCError(f"LinuxCNC did not start: {last_words(printed)}") from None
        if ended["problem"] or ended["lost"]:
            raise LinuxCNCError(f"{ended['problem']}; {ended['lost']} cycles not sampled; the component: {said}")
        given = np.genfromtxt(place / "given.csv", delimiter=",", names=True)
    return Followed(log[:, :JOINTS], log[:, JOINTS:], given, tuple(ended["messages"]))


def _component(place: Path, running: Future[str], arguments: list[str]) -> str:
    """Run the component from when LinuxCNC waits for it to when it may go; what it said."""
    if not _until(lambda: (place / "waiting").exists() or running.done()) or running.done():
        return "was not started"
    command = [sys.executable, "-m", "toolpace", "follow", *arguments, "--record", str(place / "given.csv")]
    command = [*beside(int((place / "waiting").read_text())), *command]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        while process.poll() is None and not (place / "component-may-go").exists() and not running.done():
            time.sleep(0.01)
        process.terminate()
        said, _ = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    return f"{last_words(said)} (exit code {process.returncode})"


def _until(reached: Callable[[], bool]) -> bool:
    deadline = time.monotonic() + PATIENCE
    while not reached():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def _write(place: Path, cycle: float) -> None:
    """Everything that LinuxCNC needs."""
    (place / "machine.ini").write_text(_ini(place, cycle), encoding="utf-8")
    (place / "machine.hal").write_text(_hal(), encoding="utf-8")
    (place / "tool.tbl").write_text("T1 P1 Z0\n", encoding="utf-8")
    for name in ("driver.py", "follow_driver.py"):
        shutil.copy(Path(__file__).with_name(name), place / name).chmod(0o755)


def _ini(place: Path, cycle: float) -> str:
    lines = [
        "[EMC]", "VERSION = 1.1", "MACHINE = toolpace", "DEBUG = 0",
        "[DISPLAY]", f"DISPLAY = {place / 'follow_driver.py'}",
        "[TASK]", "TASK = milltask", "CYCLE_TIME = 0.01",
        "[RS274NGC]", "PARAMETER_FILE = parameters.var",
        "[EMCMOT]", "EMCMOT = motmod", "COMM_TIMEOUT = 1.0", f"SERVO_PERIOD = {round(cycle * 1e9)}",
        "[EMCIO]", "EMCIO = io", "CYCLE_TIME = 0.020", "TOOL_TABLE = tool.tbl",
        "[HAL]", "HALFILE = machine.hal",
        "[KINS]", "KINEMATICS = trivkins coordinates=X kinstype=B", f"JOINTS = {1 + JOINTS}",
        "[TRAJ]", "COORDINATES = X", "LINEAR_UNITS = mm", "ANGULAR_UNITS = degree", "NO_FORCE_HOMING = 1",
        "DEFAULT_LINEAR_VELOCITY = 1", "MAX_LINEAR_VELOCITY = 1", "MAX_LINEAR_ACCELERATION = 1",
        "[AXIS_X]", f"MIN_LIMIT = {-FAR}", f"MAX_LIMIT = {FAR}", "MAX_VELOCITY = 1", "MAX_ACCELERATION = 1",
    ]  # fmt: skip
    for number in range(1 + JOINTS):
        lines += [
            f"[JOINT_{number}]", "TYPE = LINEAR", f"MIN_LIMIT = {-FAR}", f"MAX_LIMIT = {FAR}", "MAX_VELOCITY = 1",
            "MAX_ACCELERATION = 1", "HOME = 0", "HOME_SEARCH_VEL = 0", "HOME_LATCH_VEL = 0", "HOME_SEQUENCE = 0",
            "FERROR = 1", "MIN_FERROR = 1",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _hal() -> str:
    lines = [
        "loadrt [KINS]KINEMATICS",
        "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS"
        f" num_extrajoints={JOINTS}",
        f"loadrt streamer depth=1000 cfg={'f' * JOINTS}", f"loadrt sampler depth={DEPTH} cfg={'f' * len(SHOWN)}",
        "setp sampler.0.enable 0",
        *(f"addf {name} servo-thread" for name in
          ("motion-command-handler", "streamer.0", "motion-controller", "sampler.0")),
        "net on iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
        "net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared",
        "net change iocontrol.0.tool-change => iocontrol.0.tool-changed",
        "net kinematic joint.0.motor-pos-cmd => joint.0.motor-pos-fb",
        "newsig deflection-valid bit", "newsig playing bit", "net playing => streamer.0.enable",
        *(f"newsig deflection-{axis} float" for axis in "xyz"),
    ]  # fmt: skip
    for j in range(JOINTS):
        lines.append(f"net row{j} streamer.0.pin.{j} => joint.{j + 1}.posthome-cmd")
        lines.append(f"net joint{j} joint.{j + 1}.motor-pos-cmd => joint.{j + 1}.motor-pos-fb")
    lines += [f"net {signal} => sampler.0.pin.{number}" for number, signal in enumerate(SHOWN)]
    return "\n".join(lines) + "\n"
