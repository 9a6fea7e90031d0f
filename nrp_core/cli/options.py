"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core._support.confinement import TRUST
from nrp_core.cli.output import complain, warn
from nrp_core.paths import check_free
from nrp_core.registry import Registry

if TYPE_CHECKING:
    from nrp_core.recording.recording import Recording


def _backend_option(side: str) -> Any:
    """Return the option that chooses a backend; shells complete it with the names that are installed."""
    return typer.Option(
        f"--{side}",
        metavar="NAME",
        envvar=f"NRP_{side.upper()}",
        help=f"The {side} backend to use.",
        autocompletion=beginning_with(Registry[Any](f"nrp_core.{side}", side).names),
    )


def beginning_with(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Return a function by which shells complete a word with one of these names."""
    return lambda incomplete: [name for name in names() if name.startswith(incomplete)]


def _experiments() -> list[str]:
    from nrp_core.experiment.reading.find import shipped

    return shipped()


experiment_names = beginning_with(_experiments)
"""Completes a word with the name of an installed experiment; shells themselves complete files."""

Json = Annotated[
    bool, typer.Option("--json", envvar="NRP_JSON", help="Write one JSON document to standard output.")
]
RecordingPath = Annotated[Path, typer.Argument(metavar="DIR", help="A folder made by nrp run --record.")]
ExperimentName = Annotated[
    str,
    typer.Argument(
        metavar="EXPERIMENT",
        envvar="NRP_EXPERIMENT",
        help="The name of an installed experiment (nrp list), a YAML file, or a folder with one.",
        autocompletion=experiment_names,
    ),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        envvar="NRP_SET",
        help="Override a value, e.g. -s 'world.options.timestep=1 ms'.",
    ),
]
BrainName = Annotated[str | None, _backend_option("brain")]
WorldName = Annotated[str | None, _backend_option("world")]
Models = Annotated[
    list[Path] | None,
    typer.Option(
        "--models",
        metavar="DIR",
        envvar="NRP_MODELS",
        exists=True,
        file_okay=False,
        help="A folder to search for models; repeatable.",
    ),
]
Ignore = Annotated[
    list[str] | None,
    typer.Option(
        "--ignore",
        metavar="CODE",
        envvar="NRP_IGNORE",
        help="Do not report warnings of this code; repeatable. In an experiment: checks.ignore.",
    ),
]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", envvar="NRP_VERBOSE", help="Print each problem instead of a count.")
]
Seed = Annotated[
    int | None, typer.Option("--seed", envvar="NRP_SEED", help="The seed of all random numbers.")
]
On = Annotated[
    str,
    typer.Option(
        metavar="local|dask|slurm|tcp://HOST:PORT", envvar="NRP_ON", help="Where the runs are performed."
    ),
]
Workers = Annotated[
    int | None, typer.Option(metavar="N", envvar="NRP_WORKERS", min=1, help="Number of runs at once.")
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        envvar=TRUST,
        help="Execute the scripts of the experiment unconfined, with your permissions.",
    ),
]
Overwrite = Annotated[
    bool,
    typer.Option("--overwrite", envvar="NRP_OVERWRITE", help="Replace files and folders that exist already."),
]
SHOW = "show"
FileOrShow = Annotated[
    str, typer.Argument(metavar="FILE|show", help="The file that describes the runs; or 'show' for results.")
]
ShownFolder = Annotated[Path | None, typer.Argument(metavar="DIR", help="The folder to show, after 'show'.")]
ResultsFolder = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="DIR",
        envvar="NRP_OUT",
        file_okay=False,
        help="The folder of the results; by default NAME.sweep of a sweep, NAME.evolve of a search.",
    ),
]
PlotFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", dir_okay=False, help="Draw a figure into a .png, .svg or .pdf file."),
]
SocketPath = Annotated[
    Path,
    typer.Argument(metavar="SOCKET", envvar="NRP_CONTROL", help="The socket of nrp run --control."),
]


def overrides_of(
    given: Sequence[str] | None,
    *,
    brain: str | None,
    world: str | None,
    models: Sequence[Path] | None = None,
    **values: object,
) -> list[str]:
    """Return all overrides in the form of ``--set``; a dedicated option wins over ``--set``, with a note."""
    folders = dumps([str(folder.absolute()) for folder in models]) if models else None
    named = {"brain.backend": brain, "world.backend": world, "models": folders, **values}
    options = [f"{key}={value}" for key, value in named.items() if value is not None]
    winners = {one.partition("=")[0]: one for one in options}
    last = {one.partition("=")[0].strip(): one for one in given or ()}
    for one in given or ():
        key = one.partition("=")[0].strip()
        if last[key] != one and key not in winners:
            complain(f"'-s {one}' has no effect: a later -s sets {last[key]}", label="note")
        winner = winners.get(key, one)
        if winner != one:
            complain(f"'-s {one}' has no effect: another option sets {winner}", label="note")
    return [*(given or ()), *options]


def ignored_codes(given: Sequence[str] | None) -> list[str]:
    """Return the codes of ``--ignore``.

    Raises:
        typer.BadParameter: one is not a code.
    """
    from nrp_core.errors import did_you_mean
    from nrp_core.findings import Code
    from nrp_core.findings.removed_codes import removed_in

    codes = [one.strip().upper() for one in given or ()]
    for code in codes:
        if code not in Code.__members__ and removed_in(code) is None:
            hint = did_you_mean(code, Code.__members__)
            raise typer.BadParameter(f"there is no code '{code}'{hint}", param_hint="--ignore")
    return codes


@contextmanager
def usage_errors(option: str) -> Iterator[None]:
    """Turn a ``ValueError`` into a usage error of an option."""
    try:
        yield
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=option) from error


def open_recording(folder: Path, use: str) -> Recording:
    """Open the recording of a command; warn if it is not complete.

    Args:
        folder: the first argument of the command.
        use: the use of its intact part, such as ``drawn``.

    Raises:
        typer.BadParameter: the folder is not a recording.
    """
    from nrp_core.recording.recording import Recording

    with usage_errors("DIR"):
        recording = Recording(folder)
    if not recording.complete:
        warn(
            f"the recording is truncated or damaged: only its intact beginning is {use}; "
            f"'nrp recover {folder}' also restores what follows the damage"
        )
    return recording


def time_s(text: str, option: str) -> float:
    """Return a time of 0 or more in seconds.

    Raises:
        typer.BadParameter: it is not one.
    """
    from nrp_core.clock import seconds
    from nrp_core.quantities import time_ns

    with usage_errors(option):
        t_ns = time_ns(text)
        if t_ns < 0:
            raise ValueError(f"must be 0 or more, not {text}")
        return seconds(t_ns)


def require_writable(file: Path | None, option: str, *, overwrite: bool) -> None:
    """Refuse an output file that cannot be written, before the long computation of its contents.

    Raises:
        typer.BadParameter: its folder does not exist, the path is a folder, or the file exists and is not to
            be replaced.
    """
    if file is not None and not file.absolute().parent.is_dir():
        raise typer.BadParameter(f"{file.parent}: the folder does not exist", param_hint=option)
    if file is not None and file.is_dir():
        raise typer.BadParameter(f"{file} is a folder", param_hint=option)
    if file is not None:
        with usage_errors(option):
            check_free(file, overwrite=overwrite)


def folder_to_show(
    context: typer.Context, target: str, folder: Path | None, used: Iterable[str]
) -> Path | None:
    """Return the folder that ``nrp COMMAND show DIR`` names, None if runs are asked for.

    Args:
        context: of the command.
        target: the first argument.
        folder: the second.
        used: names of the parameters that affect the output.

    Raises:
        typer.BadParameter: 'show' without a folder or with an option of runs, or a folder without 'show'.
    """
    if target == SHOW and folder is None:
        command = context.command.name
        raise typer.BadParameter(f"name the folder of the results: nrp {command} show DIR", param_hint="DIR")
    if target != SHOW and folder is not None:
        raise typer.BadParameter("only 'show' takes a folder; use --out for results", param_hint="DIR")
    if folder is not None:
        refuse_given(context, "it has no effect with 'show', which makes no run", but=("json", *used))
    return folder


def refuse_given(
    context: typer.Context, why: str, names: Iterable[str] | None = None, *, but: Iterable[str] = ()
) -> None:
    """Refuse options of the command line that have no effect on this call; variables of the environment may.

    Args:
        context: of the command.
        why: the message.
        names: names of the parameters that have none; by default all options.
        but: those that have an effect.

    Raises:
        typer.BadParameter: one of them is given.
    """
    options = {str(one.name): one for one in context.command.params if one.param_type_name == "option"}
    given = [
        max(options[name].opts, key=len)
        for name in (options if names is None else names)
        if name not in but
        and (source := context.get_parameter_source(name)) is not None
        and source.name == "COMMANDLINE"
    ]
    if given:
        raise typer.BadParameter(why, param_hint=", ".join(given))


def require_distinct(given: Iterable[str], option: str) -> None:
    """Refuse a second value for one key of a repeatable option KEY=VALUE.

    Raises:
        typer.BadParameter: a key is given twice.
    """
    keys: set[str] = set()
    for one in given:
        key = one.partition("=")[0].strip()
        if key in keys:
            raise typer.BadParameter(f"'{key}' is given twice, and takes one value", param_hint=option)
        keys.add(key)


def results_folder(out: Path | None, file: Path, command: str) -> Path:
    """Return the folder of results: the given one, or that of a file by default."""
    return out or Path(f"{file.stem}.{command}")
