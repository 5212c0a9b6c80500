"""Set-up sheets with a block of stock and one mill."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def milling_sheet(
    box: Sequence[Sequence[float]], diameter: float, flute_length: float, stick_out: float, *, teeth: int = 3,
    uncertainty: float = 0.0, **figures: Any,
) -> str:  # fmt: skip
    """A sheet: least and most corner of the stock, a flat mill of carbide, and more figures of it; all in mm."""
    lines = [f"[stock]\nbox = {[list(corner) for corner in box]}\nuncertainty = {uncertainty}", "[tools.1]"]
    lines += ['kind = "flat"', f"diameter = {diameter}", f"flute_length = {flute_length}", f"teeth = {teeth}"]
    lines += [f"stick_out = {stick_out}", 'material = "carbide"']
    lines += [f"{name} = {value}" for name, value in figures.items()]
    return "\n".join([*lines, ""])
