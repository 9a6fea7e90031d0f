"""``nrp cockpit``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from enum import StrEnum
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
from nrp_core.cli.output import warn
from nrp_core.errors import ExperimentError

if TYPE_CHECKING:
    from nrp_cockpit.session.layout import Layout
    from nrp_cockpit.session.session import Session
    from nrp_cockpit.start.session import Served
    from nrp_cockpit.wire.hub import Hub

Shown = Annotated[
    str | None,
    typer.Argument(
        metavar="EXPERIMENT",
        envvar="NRP_EXPERIMENT",
        help="An installed experiment (nrp list), a YAML file or its folder, a recording, or a sweep; by "
        "default a start page with all of them.",
        autocompletion=experiment_names,
    ),
]


def cockpit(
    experiment: Shown = None,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    seed: Seed = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 takes any free one.")] = 0,
    host: Annotated[
        str,
        typer.Option(help="The address to listen on: 0.0.0.0 lets other machines connect with the token."),
    ] = "127.0.0.1",
    origin: Annotated[
        list[str] | None,
        typer.Option(metavar="URL", help="Allow pages of this origin to connect; repeatable."),
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    play: Annotated[bool, typer.Option("--play", help="Start without waiting for Play.")] = False,
    compare: Annotated[
        str | None,
        typer.Option(
            metavar="brain=NAME,world=NAME|RECORDING",
            help="Run the same experiment on other engines in lockstep; or show a second recording.",
        ),
    ] = None,
) -> None:
    """Watch and control a run in the browser, and go back in time; or show a recording or a sweep.

    Without a name, the page lists what it can open: installed experiments, and the experiments,
    recordings and sweeps in the current folder.

    The first line on standard output is the address of the page. Ctrl-C ends the run.
    """
    from nrp_cockpit.serving import Serving
    from nrp_cockpit.start.session import StartSession

    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed)

    def open_named(name: str, hub: Hub, stack: ExitStack) -> Served:
        kind = kind_of(name)
        if kind is None:
            return stack.enter_context(open_run(name, settings, hub, other=compared(compare)))
        if settings or (kind is Kind.SWEEP and (compare or play)):
            raise ExperimentError(f"{kind}: options of a run do not apply")
        return open_sweep(name, hub) if kind is Kind.SWEEP else open_recording(name, hub, compare)

    def opened(hub: Hub, stack: ExitStack) -> Served:
        if experiment is None:
            return StartSession(hub, open_named)
        return open_named(experiment, hub, stack)

    view = "start" if experiment is None else "sweep" if kind_of(experiment) is Kind.SWEEP else ""
    Serving(host, port, tuple(origin or ()), browser=browser, play=play, view=view).serve(opened)


def compared(given: str | None) -> dict[str, str]:
    """Return the other engines that ``--compare`` names, by side.

    Raises:
        ExperimentError: it does not name a brain or a world.
    """
    parts = [part.partition("=") for part in given.split(",")] if given is not None else []
    for side, _, name in parts:
        if side not in ("brain", "world") or not name:
            raise ExperimentError(
                f"--compare takes brain=NAME, world=NAME or both with a comma, not '{given}'"
            )
    return {side: name for side, _, name in parts}


class Kind(StrEnum):
    """What can be shown without a run, and why options of a run do not apply to it."""

    RECORDING = "a recording is played unchanged"
    SWEEP = "the runs of a sweep have ended or go on elsewhere"


def kind_of(path: str) -> Kind | None:
    """Return whether a path is the folder of a recording or a sweep; None: it is an experiment."""
    from nrp_lab.sweep.table import ABOUT

    from nrp_core.recording import RUN_NAME

    folder = Path(path)
    if (folder / RUN_NAME).is_file():
        return Kind.RECORDING
    return Kind.SWEEP if (folder / ABOUT).is_file() else None


def open_sweep(path: str, hub: Hub) -> Served:
    """Return a session that shows a sweep, and offer its services."""
    from nrp_cockpit.sweep.session import SweepSession

    return SweepSession(Path(path), hub)


def open_recording(path: str, hub: Hub, other: str | None = None) -> Session:
    """Return a session that plays a recording, and offer its services.

    Args:
        path: the folder of the recording.
        hub: the hub of the clients.
        other: the folder of a second recording beside it.
    """
    from nrp_cockpit.session.controls import layout_of_recording, services_of_recording
    from nrp_cockpit.session.recorded import RecordedSession
    from nrp_cockpit.session.recorded_beside import open_beside, with_beside
    from nrp_cockpit.sharing.services import with_sharing

    session = RecordedSession(Path(path), hub)
    services = with_beside(services_of_recording(session), session)
    hub.services = with_sharing(services, lambda: Path(path))
    if other is not None:
        open_beside(session, Path(other))
    _warn_of(layout_of_recording(session))
    return session


def _warn_of(layout: Layout) -> None:
    """Write the mistakes in a layout to standard error."""
    if problem := layout.load().get("problem"):
        warn(problem)


@contextmanager
def open_run(
    experiment: str,
    settings: list[str],
    hub: Hub,
    design: Path | None = None,
    other: Mapping[str, str] | None = None,
) -> Iterator[Session]:
    """Give a session with a run of an experiment, and offer its services.

    Args:
        experiment: its name, file or folder.
        settings: ``dotted.key=value``.
        hub: the hub of the clients.
        design: the model that the designer opens first; None: one of the experiment.
        other: the backends of a second run, by side.
    """
    from nrp_cockpit.designer.services import offer_services
    from nrp_cockpit.session.controls import layout_of
    from nrp_cockpit.session.live import LiveSession
    from nrp_cockpit.session.opening import Opening
    from nrp_core.cli.progress import display
    from nrp_core.experiment import load_experiment
    from nrp_core.recording import FilesRead
    from nrp_core.running import open_run as open_checked

    with ExitStack() as stack:
        with display() as shown:
            shown.begin_task("reading the experiment")
            files = stack.enter_context(FilesRead())
            run = stack.enter_context(open_checked(experiment, settings, progress=shown.begin_task))
            session = LiveSession(run, hub, files=files)
            opening = Opening(session, lambda more: load_experiment(experiment, [*settings, *more]))
            stack.callback(lambda: session.run.close())
            offer_services(opening, design)
            if other:
                shown.begin_task("opening the other engines")
                opening.compare(**other)
        _warn_of(layout_of(session))
        yield session
