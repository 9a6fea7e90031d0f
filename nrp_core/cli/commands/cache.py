"""``nrp cache``: the files that are kept for later runs, and their size."""

from __future__ import annotations

from collections import Counter
from typing import Annotated

import typer

from nrp_core.cli.options import Json
from nrp_core.cli.output import document, size_text


def cache(
    clear: Annotated[
        bool, typer.Option("--clear", help="Remove everything; do this while no simulation opens.")
    ] = False,
    json: Json = False,
) -> None:
    """Show the size of the cache: compiled kernels, converted meshes and results of checks.

    What was not used for longest is removed when the cache exceeds its limit, 2000 MB or the value of
    the environment variable NRP_CACHE_LIMIT_MB. Removing it costs time only: the next run makes it anew.
    """
    from nrp_core._support.cache import cache_root, entries, limit_bytes

    found = list(entries())
    sizes = Counter[str]()
    for entry in found:
        sizes[entry.kind] += entry.n_bytes
        if clear:
            entry.remove()
    total = sum(sizes.values())
    if json:
        data = {"folder": cache_root(), "limit_bytes": limit_bytes(), "bytes": dict(sizes), "cleared": clear}
        document(data)
    elif clear:
        typer.echo(f"removed {size_text(total)} from {cache_root()}")
    else:
        typer.echo(f"{cache_root()}: {size_text(total)} of at most {size_text(limit_bytes())}")
        for kind, size in sizes.most_common():
            typer.echo(f"  {kind:<10} {size_text(size):>10}")
