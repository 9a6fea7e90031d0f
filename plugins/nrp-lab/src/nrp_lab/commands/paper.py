"""``nrp paper``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import (
    Json,
    Models,
    Overrides,
    Overwrite,
    experiment_names,
    overrides_of,
    refuse_given,
    require_writable,
)
from nrp_core.cli.output import NO, document, warn
from nrp_lab.commands.diff import Brains, Controls, Jobs, Worlds, chosen_controls, names

if TYPE_CHECKING:
    from nrp_lab.paper.verification import Verification

_OF_RUNS = ("output", "brains", "worlds", "controls", "seeds", "overrides", "models", "jobs")
"""Parameters that affect a new archive."""


def paper(
    context: typer.Context,
    experiment: Annotated[
        str,
        typer.Argument(
            metavar="EXPERIMENT",
            help="An experiment, as for nrp run, or a recording; with --verify an archive.",
            autocompletion=experiment_names,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", dir_okay=False, help="The .zip file; by default NAME.paper.zip."
        ),
    ] = None,
    verify: Annotated[
        bool, typer.Option("--verify", help="Repeat the runs of an archive; fail if one is different.")
    ] = False,
    brains: Brains = "",
    worlds: Worlds = "",
    controls: Controls = "",
    seeds: Annotated[
        int,
        typer.Option(metavar="N", min=1, help="Number of seeds, counted up from the experiment's."),
    ] = 3,
    overrides: Overrides = None,
    models: Models = None,
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Pack an experiment as one archive that others can repeat: runs, figures, methods and verdict.

    With --verify, an archive is checked and its runs are executed again; this executes code from the archive.
    """
    if verify:
        refuse_given(context, "an archive has its own runs; omit this option", _OF_RUNS)
        _verify(Path(experiment), as_json=json)
    from nrp_core.cli.progress import display
    from nrp_core.utilities import cores
    from nrp_lab.comparison.grid import RunGrid
    from nrp_lab.paper.archive import write_archive

    target = output or Path(f"{Path(experiment).resolve().name}.paper.zip")
    require_writable(target, "--output", overwrite=overwrite)
    settings = overrides_of(overrides, brain=None, world=None, models=models)
    grid = RunGrid.of(
        experiment, names(brains), names(worlds), seeds, settings, {}, chosen_controls(controls)
    )
    with display() as shown:
        manifest = write_archive(
            grid, target, jobs or cores(), lambda done, total, last: shown.count("runs", done, total, last)
        )
    for path in manifest["elsewhere"]:
        warn(f"the archive lacks {path}, which the runs read outside of the experiment's folder")
    if json:
        document({"archive": target, **{key: manifest[key] for key in ("verdict", "runs", "elsewhere")}})
        return
    if manifest["verdict"]:
        typer.echo(manifest["verdict"])
    runs = len(manifest["runs"])
    typer.echo(f"{target}: {runs} run{'' if runs == 1 else 's'}, {target.stat().st_size / 1e6:.1f} MB")


def _verify(archive: Path, *, as_json: bool) -> None:
    """Verify an archive, report the result, and end."""
    from nrp_core.cli.progress import display
    from nrp_lab.paper.verification import verify_archive

    with display() as shown:
        found = verify_archive(archive, lambda done, total, last: shown.count("runs", done, total, last))
    if as_json:
        document({"holds": found.holds, "changed": found.changed, "runs": found.runs})
    else:
        _print(found)
    raise typer.Exit(0 if found.holds else NO)


def _print(found: Verification) -> None:
    for name in found.changed:
        typer.echo(f"changed: {name}")
    for run in found.runs:
        reason = f": {run.reason}" if run.reason else ""
        typer.echo(f"{run.folder}: {run.outcome}, {run.steps} steps{reason}")
    if found.changed:
        typer.echo(f"{found.experiment}: not the files that were packed; nothing was run")
    else:
        verdict = typer.style("verified", fg="green") if found.holds else typer.style("differs", fg="red")
        typer.echo(f"{found.experiment}: {verdict}")
