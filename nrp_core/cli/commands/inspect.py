"""``nrp inspect``: describe and draw the contents of a file; its content decides its kind."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.options import (
    Ignore,
    Json,
    Models,
    Overrides,
    Overwrite,
    Verbose,
    experiment_names,
    ignored_codes,
    overrides_of,
    refuse_given,
    usage_errors,
)
from nrp_core.cli.output import document
from nrp_core.paths import check_free

if TYPE_CHECKING:
    from nrp_core.scene.model import Model, Scene

IMAGES = (".png", ".jpg")
MAPS = (".svg", ".png")
_BEGINNING = 4096  # number of bytes that are searched for the first element of an XML file
_ROOTS = ("sdf", "robot", "gazebo")
_ARGS = "args."
_WORLD = "in the section 'world' of an experiment"
_SUFFIXES = (".sdf", ".world", ".urdf", ".xacro", ".zip")


def inspect(
    context: typer.Context,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="An experiment (its name or file), a robot or room in SDF, URDF, xacro or a ZIP archive, "
            "transfer functions, a brain script, a network file, or a recording.",
            autocompletion=experiment_names,
        ),
    ],
    image: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            envvar="NRP_IMAGE",
            dir_okay=False,
            help="Also draw the scene into a .png or .jpg file, or the map of a network into a .svg file.",
        ),
    ] = None,
    overrides: Overrides = None,
    models: Models = None,
    ignore: Ignore = None,
    verbose: Verbose = False,
    check: Annotated[
        bool,
        typer.Option("--check", help="Only check the integrity of a recording."),
    ] = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Show the contents of an experiment, a robot, a room, functions, a brain script or a recording.

    Nothing is executed. For an experiment: its files, backends, and the parameters of its scripts with their
    values, units and ranges. For a brain script: its parameters. For a robot or a room: links, joints,
    sensors, drives, topics, warnings. For transfer functions: the inputs, outputs and return values of each,
    and the parameters. For a recording: the experiment, the duration, the parameters, the recorded topics,
    and whether it is complete. For a network file: cells by group and sign, degrees, hubs, and how many
    synapses its groups are apart.
    """
    from nrp_core.cli.inspect_experiments import (
        are_functions,
        inspect_experiment,
        inspect_functions,
        is_experiment,
    )
    from nrp_core.cli.inspect_networks import inspect_network, is_network
    from nrp_core.cli.inspect_recordings import inspect_recording, is_recording

    if is_recording(file):
        why = "a recording has the settings of its run; omit this option"
        refuse_given(context, why, ("overrides", "models"))
    if check:
        _check(file, {"--image": image, "--models": models}, as_json=json)
    given = overrides_of(overrides, brain=None, world=None, models=models)
    if image is not None:
        _check_image(file, image, overwrite=overwrite)
    if is_network(file):
        refuse_given(context, "a network has no settings; omit this option", ("overrides", "models"))
        inspect_network(file, image, as_json=json)
        return
    if is_recording(file):  # first, because its folder holds the experiment, too
        inspect_recording(file, as_json=json, details=verbose)
        return
    if is_experiment(file):
        inspect_experiment(str(file), given, as_json=json)
        return
    if are_functions(file):
        inspect_functions(context, file, given, as_json=json)
        return
    if not _is_scene(file):
        from nrp_core.errors import ExperimentError

        raise ExperimentError(
            "not an experiment, an SDF or URDF file, an archive of one, transfer functions, a brain script "
            "or a recording",
            path=file,
        )
    args = _arguments(overrides or [])
    scene = _read(file, models or [], args, ignored_codes(ignore))
    _show(scene, file, image, as_json=json)
    if not json:
        _print_scene(scene, file, models or [], args, details=verbose)


def _is_scene(file: Path) -> bool:
    """Return whether a file is an archive, or XML of a robot or a room; plugins may add formats."""
    from zipfile import is_zipfile

    from nrp_core.scene.reading.context import added_formats

    if file.is_dir():
        return False
    if file.suffix.lower() in _SUFFIXES:
        return True
    with file.open("rb") as opened:
        beginning = opened.read(_BEGINNING)
    roots = (*_ROOTS, *added_formats())
    return any(f"<{root}".encode() in beginning for root in roots) or is_zipfile(file)


def _arguments(overrides: list[str]) -> dict[str, str]:
    """Return the arguments of a xacro file that ``-s args.NAME=VALUE`` gives."""
    given = {}
    for one in overrides:
        key, _, value = one.partition("=")
        if not key.strip().startswith(_ARGS) or "=" not in one:
            raise typer.BadParameter(
                f"of a robot or a room only the arguments of a xacro file are set, {_ARGS}NAME=VALUE, not "
                f"'{one}'",
                param_hint="--set",
            )
        given[key.strip().removeprefix(_ARGS)] = value
    return given


def _read(file: Path, models: list[Path], args: dict[str, str], ignored: list[str]) -> Scene:
    """Return the scene in a file, without unusable parts."""
    from dataclasses import replace
    from functools import partial

    from nrp_core.findings.problems import without as not_of
    from nrp_core.scene.reading.context import read_without
    from nrp_core.scene.sdf import read_scene

    read = partial(read_scene, file, search_path=models, lenient=True, args=args)
    scene, left_out = read_without(lambda without: read(without=without))
    return replace(scene, warnings=tuple(not_of((*scene.warnings, *left_out), ignored)))


def _show(scene: Scene, file: Path, image: Path | None, *, as_json: bool) -> None:
    if image is not None:
        _draw(scene, image)
    if as_json:
        document({"file": file, "image": image, **_as_data(scene)})


def _print_scene(
    scene: Scene, file: Path, models: list[Path], args: dict[str, str], *, details: bool
) -> None:
    from nrp_core.cli.summary import print_findings
    from nrp_core.scene.outline import outline

    for line in outline(scene, file.name).lines():
        typer.echo(line)
    for line in _open_joints(scene, file, models, args):
        typer.echo(line)
    print_findings(scene.warnings, details=details)


def _open_joints(scene: Scene, file: Path, models: list[Path], args: dict[str, str]) -> Iterator[str]:
    """Yield the lines to write for each robot whose joints take no commands."""
    from nrp_core.world.robot_setup import models_for, section_for, sensors_for, without_commands

    moving = [model for model in scene.models if not model.static]
    count = len(without_commands(moving[0])) if len(moving) == 1 else 0
    if count:
        joints = "1 joint takes" if count == 1 else f"{count} joints take"
        where = f"'{models_for(models)}' in an experiment, and in its section 'world'" if models else _WORLD
        yield f"{joints} no commands. To command joints, write {where}:"
        yield from (f"  {line}" for line in section_for(moving[0], str(file), args))
        if not any(link.sensors for link in moving[0].links):
            yield from (f"  {line}" for line in sensors_for(moving[0]))


def _as_data(scene: Scene) -> dict[str, Any]:
    """Return all data about a scene; the keys are the field names of the scene's classes."""
    from nrp_core._support.json_values import to_jsonable

    return {
        "gravity": scene.gravity,
        "models": [
            {**to_jsonable(model), "topics": _topics(model), "without_commands": _names(model)}
            for model in scene.models
        ],
        "lights": scene.lights,
        "warnings": [warning.to_dict() for warning in scene.warnings],
        "digest": scene.digest,
    }


def _names(model: Model) -> list[str]:
    from nrp_core.world.robot_setup import without_commands

    return [joint.name for joint in without_commands(model)]


def _topics(model: Model) -> list[dict[str, str]]:
    from nrp_core.scene.outline import topics_of

    return [
        {"topic": topic.name, "direction": "listens" if topic.commands else "serves", "of": topic.of}
        for topic in topics_of(model)
    ]


def _check(file: Path, others: Mapping[str, object], *, as_json: bool) -> None:
    from nrp_core.cli.inspect_recordings import check_recording, is_recording

    if not is_recording(file):
        raise typer.BadParameter(f"only a recording can be checked, not {file}", param_hint="--check")
    for name, value in others.items():
        if value:
            raise typer.BadParameter("it has no effect with --check", param_hint=name)
    check_recording(file, as_json=as_json)


def _check_image(file: Path, image: Path, *, overwrite: bool) -> None:
    from nrp_core.cli.inspect_experiments import are_functions, is_experiment
    from nrp_core.cli.inspect_networks import is_network
    from nrp_core.cli.inspect_recordings import is_recording

    kinds = MAPS if is_network(file) else IMAGES
    with usage_errors("--image"):
        if image.suffix.lower() not in kinds:
            raise ValueError(f"an image is a {' or '.join(kinds)} file, not '{image.name}'")
        if not image.absolute().parent.is_dir():
            raise ValueError(f"the folder {image.parent} does not exist")
        check_free(image, overwrite=overwrite)
        if is_experiment(file) or is_recording(file) or are_functions(file):
            raise ValueError(f"only a robot, a room or a network is drawn, not {file}")


def _draw(scene: Scene, path: Path) -> None:
    import cv2

    from nrp_core._support.files import replace_file
    from nrp_core.world.render.portrait import portrait

    _, data = cv2.imencode(path.suffix, portrait(scene)[:, :, ::-1])
    replace_file(path, data.tobytes())
