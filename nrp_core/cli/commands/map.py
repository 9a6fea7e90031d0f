"""``nrp map``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import (
    BrainName,
    ExperimentName,
    Json,
    Models,
    Overrides,
    Overwrite,
    Seed,
    Trust,
    overrides_of,
    require_writable,
)
from nrp_core.cli.output import complain, document

if TYPE_CHECKING:
    from nrp_core.brain.capabilities import Report, Table
    from nrp_core.experiment.reports import Account

TEMPLATE = "map.html.j2"
_NAME_WIDTH = 13
"""Minimum width of a name in columns of the terminal."""


def map(  # noqa: A001  the name of the command
    experiment: ExperimentName,
    brain: BrainName = None,
    overrides: Overrides = None,
    models: Models = None,
    seed: Seed = None,
    trust: Trust = False,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", envvar="NRP_HTML", dir_okay=False, help="Also write an HTML page."),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Report the resources that a brain backend needs for a network and the values that it changes.

    This executes the brain script, in a process without network that can write only temporary files. Where
    the system does not allow that (nrp doctor), it is not executed without --trust.
    """
    from nrp_core._support.confinement import trusting

    require_writable(html, "--html", overwrite=overwrite)
    with trusting(trust):
        account = _account(experiment, overrides, models, brain, seed)
    if html is not None:
        from nrp_core._support.files import replace_file

        replace_file(html, _page(account))
    if json:
        document(as_data(account))
    else:
        _print(account)


def as_data(account: Account) -> dict[str, Any]:
    """Return the reports as a dictionary."""
    return {
        "experiment": account.experiment,
        "brain": account.brain,
        "neurons": account.neurons,
        "synapses": account.synapses,
        "network_digest": account.digest,
        "reports": [report.as_dict() for report in account.reports],
    }


def _account(
    experiment: str, overrides: list[str] | None, models: list[Path] | None, brain: str | None,
    seed: int | None,
) -> Account:  # fmt: skip
    """Return the reports of the requested backend, the experiment's backend, or the only one with reports."""
    from nrp_core.checks.confined_network import build_confined
    from nrp_core.clock import seconds
    from nrp_core.errors import CapabilityError
    from nrp_core.experiment.reading.find import load_experiment
    from nrp_core.experiment.reports import account_of, reporting

    def of(name: str | None) -> Account:
        settings = overrides_of(overrides, brain=name, world=None, models=models, seed=seed)
        loaded = load_experiment(experiment, settings)
        limit_ns = loaded.brain.time_limit
        limit_s = None if limit_ns is None else seconds(limit_ns)
        return account_of(loaded, build=lambda make: build_confined(make, limit_s))

    try:
        return of(brain)
    except CapabilityError:
        others = reporting()
        if brain is not None or len(others) != 1:
            raise
    complain(
        f"the experiment's brain backend has no reports; these are of {others[0]}", label="note", color="blue"
    )
    return of(others[0])


def _page(account: Account) -> str:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("nrp_core.cli"),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(account=account)


def _print(account: Account) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=False)
    sizes = f"{account.neurons:,} neurons, {account.synapses:,} synapses"
    console.print(f"[bold]{account.experiment}[/bold] on {account.brain}: {sizes}")
    for report in account.reports:
        _print_report(console, report)


def _print_report(console: Any, report: Report) -> None:
    from rich.text import Text

    console.print()
    console.print(Text(report.title, style="bold underline"))
    if report.facts:
        console.print(Text(", ".join(f"{fact.quantity.title} {fact}" for fact in report.facts)))
    for table in report.tables:
        if table.rows and not table.is_detail:
            console.print(_rich_table(table))
    warnings = [warning.message for warning in report.warnings]
    for style, lines in (("red", warnings), ("yellow", report.advice), ("dim", report.notes)):
        for line in lines:
            console.print(Text(line, style=style))


def _rich_table(table: Table) -> Any:
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    drawn = RichTable(
        padding=(0, 1, 0, 0),
        pad_edge=False,
        title=table.title,
        title_justify="left",
        box=box.SIMPLE_HEAD,
        title_style="bold",
    )
    chosen = [index for index, column in enumerate(table.columns) if not column.is_detail]
    rows = table.cell_texts()
    for index in chosen:
        widest = max(len(row[index]) for row in rows)
        is_number = table.is_number(index)
        drawn.add_column(
            table.columns[index].title,
            justify="right" if is_number else "left",
            min_width=widest if is_number else min(widest, _NAME_WIDTH),
            overflow="fold",
        )
    for row in rows:
        drawn.add_row(*[Text(row[index]) for index in chosen])
    return drawn
