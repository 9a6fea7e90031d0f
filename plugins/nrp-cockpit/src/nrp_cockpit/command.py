"""``nrp cockpit``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import (
    BrainName,
    Models,
    Overrides,
    Seed,
    WorldName,
    experiment_names,
    overrides_of,
)
from nrp_core.errors import ExperimentError

if TYPE_CHECKING:
    from nrp_cockpit.session.session import Session
    from nrp_cockpit.wire.hub import Hub

Shown = Annotated[
    str,
    typer.Argument(
        metavar="EXPERIMENT",
        envvar="NRP_EXPERIMENT",
        help="The name of an installed experiment (nrp list), a YAML file or its folder, or a recording.",
        autocompletion=experiment_names,
    ),
]


def cockpit(
    experiment: Shown,
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
    """See a run in the browser, steer it, and go back in time; or play a recording there.

    The first line on standard output is the address of the page. Ctrl-C ends the run.
    """
    from nrp_cockpit.serving import Serving

    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed)

    def opened(hub: Hub, stack: ExitStack) -> Session:
        if not is_recording(experiment):
            return stack.enter_context(open_run(experiment, settings, hub))
        if brain or world or overrides or seed is not None:
            raise ExperimentError("a recording is played as it was made: no option changes it")
        return open_recording(experiment, hub)

    Serving(host, port, tuple(origin or ()), browser=browser, play=play).serve(opened)


def is_recording(path: str) -> bool:
    """Return whether a path is the folder of a recording; else it leads to an experiment."""
    from nrp_core.recording.layout import RUN_NAME

    return (Path(path) / RUN_NAME).is_file()


def open_recording(path: str, hub: Hub) -> Session:
    """Return a session that plays a recording, and offer its services."""
    from nrp_cockpit.session.controls import services_of_recording
    from nrp_cockpit.session.recorded import RecordedSession

    session = RecordedSession(Path(path), hub)
    hub.services = services_of_recording(session)
    return session


@contextmanager
def open_run(experiment: str, settings: list[str], hub: Hub, design: Path | None = None) -> Iterator[Session]:
    """Give a session with a run of an experiment, and offer its services.

    Args:
        experiment: as people name it.
        settings: ``dotted.key=value``.
        hub: of the clients.
        design: the model that the designer begins with; None: one of the experiment.
    """
    from nrp_cockpit.designer.services import with_designer
    from nrp_cockpit.session.controls import services_of
    from nrp_cockpit.session.live import LiveSession
    from nrp_core.cli.progress import display
    from nrp_core.experiment.reading.find import load_experiment
    from nrp_core.experiment.running.run import Run

    with ExitStack() as stack:
        with display() as shown:
            shown.begin_task("reading the experiment")
            run = stack.enter_context(Run(load_experiment(experiment, settings), shown.begin_task))
        session = LiveSession(run, hub)
        hub.services = with_designer(services_of(session), session, design)
        yield session
