"""Find the commands of the core and of other packages, run one, and turn errors into exit codes.

An entry point in ``nrp_core.commands`` names a function or a Typer app. A command is imported when it is
called; ``nrp --help`` imports those of this project and reads only the metadata of the others.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from difflib import get_close_matches
from functools import cached_property
from importlib import import_module
from inspect import getdoc
from typing import Annotated, Any, cast

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption
from typer.main import get_command

from nrp_core._support.files import regular_files_only
from nrp_core.cli.commands import COMMANDS
from nrp_core.cli.output import (
    complain,
    plain_streams,
    report,
    report_interrupt,
    report_usage,
    reserve_stdout,
)
from nrp_core.registry import OPTIONAL, Provider, Registry

_OURS = {"nrp-core", *OPTIONAL}
"""The distributions whose commands are described in the help text."""
_READERS = {"inspect", "explain", "validate", "map", "generate", "import-connectome"}
"""Commands that read the files of others, and execute nothing of them with the user's permissions."""
_ALIKE = 0.85
"""Minimum similarity, from 0 to 1, of a name and its misspelling."""

ADDED: Registry[Any] = Registry("nrp_core.commands", "command")
EXIT_CODES = (
    "Exit codes: 0 success; 1 negative result or failed run; 2 usage error; "
    "3 an experiment is not valid; 4 a backend is missing; 130 interrupted."
)
# typer vendors the base class of its errors and has moved it between versions
_UsageError = cast("type[Exception]", typer.BadParameter.__mro__[1])


class CommandGroup(TyperGroup):
    """The commands of the core and of all installed packages; those of the core cannot be replaced."""

    @cached_property
    def _added(self) -> dict[str, Provider]:
        return {one.name: one for one in ADDED.providers() if one.name not in COMMANDS}

    def list_commands(self, ctx: Any) -> list[str]:
        """Return all names: those of the core in their order, then the others by name."""
        return [*COMMANDS, *self._added]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a command and return it.

        Raises:
            BackendError: the package that adds the command is broken, or two packages add it.
        """
        if cmd_name not in self.commands:
            if cmd_name in COMMANDS:
                self.commands[cmd_name] = _command(cmd_name, core_function(cmd_name))
            elif cmd_name in self._added or ADDED.distribution_with(cmd_name):
                self.commands[cmd_name] = _command(cmd_name, ADDED.load(cmd_name))
            else:
                for name in COMMANDS:  # typer proposes one of those that are there
                    self.get_command(ctx, name)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that was called, and warn of misspelt environment variables of its options."""
        found = super().resolve_command(ctx, args)
        self._note_variables(os.environ)
        return found

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the command line.

        Raises:
            typer.Abort: Ctrl-C was pressed; Typer itself would end without a message.
        """
        try:
            return super().make_context(*arguments, **options)
        except KeyboardInterrupt:
            raise typer.Abort from None

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was called.

        Raises:
            typer.Abort: Ctrl-C was pressed, as when the command line is read.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise typer.Abort from None

    def _note_variables(self, variables: Mapping[str, str]) -> None:
        """Warn of each environment variable that resembles one of an option."""
        known = {
            str(one.envvar) for command in self.commands.values() for one in command.params if one.envvar
        }
        for name in variables:
            near = get_close_matches(name, known, n=1, cutoff=_ALIKE)
            if name.startswith("NRP_") and name not in known and near and near[0] not in variables:
                complain(f"{name} is not read; did you mean {near[0]}?", label="note")

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands for the help text."""
        ours = {name: core_function(name) for name in COMMANDS}
        ours |= {name: ADDED.load(name) for name, one in self._added.items() if one.distribution in _OURS}
        with formatter.section("Commands"):
            formatter.write_dl([(name, _summary(name, function)) for name, function in ours.items()])
        others = [
            (name, f"added by {_owner(added)}") for name, added in self._added.items() if name not in ours
        ]
        if others:
            with formatter.section("Commands of other packages"):
                formatter.write_dl(others)


class Command(TyperCommand):
    """A command that refuses a second value for an option that takes one, and the same value twice."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments.

        Raises:
            typer.BadParameter: an option that takes one value is given twice, or one value of another twice.
        """
        given = self.make_parser(ctx).parse_args(args=list(args))[2]
        for option in (each for each in self.params if isinstance(each, TyperOption)):
            repeatable = option.multiple or option.is_flag or option.count
            if not repeatable and given.count(option) > 1:
                raise typer.BadParameter("given twice, and it takes one value", ctx=ctx, param=option)
        rest = super().parse_args(ctx, args)
        for option in (each for each in self.params if isinstance(each, TyperOption) and each.multiple):
            values = ctx.params.get(str(option.name)) or ()
            if repeated := [one for place, one in enumerate(values) if one in values[:place]]:
                raise typer.BadParameter(f"'{repeated[0]}' is given twice", ctx=ctx, param=option)
        return rest

    def invoke(self, ctx: Any) -> Any:
        """Run the command; one that only reads files opens no pipes and devices, which would never end."""
        with regular_files_only() if self.name in _READERS else nullcontext():
            return super().invoke(ctx)


def _summary(name: str, function: Callable[..., None]) -> str:
    """Return the line about a command, without making its options."""
    return TyperCommand(name, help=getdoc(function)).get_short_help_str(120)


def _owner(provider: Provider) -> str:
    return f"{provider.package} ({provider.distribution} {provider.version})"


def core_function(name: str) -> Callable[..., None]:
    """Import a command of the core and return its function."""
    module = import_module(f"nrp_core.cli.commands.{COMMANDS[name]}")
    function: Callable[..., None] = getattr(module, name.replace("-", "_"))
    return function


def _command(name: str, found: Any) -> Any:
    if isinstance(found, typer.Typer):
        return get_command(found)
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(name, cls=Command)(found)
    return get_command(app)


def build_app() -> typer.Typer:
    """Return the application; its commands are found when they are called."""
    app = typer.Typer(cls=CommandGroup, rich_markup_mode=None, no_args_is_help=True, epilog=EXIT_CODES)
    app.callback()(nrp)
    return app


def run_app(arguments: Sequence[str]) -> int:
    """Run a command line and return its exit code; show a traceback only if asked for."""
    with plain_streams():
        return _run(arguments)


def _run(arguments: Sequence[str]) -> int:
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
