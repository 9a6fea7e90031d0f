"""A comparison as one self-contained HTML page."""

from __future__ import annotations

from typing import Any

import jinja2

from nrp_lab.comparison.report import words
from nrp_lab.comparison.report.figures import grid_figures, pair_figures
from nrp_lab.comparison.result import GridDiff, PairDiff


def grid_page(diff: GridDiff) -> str:
    """Return the page of a grid."""
    return _render("grid.html.j2", diff=diff, figures=list(grid_figures(diff)), words=words)


def pair_page(diff: PairDiff) -> str:
    """Return the page of two recordings."""
    return _render("pair.html.j2", diff=diff, figures=list(pair_figures(diff)), words=words)


def _render(template: str, **about: Any) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("nrp_lab.comparison.report"),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**about)
