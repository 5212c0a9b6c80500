#!/usr/bin/python3
"""The display of a headless LinuxCNC, run by /usr/bin/python3: power, home, run the program, log each servo cycle.

It reads `sampled.json`, loads the HAL files `more_*.hal` in the order of their names, as a GUI does those of
POSTGUI_HALFILE, runs `program.ngc`, and writes `log.bin` (rows of doubles: line, path velocity, joints) and
`ended.json`. LinuxCNC's modules `linuxcnc` and `hal` belong to the system's Python; nothing else is imported.
"""

import array
import json
import subprocess
import sys
import time
from pathlib import Path

import hal
import linuxcnc

PATIENCE = 30.0
"""Longest wait for LinuxCNC to do what takes it no motion [s]."""


class Session:
    """LinuxCNC's channels, the messages that it sent, and the queue of samples."""

    def __init__(self, joints, columns):
        self.joints = joints
        self.command, self.state, self.errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
        self.component = hal.component("toolpace-log")
        self.samples = hal.stream(self.component, hal.sampler_base, columns)
        self.component.ready()
        self.messages = []
        self.rows = 0

    def poll(self):
        """State and messages; whether one of them is an error."""
        self.state.poll()
        failed = False
        message = self.errors.poll()
        while message:
            self.messages.append(message[1].strip())
            failed = failed or message[0] in (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR)
            message = self.errors.poll()
        return failed

    def until(self, reached, what):
        """Wait for a state."""
        began = time.monotonic()
        while not reached():
            if time.monotonic() - began > PATIENCE:
                raise RuntimeError(f"LinuxCNC did not get to: {what}")
            time.sleep(0.01)
            self.poll()

    def ready(self):
        """Power on, joints homed, automatic mode."""
        self.command.state(linuxcnc.STATE_ESTOP_RESET)
        self.until(lambda: self.state.task_state != linuxcnc.STATE_ESTOP, "emergency stop reset")
        load_hal_files()  # the task answers by now, and its pins are there
        self.command.state(linuxcnc.STATE_ON)
        self.until(lambda: self.state.task_state == linuxcnc.STATE_ON, "machine on")
        self.command.home(-1)
        self.until(lambda: all(self.state.homed[: self.joints]), "joints homed")
        # what its canon begins with, which is lost where the power comes on before its first cycles are through
        self.command.mode(linuxcnc.MODE_MDI)
        self.command.wait_complete()
        self.command.mdi("G21 G64 P0.0254")
        self.command.wait_complete()
        self.command.mode(linuxcnc.MODE_AUTO)
        self.command.wait_complete()
        self.until(lambda: self.state.task_mode == linuxcnc.MODE_AUTO, "automatic mode")

    def run(self, program, out):
        """Run a program to where the interpreter rests; whether an error was reported."""
        self.command.program_open(program)
        self.command.wait_complete()
        hal.set_p("sampler.0.enable", "1")
        time.sleep(0.05)
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.until(lambda: self.state.interp_state != linuxcnc.INTERP_IDLE, "the program's start")
        failed = idle = False
        while not failed:
            self.drain(out)
            failed = self.poll()
            # twice in a row: while the queue is handed on, one look may find everything at rest
            resting = self.state.interp_state == linuxcnc.INTERP_IDLE and self.state.inpos and not self.state.queue
            if resting and idle:
                break
            idle = resting
            time.sleep(0.01)
        time.sleep(0.1)
        self.drain(out)
        hal.set_p("sampler.0.enable", "0")
        return failed

    def drain(self, out):
        """Write what the servo thread has sampled."""
        block = array.array("d")
        while self.samples.readable:
            block.extend(self.samples.read())
            self.rows += 1
        block.tofile(out)


def load_hal_files():
    """Of the folder; what HAL says of one that it does not take is an error."""
    for file in sorted(Path().glob("more_*.hal")):
        done = subprocess.run(["halcmd", "-i", "machine.ini", "-f", file.name], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{file.name}: {done.stdout.strip()} {done.stderr.strip()}")


def main():
    session = Session(**json.loads(Path("sampled.json").read_text()))
    problem = ""
    try:
        session.ready()
        with Path("log.bin").open("wb") as out:
            failed = session.run(str(Path("program.ngc").resolve()), out)
    except RuntimeError as error:
        problem, failed = str(error), True
    ended = {
        "failed": failed, "problem": problem, "messages": session.messages, "rows": session.rows,
        "line": session.state.motion_line, "to_the_end": bool(hal.get_value("motion.digital-out-00")),
        "lost": session.samples.num_overruns,
    }  # fmt: skip
    Path("ended.json").write_text(json.dumps(ended))
    session.command.abort()
    session.command.state(linuxcnc.STATE_OFF)
    session.command.wait_complete()
    return 0


if __name__ == "__main__":
    sys.exit(main())
