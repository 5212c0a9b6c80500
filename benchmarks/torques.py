"""Arms whose motors limit torque, with weight, beside toppra and COPP: duration, and CPU time a point.

python -m benchmarks.torques        writes benchmarks/results/torques.md; needs pinocchio (pip install pin)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import copp_py as copp
import numpy as np
import pinocchio as pin
from toppra.algorithm import TOPPRA
from toppra.constraint import JointTorqueConstraint, JointVelocityConstraint

from benchmarks.machine import RESULTS, written_by
from benchmarks.peers import Stopwatch
from benchmarks.peers.copp import PASSES, SETTLED
from benchmarks.peers.toppra import RunPath
from benchmarks.tables import Table
from testbed import jets
from toolpace.common.arrays import Floats
from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.dynamics.torques import torque_rows
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.planner import plan

JOINTS = (2, 3, 6, 7)
POINTS = 1000
VELOCITY, JERK = 3.0, 400.0
Single = Callable[[Floats, Floats, Floats], Floats]


def arm(joints: int) -> Dynamics:
    """Rods of 0.3 m in a row, the first upright, joints across them and along them in turn."""
    links = []
    for k in range(joints):
        mass, reach = 8.0 / (1 + k), 0.3 * k
        across = mass * 0.3**2 / 12.0
        direction = (0.0, 0.0, 1.0) if k == 0 else (0.0, 1.0, 0.0) if k % 2 else (1.0, 0.0, 0.0)
        place, centre = (reach, 0.0, 0.0), (reach + 0.15, 0.0, 0.02)
        inertia = 0.02 * across, across, across
        links.append(Link("rotary", direction, place, mass, centre, inertia, rotor_inertia=0.05))
    return Dynamics(tuple(links))


def by_pinocchio(dynamics: Dynamics) -> Single:
    """Its torques at one motion, (joints,) each: what a peer asks for point by point."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array(dynamics.gravity), np.zeros(3))
    below, last = np.zeros(3), 0
    for k, link in enumerate(dynamics.links):
        joint = pin.JointModelRevoluteUnaligned(np.array(link.direction))
        last = model.addJoint(last, joint, pin.SE3(np.eye(3), np.array(link.point) - below), f"q{k}")
        below = np.array(link.point)
        body = pin.Inertia(link.mass, np.array(link.centre) - below, link.tensor)
        model.appendBodyToJoint(last, body, pin.SE3.Identity())
    data = model.createData()
    model.armature = np.array([link.rotor_inertia for link in dynamics.links])
    return lambda q, qd, qdd: pin.rnea(model, data, q, qd, qdd)


def problem(joints: int) -> tuple[AxisPath, Limits, Dynamics, Floats]:
    """A random path, and torques of twice the weight at least."""
    path = AxisPath.from_callable(jets.Remembered(jets.harmonics(np.random.default_rng(joints), joints, 4)))
    run, dynamics = path.runs[0], arm(joints)
    q = run.evaluate(np.linspace(run.s0, run.s1, POINTS))
    weight = np.abs(dynamics.along(q).constant).max(axis=0)
    most = 1.3 * weight + 0.15 * weight.max()
    return path, Limits(VELOCITY, np.inf, np.inf, path.joints), dynamics, most


def by_toppra(path: AxisPath, torque: Single, most: Floats) -> tuple[float, float]:
    """Duration and CPU time [s]."""
    watch, run = Stopwatch(), path.runs[0]
    grid = np.linspace(run.s0, run.s1, POINTS)
    none = np.zeros(len(most))
    constraints = [
        JointVelocityConstraint(np.full(len(most), VELOCITY)),
        JointTorqueConstraint(torque, np.stack([-most, most], axis=1), none),
    ]
    found = TOPPRA(constraints, RunPath(run, len(most)), gridpoints=grid, solver_wrapper="seidel")
    _, speed, _ = found.compute_parameterization(0.0, 0.0)
    return float((2.0 * np.diff(grid) / (speed[1:] + speed[:-1])).sum()), watch()


def by_copp(path: AxisPath, torque: Single, most: Floats, jerk: float = np.inf) -> tuple[float, float]:
    """The same by its reachability analysis, or with a jerk limit its conic program, until the time settles."""
    watch, run = Stopwatch(), path.runs[0]
    s, count = np.linspace(run.s0, run.s1, POINTS), len(most)
    q = [np.ascontiguousarray(value) for value in run.evaluate(s)]
    robot = copp.Robot(count, capacity=POINTS)
    robot.append_s(s)
    robot.set_q(q[0], q[1], q[2], 0, dddq=q[3])
    robot.set_inverse_dynamics(torque)
    velocity = np.full(count, VELOCITY)
    robot.add_velocity_limits(velocity, -velocity, start_idx_s=0, length=POINTS)
    robot.add_torque_limits(most, -most, start_idx_s=0, length=POINTS)
    first = copp.solver.topp2_ra.solve(copp.solver.topp2_ra.Problem(robot.constraints, (0, POINTS - 1), (0.0, 0.0)))
    if not np.isfinite(jerk):
        speed = np.sqrt(first)
        return float((2.0 * np.diff(s) / (speed[1:] + speed[:-1])).sum()), watch()
    limit = np.full(count, jerk)
    robot.add_jerk_limits(limit, -limit, start_idx_s=0, length=POINTS)
    robot.constraints.amax_substitute(first, 0)
    profile, duration = None, np.inf
    for _ in range(PASSES):
        about, slope = (first, None) if profile is None else (profile.a, profile.b)
        asked = copp.solver.topp3_socp.Problem(robot.constraints, about, num_stationary_max=1, b_linearization=slope)
        found = copp.solver.topp3_socp.solve(asked)
        found.force_positive_a(s)
        total = float(copp.interpolation.s_to_t_topp3(s, found)[0])
        settled = abs(duration - total) < SETTLED * total
        if total < duration:
            profile, duration = found, total
        if settled:
            break
    return duration, watch()


def ours(path: AxisPath, limits: Limits, dynamics: Dynamics, most: Floats, jerk: float) -> tuple[float, float, float]:
    """Duration, CPU time [s], and the largest torque over its limit at ten thousand times."""
    held = replace(limits, jerk=np.full(len(most), jerk), rows=torque_rows(dynamics, most, limits.joints))
    watch = Stopwatch()
    trajectory = plan(path, held, mesh=POINTS - 1, bound=False)
    seconds = watch()
    moment = trajectory.at(np.linspace(0.0, trajectory.duration, 10_000))
    return trajectory.duration, seconds, float((np.abs(dynamics(moment.q, moment.qd, moment.qdd)) / most).max())


def main() -> None:
    """The table, on the terminal and in benchmarks/results."""
    heads = ["joints", "toppra [s]", "COPP [s]", "COPP, jerk [s]", "ours, jerk [s]", "ours: largest torque"]
    heads += [f"{name} [us]" for name in ("toppra", "COPP", "COPP, jerk", "ours, jerk")]
    table = Table(f"{POINTS} points", heads)
    for joints in JOINTS:
        path, limits, dynamics, most = problem(joints)
        torque = by_pinocchio(dynamics)
        ours(path, limits, dynamics, most, JERK)  # compiles the kernels, loads the libraries
        free, copp_free, copp_jerk = by_toppra(path, torque, most), by_copp(path, torque, most), (np.nan, np.nan)
        try:
            copp_jerk = by_copp(path, torque, most, JERK)
        except Exception as error:  # whatever a peer raises is its result
            print(f"{joints} joints, COPP: {error}")
        mine = ours(path, limits, dynamics, most, JERK)
        durations = [free[0], copp_free[0], copp_jerk[0], mine[0]]
        times = [1e6 * each / POINTS for each in (free[1], copp_free[1], copp_jerk[1], mine[1])]
        row = [str(joints), *(f"{value:.4f}" for value in durations), f"{mine[2]:.6f}"]
        table.lines.append([*row, *(f"{value:.0f}" for value in times)])
    table.show()
    head = (
        "# Torques beside toppra and COPP\n\n"
        f"{written_by('python -m benchmarks.torques')}\n"
        f"Arms of rods with weight, velocities below {VELOCITY:g} rad/s, on random paths. toppra and the first\n"
        f"of COPP know no jerk; the others keep it below {JERK:g} rad/s3. Peers ask pinocchio point by point;\n"
        "ours has masses. COPP holds its limits at the points, ours between them too. CPU times of one plan, a\n"
        "point of the mesh; compare ratios, not microseconds: the machine was not idle.\n\n"
    )
    (RESULTS / "torques.md").write_text(head + table.markdown())


if __name__ == "__main__":
    main()
