"""The layout of a recording.

A recording is a folder::

    run.json         description of the run: versions, machine, seed, options; at the end its result
    recording.mcap   every message, in the encoding of ROS 2, stamped with simulated time
    experiment.yaml  the experiment with its overrides; ``nrp run`` takes the folder
    experiment/      the files that were used, with their relative paths
    csv/             the files of CSV recorders
"""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path

from nrp_core.errors import ExperimentError
from nrp_core.paths import check_free

MCAP_NAME = "recording.mcap"
RUN_NAME = "run.json"
FILES_FOLDER = "experiment"
CSV_FOLDER = "csv"
EXPERIMENT_NAME = "experiment.yaml"

RUNNING = "running"
"""State of a recording while its run continues, or after it was killed."""

SCENE = "/scene"
"""Topic of the visuals of the scene, as Foxglove's entities, in the frames of their links."""
TRANSFORMS = "/tf"
"""Topic of the poses of links that can move, in the frame of the world."""
MUSCLES = "/scene/muscles"
"""Topic of the muscles, as lines along their paths in the frame of the world, coloured by activation."""
WORLD_FRAME = "world"
MESH_TYPE = "model/stl"
"""Media type of the meshes in a recording."""
TEXTURED_TYPE = "model/gltf-binary"
"""Media type of shapes with an image on them."""
STEPS = "/nrp/steps"
"""Topic of the hash of every step; the step's messages are those since the previous hash."""
SNAPSHOTS = "/nrp/snapshots"
"""Topic of the complete state of the run, at intervals."""
PUBLISHED = "/nrp/published"
"""Topic of messages from outside the run."""
CALLED = "/nrp/called"
"""Topic of other calls from outside the run: replaced transfer functions, added models."""


class Images(StrEnum):
    """How camera images are recorded."""

    EXACT = "exact"
    """Lossless, so that a replay can compare every bit. The file is compressed: an image of a drawn scene,
    320x240, takes about 5 kB and is recorded faster than as JPEG; an image of noise takes 230 kB."""
    JPEG = "jpeg"
    """With small losses, as ``sensor_msgs/CompressedImage`` on ``<topic>/compressed``: for real cameras."""
    HASH = "hash"
    """Only a hash of each, on ``<topic>/hash``: a replay can compare its images."""
    OFF = "off"
    """Not at all."""


class Role(StrEnum):
    """The role of a topic in a recording, in the metadata of each channel."""

    SCENE = "scene"
    """The visuals of the room and the robots."""
    MODELS = "models"
    """Poses of the moving models, every step."""
    TRANSFORMS = "transforms"
    """Poses of the moving links, for viewers; they do not count as a result of the run."""
    MUSCLES = "muscles"
    """The paths and activations of muscles, for viewers; they do not count as a result of the run."""
    SENSOR = "sensor"
    """Sensor data of the world."""
    CAMERA = "camera"
    """Images."""
    PUBLISHED = "published"
    """Messages published by transfer functions, events and the user."""
    SPIKES = "spikes"
    """The spikes of a population."""
    VOLTAGE = "voltage"
    """Samples of membrane voltages."""
    SINK = "sink"
    """The value of a device that records neurons, whenever it changes."""
    SOURCE = "source"
    """The settings of a device that drives neurons, whenever they change."""
    RUN = "run"
    """Data of the platform to verify and continue a run."""


def spikes_topic(population: str) -> str:
    """Return the topic of a population's spikes."""
    return f"/brain/{population}/spikes"


def voltages_topic(population: str) -> str:
    """Return the topic of the membrane voltages of cells of a population or view."""
    return f"/brain/{population}/voltages"


def device_topic(device: str, quantity: str) -> str:
    """Return the topic of a device's value."""
    return f"/brain/devices/{device}/{quantity}"


_OF_GROUP = re.compile(r"(/brain/devices/.+)/(\d+)/([^/]+)")


def device_group(topic: str) -> tuple[str, str] | None:
    """Return the pattern of the topics of a group of devices, and the number of one in it; None: no group.

    ``nrp.map_neurons`` makes groups: ``/brain/devices/turn/rates/*/rate``.
    """
    found = _OF_GROUP.fullmatch(topic)
    return found and (f"{found[1]}/*/{found[3]}", found[2])


def compressed_topic(camera: str) -> str:
    """Return the topic of a camera's compressed images, by ROS's convention."""
    return f"{camera}/compressed"


def hash_topic(camera: str) -> str:
    """Return the topic of the hashes of a camera's images."""
    return f"{camera}/hash"


def check_folder(folder: Path, *, overwrite: bool = False) -> None:
    """Refuse a folder to record into that is not empty, unless it is a recording to be replaced.

    Raises:
        ExperimentError: the folder is a file, or not empty.
    """
    check_free(folder, overwrite=overwrite)
    is_recording = any((folder / name).is_file() for name in (MCAP_NAME, RUN_NAME))
    if not is_recording and (folder.is_file() or (folder.is_dir() and any(folder.iterdir()))):
        raise ExperimentError("only a recording is replaced, and this is something else", path=folder)
