"""Assemble the commands, run one, and turn errors into messages and exit codes."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Annotated, cast

import typer

from nrp_core.cli.extensions import CommandGroup
from nrp_core.cli.failure import report, report_interrupt, report_usage
from nrp_core.cli.output import reserve_stdout

EXIT_CODES = (
    "Exit codes: 0 success; 1 negative result or failed run; 2 usage error; "
    "3 an experiment is not valid; 4 a backend is missing; 130 interrupted."
)

# typer vendors the base class of its errors and has moved it between versions
_UsageError = cast("type[Exception]", typer.BadParameter.__mro__[1])


def build_app() -> typer.Typer:
    """Return the application; its commands are found when they are called."""
    app = typer.Typer(cls=CommandGroup, rich_markup_mode=None, no_args_is_help=True, epilog=EXIT_CODES)
    app.callback()(nrp)
    return app


def run_app(arguments: Sequence[str]) -> int:
    """Run a command line and return its exit code; show a traceback only if asked for."""
    as_json = "--json" in arguments or _is_set("NRP_JSON")
    if as_json:
        reserve_stdout()
    try:
        return int(build_app()(args=list(arguments), prog_name="nrp", standalone_mode=False) or 0)
    except _UsageError as error:
        return report_usage(error, as_json=as_json)
    except typer.Abort:
        return report_interrupt(as_json=as_json)
    except Exception as error:  # noqa: BLE001  the last resort: one readable line instead of a traceback
        return report(error, as_json=as_json, debug=_is_set("NRP_DEBUG") or "--debug" in arguments)


def nrp(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            is_eager=True,
            callback=lambda value: _show_version(value),
            help="Show the version and exit.",
        ),
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", envvar="NRP_DEBUG", help="Show the traceback of an error.")
    ] = False,
) -> None:
    """Closed loops between spiking brains and simulated robots, with any simulator on either side."""


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"nrp-core {version('nrp-core')}")
        raise typer.Exit


def _is_set(variable: str) -> bool:
    return os.environ.get(variable, "").lower() not in ("", "0", "false", "no", "off")
