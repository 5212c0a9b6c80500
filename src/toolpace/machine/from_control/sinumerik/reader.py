"""A record from machine data and swivel data of a Sinumerik."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.from_control.control_file import ControlFile, ControlFileError, machine_name
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.sinumerik.channel_axes import ChannelAxis, channel_axes, is_spindle, straight_axes
from toolpace.machine.from_control.sinumerik.dynamics import add_dynamics, joint_figures
from toolpace.machine.from_control.sinumerik.five_axis import (
    BY_CARRIER,
    OTHERS,
    Transformation,
    carrier_number,
    carrier_numbers,
    chain_of_carrier,
    chain_of_transformation,
    sets_by_hand,
    transformation,
)
from toolpace.machine.from_control.sinumerik.kinematic_chain import kinematic_transformation
from toolpace.machine.from_control.sinumerik.machine_data import MachineData, has_data
from toolpace.machine.from_control.sinumerik.vector_chain import ON_TABLE, VectorChain
from toolpace.machine.from_control.stand_ins import Answers, Question
from toolpace.machine.from_control.unplaced_axes import ALONG, TURNING, Unplaced, place_axes

CONTROL = "Sinumerik"
TOLD_BY = "machine data as text ($MN_..., $MC_..., $MA_...), swivel data ($TC_CARR...), kinematic chains ($NK_...)"
IN_MM = {"mm": 1.0, "in": 25.4}
OWN_UNITS = 8
"""Bits of MD10220 that give lengths, angles and their derivatives other units than those of the manuals."""
SHOWN = 8
"""Most names of axes in a remark."""
SAME = 1e-3
"""Within which vectors of two sources agree [mm]."""


def recognises(file: ControlFile) -> bool:
    """Whether a text assigns machine data or swivel data."""
    return has_data(file)


def read(files: Sequence[ControlFile], answers: Answers) -> MachineRecord:
    """The machine of one channel. Raises ControlFileError."""
    data = MachineData.of(files)
    remarks = _choose_channel(data)
    length = _length(data, answers)
    record = MachineRecord(
        CONTROL, machine_name(files[0], CONTROL), tuple(file.name for file in files), length,
        Figure("deg", (Origin("Sinumerik counts turns in degrees"),)), remarks=remarks,
    )  # fmt: skip
    axes = channel_axes(data, answers)
    if not axes:
        raise ControlFileError("has no axis; give general, channel and axis data", file=files[0].name)
    chain, inputs = _chain_and_inputs(data, axes, answers, record)
    straight = straight_axes(data, axes, inputs)
    joints = dict(zip("XYZ", straight)) | _turning(data, axes, chain)
    for letter, axis in joints.items():
        kind = _kind(data, letter, axis)
        record.joints[letter] = joint_figures(data, axis, kind, str(length.value))
        if letter in "XYZ":
            record.joints[letter]["direction"] = Figure(ALONG[letter], (Origin(f"axis {axis.name}"),))
            record.machine_zero[letter] = Figure(0.0, (Origin("the display shows positions of the joints"),))
        if axis.name != letter:
            record.remarks.append(f"{letter} is the axis {axis.name} of the control ({axis.origin}).")
    if chain is not None:
        _check_open(chain, record, IN_MM[str(length.value)])
        chain.place(record)
    else:
        at = Unplaced(record, answers, "$MC_TRAFO_TYPE_1", Origin("$MC_TRAFO_TYPE_1", files[0].name), "the channel")
        place_axes(at, "".join(joints))
    _add_remarks(data, axes, joints, chain, record)
    add_dynamics(data, record, joints)
    return record


def _choose_channel(data: MachineData) -> list[str]:
    """Take the first channel with a transformation that turns a tool, else the first; remarks on the others."""
    channels = data.channels
    data.channel = channels[0]
    if channels == [0]:
        return []
    types = [(key[3], found[0].number()) for key, found in data.data.items() if key[0].startswith("MC_TRAFO_TYPE")]
    turning = {channel for channel, kind in types if kind and kind not in OTHERS}
    data.channel = next((channel for channel in channels if channel in turning), channels[0])
    others = [str(channel) for channel in channels if channel != data.channel]
    return [f"Channel {data.channel} is read; channels {', '.join(others)} are not."] if others else []


def _length(data: MachineData, answers: Answers) -> Figure:
    """The unit of lengths: MD10240. Raises ControlFileError where units are the builder's own."""
    mask = data.datum("MN_SCALING_USER_DEF_MASK")
    if mask is not None and int(mask.number()) % 2**OWN_UNITS:
        raise mask.origin.error(f"= {mask.text[:20]} gives data units of their own (MD10230); print them with mask 0")
    metric = data.datum("MN_SCALING_SYSTEM_IS_METRIC")
    if metric is not None:
        return Figure("mm" if metric.number() else "in", (metric.origin,))
    question = Question("basic unit of lengths (mm, in)", "mm", "no file has $MN_SCALING_SYSTEM_IS_METRIC (MD10240)")
    return answers.choice(question, tuple(IN_MM))


def _chain_and_inputs(
    data: MachineData, axes: Mapping[int, ChannelAxis], answers: Answers, record: MachineRecord
) -> tuple[VectorChain | None, list[tuple[int, Origin]]]:
    """The chain, and the channel axes that are X, Y and Z where something names them."""
    by_elements = kinematic_transformation(data, axes, record)
    if by_elements is None:
        found, others = transformation(data)
        record.remarks += others
        inputs = found.inputs(data)[:3] if found is not None and found.names_axes(data) else []
        return _chain(data, found, axes, answers, record), inputs
    record.remarks += sets_by_hand(data)
    if len(carrier_numbers(data)) == 1:
        number = carrier_number(data, None, answers)
        assert number is not None
        _compare(by_elements.chain, chain_of_carrier(data, number, axes, answers, record.remarks), record)
    return by_elements.chain, by_elements.inputs


def _chain(
    data: MachineData, found: Transformation | None, axes: Mapping[int, ChannelAxis], answers: Answers,
    record: MachineRecord,
) -> VectorChain | None:  # fmt: skip
    """The chain of the transformation, else that of the swivel data; None where there is neither.

    Raises ControlFileError where both are there and contradict.
    """
    record.remarks += sets_by_hand(data)
    by_type = found is not None and found.type != BY_CARRIER
    # of several swivel data sets none need be that of the transformation
    single = not by_type or len(carrier_numbers(data)) == 1
    number = carrier_number(data, found, answers) if single else None
    swivel = None if number is None else chain_of_carrier(data, number, axes, answers, record.remarks)
    if found is None or not by_type:
        return swivel
    chain = chain_of_transformation(data, found, axes, answers, str(record.length.value))
    if not any(chain.axes):
        return None
    for axis in chain.axes:
        if axis is not None and axis.start.number:
            record.remarks.append(
                f"{axis.start.origin} = {axis.start.number:g}: turns of {axis.name} count from there (assumption)."
            )
    if found.is_by_letters and chain.kind.value != "T":
        if swivel is None:
            record.remarks.append(
                f"{found.kind.origin} = {found.type} gives no direction of the table: by $MC_TRAFO5_ROT_SIGN_IS_PLUS = "
                "1 a positive turn is right-handed (assumption). Compare it with the real one."
            )
        else:
            chain = _with_senses(chain, swivel, record)
    if swivel is not None:
        _compare(chain, swivel, record)
    return chain


def _with_senses(chain: VectorChain, swivel: VectorChain, record: MachineRecord) -> VectorChain:
    """A chain of letters with the directions of tables that swivel data give it."""
    axes = list(chain.axes)
    for k, (own, other, table) in enumerate(zip(chain.axes, swivel.axes, ON_TABLE[str(chain.kind.value)])):
        if not table or own is None or other is None or own.name != other.name:
            continue
        if np.dot(own.direction.vector, other.direction.vector) < 0.0:
            record.remarks.append(
                f"{other.direction.origin} turns {own.name} in the other sense than {own.direction.origin} by its sign "
                "alone: it counts, and names a direction."
            )
        axes[k] = replace(own, direction=other.direction)
    return replace(chain, axes=(axes[0], axes[1]))


def _compare(chain: VectorChain, swivel: VectorChain, record: MachineRecord) -> None:
    """Refuse a transformation and swivel data of other axes; other figures are told."""
    if chain.kind.value != swivel.kind.value:
        raise swivel.kind.origins[0].error(
            f"= {swivel.kind.value} contradicts {chain.kind.origin}, which is kind {chain.kind.value}; give one of both"
        )
    for one, other in zip(chain.axes, swivel.axes):
        if one is None or other is None:
            continue
        if one.name != other.name:
            raise other.direction.origins[0].error(
                f"is of the axis {other.name}, where {one.direction.origin} is of {one.name}; correct one of both"
            )
        first, second = (np.array(each.direction.vector) for each in (one, other))
        cosine = float(first @ second / np.linalg.norm(first) / np.linalg.norm(second))
        if cosine < 0.0:
            raise other.direction.origins[0].error(
                f"turns {other.name} in the other sense than {one.direction.origin}; correct one of both"
            )
    for name in ("I1", "I2", "I3", "I4"):
        apart = float(np.abs(chain.vector(name) - swivel.vector(name)).max())
        if apart * IN_MM[str(record.length.value)] > SAME:
            record.remarks.append(
                f"{name} of the swivel data is {_shown(swivel.vector(name))}, that of the transformation "
                f"{_shown(chain.vector(name))} [{record.length.value}]: the transformation is taken."
            )


def _check_open(chain: VectorChain, record: MachineRecord, unit: float) -> None:
    """Say where a chain does not close; refuse a closing vector with the wrong sign.

    A chain closes where head and table are never changed (IM9). An open one is a machine too: the closing vector is in
    the tool's length or in the zero offset, as in the manual's own example of a head (W1, 08/2005, page 2-92).
    """
    for end in chain.open_ends(unit):
        shown, wanted = _shown(end.vector), _shown(end.wanted)
        if end.vector.any() and np.abs(end.vector + end.wanted).max() * unit < SAME:
            raise end.figure.origins[0].error(
                f"is {shown}, and {end.of_others} needs {wanted} to close the chain: the sign of one of them is wrong"
            )
        record.remarks.append(
            f"{end.name} is {shown} [{record.length.value}] ({end.figure.origin}), and {wanted} would close the chain: "
            "positions with that and without differ by it, and so do zero offsets and tool lengths."
        )


def _shown(vector: Floats) -> str:
    return "(" + ", ".join(f"{value:g}" for value in np.round(vector, 6) + 0.0) + ")"


def _turning(data: MachineData, axes: Mapping[int, ChannelAxis], chain: VectorChain | None) -> dict[str, ChannelAxis]:
    """The turning axes by letter: those of the chain, else all of the channel that turn and are no spindle."""
    if chain is None:
        found: dict[str, ChannelAxis] = {}
        for axis in axes.values():
            if axis.letter not in tuple(TURNING) or is_spindle(data, axis.words):
                continue
            if axis.letter in found:
                raise axis.origin.error(f"is the axis {axis.name}, as is {found[axis.letter].origin}; give one of both")
            found[axis.letter] = axis
        return found
    return {axis.name: axis.axis for axis in chain.axes if axis is not None}


def _kind(data: MachineData, letter: str, axis: ChannelAxis) -> Figure:
    """Whether a joint turns; MD30300 must agree."""
    rotary = letter in TURNING
    datum = data.datum("MA_IS_ROT_AX", 0, axis.words)
    if datum is None:
        return Figure("rotary" if rotary else "linear", (Origin(f"axis {axis.name}"),))
    if bool(datum.number()) != rotary:
        raise datum.origin.error(
            f"= {datum.text[:20]}, and {axis.origin} makes it the axis {letter}, which "
            f"{'turns' if rotary else 'is linear'}; correct one of both"
        )
    return Figure("rotary" if rotary else "linear", (datum.origin,))


def _add_remarks(
    data: MachineData, axes: Mapping[int, ChannelAxis], joints: Mapping[str, ChannelAxis], chain: VectorChain | None,
    record: MachineRecord,
) -> None:  # fmt: skip
    """What a person should know: axes that are no joints, data of no axis, and turns against ISO 841."""
    if data.strange:
        record.remarks.append(
            f"Lines that name machine data and assign nothing: {len(data.strange)}, the first is {data.strange[0]}."
        )
    others = [axis.name for axis in axes.values() if axis not in joints.values()]
    if others:
        record.remarks.append(f"No joints of this machine: {', '.join(others)}.")
    words = {word for axis in axes.values() for word in axis.words}
    strange = [word[:20] for word in data.axis_words() if word not in words and not word.startswith("AX")]
    if strange:
        shown = ", ".join(strange[:SHOWN]) + (", ..." if len(strange) > SHOWN else "")
        record.remarks.append(f"$MA data of {shown} are not read: the channel has no such axis.")
    for name in chain.against_iso() if chain is not None else ():
        record.remarks.append(
            f"+{name} turns the tool, as the part sees it, against the right-hand rule, other than ISO 841 wants: is "
            "the sign of its direction right?"
        )
