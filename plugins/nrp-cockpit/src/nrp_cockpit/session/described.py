"""The description of a run for the page: its parts and its capabilities."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from nrp_cockpit.session.groups import groups_data
from nrp_cockpit.streaming.weights import weights_data
from nrp_core import brains, worlds
from nrp_core.brain import WEIGHTS, Brain, SinkPort
from nrp_core.clock import seconds
from nrp_core.experiment import Run
from nrp_core.findings import refusals
from nrp_core.messages.base import type_name
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.network.data import Population
from nrp_core.recording.folder.recording_folder import lights_data, mounts_data, projection_data, views_data
from nrp_core.recording.layout import device_topic
from nrp_core.world import World
from nrp_core.world.topics import Direction, TopicInfo

MOST_POSITIONS = 5_000
"""Positions are not sent for larger populations."""


def run_data(run: Run, refused: Mapping[str, str]) -> dict[str, Any]:
    """Return the description of a run.

    Args:
        run: the run.
        refused: the capabilities that it has lost, with the reasons.
    """
    experiment, world = run.experiment, run.world
    return {
        "name": experiment.name,
        "file": str(experiment.source.place.path or ""),
        "brain": experiment.brain.backend,
        "world": experiment.world.backend,
        "seed": run.seed,
        "duration_s": seconds(experiment.duration),
        "timestep_s": seconds(experiment.timestep),
        "source": "live",
        "backends": {"brain": sorted(brains().names()), "world": sorted(worlds().names())},
        "capabilities": {**_capabilities(run), **refused},
        "topics": [
            *(topic_data(topic) for topic in world.topics.values() if topic.response is None),
            *weights_data(run.brain.network),
        ],
        "robots": list(experiment.world.robots),
        "populations": list(populations_data(run.brain)),
        "groups": groups_data(
            views_data(run.brain.network),
            {label: one.size for label, one in run.brain.network.populations.items()},
        ),
        "projections": [projection_data(each) for each in run.brain.network.projections],
        "devices": list(devices_data(run.brain)),
        "bodies": list(bodies_data(world, experiment.aliases)),
        "mounts": list(mounts_data(world)),
        "lights": lights_data(world.scene),
    }


def topic_data(topic: TopicInfo) -> dict[str, Any]:
    """Return the description of a topic; ``in``: the run subscribes to it."""
    return {
        "name": topic.name,
        "type": type_name(topic.type),
        "direction": "in" if topic.direction is Direction.IN else "out",
        "unit": topic.unit or None,
        "elements": list(topic.elements),
        "rate_hz": topic.rate_hz,
    }


def populations_data(brain: Brain) -> Iterator[dict[str, Any]]:
    """Yield the populations. Those that are driven are sensors, those that are read are actors."""
    read = _touched(brain, sinks=True)
    driven = _touched(brain, sinks=False)
    for label, population in brain.network.populations.items():
        ids = brain.network.ids_of(label)
        yield {
            "label": label,
            "size": population.size,
            "first": int(brain.network.offsets[label]),
            "cell": population.cell_type,
            "role": role_of(
                population.is_source, bool(np.isin(ids, driven).any()), bool(np.isin(ids, read).any())
            ),
            "positions": _positions(population),
            "placed": population.positions_um is not None,
        }


def devices_data(brain: Brain) -> Iterator[dict[str, Any]]:
    """Yield the devices that have a value."""
    for port in brain.devices:
        if port.quantity is None or not len(port.neurons):
            continue
        label, _ = brain.network.label_of(int(port.neurons[0]))
        yield {
            "name": port.name,
            "topic": device_topic(port.name, port.quantity),
            "population": label,
            "neurons": port.neurons.tolist(),
            "kind": "sink" if isinstance(port, SinkPort) else "source",
            "unit": port.unit,
        }


def bodies_data(world: World, aliases: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    """Yield the models of the scene with their topics; those that never move also with their pose."""
    for model in world.scene.models:
        topics = [name for name in world.topics if name.startswith(f"/{model.name}/")]
        colour, part = _colour_topic(world, topics, aliases)
        yield {
            "name": model.name,
            "static": model.static,
            "pose": asdict(model.pose) if model.static else None,
            "topics": topics,
            "colorable": colour,
            "colored_part": part,
        }


def _colour_topic(
    world: World, topics: list[str], aliases: Mapping[str, str]
) -> tuple[str | None, str | None]:
    """Return the topic that colours a model, preferably one with an alias, and the coloured visual."""
    colours = [name for name in topics if world.topics[name].type is ColorRGBA]
    if not colours:
        return None, None
    aliased = ((alias, name) for alias, name in aliases.items() if name in colours)
    topic, name = next(aliased, (colours[0], colours[0]))
    return topic, name.removeprefix("/").removesuffix("/color")


def _capabilities(run: Run) -> dict[str, bool | str]:
    brain, world = run.brain.capabilities, run.world.capabilities
    of_brain = f"the brain '{run.experiment.brain.backend}'"
    of_world = f"the world '{run.experiment.world.backend}'"
    savable: bool | str = True
    if not (brain.snapshot and world.snapshot):
        savable = f"{of_world if brain.snapshot else of_brain} {refusals.SNAPSHOTS}"
    return {
        "snapshot": savable,
        "step_back": savable,
        "weights": WEIGHTS in brain.changes or f"{of_brain} cannot change weights while it runs",
        "place": world.changes or f"{of_world} {refusals.MODEL_MOVES}",
        "push": world.joint_control or f"{of_world} {refusals.JOINT_CONTROL}",
    }


def role_of(is_source: bool, driven: bool, read: bool) -> str:
    """Return the role of a population by whether its neurons are driven and read from outside."""
    if is_source or (driven and not read):
        return "sensor"
    return "actor" if read and not driven else "circuit"


def _touched(brain: Brain, *, sinks: bool) -> np.ndarray[Any, Any]:
    found = [
        port.neurons
        for port in brain.devices
        if port.quantity is not None and isinstance(port, SinkPort) is sinks
    ]
    return np.concatenate(found) if found else np.empty(0, int)


def _positions(population: Population) -> list[list[float]] | None:
    positions = population.positions_um
    return None if positions is None or len(positions) > MOST_POSITIONS else positions.tolist()
