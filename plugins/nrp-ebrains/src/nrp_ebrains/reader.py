"""Read a ``simulation_config.json`` as one of our experiments, and write it as one."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nrp_legacy.files import EMPTY_ROOM
from ruamel.yaml import YAML

from nrp_core.clock import NS_PER_MS, from_seconds
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Experiment, Place, Tree, experiment_of
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_ebrains.config import (
    GAZEBO,
    NEST,
    WHAT,
    Configuration,
    file_in,
    is_configuration,
    read_configuration,
)
from nrp_ebrains.maker import ConfigurationMaker

DURATION_S = 10.0
"""The duration of an experiment without a timeout."""
_USUAL_NS = 2 * NS_PER_MS
_STEP = re.compile(r"<max_step_size>\s*([0-9.eE+-]+)\s*</max_step_size>")
FILE = "experiment.yaml"


def read_json(path: Path, overrides: Sequence[str] = ()) -> Experiment:
    """Read an experiment of NRP-core 4, to run it unchanged.

    Args:
        path: the configuration.
        overrides: ``dotted.key=value`` of our own format.

    Raises:
        InvalidExperimentError: it is not valid, or needs something that is not supported.
    """
    path = path.resolve()
    if not is_configuration(path):
        message = f"this JSON file is not {WHAT}: it has no EngineConfigs"
        raise InvalidExperimentError([Finding(Code.NRP200, message, path=path)])
    configuration, source, notes = read_configuration(path)
    tree = _placed(_described(path, configuration), source.place)
    experiment = experiment_of(tree, overrides)
    return experiment.with_maker(ConfigurationMaker(path, configuration, notes)).with_overrides(overrides)


read_json.recognizes = is_configuration  # type: ignore[attr-defined] # most JSON files are something else


def _described(path: Path, configuration: Configuration) -> dict[str, Any]:
    """Return the contents of the file in the keys of our experiments."""
    folder, step_ns = path.parent, configuration.timestep_ns
    timeout_s = configuration.timeout_s or DURATION_S
    duration_ns = -(-from_seconds(timeout_s) // step_ns) * step_ns
    nest, gazebo = configuration.engines(*NEST), configuration.engines(*GAZEBO)
    model = file_in(folder, nest[0].NestInitFileName) if nest else path
    world: dict[str, Any] = {"backend": "mujoco", "scene": str(EMPTY_ROOM)}
    longest_ns = step_ns
    for engine in gazebo:
        scene = file_in(folder, engine.GazeboWorldFile)
        world["scene"], longest_ns = str(scene), _physics_step_ns(scene)
        world["robots"] = {
            one.Name: {"model": str(file_in(folder, one.File)), "pose": one.pose}
            for one in engine.GazeboSDFModels
        }
    world["options"] = {"timestep": f"{_divisor(step_ns, longest_ns)} ns"}
    return {
        "name": configuration.SimulationName or path.parent.name or "experiment",
        "description": configuration.SimulationDescription,
        "timestep": f"{step_ns} ns",
        "duration": f"{duration_ns} ns",
        "seed": gazebo[0].GazeboRNGSeed if gazebo else 0,
        "brain": {"backend": "event", "model": str(model)},
        "world": world,
        "strict": False,
        "models": [str(folder)],
    }


def _physics_step_ns(scene: Path) -> int:
    """Return the step of physics that a world file asks for; without one, that of the worlds here."""
    found = _STEP.search(scene.read_text("utf-8", errors="replace"))
    step_s = float(found[1]) if found else 0.0
    return from_seconds(step_s) if step_s > 0 else _USUAL_NS


def _divisor(period_ns: int, longest_ns: int) -> int:
    """Return the longest time that fits into a period without a rest and is not longer than another time."""
    parts = -(-period_ns // longest_ns)
    while period_ns % parts:
        parts += 1
    return period_ns // parts


def _placed(data: Any, place: Place) -> Tree:
    """Return data as a tree, all of it at the place of the file."""
    if isinstance(data, dict):
        return Tree({key: _placed(value, place) for key, value in data.items()}, place)
    if isinstance(data, list):
        return Tree([_placed(value, place) for value in data], place)
    return Tree(data, place)


def import_configuration(path: Path, output: Path, overrides: Sequence[str] = ()) -> dict[str, list[str]]:
    """Write an experiment of NRP-core 4 as a folder in our own format, with a copy of its files.

    Args:
        path: the configuration.
        output: the folder, which is made.
        overrides: as of :func:`read_json`; only checked.

    Returns:
        lists of notes by title.

    Raises:
        InvalidExperimentError: the configuration is not valid.
        ExperimentError: the folder is inside that of the experiment.
    """
    path = path.resolve()
    read_json(path, overrides)
    configuration, _, notes = read_configuration(path)
    if output.resolve().is_relative_to(path.parent):
        raise ExperimentError(f"the folder {output} is inside the experiment's own; name another")
    shutil.copytree(path.parent, output, dirs_exist_ok=True, ignore=_left_out)
    described = _relative(_described(path, configuration), str(path.parent))
    described["compatibility"] = {"platform": "nrp_core_4", "options": {"configuration": path.name}}
    yaml = YAML()
    yaml.default_flow_style = False
    with (output / FILE).open("w", encoding="utf-8") as file:
        yaml.dump(described, file)
    return {"notes": [str(note) for note in notes]}


def _left_out(folder: str, names: list[str]) -> set[str]:
    """Return the entries of a folder that are not copied: compiled code, versions, links out of it."""
    home = Path(folder).resolve()
    outside = {name for name in names if not (home / name).resolve().is_relative_to(home)}
    return outside | {"__pycache__", ".git"}.intersection(names)


def _relative(data: Any, folder: str) -> Any:
    """Return data with paths relative to a folder."""
    if isinstance(data, dict):
        return {key: _relative(value, folder) for key, value in data.items()}
    if isinstance(data, list):
        return [_relative(value, folder) for value in data]
    if isinstance(data, str) and data.startswith(folder):
        return data[len(folder) :].lstrip("/") or "."
    return data
