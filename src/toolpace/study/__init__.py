"""The simulation study of the paper (section III): figures, numbers, errata."""

from __future__ import annotations

import json
import os
from collections.abc import Callable

SIMULATED = 0.6
"""Share of the work that is done with the simulation; drawing the pictures is most of the rest."""


def write_study(out_dir: str | os.PathLike[str], progress: Callable[[float], None] | None = None) -> dict[str, object]:
    """Simulate, and write study.html (opens offline), figure_1.svg to figure_3.svg, figure_4.png to figure_10.png and
    study.json into a folder.

    The folder appears by one step, and replaces only what toolpace wrote (see `write_folder`; UsageError). Returns what
    study.json holds. `progress` is called with the share done. Without matplotlib (the extra `png`) the
    page and the figures' data are complete, but no PNG is written, and study.json says so under `png`.
    """
    from toolpace.common.files import whole_folder, write_text
    from toolpace.study import figures, page, png, sketches
    from toolpace.study.simulation import simulate

    tell = progress or (lambda share: None)
    with whole_folder(out_dir, seal="study.json") as out:
        study = simulate(lambda share: tell(SIMULATED * share))
        drawn = figures.all_figures(study)
        tell(SIMULATED + 0.05)
        pictures = png.write_pictures(drawn, out)
        tell(0.9)
        facts = study.facts()
        sketched = sketches.all_sketches()
        for sketch in sketched:
            write_text(out / f"figure_{sketch.number}.svg", sketch.svg + "\n")
        facts["png"] = pictures if pictures else "not written: install matplotlib, or toolpace[png]"
        write_text(out / "study.html", page.study_page(study, sketched, drawn))
        write_text(out / "study.json", json.dumps(facts, indent=1) + "\n")
    tell(1.0)
    return facts
