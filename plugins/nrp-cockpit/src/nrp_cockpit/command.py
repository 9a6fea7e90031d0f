"""``nrp cockpit``."""

from __future__ import annotations

import sys
import webbrowser
from contextlib import ExitStack
from typing import Annotated

import typer

from nrp_core.cli.options import BrainName, ExperimentName, Models, Overrides, Seed, WorldName, overrides_of


def cockpit(
    experiment: ExperimentName,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    seed: Seed = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 takes any free one.")] = 0,
    host: Annotated[
        str, typer.Option(help="The address to listen on; others than this machine's own need the token too.")
    ] = "127.0.0.1",
    origin: Annotated[
        list[str] | None,
        typer.Option(metavar="URL", help="Let pages of this origin connect; repeatable."),
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    play: Annotated[bool, typer.Option("--play", help="Do not wait for somebody to press Play.")] = False,
) -> None:
    """See a run in the browser, steer it, and go back in time.

    The first line on standard output is the address of the page. Ctrl-C ends the run.
    """
    from nrp_cockpit.session.controls import services_of
    from nrp_cockpit.session.live import LiveSession
    from nrp_cockpit.wire.guard import LOOPBACK, Guard
    from nrp_cockpit.wire.hub import Hub
    from nrp_cockpit.wire.server import Server
    from nrp_core.cli.progress import display
    from nrp_core.experiment.reading.find import load_experiment
    from nrp_core.experiment.running.run import Run

    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed)
    hosts = LOOPBACK if host in ("127.0.0.1", "localhost", "::1") else ()
    guard, hub = Guard(hosts, tuple(origin or ())), Hub()
    with ExitStack() as stack:
        with display() as shown:
            shown.begin_task("reading the experiment")
            run = stack.enter_context(Run(load_experiment(experiment, settings), shown.begin_task))
        session = LiveSession(run, hub)
        hub.services = services_of(session)
        server = Server(hub, host=host, port=port, guard=guard)
        stack.callback(server.close)
        where = "127.0.0.1" if host in ("0.0.0.0", "localhost") else f"[{host}]" if ":" in host else host
        address = f"http://{where}:{server.port}/?token="
        typer.echo(f"{address}{guard.token}")
        typer.echo(f"to watch only: {address}{guard.watch_token}", err=True)
        sys.stdout.flush()
        if browser:
            webbrowser.open(f"{address}{guard.token}")
        if play:
            session.play()
        try:
            session.serve()
        except KeyboardInterrupt:
            session.close()
