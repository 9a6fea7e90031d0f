"""``nrp import-connectome``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrp_core.cli.options import Json, Overwrite, require_writable
from nrp_core.cli.output import document, warn


def import_connectome(
    edges: Annotated[
        Path,
        typer.Argument(
            metavar="EDGES",
            help="Table of edges (.csv, .tsv, .feather, .parquet), matrix in text, or .json file of cect.",
        ),
    ],
    neurons: Annotated[
        list[Path] | None,
        typer.Option(
            "--neurons",
            "-n",
            metavar="TABLE",
            help="A table of neurons: ids, types, sides, ...; repeatable: the first has all neurons, the "
            "others add what it lacks, such as transmitters.",
        ),
    ] = None,
    junctions: Annotated[
        Path | None, typer.Option(metavar="TABLE", help="A table or matrix of gap junctions.")
    ] = None,
    unknown: Annotated[
        str | None,
        typer.Option(
            metavar="RULE",
            help="What edges of unknown sign are: exclude, excite, or a table with the columns type and sign "
            "(excitatory, inhibitory, exclude).",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="The file to write; by default EDGES.nrpnet in the current folder.",
        ),
    ] = None,
    group: Annotated[
        list[str] | None,
        typer.Option("--group", "-g", metavar="PATTERN", help="Make only these named groups, e.g. 'MN9*'."),
    ] = None,
    unit_mv: Annotated[float, typer.Option(min=0.0, help="The weight of one synapse, mV.")] = 0.275,
    delay_ms: Annotated[float, typer.Option(min=0.0, help="The delay of all synapses, ms.")] = 1.8,
    junction_ns: Annotated[
        float, typer.Option(min=0.0, help="The conductance of one gap junction, nS; 0 leaves them out.")
    ] = 0.1,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Make a network file from a connectome, with the cell model of Shiu et al. (2024)."""
    from nrp_core.network.files.network_file import SUFFIX, save_network
    from nrp_formats.connectome.network import counts_by_type, read_connectome

    target = output or Path(f"{edges.stem}{SUFFIX}")
    if target.suffix != SUFFIX:
        raise typer.BadParameter(
            f"a network file is called {SUFFIX}, not '{target.name}'", param_hint="--output"
        )
    require_writable(target, "--output", overwrite=overwrite)
    made = read_connectome(
        edges, neurons or (), junctions=junctions, groups=tuple(group or ()), unit_mv=unit_mv,
        delay_ms=delay_ms, junction_ns=junction_ns, unknown=unknown,
    )  # fmt: skip
    save_network(made.network, target, overwrite=overwrite)
    sizes = {projection.label: projection.size for projection in made.network.projections}
    if json:
        facts = {"neurons": made.network.size, "edges": sizes, "groups": len(made.network.views)}
        document(
            {
                "file": target,
                **facts,
                "left_out": made.left_out,
                "unknown": made.unknown,
                "empty": made.empty,
                "self_junctions": made.self_junctions,
                "sources": made.sources,
                "remarks": made.network.remarks,
            }
        )
        return
    if made.left_out:
        warn(f"{made.left_out} edges were left out because one of their neurons is not in the table")
    if made.empty:
        warn(f"{made.empty} edges were left out because a cell of the table is empty")
    if made.self_junctions:
        warn(f"{made.self_junctions} gap junctions of a cell with itself have no effect and were left out")
    if made.unknown:
        warn(
            f"{sum(made.unknown.values())} edges have a transmitter of unknown sign, to which '--unknown "
            f"{unknown}' was applied: {counts_by_type(made.unknown)}"
        )
    for remark in made.network.remarks:
        warn(remark)
    counts = ", ".join(f"{n} {label} edges" for label, n in sizes.items())
    typer.echo(f"{target}: {made.network.size} neurons, {counts}, {len(made.network.views)} groups")
    for path, sha256 in made.sources.items():
        typer.echo(f"{path}: sha256 {sha256}")
