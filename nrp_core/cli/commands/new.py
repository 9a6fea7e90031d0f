"""``nrp new``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from nrp_core.cli.options import Json, Overwrite, usage_errors
from nrp_core.cli.output import document
from nrp_core.paths import check_free

NAME = re.compile(r"[a-z][a-z0-9]*([_-][a-z0-9]+)*")
TEMPLATES = Path(__file__).parents[1] / "templates" / "new"


class Subject(StrEnum):
    """The kinds of distribution."""

    BRAIN = "brain"
    WORLD = "world"
    EXPERIMENT = "experiment"
    SENSOR = "sensor"
    DEVICE = "device"


_GROUPS: Mapping[Subject, str] = {
    Subject.BRAIN: "nrp_core.brain",
    Subject.WORLD: "nrp_core.world",
    Subject.EXPERIMENT: "nrp_core.experiments",
    Subject.SENSOR: "nrp_core.sensors",
    Subject.DEVICE: "nrp_core.devices",
}
"""The entry-point groups."""


def new(
    subject: Annotated[Subject, typer.Argument(metavar="SUBJECT", help="The kind of distribution.")],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="The name for users, in lower case, e.g. acme.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="DIR", help="The new folder; by default nrp-SUBJECT-NAME."),
    ] = None,
    robot: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="A robot in URDF, SDF or xacro: an experiment in which it moves, instead of a package.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Create a distribution for your own brain, world, experiment, sensor or device.

    With --from, create the files of an experiment with a robot of your own: a brain, its wheels or joints, a
    lidar, a room with walls, and a criterion.
    """
    if not NAME.fullmatch(name):
        rule = "use lower-case letters, digits, '_' and '-', and begin with a letter"
        raise typer.BadParameter(f"'{name}' is not a valid name: {rule}", param_hint="NAME")
    if robot is not None:
        from nrp_core.cli.new_robot import robot_values

        if subject is not Subject.EXPERIMENT:
            raise typer.BadParameter(
                f"only an experiment is made of a robot, not a {subject}", param_hint="--from"
            )
        folder, templates = output or Path(name), TEMPLATES.with_name("robot")
        values = {"name": name, "package": "", **robot_values(robot)}
    else:
        _require_free(subject, name)
        folder, templates = output or Path(f"nrp-{subject}-{name.replace('_', '-')}"), TEMPLATES / subject
        values = dict(_values(subject, name))
    files = _write(folder, templates, values, overwrite=overwrite)
    if json:
        document({"folder": str(folder), "files": [str(file) for file in files]})
        return
    for file in files:
        typer.echo(f"created {folder / file}")
    typer.echo(f"next steps: {f'nrp run {folder}' if robot is not None else folder / 'README.md'}")


def _require_free(subject: Subject, name: str) -> None:
    from nrp_core.errors import ExperimentError
    from nrp_core.registry import Registry

    for provider in Registry[Any](_GROUPS[subject], subject).providers():
        if provider.name == name:
            raise ExperimentError(f"{provider} already provides the {subject} '{name}'; choose another name")


def _values(subject: Subject, name: str) -> Mapping[str, Any]:
    """Return the variables of the templates."""
    from importlib.metadata import version

    from nrp_core.brain.backend import BRAIN_INTERFACE_VERSION
    from nrp_core.world.backend import WORLD_INTERFACE_VERSION

    words = re.split("[_-]", name)
    distribution = "-".join(["nrp", subject, *words])
    return {
        "name": name,
        "distribution": distribution,
        "package": distribution.replace("-", "_"),
        "class_name": "".join(word.capitalize() for word in words),
        "core_version": version("nrp-core"),
        "interface_version": BRAIN_INTERFACE_VERSION if subject is Subject.BRAIN else WORLD_INTERFACE_VERSION,
    }


def _write(folder: Path, templates: Path, values: Mapping[str, Any], *, overwrite: bool) -> list[Path]:
    """Fill a new or empty folder and return its files."""
    import jinja2

    from nrp_core._support.files import writing

    with usage_errors("--output"):
        check_free(folder, overwrite=overwrite)
    loader = jinja2.FileSystemLoader(templates)
    environment = jinja2.Environment(
        loader=loader, undefined=jinja2.StrictUndefined, keep_trailing_newline=True,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    files = []
    with writing(folder):
        for source in environment.list_templates():
            file = Path(source.removesuffix(".j2").replace("__package__", values["package"]))
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(environment.get_template(source).render(values), "utf-8")
            files.append(file)
    return files
