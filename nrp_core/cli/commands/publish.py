"""``nrp publish``."""

from __future__ import annotations

from typing import Annotated

import typer

from nrp_core.cli.failure import NO, complain, report
from nrp_core.cli.options import Json, SocketPath, usage_errors
from nrp_core.cli.output import document


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
    from nrp_core.experiment.running.control import tell

    with usage_errors("VALUE"):
        given = parse_tree(value, Place()).plain()
    try:
        others = tell(socket, "publish", topic=topic, value=given)
    except ExperimentError as error:
        report(error, as_json=json)
        raise typer.Exit(NO) from None
    if json:
        document({"published": True, "topic": topic, "value": given, "functions": others})
    elif others:
        named = " and ".join(f"'{name}'" for name in others)
        complain(f"{named} also publish on {topic}; the next message replaces this one", label="note")
