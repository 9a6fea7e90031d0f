"""The section of an experiment file that gives a robot's joints commands, for a person to paste."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from nrp_core.world.fitting import commandable, without_commands
from nrp_core.world.scene.model import Joint, Model

_NONE: Final[Mapping[str, str]] = MappingProxyType({})
_PLAIN: Final = re.compile(r"(?:\.{1,2}/|[A-Za-z_/])[\w/.-]*")
_WORDS: Final = ("null", "true", "false", "yes", "no", "on", "off", "y", "n")
"""Words that some version of YAML takes for something else than a text."""


def section_for(model: Model, file: str, args: Mapping[str, str] = _NONE) -> Iterator[str]:
    """Yield the lines of an experiment file that give a robot's joints commands.

    Args:
        model: the robot.
        file: its file, as the experiment names it.
        args: the arguments that it was expanded with.
    """
    open_joints = without_commands(model)
    yield from ("robots:", f"  {_text(_identifier(model.name))}:", f"    model: {_text(file)}")
    if args:
        given = ", ".join(f"{_text(name)}: {json.dumps(value)}" for name, value in args.items())
        yield f"    args: {{{given}}}"
    yield "    control:"
    everything = {joint.name for joint in open_joints} == {joint.name for joint in commandable(model)}
    if everything and len({joint.kind == "continuous" for joint in open_joints}) == 1:
        yield f'      ".*": {{mode: {_mode(open_joints[0])}}}'
        return
    for joint in open_joints:
        yield f"      {_text(re.escape(joint.name))}: {{mode: {_mode(joint)}}}"


def models_for(folders: Iterable[Path]) -> str:
    """Return the line of an experiment file with the folders in which the parts of robots are searched."""
    return f"models: [{', '.join(_text(str(folder)) for folder in folders)}]"


def sensors_for(model: Model) -> Iterator[str]:
    """Yield lines, as comments in the section of a robot, that would give it sensors."""
    link = _text(model.links[0].name)
    image = "camera: {horizontal_fov: 1.2, image: {width: 160, height: 120}}"
    yield "    # add_sensors:"
    yield f"    #   - {{type: imu, link: {link}, rate: 100 Hz}}"
    yield f"    #   - {{type: camera, link: {link}, pose: [0.1, 0, 0.1, 0, 0, 0], {image}}}"


def _mode(joint: Joint) -> str:
    return "velocity" if joint.kind == "continuous" else "position"


def _text(text: str) -> str:
    """Return a text as YAML has it: as it is where YAML takes it for a text, else quoted."""
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if plain else json.dumps(text, ensure_ascii=False)


def _identifier(name: str) -> str:
    """Return a name as that of a robot in an experiment."""
    plain = re.sub(r"\W", "_", name)
    return plain if plain.isidentifier() else f"robot_{plain}"
