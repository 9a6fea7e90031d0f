"""``nrp design``."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrp_core.cli.options import BrainName, Models, Overrides, Seed, WorldName, experiment_names, overrides_of
from nrp_core.errors import ExperimentError

if TYPE_CHECKING:
    from nrp_cockpit.session.session import Session
    from nrp_cockpit.wire.hub import Hub

_FILES = (".bibi", ".py")


def design(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            help="A BIBI model, which need not exist yet; Python with transfer functions; or an experiment.",
        ),
    ] = ".",
    experiment: Annotated[
        str | None,
        typer.Option(
            "--experiment",
            "-e",
            help="The experiment that the model is for; by default the one in its folder.",
            autocompletion=experiment_names,
        ),
    ] = None,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    models: Models = None,
    seed: Seed = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 takes any free one.")] = 0,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
) -> None:
    """Draw transfer functions as boxes and wires in the browser, and run them there.

    The first line on standard output is the address of the page. Ctrl-C ends it.
    """
    from nrp_cockpit.command import open_run
    from nrp_cockpit.serving import Serving

    settings = overrides_of(overrides, brain=brain, world=world, models=models, seed=seed)
    model, name, more = wanted(file, experiment)

    def opened(hub: Hub, stack: ExitStack) -> Session:
        return stack.enter_context(open_run(name, [*more, *settings], hub, model))

    Serving(host, port, browser=browser, view="designer").serve(opened)


def wanted(file: str, experiment: str | None) -> tuple[Path | None, str, list[str]]:
    """Return the model to draw, its experiment, and the overrides of the experiment.

    A model that the experiment does not name replaces all its transfer functions.

    Raises:
        ExperimentError: no experiment uses the file.
    """
    from nrp_core.experiment import load_experiment

    path = Path(file).absolute()
    if path.suffix not in _FILES:
        if experiment is not None:
            raise ExperimentError(f"'{file}' is not a model; the name of a model ends in .bibi")
        return None, file, []
    if not path.parent.is_dir():
        raise ExperimentError("its folder does not exist", path=path)
    name = experiment or _beside(path)
    if path in load_experiment(name).transfer_functions:
        return path, name, []
    given = [str(path)] if path.suffix == ".bibi" and path.exists() else []
    return path, name, [f"transfer_functions={given}"]


def _beside(path: Path) -> str:
    """Return the experiment in a model's folder that names the model, or else the only one there."""
    from nrp_core.errors import NrpError
    from nrp_core.experiment import READERS, find_file, load_experiment

    for file in sorted(one for one in path.parent.iterdir() if one.suffix in READERS.names()):
        try:
            if path in load_experiment(file).transfer_functions:
                return str(file)
        except NrpError:  # a broken neighbour cannot be the experiment
            continue
    try:
        return str(find_file(str(path.parent)))
    except ExperimentError as error:
        raise ExperimentError(f"{error.message}; name one: --experiment", path=path) from None
