"""What is where in a recording.

A recording is a folder::

    run.json         what ran: versions, machine, seed, options; at the end the result
    recording.mcap   every message, in the encoding of ROS 2, stamped with simulated time
    experiment.yaml  the experiment as it was run, overrides and all: ``nrp run`` takes the folder
    experiment/      the files that were used, in their places relative to each other
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

from nrp_core.errors import ExperimentError

MCAP_NAME = "recording.mcap"
RUN_NAME = "run.json"
FILES_FOLDER = "experiment"
EXPERIMENT_NAME = "experiment.yaml"

SCENE = "/scene"
"""Topic of what there is to see, as markers: those of a model that moves lie in its own frame."""
WORLD_FRAME = "world"
STEPS = "/nrp/steps"
"""Topic of the hash of every step; the messages since the last one are those of the step."""
SNAPSHOTS = "/nrp/snapshots"
"""Topic of the complete state of the run, now and then."""
PUBLISHED = "/nrp/published"
"""Topic of what came from outside of the run."""
CALLED = "/nrp/called"
"""Topic of what else was done to the run from outside: transfer functions exchanged, models put in."""


class Pictures(StrEnum):
    """How camera pictures are recorded."""

    EXACT = "exact"
    """As they are, so that a replay sees every bit. The file is packed: a drawn scene of 320x240 takes some
    5 kB a picture and is recorded quicker than as JPEG; one full of noise takes 230 kB."""
    JPEG = "jpeg"
    """With small losses, as ``sensor_msgs/CompressedImage`` on ``<topic>/compressed``: for real cameras."""
    HASH = "hash"
    """Only a hash of each, on ``<topic>/hash``: a replay can tell whether it sees the same."""
    OFF = "off"
    """Not at all."""


class Role(StrEnum):
    """What a topic of a recording is; each channel of the file says it in its metadata."""

    SCENE = "scene"
    """The look of the room and the robots at the start."""
    MODELS = "models"
    """Where the moving models are, every step."""
    SENSOR = "sensor"
    """What the world gave."""
    CAMERA = "camera"
    """Pictures."""
    PUBLISHED = "published"
    """What somebody published: transfer functions, events, the user."""
    SPIKES = "spikes"
    """The spikes of a population."""
    SINK = "sink"
    """The value of a device that listens to neurons, whenever it changed."""
    SOURCE = "source"
    """The settings of a device that acts on neurons, whenever they changed."""
    RUN = "run"
    """What the platform itself needs to verify and continue a run."""


def spikes_topic(population: str) -> str:
    """Return the topic of a population's spikes."""
    return f"/brain/{population}/spikes"


def device_topic(device: str, quantity: str) -> str:
    """Return the topic of a device's value."""
    return f"/brain/devices/{device}/{quantity}"


def compressed_topic(camera: str) -> str:
    """Return the topic of a camera's compressed pictures, named as ROS names it."""
    return f"{camera}/compressed"


def hash_topic(camera: str) -> str:
    """Return the topic of the hashes of a camera's pictures."""
    return f"{camera}/hash"


def check_folder(folder: Path) -> None:
    """Refuse to record where something is already.

    Raises:
        ExperimentError: the folder is a file, or holds something.
    """
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise ExperimentError("there is something already; a recording begins in a new folder", path=folder)
