"""What a language of letters and numbers remembers from block to block."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.units import INCH, MILLIMETRE


@dataclass(slots=True)
class Modal:
    """The state of the reader; defaults are millimetres, absolute, XY plane, continuous path."""

    unit: float = MILLIMETRE
    absolute: bool = True
    arc_absolute: bool = False
    plane: int = 0
    motion: int | None = None
    exact_stop: bool = False
    switched_tip_mode: bool = False
    """By M428, M429."""
    length_tip_mode: bool = False
    """By G43.4, G49."""
    ended: bool = False

    @property
    def tip_mode(self) -> bool:
        return self.switched_tip_mode or self.length_tip_mode

    def set_units(self, code: int) -> None:
        self.unit = INCH if code == 200 else MILLIMETRE
