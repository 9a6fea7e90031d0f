"""``nrp diff``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import filterfalse
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import (
    Json,
    Models,
    Overrides,
    Overwrite,
    experiment_names,
    overrides_of,
    refuse_given,
    require_distinct,
    require_writable,
    usage_errors,
)
from nrp_core.cli.output import NO, complain, document

if TYPE_CHECKING:
    from rich.console import Console

    from nrp_lab.comparison.engine_verdict import EngineVerdict
    from nrp_lab.comparison.grid import RunGrid
    from nrp_lab.comparison.metric import Margins, Metric
    from nrp_lab.comparison.old_records import RecordsDiff
    from nrp_lab.comparison.result import GridDiff, PairDiff

RESULTS_SUFFIX = ".diff"
_OF_RUNS = (
    "brains",
    "worlds",
    "controls",
    "timesteps",
    "seeds",
    "vary",
    "overrides",
    "models",
    "results",
    "jobs",
)
"""Parameters that affect runs."""
_OF_ENGINES = ("engines", "baseline")

Brains = Annotated[
    str,
    typer.Option(metavar="A,B", envvar="NRP_BRAINS", help="Brain backends; by default the experiment's."),
]
Worlds = Annotated[
    str,
    typer.Option(
        metavar="X,Y",
        envvar="NRP_WORLDS",
        help="World backends, or all: every installed physics engine that can simulate the scene; "
        "by default the experiment's.",
    ),
]
Controls = Annotated[
    str,
    typer.Option(
        metavar="A,B",
        envvar="NRP_CONTROLS",
        help="Controls of the wiring, compared with the original: rewire, signs, weights, all of these, "
        "or 'silence: CELLS'.",
    ),
]
Jobs = Annotated[
    int | None, typer.Option(metavar="N", envvar="NRP_JOBS", min=1, help="Number of runs in parallel.")
]


def diff(
    context: typer.Context,
    experiment: Annotated[
        str,
        typer.Argument(
            metavar="EXPERIMENT",
            help="An experiment, as for nrp run; or the first of two recordings.",
            autocompletion=experiment_names,
        ),
    ],
    other: Annotated[
        Path | None,
        typer.Argument(
            metavar="DIR2",
            help="The second recording, or old records, a CSV file or a folder: compare without a run.",
        ),
    ] = None,
    brains: Brains = "",
    worlds: Worlds = "",
    controls: Controls = "",
    timesteps: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            envvar="NRP_TIMESTEPS",
            help="Steps of the loop, as '20 ms,10 ms,5 ms', compared with the finest.",
        ),
    ] = "",
    seeds: Annotated[
        int,
        typer.Option(
            metavar="N", envvar="NRP_SEEDS", min=1, help="Number of seeds, counted up from the experiment's."
        ),
    ] = 20,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW..HIGH",
            help="Draw a setting at random for each seed, e.g. 'events.go.at=4..8 s'; repeatable.",
        ),
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(
            metavar="METRIC=VALUE",
            help="Equivalence margin, in the metric's unit or as 2sd, for a METRIC or a "
            "METRIC/PART, or a measure of engines; for old records FILE or FILE/HEADER; repeatable.",
        ),
    ] = None,
    evidence: Annotated[
        bool,
        typer.Option(
            "--evidence",
            envvar="NRP_EVIDENCE",
            help="Is it the wiring? Run all controls, the decoder alone, and what --animal, --brains, "
            "--worlds and --timesteps name, and write a page (by default EXPERIMENT.evidence.html).",
        ),
    ] = False,
    animal: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            envvar="NRP_ANIMAL",
            help="With --evidence: a network file of another animal; repeatable.",
        ),
    ] = None,
    engines: Annotated[
        bool,
        typer.Option(
            "--engines", envvar="NRP_ENGINES", help="Fail if the engines differ, independent of the finding."
        ),
    ] = False,
    baseline: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            envvar="NRP_BASELINE",
            dir_okay=False,
            help="Known differences between the engines; only new ones count. Created if it does not exist.",
        ),
    ] = None,
    overrides: Overrides = None,
    models: Models = None,
    results: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            envvar="NRP_RESULTS",
            file_okay=False,
            help="Folder of the recorded runs; existing runs are reused.",
        ),
    ] = None,
    jobs: Jobs = None,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", envvar="NRP_HTML", dir_okay=False, help="Also write an HTML page."),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Report if a result depends on the simulator, the wiring or the time step; fail if it does or may."""
    from nrp_lab.commands.evidence import Request, write_evidence
    from nrp_lab.comparison.engine_measures import MEASURES, is_measure
    from nrp_lab.comparison.metric import Margins, all_metrics
    from nrp_lab.comparison.old_records import RecordsDiff, is_records, tolerances_of

    if other is not None:
        refuse_given(context, "two recordings are compared without a run; omit this option", _OF_RUNS)
        if Path(experiment).resolve() == other.resolve():
            raise typer.BadParameter("it is the first recording, which has no difference", param_hint="DIR2")
    require_writable(html, "--html", overwrite=overwrite)
    require_writable(baseline, "--baseline", overwrite=True)  # a file that exists is read, and left as it is
    require_distinct(vary or (), "--vary")
    require_distinct(margin or (), "--margin")
    if html is not None:
        from nrp_core.recording.figures import require_matplotlib

        with usage_errors("--html"):
            require_matplotlib()
    if other is not None and is_records(other):
        refuse_given(context, "old records are compared by their numbers; omit this option", _OF_ENGINES)
        with usage_errors("--margin"):
            tolerances = tolerances_of(margin or ())
        records = RecordsDiff.of(Path(experiment), other, tolerances)
        _report(records, html, as_json=json)
        raise typer.Exit(0 if records.agrees else NO)
    metrics = all_metrics()
    with usage_errors("--margin"):
        engine_margins = Margins.parse(filter(is_measure, margin or ()), MEASURES, in_sd=False)
        margins = Margins.parse(filterfalse(is_measure, margin or ()), metrics)
        if other is not None and margins.given:
            measures = ", ".join(measure.name for measure in MEASURES)
            raise ValueError(
                f"'{next(iter(margins.given))}' needs many seeds; two recordings have {measures}"
            )
    if other is not None:
        from nrp_lab.comparison.result import PairDiff

        pair = PairDiff.of(Path(experiment), other, metrics, engine_margins)
        name = str(pair.one.settings.get("name", "?"))
        pair = replace(pair, engines=_with_baseline(pair.engines, name, baseline))
        _report(pair, html, as_json=json)
        raise typer.Exit(
            0 if (pair.engines.agrees and not pair.flaws if engines else pair.is_identical) else NO
        )
    settings = overrides_of(overrides, brain=None, world=None, models=models)
    if evidence or animal:
        refuse_given(context, "the evidence is about the wiring; omit this option", _OF_ENGINES)
        others = {
            "animal": [str(path) for path in animal or ()],
            "brain": names(brains),
            "world": chosen_worlds(experiment, worlds),
            "timestep": names(timesteps),
        }
        request = Request(
            experiment, chosen_controls(controls), others, seeds, settings, vary or [], results, jobs, margins
        )
        page = html or _folder(experiment).with_suffix(".evidence.html")
        require_writable(page, "--html", overwrite=overwrite)
        raise typer.Exit(0 if write_evidence(request, page, as_json=json) else NO)
    grid = _grid(experiment, brains, worlds, controls, seeds, settings, vary or [], timesteps)
    if grid.compares_variants and (engines or baseline):
        raise typer.BadParameter(
            f"{'time steps' if grid.timesteps else 'wirings'} are compared on one brain and one world; omit "
            "this option",
            param_hint="--engines" if engines else "--baseline",
        )
    margins.require_possible(metrics, grid.load(grid.cells[0]))
    if baseline is not None and baseline.exists():
        from nrp_lab.comparison.engine_verdict import Baseline

        Baseline.read(baseline)  # before hours of runs
    found = _compared(grid, metrics, margins, engine_margins, results or _folder(experiment), jobs)
    found = replace(found, engines=_with_baseline(found.engines, found.name, baseline))
    _report(found, html, as_json=json)
    raise typer.Exit(0 if (found.engines.agrees if engines else found.answer.is_independent) else NO)


def _with_baseline(verdict: EngineVerdict, experiment: str, path: Path | None) -> EngineVerdict:
    """Mark the differences that the baseline contains; create a missing file with all of them."""
    from nrp_lab.comparison.engine_verdict import Baseline

    if path is None:
        return verdict
    if path.exists():
        return Baseline.read(path, experiment).applied(verdict)
    found = Baseline.of(experiment, verdict.differences)
    found.write(path)
    typer.echo(f"baseline of {len(found.known)} differences written to {path}", err=True)
    return found.applied(verdict)


def _grid(
    experiment: str,
    brains: str,
    worlds: str,
    controls: str,
    seeds: int,
    settings: list[str],
    vary: list[str],
    timesteps: str,
) -> RunGrid:
    from nrp_core.experiment import keyed_range
    from nrp_core.quantities import time_ns
    from nrp_lab.comparison.grid import RunGrid

    with usage_errors("--vary"):
        varied = dict(map(keyed_range, vary))
        if "seed" in varied:
            raise ValueError("every run has a seed of its own; their number is that of --seeds")
    wirings = chosen_controls(controls)
    with usage_errors("--timesteps"):
        steps = [step for step in names(timesteps) if time_ns(step)]
    grid = RunGrid.of(
        experiment, names(brains), chosen_worlds(experiment, worlds), seeds, settings, varied, wirings, steps
    )
    if len(grid.conditions) < 2:
        raise typer.BadParameter(
            "give two names to one of the first two options, a control to the third, or steps to the last",
            param_hint="--brains, --worlds, --controls, --timesteps",
        )
    return grid


def _compared(
    grid: RunGrid, metrics: list[Metric], margins: Margins, engine_margins: Margins, results: Path,
    jobs: int | None,
) -> GridDiff:  # fmt: skip
    from nrp_core.cli.progress import display
    from nrp_core.utilities import cores
    from nrp_lab.comparison.engine_verdict import NOT_COMPARED, compare_engines
    from nrp_lab.comparison.grid import run_grid
    from nrp_lab.comparison.result import GridDiff

    with display() as shown:
        runs = run_grid(
            grid, results, jobs or cores(), lambda done, total, last: shown.count("runs", done, total, last)
        )
        engines = NOT_COMPARED
        if not grid.compares_variants:
            shown.begin_task("running each engine on the inputs of another")
            engines = compare_engines(
                grid,
                results,
                engine_margins,
                lambda done, total, last: shown.count("engines", done, total, last),
            )
        shown.begin_task("comparing the runs")
        return GridDiff.of(grid, runs, metrics, margins, results, engines)


def _report(found: GridDiff | PairDiff | RecordsDiff, html: Path | None, *, as_json: bool) -> None:
    from rich.console import Console

    data, page, print_text = _forms(found)
    if html is not None:
        from nrp_core.utilities import replace_file

        replace_file(html, page(found))
    if as_json:
        document(data(found))
        return
    print_text(found, Console(highlight=False))
    if html is not None:
        typer.echo(f"written to {html}")


def _forms(
    found: GridDiff | PairDiff | RecordsDiff,
) -> tuple[Callable[[Any], Any], Callable[[Any], str], Callable[[Any, Console], None]]:
    from nrp_lab.comparison import report, report_page
    from nrp_lab.comparison.old_records import RecordsDiff
    from nrp_lab.comparison.result import GridDiff

    if isinstance(found, GridDiff):
        return report.grid_data, report_page.grid_page, report.print_grid
    if isinstance(found, RecordsDiff):
        return report.records_data, report_page.records_page, report.print_records
    return report.pair_data, report_page.pair_page, report.print_pair


def chosen_controls(text: str) -> tuple[str, ...]:
    """Return the controls that an option names.

    Raises:
        typer.BadParameter: no control, or several, have the name.
    """
    from nrp_lab.comparison.grid import WIRINGS, wiring_named

    with usage_errors("--controls"):
        return WIRINGS if text.strip() == "all" else tuple(map(wiring_named, names(text)))


def chosen_worlds(experiment: str, text: str) -> list[str]:
    """Return the worlds that an option names."""
    return installed_worlds(experiment) if text.strip() == "all" else names(text)


def installed_worlds(experiment: str) -> list[str]:
    """Return the physics engines on this machine that can simulate the scene of an experiment."""
    from nrp_core import worlds
    from nrp_core.errors import BackendError
    from nrp_core.experiment import load_experiment, scene_of
    from nrp_core.world import PhysicsBackend

    scene, found = scene_of(load_experiment(experiment)), []
    for name in worlds().names():
        try:
            backend = worlds().load(name)
        except BackendError as error:
            complain(f"left out: {error}", label="note")
            continue
        lacking = any(each.needed and not each.present for each in backend.diagnose())
        if isinstance(backend, PhysicsBackend) and not lacking:
            if missing := backend.capabilities(backend.options()).lacking_for(scene):
                complain(f"left out: {name} {missing}", label="note")
            else:
                found.append(name)
    return found


def names(text: str) -> list[str]:
    """Return the names in a list that is separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def _folder(experiment: str) -> Path:
    """Return the default folder of the results, in the current folder."""
    return Path(Path(experiment).resolve().name).with_suffix(RESULTS_SUFFIX)
