"""The layout of a recording.

A recording is a folder::

    run.json         what ran: versions, machine, seed, options; at the end the result
    recording.mcap   every message, in the encoding of ROS 2, stamped with simulated time
    experiment.yaml  the experiment as it was run, overrides and all: ``nrp run`` takes the folder
    experiment/      the files that were used, in their places relative to each other
    csv/             the files of CSV recorders
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

from nrp_core.errors import ExperimentError

MCAP_NAME = "recording.mcap"
RUN_NAME = "run.json"
FILES_FOLDER = "experiment"
CSV_FOLDER = "csv"
EXPERIMENT_NAME = "experiment.yaml"

RUNNING = "running"
"""State of a recording whose run goes on, or was killed; else how it ended."""

SCENE = "/scene"
"""Topic of the look of the scene, as Foxglove's entities, in the frames of the links that they move with."""
TRANSFORMS = "/tf"
"""Topic of the poses of links that can move, in the frame of the world."""
WORLD_FRAME = "world"
MESH_TYPE = "model/stl"
"""Media type of the meshes in a recording."""
STEPS = "/nrp/steps"
"""Topic of the hash of every step; the messages since the last one are those of the step."""
SNAPSHOTS = "/nrp/snapshots"
"""Topic of the complete state of the run, at intervals."""
PUBLISHED = "/nrp/published"
"""Topic of messages from outside the run."""
CALLED = "/nrp/called"
"""Topic of other calls from outside the run: transfer functions exchanged, models added."""


class Images(StrEnum):
    """How camera images are recorded."""

    EXACT = "exact"
    """As they are, so that a replay sees every bit. The file is packed: a drawn scene of 320x240 takes some
    5 kB an image and is recorded quicker than as JPEG; one full of noise takes 230 kB."""
    JPEG = "jpeg"
    """With small losses, as ``sensor_msgs/CompressedImage`` on ``<topic>/compressed``: for real cameras."""
    HASH = "hash"
    """Only a hash of each, on ``<topic>/hash``: a replay can compare its images."""
    OFF = "off"
    """Not at all."""


class Role(StrEnum):
    """The role of a topic in a recording, in the metadata of each channel."""

    SCENE = "scene"
    """The look of the room and the robots at the start."""
    MODELS = "models"
    """Poses of the moving models, every step."""
    TRANSFORMS = "transforms"
    """Where the moving links are, for viewers; it does not count as a result of the run."""
    SENSOR = "sensor"
    """Sensor data of the world."""
    CAMERA = "camera"
    """Images."""
    PUBLISHED = "published"
    """Messages published by transfer functions, events and the user."""
    SPIKES = "spikes"
    """The spikes of a population."""
    SINK = "sink"
    """The value of a device that listens to neurons, whenever it changed."""
    SOURCE = "source"
    """The settings of a device that acts on neurons, whenever they changed."""
    RUN = "run"
    """Data of the platform to verify and continue a run."""


def spikes_topic(population: str) -> str:
    """Return the topic of a population's spikes."""
    return f"/brain/{population}/spikes"


def device_topic(device: str, quantity: str) -> str:
    """Return the topic of a device's value."""
    return f"/brain/devices/{device}/{quantity}"


def compressed_topic(camera: str) -> str:
    """Return the topic of a camera's compressed images, named as ROS names it."""
    return f"{camera}/compressed"


def hash_topic(camera: str) -> str:
    """Return the topic of the hashes of a camera's images."""
    return f"{camera}/hash"


def check_folder(folder: Path) -> None:
    """Refuse a folder that is not empty.

    Raises:
        ExperimentError: the folder is a file, or not empty.
    """
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise ExperimentError("there is something already; a recording begins in a new folder", path=folder)
