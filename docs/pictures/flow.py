"""Where data flows, as flow.svg beside this file: `python docs/pictures/flow.py` writes it anew."""

from __future__ import annotations

from pathlib import Path

WIDTH, HEIGHT = 900, 250
BOX = (112, 44)
INK, PAPER, LINE, NOUN, GIVEN = "#1b2a38", "#ffffff", "#5b6b7a", "#dcecf5", "#f3ead7"
BOXES = {
    "program": (70, 60, GIVEN, "G-code, APT, table"),
    "ToolPath": (262, 60, NOUN, "what it says"),
    "Path": (454, 60, NOUN, "smooth, in tolerance"),
    "AxisPath": (646, 60, NOUN, "joints along s"),
    "Trajectory": (830, 60, NOUN, "joints over time"),
    "Machine": (550, 185, GIVEN, "chains and limits"),
    "SetPoints": (830, 185, NOUN, "every millisecond"),
    "verdict": (262, 185, NOUN, "by differences"),
}
ARROWS = [
    ("program", "ToolPath", "read"),
    ("ToolPath", "Path", "fit"),
    ("Path", "AxisPath", "follow"),
    ("AxisPath", "Trajectory", "plan"),
    ("Trajectory", "SetPoints", "sample"),
]


def box(name: str) -> str:
    """A box with its name, and in small letters what it is."""
    x, y, fill, words = BOXES[name]
    w, h = BOX
    return (
        f'<rect x="{x - w / 2:g}" y="{y - h / 2:g}" width="{w}" height="{h}" rx="7" fill="{fill}" stroke="{LINE}"/>'
        f'<text x="{x}" y="{y - 2}" font-weight="600">{name}</text>'
        f'<text x="{x}" y="{y + 14}" font-size="10">{words}</text>'
    )


def arrow(way: str, word: str = "", at: tuple[float, float] = (0.0, 0.0)) -> str:
    """An arrow along a way (an SVG path), and the word beside it."""
    text = f'<text x="{at[0]:g}" y="{at[1]:g}" font-style="italic">{word}</text>' if word else ""
    return f'<path d="{way}" fill="none" stroke="{LINE}" stroke-width="1.6" marker-end="url(#head)"/>{text}'


def between(start: str, end: str, word: str) -> str:
    """A straight arrow from box to box."""
    (x0, y0), (x1, y1) = BOXES[start][:2], BOXES[end][:2]
    if y0 == y1:
        side = 1 if x1 > x0 else -1
        way = f"M {x0 + side * BOX[0] / 2:g} {y0} L {x1 - side * (BOX[0] / 2 + 3):g} {y1}"
        return arrow(way, word, ((x0 + x1) / 2, y0 - 8))
    return arrow(f"M {x0} {y0 + BOX[1] / 2:g} L {x1} {y1 - BOX[1] / 2 - 3:g}", word, (x0 - 30, (y0 + y1) / 2 + 4))


def picture() -> str:
    """The whole file."""
    machine, verdict = BOXES["Machine"], BOXES["verdict"]
    half = BOX[1] / 2
    extra = [
        arrow(f"M {machine[0]} {machine[1] - half:g} L {machine[0]} 66"),
        arrow(f"M 590 {machine[1] - half:g} C 600 120, 700 130, 738 68"),
        # the judge: set-points, machine and program, nothing else
        arrow(f"M 774 198 C 700 245, 420 245, {verdict[0] + 59} 198", "verify", (470, 224)),
        arrow(f"M {machine[0] - 56} 185 L {verdict[0] + 59} 185"),
        arrow(f"M {verdict[0]} 82 L {verdict[0]} 160"),
        arrow("M 800 38 C 790 6, 870 6, 860 35", "deflect", (745, 17)),
    ]
    body = "\n".join([*extra, *(between(*each) for each in ARROWS), *map(box, BOXES)])
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"
  font-family="Helvetica, Arial, sans-serif" font-size="13" text-anchor="middle" fill="{INK}" role="img">
<title>From a program to a motion</title>
<defs><marker id="head" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="7" markerHeight="7" orient="auto">
<path d="M 0 0 L 10 5 L 0 10 z" fill="{LINE}"/></marker></defs>
<rect width="{WIDTH}" height="{HEIGHT}" rx="10" fill="{PAPER}"/>
{body}
</svg>
"""


if __name__ == "__main__":
    Path(__file__).with_suffix(".svg").write_text(picture(), encoding="utf-8")
