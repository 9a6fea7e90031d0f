"""Find the commands: those of the core, and those that other packages add.

An entry point in ``nrp_core.commands`` names a function or a Typer app. A command is imported when it is
called; ``nrp --help`` imports those of this project and reads only the metadata of the others.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cached_property
from importlib import import_module
from inspect import getdoc
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption
from typer.main import get_command

from nrp_core.cli.commands import COMMANDS
from nrp_core.cli.failure import complain
from nrp_core.registry import OPTIONAL, Provider, Registry

_OURS = {"nrp-core", *OPTIONAL}
"""The distributions whose commands are described in the help text."""
_ALIKE = 0.85
"""Minimum similarity, from 0 to 1, of a name and its misspelling."""

ADDED: Registry[Any] = Registry("nrp_core.commands", "command")


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


def _summary(name: str, function: Callable[..., None]) -> str:
    """Return the line about a command, without making its options."""
    return TyperCommand(name, help=getdoc(function)).get_short_help_str(120)


def _owner(provider: Provider) -> str:
    return f"{provider.package} ({provider.distribution} {provider.version})"


def core_function(name: str) -> Callable[..., None]:
    """Import a command of the core and return its function."""
    function = name.replace("-", "_")
    found: Callable[..., None] = getattr(import_module(f"nrp_core.cli.commands.{function}"), function)
    return found


def _command(name: str, found: Any) -> Any:
    if isinstance(found, typer.Typer):
        return get_command(found)
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(name, cls=Command)(found)
    return get_command(app)
