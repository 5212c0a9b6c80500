"""The study as one HTML page that opens offline."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from toolpace.arrays import Floats
from toolpace.reporting.policy import with_policy
from toolpace.study.errata import CHOICES, all_errata, comparison
from toolpace.study.figures import FAR, Figure, Panel
from toolpace.study.simulation import CLOSED_FORM, Study, periods

if TYPE_CHECKING:
    import plotly.graph_objects as go

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
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 500; border-bottom: 1px solid var(--line); }
th, td { padding: 6px 10px; vertical-align: top; } td { border-bottom: 1px solid #eff2f6; }
td.n, th.n { text-align: right; white-space: nowrap; } tr:last-child td { border-bottom: 0; }
"""
"""Of the page; it has no file of its own, since it is read by nobody else."""


def study_page(study: Study, figures: Sequence[Figure]) -> str:
    """The whole page; about 5 MB of it are plotly.js."""
    from plotly.offline import get_plotlyjs

    parts = [
        "<!doctype html><html lang='en'><head><meta charset=\"utf-8\">"
        "<meta name='viewport' content='width=device-width, initial-scale=1'><link rel='icon' href='data:,'>"
        f"<title>The paper's study</title><style>{STYLE}</style><script>{get_plotlyjs()}</script></head><body><main>"
        "<h1>Local minimum time, without and with deflection</h1>"
        "<p>The simulation study (section III) of Wu, Li, Liu and Perez, American Control Conference 2009, doi"
        " 10.1109/ACC.2009.5160578, done anew by <code>toolpace study</code>.</p>",
        section("Times", TIMES_LEAD, times_table(study)),
        section("Printed and ours", "", table(["", "printed", "ours"], comparison(study))),
    ]
    parts += [figure_section(figure) for figure in figures]
    parts += [
        section("Time in each interval, T_i", "In seconds, interval by interval.", periods_table(study)),
        section("Errata", "What the paper prints, what holds, and a check that was worked out for this page.",
                table(["where", "printed", "holds", "check"],
                      [(e.where, e.printed, e.holds, e.check) for e in all_errata(study)])),
        section("What the paper does not say, and what was chosen", "", table(["", "chosen"], CHOICES)),
        "</main></body></html>",
    ]  # fmt: skip
    return with_policy("\n".join(parts))


TIMES_LEAD = (
    "The case is limited by the feed: no motion takes less than the length of the curve over the feed, 5.23599 s, and"
    " even the best planner gains little. The genetic planner loses about half of its time in the first and the last"
    " interval, whose single quintic cannot both leave rest quickly and stay at the feed; the rest is what its preset"
    " speeds keep in reserve, and what a few generations do not find."
)
"""What the table of times shows, above it."""


def section(title: str, lead: str, body: str) -> str:
    """A box of the page."""
    return f"<section><h2>{escape(title)}</h2>{f'<p>{escape(lead)}</p>' if lead else ''}{body}</section>"


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numeric: bool = False) -> str:
    """An HTML table; with `numeric` all but the first column stand right."""
    kind = ["", *([" class='n'"] * (len(head) - 1) if numeric else [""] * (len(head) - 1))]
    top = "".join(f"<th{k}>{escape(cell)}</th>" for k, cell in zip(kind, head))
    body = "".join(f"<tr>{''.join(f'<td{k}>{escape(cell)}</td>' for k, cell in zip(kind, row))}</tr>" for row in rows)
    return f"<div class='scroll'><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>"


def times_table(study: Study) -> str:
    """Totals and bounds."""
    best = study.optimal.duration
    rows = [
        (f"genetic, {n} generation{'s' if n > 1 else ''}", f"{t.duration:.5f}",
         f"{100 * (t.duration / best - 1):+.3f} %", f"{t.usage().worst:.5f}", f"{t.solve_seconds:.2f} s")
        for n, t in study.genetic.items()
    ]  # fmt: skip
    rows.append(
        ("optimal", f"{best:.5f}", "", f"{study.optimal.usage().worst:.5f}", f"{study.optimal.solve_seconds:.2f} s")
    )
    rows.append(
        (
            "optimum in closed form, to first order",
            f"{CLOSED_FORM:.4f}",
            f"{100 * (CLOSED_FORM / best - 1):+.3f} %",
            "",
            "",
        )
    )
    if study.optimal.lower_bound > 0.0:
        bound = study.optimal.lower_bound
        rows.append(
            ("lower bound on this mesh, all limits", f"{bound:.5f}", f"{100 * (bound / best - 1):+.3f} %", "", "")
        )
    rows.append(
        ("lower bound, feed alone", f"{study.feed_bound:.5f}", f"{100 * (study.feed_bound / best - 1):+.3f} %", "", "")
    )
    for name, (before, after) in study.pairs().items():
        spent = study.instant[name] + after.duration
        rows.append(
            (f"{name}, with deflection at {study.instant[name]:.3f} s", f"{spent:.5f}",
             f"{1e3 * (spent - before.duration):+.0f} ms by it", f"{after.usage().worst:.5f}",
             f"{after.solve_seconds:.2f} s")
        )  # fmt: skip
    return table(["", "total [s]", "against optimal", "peak use", "computed in"], rows, numeric=True)


def periods_table(study: Study) -> str:
    """T_i by planner."""
    columns = {f"genetic, {n}": periods(study, t) for n, t in study.genetic.items()}
    columns["optimal"] = periods(study, study.optimal)
    count = len(study.points) - 1
    rows = [[str(k + 1), *(f"{v[k]:.5f}" for v in columns.values())] for k in range(count)]
    rows.append(["sum", *(f"{v.sum():.5f}" for v in columns.values())])
    return table(["interval", *columns], rows, numeric=True)


def figure_section(figure: Figure) -> str:
    """A figure as an interactive drawing."""
    import plotly.io

    drawing = plotly.io.to_html(
        drawn(figure), full_html=False, include_plotlyjs=False, div_id=f"figure-{figure.number}",
        config={"displaylogo": False, "responsive": True},
    )  # fmt: skip
    return section(f"Figure {figure.number}. {figure.title}", figure.caption, drawing)


def drawn(figure: Figure) -> go.Figure:
    """The plotly figure."""
    from plotly.subplots import make_subplots

    rows, columns = len(figure.rows), max(map(len, figure.rows))
    specs = [[{"type": "scene" if panel.in_space else "xy"} for panel in row] for row in figure.rows]
    titles = [f"{p.title}<br><sup>{p.note}</sup>" if p.note else p.title for row in figure.rows for p in row]
    out = make_subplots(
        rows=rows, cols=columns, specs=specs, subplot_titles=titles, horizontal_spacing=0.08,
        vertical_spacing=0.4 / rows if rows > 1 else 0.1,
    )  # fmt: skip
    shown: set[str] = set()
    for i, row in enumerate(figure.rows, 1):
        for j, panel in enumerate(row, 1):
            add_panel(out, panel, i, j, shown)
    out.update_layout(
        height=460 if rows == 1 else 290 * rows + 60, template="plotly_white",
        margin={"l": 60, "r": 20, "t": 60, "b": 50},
        legend={"orientation": "h", "y": 1.06 if rows == 1 else 1.04, "yanchor": "bottom", "x": 0}, hovermode="closest",
        font={"size": 12},
    )  # fmt: skip
    return out


def add_panel(out: go.Figure, panel: Panel, i: int, j: int, shown: set[str]) -> None:
    """One panel of a plotly figure; every name stands once in the legend."""
    import plotly.graph_objects as go

    for curve in panel.curves:
        marks = curve.style == "marks"
        common = {
            "name": curve.name, "legendgroup": curve.name, "mode": "markers" if marks else "lines",
            "showlegend": bool(curve.name) and curve.name not in shown,
        }  # fmt: skip
        shown.add(curve.name)
        line = {"color": curve.colour, "width": 2 if curve.z is None else 4}
        marker = {"color": curve.colour, "size": 7 if curve.z is None else 3}
        style = {"marker": marker} if marks else {"line": line}
        x, y = rounded(curve.x), rounded(curve.y)
        if curve.z is not None:
            out.add_trace(go.Scatter3d(x=x, y=y, z=rounded(curve.z), **common, **style), i, j)
        else:
            out.add_trace(go.Scatter(x=x, y=y, **common, **style), i, j)
    if panel.in_space:
        out.update_scenes(
            {
                "xaxis_title": panel.x_label, "yaxis_title": panel.y_label, "zaxis_title": panel.z_label,
                "aspectmode": "data",
                "camera": {"eye": {"x": 1.0, "y": -2.2, "z": 0.8}, "center": {"x": 0, "y": 0, "z": -0.15}},
            }, row=i, col=j,
        )  # fmt: skip
        return
    out.update_xaxes(title_text=panel.x_label, row=i, col=j)
    out.update_yaxes(title_text=panel.y_label, row=i, col=j)
    if panel.equal:
        name = next(t for t in reversed(out.data) if t.type == "scatter").xaxis or "x"
        out.update_yaxes(scaleanchor=name, scaleratio=1, row=i, col=j)
    if panel.limit is not None:
        low = min(np.nanmin(curve.y) for curve in panel.curves)
        high = max(np.nanmax(curve.y) for curve in panel.curves)
        for sign, reach in ((1.0, high), (-1.0, -low)):
            if FAR * reach >= panel.limit:
                out.add_hline(sign * panel.limit, line={"color": "#c92a3f", "width": 1, "dash": "dash"}, row=i, col=j)


def rounded(values: Floats) -> list[float | None]:
    """Six digits are enough for a drawing; a gap where there is no number."""
    return [None if not np.isfinite(v) else float(f"{v:.6g}") for v in values]
