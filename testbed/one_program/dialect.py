"""What a dialect can say: motions each one can, the rest where it has words for it."""

from __future__ import annotations

from abc import ABC, abstractmethod

from testbed.one_program.motion import Circle, Move
from testbed.one_program.nodes import Frame, Holes, Plane, Row
from toolpace.common.arrays import Floats


class Dialect(ABC):
    """Says nodes natively; what answers False is written out by other means."""

    name = ""
    points_only = False
    """Whether the dialect gives points and axes of the tool, and no joints."""

    swivel_stops = False
    """Whether the word that turns the joints to a plane ends at rest."""

    @abstractmethod
    def header(self) -> None:
        """Up to the first place."""

    @abstractmethod
    def footer(self) -> None:
        """The end."""

    @abstractmethod
    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        """A straight motion to words (3,); `by`: as a distance, where the dialect likes."""

    @abstractmethod
    def say_arc(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        """An arc in the control's coordinates."""

    @abstractmethod
    def say_dwell(self, seconds: float) -> None:
        """Rest, and wait."""

    @abstractmethod
    def say_stop(self) -> None:
        """Rest."""

    @abstractmethod
    def say_tool(self, number: str) -> None:
        """Take a tool."""

    def say_offset(self, name: str) -> bool:
        """Whether it could."""
        return False

    def say_home(self, to: dict[int, float]) -> bool:
        return False

    def say_holes(self, node: Holes) -> bool:
        return False

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        """Enter a frame; whether the control has a word for it here."""
        return False

    def end_frame(self, kind: str) -> None:
        """Leave the innermost frame."""
        return

    @abstractmethod
    def begin_tip(self) -> None:
        """Words are the tip on the part from now on; sets `under` where that is not the work offset."""

    @abstractmethod
    def end_tip(self) -> None:
        """Words are those of the joints again."""

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        """Enter a plane (4, 4), after the rotary joints were turned: the control's coordinates are in it."""
        return False

    def end_plane(self) -> None:
        """Leave it; the joints stay."""
        return

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        """Enter a plane with the turn to it by one word; whether the dialect can here."""
        return False

    def say_repeat(self, times: int, text: list[str]) -> bool:
        return False

    def say_call(self, name: int, text: list[str]) -> bool:
        return False

    def say_row(self, node: Row) -> bool:
        return False

    def forget(self) -> None:
        """Say every mode again from here on."""
        return
