"""The study as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from toolpace.results.report.shell import with_policy
from toolpace.study.drawings import Figure, figure_svg
from toolpace.study.simulation import Study
from toolpace.study.sketches import Sketch
from toolpace.study.tables import CHOICES, Table, all_errata, comparison, periods_table, times_table, ways_table

STYLE = """
:root { --ink: #17202e; --soft: #5b6778; --line: #e4e8ee; --ground: #f4f6f9; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font-variant-numeric: tabular-nums;
  font: 15px/1.5 Inter, "Segoe UI", system-ui, "Helvetica Neue", "Liberation Sans", Arial, sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 28px; }
h1 { font-size: 26px; margin: 0; letter-spacing: -0.02em; } h2 { font-size: 17px; margin: 0 0 6px; }
p { margin: 4px 0 10px; color: var(--soft); max-width: 90ch; }
section { background: #fff; border: 1px solid var(--line); border-radius: 12px; padding: 18px 20px; margin: 16px 0; }
.scroll { overflow-x: auto; }
svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 500; border-bottom: 1px solid var(--line); }
th, td { padding: 6px 10px; vertical-align: top; } td { border-bottom: 1px solid #eff2f6; }
td.n, th.n { text-align: right; white-space: nowrap; } tr:last-child td { border-bottom: 0; }
"""
"""Of the page; it has no file of its own, since it is read by nobody else."""
WAYS_LEAD = (
    "Step (2) of section II.D sets velocity, acceleration and jerk at the deflection to those at the projection, in the"
    " workpiece frame. A quintic has six coefficients: with both positions, velocity and acceleration they are used up,"
    " and the jerks at both ends differ by 12 times the acceleration over T_dp. All three are the same only where that"
    " acceleration is zero. Either reading asks the linear motors for a jump of velocity, for at another place the same"
    " velocity of the tip is another one of the motors wherever a rotary axis turns. Ours lets the joints go on as they"
    " move, and asks for no jump."
)
"""What the table of ways shows, above it."""
CAUSES_LEAD = (
    "A tip that is measured off its path has one of two causes, and each has its own answer. The paper treats the"
    " first, though it speaks of a tool that deflects, and so does every figure of this page."
)
"""What both causes are about, above their table."""
CAUSES = Table(
    ("", "displaced", "bending"),
    (
        ("What has happened", "the joints are not where they were commanded: their state has jumped",
         "the tool or the part bends; the joints are where they were commanded, and their encoders say so"),
        ("Where the joints are", "at the pose that has the measured tip", "on the path"),
        ("The answer", "a motion of the joints back to the path, from the state that they are in",
         "a command that aims off by as much as it bends, for as long as it bends"),
        ("The other answer instead", "compensation leaves the joints as far off as they are",
         "a motion back begins from a pose that the joints are not in: the tip is then off by twice the bending at"
         " first, and by the bending ever after"),
        ("Here", "Fig. 8 to 10, with the paper's deflection", "not in the paper, and in no figure here"),
    ),
)  # fmt: skip
"""Both causes, for who measures a tip."""
TIMES_LEAD = (
    "The case is limited by the feed: no motion takes less than the length of the curve over the feed, 5.23599 s, and"
    " even the best planner gains little. The genetic planner loses about half of its time in the first and the last"
    " interval, whose single quintic cannot both leave rest quickly and stay at the feed; the rest is what its preset"
    " speeds keep in reserve, and what a few generations do not find."
)
"""What the table of times shows, above it."""


def study_page(study: Study, sketches: Sequence[Sketch], figures: Sequence[Figure]) -> str:
    """The whole page."""
    parts = [
        "<!doctype html><html lang='en'><head><meta charset=\"utf-8\">"
        "<meta name='viewport' content='width=device-width, initial-scale=1'><link rel='icon' href='data:,'>"
        f"<title>The paper's study</title><style>{STYLE}</style></head><body><main>"
        "<h1>Local minimum time, without and with deflection</h1>"
        "<p>The simulation study (section III) of Wu, Li, Liu and Perez, American Control Conference 2009, doi"
        " 10.1109/ACC.2009.5160578, done anew by <code>toolpace study</code>.</p>",
        section("Times", TIMES_LEAD, table(times_table(study))),
        section("Printed and ours", "", table(comparison(study))),
        *map(sketch_section, sketches),
        *map(figure_section, figures),
        section("The way back, to the letter and ours", WAYS_LEAD, table(ways_table(study))),
        section("What a measured tip means", CAUSES_LEAD, table(CAUSES)),
        section("Time in each interval, T_i", "In seconds, interval by interval.", table(periods_table(study))),
        section("Errata", "What the paper prints, what holds, and a check that was worked out for this page.",
                table(all_errata(study))),
        section("What the paper does not say, and what was chosen", "", table(CHOICES)),
        "</main></body></html>",
    ]  # fmt: skip
    return with_policy("\n".join(parts))


def section(title: str, lead: str, body: str) -> str:
    """A box of the page."""
    return f"<section><h2>{escape(title)}</h2>{f'<p>{escape(lead)}</p>' if lead else ''}{body}</section>"


def table(content: Table) -> str:
    """An HTML table; where it is one of numbers all but the first column stand right."""
    kind = ["", *[" class='n'" if content.numeric else ""] * (len(content.head) - 1)]
    top = "".join(f"<th{k}>{escape(cell)}</th>" for k, cell in zip(kind, content.head))
    rows = ("".join(f"<td{k}>{escape(cell)}</td>" for k, cell in zip(kind, row)) for row in content.rows)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"<div class='scroll'><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>"


def figure_section(figure: Figure) -> str:
    """A figure, drawn where it stands."""
    drawn = f'<div class="scroll" id="figure-{figure.number}">{figure_svg(figure)}</div>'
    return section(f"Figure {figure.number}. {figure.title}", figure.caption, drawn)


def sketch_section(sketch: Sketch) -> str:
    """A sketch, drawn where it stands."""
    return section(f"Figure {sketch.number}. {sketch.title}", sketch.caption, f"<div class='scroll'>{sketch.svg}</div>")
