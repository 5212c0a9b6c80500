"""The text of a contour for a control, in the ways in which one can be written."""

from __future__ import annotations

from dataclasses import dataclass

from testbed.compensation.contours import Contour, Element

PLANES = {"G17": ("X", "Y", "Z", "I", "J"), "G18": ("Z", "X", "Y", "K", "I"), "G19": ("Y", "Z", "X", "J", "K")}
"""The axes of a plane, the axis across it, and the words of centres."""


@dataclass(frozen=True)
class Form:
    """How a contour is written."""

    plane: str = "G17"
    incremental: bool = False
    inch: bool = False
    ramps: bool = False
    """Whether each element goes down by 1.5 mm."""
    head: str = ""
    """Blocks before the contour."""
    tail: str = ""
    """Blocks behind it."""


def word_address(contour: Contour, control: str, form: Form) -> str:
    """A program of Fanuc and its kin, or of a Sinumerik."""
    first, second, normal, i, j = PLANES[form.plane]
    unit = 1.0 / 25.4 if form.inch else 1.0
    sinumerik = control == "sinumerik"
    units = ("G700", "G710") if sinumerik else ("G20", "G21")
    word = ("G41" if contour.side > 0 else "G42") + ("" if sinumerik else " D1")
    place = contour.entry

    def to(point: complex) -> str:
        nonlocal place
        told, place = (point - place if form.incremental else point), point
        return f"{first}{told.real * unit:.9f} {second}{told.imag * unit:.9f}"

    def block(number: int, element: Element) -> str:
        depth = -1.5 * unit * (1 if form.incremental else number + 1)
        ramp = f" {normal}{depth:.9f}" if form.ramps else ""
        if element.centre is None:
            return f"G1 {to(element.end)}{ramp}"
        spoke = (element.centre - element.start) * unit
        motion = "G3" if element.sense > 0 else "G2"
        return f"{motion} {to(element.end)} {i}{spoke.real:.9f} {j}{spoke.imag:.9f}{ramp}"

    lines = [
        f"{units[0] if form.inch else units[1]} G90 {form.plane} G94", "T1 M6", form.head,
        f"G0 {first}{place.real * unit:.9f} {second}{place.imag * unit:.9f} {normal}0.",
        "G91" if form.incremental else "",
        f"{word} G1 {to(contour.elements[0].start)} F{500.0 * unit:.4f}",
        *(block(number, element) for number, element in enumerate(contour.elements)),
        f"G40 G1 {to(contour.away)}", "G90", form.tail, "M30",
    ]  # fmt: skip
    return "\n".join(line for line in lines if line) + "\n"


def klartext(contour: Contour, form: Form) -> str:
    """A program of Klartext, in millimetres in the plane XY."""
    place = contour.entry

    def to(point: complex) -> str:
        nonlocal place
        told, place = (point - place if form.incremental else point), point
        first, second = ("IX", "IY") if form.incremental else ("X", "Y")
        return f"{first}{told.real:+.9f} {second}{told.imag:+.9f}"

    lines = [
        "BEGIN PGM A MM", "TOOL CALL 1 Z S1000", form.head,
        f"L X{place.real:+.9f} Y{place.imag:+.9f} Z+0 R0 FMAX",
        f"L {to(contour.elements[0].start)} {'RL' if contour.side > 0 else 'RR'} F500",
    ]  # fmt: skip
    for element in contour.elements:
        if element.centre is None:
            lines.append(f"L {to(element.end)}")
        else:
            lines.append(f"CC X{element.centre.real:+.9f} Y{element.centre.imag:+.9f}")
            lines.append(f"C {to(element.end)} DR{'+' if element.sense > 0 else '-'}")
    lines += [f"L {to(contour.away)} R0", form.tail, "M30", "END PGM A MM"]
    return "\n".join(line for line in lines if line) + "\n"
