"""A machine as text: its file as a person would write it, and tables of its joints and of poses, in mm and degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import printable
from toolpace.common.files.toml import toml_value
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine import kinematics
from toolpace.machine.curves_file import corners_text, curve_text, figures_of
from toolpace.machine.file import ANGLES, GRAVITY, LENGTHS, JointFile, MachineFile, WorkpieceFile
from toolpace.machine.geometry import Geometry
from toolpace.machine.limits import MOTORS

LENGTH_ORDER, ANGLE_ORDER = ("mm", "in", "m"), ("deg", "rad")
"""Units to write in: of those in which the figures are equally short, the first."""
COLUMN, WIDEST = 30, 48
"""At which column comments begin, unless a line before it is longer, and to which they move for the sake of those."""
PLAIN = (1e-6, 1e12)
"""Between which figures are written without an exponent."""
TURN_PER_MINUTE = {"deg": 1.0 / 6.0, "rad": 30.0 / math.pi}
"""Of a rotary joint's velocity, by its unit."""

Line = tuple[str, str]
"""What is written, and what explains it."""
STEP = 0.1
"""How far a linear joint goes in a pose [m]."""
TURNS = (30 * DEGREE, 90 * DEGREE)
"""How far a rotary joint turns in a pose [rad]; the other way where travel does not reach."""
LESS = (1.0, 0.5, 0.2)
"""Of that step for each linear joint where all move: no two alike, so that none is taken for another."""


def machine_text(file: MachineFile, leanings: Mapping[str, str]) -> str:
    """The text that loads to exactly `file`; `leanings` says what each rotary joint does to the tool axis.

    Units are those in which all figures are exact and shortest; metres and radians always are exact.
    """
    length, angle = units_of(file)
    order = [*file.chain.workpiece, *file.chain.tool]
    lines: list[Line] = [(f"name = {toml_value(file.name)}", "what the machine is called")]
    if file.note:
        lines.append((f"note = {toml_value(file.note)}", "what it is, in a line"))
    if order != list(file.joints):
        lines.append((f"columns = {listed(file.joints)}", "order in which positions are listed"))
    lines += [("", ""), ("[units]", "of this file only; seconds throughout")]
    lines.append((f'length = "{length}"', "mm, in or m"))
    lines.append((f'angle = "{angle}"', "deg or rad"))
    lines += [("", ""), ("[chain]", "points and directions: in the frame of the bed, every joint at zero")]
    lines += _chain(file, LENGTHS[length])
    for name in order:
        lines += [("", ""), *_joint(file, name, length, angle, leanings.get(name, ""))]
    if file.workpiece is not None:
        lines += [("", ""), ("[workpiece]", f"the part with its fixture, on {['the bed', *file.chain.workpiece][-1]}")]
        lines += _body(file.workpiece, LENGTHS[length])
    return "".join(_laid_out(lines))


def units_of(file: MachineFile) -> tuple[str, str]:
    """The units of length and angle in which the figures of a machine are exact and shortest."""
    chain, joints = file.chain, list(file.joints.values())
    points = [*chain.spindle_nose, *chain.workpiece_origin, chain.tool_length]
    points += file.workpiece.centre if file.workpiece is not None else ()
    lengths = points + [figure for joint in joints for figure in (*joint.point, *joint.centre)]
    lengths += [figure for joint in joints if joint.kind == "linear" for figure in _motion(joint)]
    angles = [figure for joint in joints if joint.kind == "rotary" for figure in _motion(joint)]
    return _shortest(lengths, LENGTH_ORDER, LENGTHS), _shortest(angles, ANGLE_ORDER, ANGLES)


def _motion(joint: JointFile) -> tuple[float, ...]:
    motor = () if joint.motor is None else joint.motor.speed.tolist()
    return (
        *(joint.travel or ()), joint.velocity, joint.acceleration, joint.jerk, *figures_of(joint.curves), *motor
    )  # fmt: skip


def _shortest(figures: list[float], order: tuple[str, ...], scales: dict[str, float]) -> str:
    """The unit in which all figures are exact, with the least digits on the whole."""
    digits: dict[str, int] = {}
    for unit in order:
        texts = [_exact(figure, scales[unit]) for figure in figures]
        if None not in texts:
            digits[unit] = sum(_digits(text) for text in texts if text)
    return min(digits, key=lambda unit: digits[unit])


def _digits(text: str) -> int:
    figure = Decimal(text)
    return len(figure.normalize().as_tuple().digits) if figure.is_finite() else 0


def _exact(value: float, scale: float) -> str | None:
    """The shortest decimal that times `scale` is just this value, or None where none is."""
    if value == 0.0:
        return "0"
    if math.isinf(value) or scale == 1.0:
        return _plain(repr(float(value)))
    about = float(value) / scale
    for digits in range(1, 16):
        text = f"{about:.{digits}g}"
        if float(text) * scale == value:
            return _plain(text)
    for near in (about, math.nextafter(about, math.inf), math.nextafter(about, -math.inf)):
        if near * scale == value:
            return _plain(repr(near))
    return None


def _plain(text: str) -> str:
    """A number without a needless exponent, point or zero."""
    figure = Decimal(text)
    if not figure.is_finite() or not PLAIN[0] <= abs(figure) < PLAIN[1]:
        return repr(float(text))
    return f"{figure:f}".rstrip("0").rstrip(".") if "." in f"{figure:f}" else f"{figure:f}"


def _figure(value: float, scale: float = 1.0) -> str:
    """A figure in units in which all of the machine are exact."""
    text = _exact(value, scale)
    assert text is not None
    return text


def _figures(values: tuple[float, ...], scale: float = 1.0) -> str:
    return "[" + ", ".join(_figure(value, scale) for value in values) + "]"


def _chain(file: MachineFile, scale: float) -> Iterator[Line]:
    chain = file.chain
    yield f"workpiece = {listed(chain.workpiece)}", "joints that carry the workpiece, from the bed to it"
    yield f"workpiece_origin = {_figures(chain.workpiece_origin, scale)}", "zero of the program"
    if chain.workpiece_x != (1.0, 0.0, 0.0):
        yield f"workpiece_x = {_figures(chain.workpiece_x)}", "direction of the program's X"
    if chain.workpiece_z != (0.0, 0.0, 1.0):
        yield f"workpiece_z = {_figures(chain.workpiece_z)}", "direction of the program's Z"
    yield f"tool = {listed(chain.tool)}", "joints that carry the tool, from the bed to it"
    yield f"spindle_nose = {_figures(chain.spindle_nose, scale)}", "where the tool is held"
    if chain.tool_axis != (0.0, 0.0, 1.0):
        yield f"tool_axis = {_figures(chain.tool_axis)}", "from the tip to the spindle"
    yield f"tool_length = {_figure(chain.tool_length, scale)}", "from the nose to the tip"
    if chain.gravity != GRAVITY:
        yield f"gravity = {_figures(chain.gravity)}", "m/s^2"


def _joint(file: MachineFile, name: str, length: str, angle: str, leaning: str) -> Iterator[Line]:
    joint, rotary = file.joints[name], file.joints[name].kind == "rotary"
    unit, scale = (angle, ANGLES[angle]) if rotary else (length, LENGTHS[length])
    side = "workpiece" if name in file.chain.workpiece else "tool"
    key = name if name.isidentifier() and name.isascii() else toml_value(name)
    yield f"[joints.{key}]", _carried(file, name)
    yield f'kind = "{joint.kind}"', f"{'turns' if rotary else 'moves'} the {side}"
    if rotary:
        yield f"direction = {_figures(joint.direction)}", f"its axis; seen from the workpiece {leaning}"
    else:
        yield f"direction = {_figures(joint.direction)}", f"where positive {name} moves the {side}"
    if rotary or joint.point != (0.0, 0.0, 0.0):
        yield f"point = {_figures(joint.point, LENGTHS[length])}", "a point on its axis"
    if joint.travel is None:
        yield "wrap = true", "turns without end"
    else:
        yield f"travel = {_figures(joint.travel, scale)}", f"{unit}, lowest and highest position"
    yield f"velocity = {_figure(joint.velocity, scale)}", f"{unit}/s{_a_minute(joint.velocity / scale, unit)}"
    texts = {each.kind: curve_text(each, lambda value: _figure(value, scale)) for each in joint.curves}
    for kind, power in (("acceleration", 2), ("jerk", 3)):
        figure, over = texts.get(kind, _figure(getattr(joint, kind), scale)), f" over {unit}/s" if kind in texts else ""
        yield f"{kind} = {figure}", f"{unit}/s^{power}{over}"
    per = "N m" if rotary else "N"
    limit = joint.torque if rotary else joint.force
    if joint.motor_curve is not None:
        text = corners_text(joint.motor_curve, lambda speed: _figure(speed, scale), _figure)
        yield f"{MOTORS[rotary]} = {text}", f"{per} over {unit}/s, of the motor at the joint"
    elif limit is not None:
        yield f"{MOTORS[rotary]} = {_figure(limit)}", f"{per}, of the motor at the joint"
    if joint.continuous is not None:
        yield f"{MOTORS[rotary]}_continuous = {_figure(joint.continuous)}", f"{per}, root mean square over the window"
        if math.isfinite(joint.thermal_window):
            yield f"thermal_window = {_figure(joint.thermal_window)}", "s"
    yield from _body(joint, LENGTHS[length])
    for value, what, comment in (
        (joint.rotor_inertia, "rotor_inertia", f"{'kg m^2' if rotary else 'kg'}, of motor and gear at the joint"),
        (joint.viscous_friction, "viscous_friction", f"{per} {'s/rad' if rotary else 's/m'}"),
        (joint.dry_friction, "dry_friction", per),
        (joint.balance, "balance", f"{per}, forwards, by a counterweight"),
    ):
        if value:
            yield f"{what} = {_figure(value)}", comment


def _body(body: JointFile | WorkpieceFile, scale: float) -> Iterator[Line]:
    """Mass, centre and inertia, where there are any."""
    if body.mass or isinstance(body, WorkpieceFile):
        yield f"mass = {_figure(body.mass)}", "kg"
    if body.centre != (0.0, 0.0, 0.0):
        yield f"centre = {_figures(body.centre, scale)}", "of the mass, every joint at zero"
    if any(body.inertia):
        yield f"inertia = {_figures(body.inertia)}", f"kg m^2 about it, xx yy zz{' xy xz yz' * (len(body.inertia) > 3)}"


def _carried(file: MachineFile, name: str) -> str:
    """What a joint sits on, and what it carries."""
    for order, end in ((file.chain.workpiece, "workpiece"), (file.chain.tool, "tool")):
        if name in order:
            at = order.index(name)
            below = "the bed" if at == 0 else order[at - 1]
            above = f"the {end}" if at + 1 == len(order) else order[at + 1]
            return f"sits on {below} and carries {above}"
    return ""


def _a_minute(velocity: float, unit: str) -> str:
    """The same velocity as it stands in a maker's data sheet."""
    if not math.isfinite(velocity):
        return ""
    if unit in TURN_PER_MINUTE:
        return f", {velocity * TURN_PER_MINUTE[unit]:.4g} rpm"
    return f", {60.0 * velocity:.4g} in/min" if unit == "in" else f", {60.0 * velocity * LENGTHS[unit]:.4g} m/min"


def _laid_out(lines: list[Line]) -> Iterator[str]:
    """The lines with their comments one below the other."""
    widest = max((len(text) for text, _ in lines if len(text) < WIDEST), default=0)
    column = max(COLUMN, widest + 2)
    for text, comment in lines:
        yield (f"{text:<{column - 2}}  # {printable(comment)}" if comment else text) + "\n"


def listed(names: Iterable[str]) -> str:
    """A TOML array of strings."""
    return toml_value(list(names))


def rows(file: MachineFile, kind: str) -> list[dict[str, str]]:
    """One row a joint of a machine of some class: machine, class, joint, kind, carries, travel, limits; force or torque
    where its motor has a limit."""
    table = []
    for name, joint in file.joints.items():
        unit, scale = ("deg", 180.0 / math.pi) if joint.kind == "rotary" else ("mm", 1e3)
        low, high = joint.travel or (-math.inf, math.inf)
        table.append(
            {
                "machine": file.name,
                "class": kind,
                "joint": name,
                "kind": joint.kind,
                "carries": "workpiece" if name in file.chain.workpiece else "tool",
                "travel": "endless" if joint.wrap else f"{low * scale:g} .. {high * scale:g} {unit}",
                "velocity": f"{joint.velocity * scale:g} {unit}/s",
                "acceleration": f"{_range(joint, 'acceleration', scale)} {unit}/s^2",
                "jerk": f"{_range(joint, 'jerk', scale)} {unit}/s^3",
            }
        )
        if joint.motor is not None:
            turns, falls = joint.kind == "rotary", joint.motor.least < joint.motor.largest
            largest = f"{joint.motor.largest:g} .. " if falls else ""
            table[-1][MOTORS[turns]] = f"{largest}{joint.motor.least:g} {('N', 'N m')[turns]}"
    return table


def _range(joint: JointFile, kind: str, scale: float) -> str:
    """The limit of a joint, or the largest and the least of its curve."""
    largest = [f"{curve.largest * scale:g} .. " for curve in joint.curves if curve.kind == kind]
    return f"{''.join(largest)}{getattr(joint, kind) * scale:g}"


def title(file: MachineFile, kind: str) -> str:
    """Name, class and the chain from the workpiece over the bed to the tool."""
    chain = file.chain
    inward = " < ".join(["workpiece", *reversed(chain.workpiece), "bed"])
    outward = " > ".join(["", *chain.tool, "tool"])
    tool = f"tool length {chain.tool_length * 1e3:g} mm"
    return f"{file.name}: {kind}, {inward}{outward}, {tool}"


def poses(geometry: Geometry) -> Floats:
    """(n, m) joint positions [m or rad], all within travel.

    Every joint at zero (or as near as its travel lets it), each linear joint alone by 100 mm, each rotary joint alone
    at 30 and 90 degrees, and with the linear joints moved aside; both rotary joints, and all joints together.
    """
    zero = np.clip(0.0, geometry.travel[:, 0], geometry.travel[:, 1])
    turns = {int(joint): _positions(geometry, int(joint), TURNS) for joint in sorted(geometry.rotary)}
    steps = {int(joint): _positions(geometry, int(joint), (STEP,)) for joint in sorted(geometry.linear)}
    aside = {joint: share * there[0] for share, (joint, there) in zip(LESS, steps.items())}
    moves: list[dict[int, float]] = [{}]
    moves += [{joint: position} for each in (steps, turns) for joint, there in each.items() for position in there]
    moves += [{joint: there[0]} | aside for joint, there in turns.items()]
    one, other = turns
    pairs = [(turns[one][0], turns[other][0]), (turns[one][-1], turns[other][0]), (turns[one][0], turns[other][-1])]
    moves += [{one: first, other: second} for first, second in pairs]
    moves.append(moves[-1] | aside)
    q = np.tile(zero, (len(moves), 1))
    for row, move in zip(q, moves):
        for joint, position in move.items():
            row[joint] = position
    inside = np.clip(q, geometry.travel[:, 0], geometry.travel[:, 1])
    return np.array(list(dict.fromkeys(map(tuple, inside.tolist()))))


def _positions(geometry: Geometry, joint: int, wanted: tuple[float, ...]) -> list[float]:
    """What a joint reaches of the positions, forwards or else backwards; else the farther end of its travel.

    They count from zero, or from the end of a travel that zero lies outside of.
    """
    low, high = (float(end) for end in geometry.travel[joint])
    start = min(max(0.0, low), high)
    for way in (1.0, -1.0):
        reached = [start + way * position for position in wanted if low <= start + way * position <= high]
        if reached:
            return reached
    return [low if start - low > high - start else high]


def pose_table(geometry: Geometry) -> str:
    """The poses with their tips and tool axes in the part's frame, in mm and deg, as aligned columns of text.

    Ahead of them stands where each rotary joint leans the tool axis.
    """
    q = poses(geometry)
    tip, axis = kinematics.forward(geometry, q)
    scale = np.where(geometry.is_rotary, DEGREE, MILLIMETRE)
    units = ["deg" if rotary else "mm" for rotary in geometry.is_rotary]
    columns = [[printable(name), unit] for name, unit in zip(geometry.joints, units)]
    columns += [[f"tip {name}", "mm"] for name in "xyz"] + [[f"axis {name}", ""] for name in "xyz"]
    for joints, point, direction in zip(q / scale, tip / MILLIMETRE, axis):
        cells = [*(_short(figure) for figure in joints), *(_fixed(figure, 3) for figure in point)]
        for column, cell in zip(columns, [*cells, *(_fixed(figure, 5) for figure in direction)]):
            column.append(cell)
    return "\n".join([*reversed(geometry.leanings), "", *_aligned(columns)]) + "\n"


def _short(figure: float) -> str:
    """Three decimals at most."""
    return f"{round(figure, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _fixed(figure: float, decimals: int) -> str:
    """As many decimals in each row, and no minus before zero."""
    return f"{round(figure, decimals) + 0.0:.{decimals}f}"


def _aligned(columns: list[list[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in columns]
    for row in zip(*columns):
        yield "  ".join(cell.rjust(width) for cell, width in zip(row, widths)).rstrip()
