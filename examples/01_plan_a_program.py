"""From a program to a verified motion and a report, in seven lines."""

from __future__ import annotations

import tempfile
from pathlib import Path

import toolpace as tp
from toolpace import demo


def main(folder: Path) -> tp.Trajectory:
    program = folder / "blade.ngc"
    program.write_text(demo.spiral_program(300))  # any program of yours

    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read(program, machine)
    path = tp.Path.fit(toolpath, tip_tolerance=10e-6, axis_tolerance=8e-4, machine=machine)
    trajectory = tp.plan(path, machine)

    tp.verify(trajectory, machine, toolpath, tip_tolerance=10e-6, axis_tolerance=8e-4).raise_if_failed()
    trajectory.save(folder / "setpoints.npz")
    tp.report(trajectory, folder / "report.html", toolpath)

    print(f"{len(toolpath)} points in {trajectory.duration:.3f} s, limited by {trajectory.limited_by()}")
    return trajectory


if __name__ == "__main__":
    main(Path(tempfile.mkdtemp()))
