"""A simulation of a cut as figures for other programs, in mm, mm3 and s."""

from __future__ import annotations

from toolpace.common.errors import printable
from toolpace.common.units import MILLIMETRE
from toolpace.cutting.simulation.findings import Finding
from toolpace.cutting.simulation.operation_cut import OperationCut
from toolpace.cutting.simulation.simulate import CutSimulation

MM3 = MILLIMETRE**3


def cut_record(simulation: CutSimulation, program: str, machine: str) -> dict[str, object]:
    """The entry of one program."""
    above = simulation.above_part
    return {
        "program": printable(program),
        "machine": machine,
        "stock_guessed": simulation.guessed,
        "stock_mm3": simulation.stock_volume / MM3,
        "removed_mm3": simulation.removed_volume / MM3,
        "left_mm3": simulation.left_volume / MM3,
        "resolution_mm": simulation.resolution / MILLIMETRE,
        "smallest_contact_mm": simulation.smallest_contact / MILLIMETRE,
        "left_above_part_mm": None if above is None else above.height / MILLIMETRE,
        "left_above_part_mm3": None if above is None else above.volume / MM3,
        "uncertainty_mm": simulation.uncertainty / MILLIMETRE,
        "air_s": simulation.air,
        "cutting_s": simulation.cutting,
        "operations": [_operation(each) for each in simulation.operations],
        "findings": [_finding(each) for each in simulation.findings],
        "assumed": [printable(each) for each in simulation.assumed],
    }


def _operation(each: OperationCut) -> dict[str, object]:
    return {
        "name": printable(each.name),
        "tool": printable(each.tool),
        "air_s": each.air,
        "cutting_s": each.cutting,
        "uncertain_s": each.uncertain,
        "rapid_s": each.rapid,
        "removed_mm3": each.removed / MM3,
        "removed_range_mm3": [volume / MM3 for volume in each.removed_range],
        "mean_rate_mm3_per_s": each.mean_rate / MM3,
        "peak_rate_mm3_per_s": each.peak_rate / MM3,
        "width_mm": each.width / MILLIMETRE,
        "depth_mm": each.depth / MILLIMETRE,
    }


def _finding(each: Finding) -> dict[str, object]:
    return {
        "kind": each.kind,
        "line": each.line,
        "last_line": each.last_line,
        "operation": printable(each.operation),
        "tool": printable(each.tool),
        "in": printable(each.body),
        "depth_mm": each.depth / MILLIMETRE,
        "place_mm": [x / MILLIMETRE for x in each.place],
        "time_s": each.time,
        "duration_s": each.seconds,
        "certain": each.certain,
    }
