"""``nrp publish`` and ``nrp functions``: change a run that was started with ``--control``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from nrp_core.cli.options import Json, SocketPath, usage_errors
from nrp_core.cli.output import NO, complain, document, report


def functions(
    socket: SocketPath,
    add: Annotated[
        list[Path] | None,
        typer.Option(
            "--add",
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="Add the functions of a file; each replaces the function of the same name.",
        ),
    ] = None,
    remove: Annotated[
        list[str] | None, typer.Option("--remove", metavar="NAME", help="Remove a function.")
    ] = None,
    activate: Annotated[
        list[str] | None, typer.Option("--activate", metavar="NAME", help="Resume a function.")
    ] = None,
    deactivate: Annotated[
        list[str] | None, typer.Option("--deactivate", metavar="NAME", help="Pause a function.")
    ] = None,
    json: Json = False,
) -> None:
    """List or change the transfer functions of a run that was started with --control SOCKET."""
    from nrp_core.errors import ExperimentError
    from nrp_core.experiment.running.control import send_command

    try:
        found: list[dict[str, Any]] = send_command(
            socket, "functions", add=[str(path.absolute()) for path in add or ()],
            remove=_given(remove), activate=_given(activate), deactivate=_given(deactivate),
        )  # fmt: skip
    except ExperimentError as error:
        report(error, as_json=json)
        raise typer.Exit(NO) from None
    if json:
        document({"functions": found})
        return
    for one in found:
        state = "active" if one["active"] else "failed" if one["failure"] else "paused"
        typer.echo(f"{one['name']}  {state}  {one['flow']}, {one['place']}")


def _given(names: Sequence[str] | None) -> list[str]:
    return list(names or ())


def publish(
    socket: SocketPath,
    topic: Annotated[str, typer.Argument(metavar="TOPIC", help="A topic of the run, or an alias.")],
    value: Annotated[
        str, typer.Argument(metavar="VALUE", help="The value in YAML: red, 0.5, '{linear: {x: 1}}'.")
    ],
    json: Json = False,
) -> None:
    """Publish a message in a run that was started with --control SOCKET."""
    from nrp_core.errors import ExperimentError
    from nrp_core.experiment.model.section import Place
    from nrp_core.experiment.reading.yaml_tree import parse_tree
    from nrp_core.experiment.running.control import send_command

    with usage_errors("VALUE"):
        given = parse_tree(value, Place()).plain()
    try:
        others = send_command(socket, "publish", topic=topic, value=given)
    except ExperimentError as error:
        report(error, as_json=json)
        raise typer.Exit(NO) from None
    if json:
        document({"published": True, "topic": topic, "value": given, "functions": others})
    elif others:
        named = " and ".join(f"'{name}'" for name in others)
        complain(f"{named} also publish on {topic}; the next message replaces this one", label="note")
