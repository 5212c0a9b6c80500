#!/usr/bin/python3
"""The display of a headless LinuxCNC whose joints follow the component `toolpace`, run by /usr/bin/python3.

It homes, connects a sensor of its own with the component, disturbs what that shows, and writes `log.bin` (rows of
doubles: joints, deflection) and `ended.json`.
"""

import json
import math
import os
import random
import sys
import time
from pathlib import Path

import hal
import linuxcnc
from driver import Session

WAITING, ENDED = Path("waiting"), Path("component-may-go")
"""The first holds the number of this process."""
PATIENCE = 60.0
"""Longest wait for the component, to come or to go [s]."""
COMPONENT = "toolpace"
TICK = 1e-3


SURELY = {1.5: ("gone", 0.5), 2.3: ("nan", 0.15), 2.6: ("huge", 0.15)}
"""What the sensor shows in any run, by when it begins, and for how long [s]: what else comes depends on the clock."""


class Sensor:
    """Deflections nobody would wish for: steps, noise, drop-outs, what is no number, what cannot be [mm]."""

    def __init__(self, seed, most):
        self.random, self.most = random.Random(seed), most
        self.pins = hal.component("sensor")
        for name in "xyz":
            self.pins.newpin(name, hal.HAL_FLOAT, hal.HAL_OUT)
        self.pins.newpin("valid", hal.HAL_BIT, hal.HAL_OUT)
        self.pins.ready()
        self.level = [0.0] * 3
        self.until, self.gone, self.broken = 0.0, -1.0, -1.0

    def show(self, now):
        """What is measured at a time [s]."""
        if now >= self.until:
            self.until = now + self.random.uniform(0.1, 0.7)
            self.level = [self.random.uniform(-self.most, self.most) for _ in "xyz"]
            what = self.random.random()
            self.gone = now + self.random.uniform(0.02, 0.3) if what < 0.3 else -1.0
            self.broken = now + 0.02 if what > 0.7 else -1.0
        surely = {what for began, (what, long) in SURELY.items() if began <= now < began + long}
        self.pins["valid"] = now >= self.gone and "gone" not in surely
        for name, level in zip("xyz", self.level):
            value = level + self.random.gauss(0.0, 5e-3)
            if now < self.broken:
                value = self.random.choice([math.nan, math.inf, 1e9])
            elif surely & {"nan", "huge"}:
                value = math.nan if "nan" in surely else 1e9
            self.pins[name] = value


def connect():
    """The sensor, the joints and the streamer with the component."""
    for axis in "xyz":
        hal.connect(f"sensor.{axis}", f"deflection-{axis}")
        hal.connect(f"{COMPONENT}.deflection-{axis}", f"deflection-{axis}")
    hal.connect("sensor.valid", "deflection-valid")
    hal.connect(f"{COMPONENT}.deflection-valid", "deflection-valid")
    hal.connect(f"{COMPONENT}.playing", "playing")
    for j in range(5):
        hal.connect(f"{COMPONENT}.position-{j}", f"joint{j}")


def until(reached, meanwhile=lambda: None):
    """Wait for a state; whether it came."""
    deadline = time.monotonic() + PATIENCE
    while not reached():
        if time.monotonic() > deadline:
            return False
        meanwhile()
        time.sleep(TICK)
    return True


def operate(now, orders):
    """What the operator does at a time: feed overrides and holds."""
    while orders and now >= orders[0][0]:
        _, pin, value = orders.pop(0)
        hal.set_p(f"{COMPONENT}.{pin}", str(value))


def follow(asked, session, out):
    """From enable to the end of the path and a while beyond, then until the component is gone; whether all came."""
    sensor = Sensor(asked["seed"], asked["most"])
    part = Path("waiting.part")
    part.write_text(str(os.getpid()), encoding="ascii")
    part.rename(WAITING)
    if not until(lambda: hal.component_exists(COMPONENT) and hal.component_is_ready(COMPONENT)):
        return "the component did not come"
    connect()
    hal.set_p("sampler.0.enable", "1")
    hal.set_p(f"{COMPONENT}.enable", "1")
    began, orders = time.monotonic(), list(asked["orders"])

    def meanwhile():
        now = time.monotonic() - began
        sensor.show(now)
        operate(now, orders)
        session.drain(out)

    def ended():
        return not hal.component_exists(COMPONENT) or (hal.get_value(f"{COMPONENT}.ended") and not orders)

    if not until(ended, meanwhile) or not hal.component_exists(COMPONENT):
        return "the path did not end"
    ENDED.touch()
    if not until(lambda: not hal.component_exists(COMPONENT), meanwhile):
        return "the component did not go"
    time.sleep(0.1)
    session.drain(out)
    return ""


def main():
    asked = json.loads(Path("follow.json").read_text())
    session = Session(asked["joints"], asked["columns"])
    try:
        session.ready()
        with Path("log.bin").open("wb") as out:
            problem = follow(asked, session, out)
    except RuntimeError as error:
        problem = str(error)
    session.poll()
    ended = {"problem": problem, "messages": session.messages, "lost": session.samples.num_overruns}
    Path("ended.json").write_text(json.dumps(ended))
    session.command.state(linuxcnc.STATE_OFF)
    session.command.wait_complete()
    return 0


if __name__ == "__main__":
    sys.exit(main())
