"""The templates for the outputs of a model, and their rendering."""

from __future__ import annotations

from functools import cache

import jinja2


@cache
def environment() -> jinja2.Environment:
    """Return the environment that renders the templates of this package; undefined names are errors."""
    return jinja2.Environment(
        loader=jinja2.PackageLoader("nrp_bibi"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
