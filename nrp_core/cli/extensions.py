"""Commands that other packages add: an entry point in ``nrp_core.commands`` names a function or a Typer app.

For ``nrp --help`` only the metadata is read; a command is imported when it is called.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from nrp_core.registry import Provider, Registry

COMMANDS: Registry[Any] = Registry("nrp_core.commands", "command")


class CommandGroup(TyperGroup):
    """The commands of the core and of all installed packages; the core's cannot be replaced."""

    @cached_property
    def _added(self) -> dict[str, Provider]:
        return {one.name: one for one in COMMANDS.providers() if one.name not in self.commands}

    def list_commands(self, ctx: Any) -> list[str]:
        """Return all names: the core's in their order, then the others by name."""
        return [*self.commands, *self._added]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, importing it if it is not the core's.

        Raises:
            BackendError: the package that adds it is broken, or two packages add it.
        """
        if cmd_name in self._added and cmd_name not in self.commands:
            self.commands[cmd_name] = _load(cmd_name)
        return super().get_command(ctx, cmd_name)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was called.

        Raises:
            typer.Abort: Ctrl-C; typer itself would end without a word.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise typer.Abort from None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands for the help text."""
        rows = [(name, command.get_short_help_str(120)) for name, command in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
        others = [(name, f"added by {_owner(added)}") for name, added in self._added.items()]
        if others:
            with formatter.section("Commands of other packages"):
                formatter.write_dl(others)


def _owner(provider: Provider) -> str:
    return f"{provider.package} ({provider.distribution} {provider.version})"


def _load(name: str) -> Any:
    found = COMMANDS.load(name)
    if isinstance(found, typer.Typer):
        return get_command(found)
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(name)(found)
    return get_command(app)
