"""``nrp inspect``: describe and draw the contents of a file; its content decides its kind."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrp_core.cli.failure import complain
from nrp_core.cli.options import Json, Models, usage_errors
from nrp_core.cli.output import document

if TYPE_CHECKING:
    from nrp_core.world.scene.model import Model, Scene

PICTURES = (".png", ".jpg")
_BEGINNING = 4096  # bytes to search for the first element of an XML file
_ROOTS = ("sdf", "robot", "gazebo")
_SUFFIXES = (".sdf", ".world", ".urdf", ".xacro", ".zip")


def inspect(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            exists=True,
            help="A robot or room in SDF, URDF, xacro or a ZIP archive, transfer functions, or a recording.",
        ),
    ],
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            envvar="NRP_PICTURE",
            dir_okay=False,
            help="Also draw the scene into a .png or .jpg file.",
        ),
    ] = None,
    models: Models = None,
    json: Json = False,
) -> None:
    """Show the contents of a file of a robot, a room or transfer functions, or of a recording.

    For a robot or a room: links, joints, sensors, drives, topics, warnings. For transfer functions: the
    inputs, outputs and return values of each. For a recording: the experiment, the duration, the recorded
    topics, and whether it is complete.
    """
    from nrp_core.cli.commands.inspect_functions import are_functions, inspect_functions
    from nrp_core.cli.commands.inspect_recording import inspect_recording, is_recording

    if is_recording(file):
        inspect_recording(file, as_json=json)
        return
    if are_functions(file):
        inspect_functions(file, as_json=json)
        return
    if picture is not None:
        _check_picture(picture)
    if not _is_scene(file):
        from nrp_core.errors import ExperimentError

        raise ExperimentError(
            "not an SDF or URDF file, an archive of one, a file of transfer functions or a recording; "
            "to check an experiment, use nrp validate",
            path=file,
        )
    _inspect_scene(file, picture, models or [], as_json=json)


def _is_scene(file: Path) -> bool:
    """Return whether a file is an archive, or XML of a robot or a room, also in a plugin's format."""
    from zipfile import is_zipfile

    from nrp_core.world.scene.reading.formats import added_formats

    if file.is_dir():
        return False
    if file.suffix.lower() in _SUFFIXES:
        return True
    with file.open("rb") as opened:
        beginning = opened.read(_BEGINNING)
    roots = (*_ROOTS, *added_formats())
    return any(f"<{root}".encode() in beginning for root in roots) or is_zipfile(file)


def _inspect_scene(file: Path, picture: Path | None, models: list[Path], *, as_json: bool) -> None:
    from nrp_core.world.scene.outline import outline
    from nrp_core.world.scene.sdf import read_scene

    scene = read_scene(file, search_path=models, lenient=True)
    if picture is not None:
        _draw(scene, picture)
    if as_json:
        document({"file": file, "picture": picture, **_as_data(scene)})
        return
    for line in outline(scene, file.name).lines():
        typer.echo(line)
    for warning in scene.warnings:
        complain(warning, label="warning", color="yellow")


def _as_data(scene: Scene) -> dict[str, Any]:
    """Return all data about a scene; the keys are the field names of the scene's classes."""
    from nrp_core._support.jsonable import to_jsonable

    return {
        "gravity": scene.gravity,
        "models": [{**to_jsonable(model), "topics": _topics(model)} for model in scene.models],
        "lights": scene.lights,
        "warnings": scene.warnings,
        "digest": scene.digest,
    }


def _topics(model: Model) -> list[dict[str, str]]:
    from nrp_core.world.scene.outline import topics_of

    return [
        {"topic": topic.name, "direction": "listens" if topic.commands else "serves", "of": topic.of}
        for topic in topics_of(model)
    ]


def _check_picture(path: Path) -> None:
    with usage_errors("--picture"):
        if path.suffix.lower() not in PICTURES:
            raise ValueError(f"an image is a {' or '.join(PICTURES)} file, not '{path.name}'")
        if not path.absolute().parent.is_dir():
            raise ValueError(f"the folder {path.parent} does not exist")


def _draw(scene: Scene, path: Path) -> None:
    import cv2

    from nrp_core.world.render.portrait import portrait

    _, data = cv2.imencode(path.suffix, portrait(scene)[:, :, ::-1])
    path.write_bytes(data.tobytes())
