"""Rooms and experiments in files of the laboratory's own, and recordings in a format of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from nrp_core.errors import SceneError
from nrp_core.experiment import Experiment, load_experiment
from nrp_core.recording import Exporter, Numbers, Recording
from nrp_core.xml import read_xml

ROOM = """<sdf version="1.9"><world name="room"><gravity>0 0 0</gravity>
<model name="wall"><static>true</static><pose>{distance} 0 0 0 0 0</pose><link name="body">
<collision name="body"><geometry><box><size>0.1 2 2</size></box></geometry></collision></link></model>
</world></sdf>"""


def read_room(path: Path) -> tuple[str, list[str]]:
    """Return the room of ``<acme_room wall="5"/>`` in SDF, and warnings."""
    return ROOM.format(distance=read_xml(path, kind=SceneError).attribute("wall")), []


def read_patrol(path: Path, overrides: Sequence[str] = ()) -> Experiment:
    """Return the patrol with the duration that a file holds."""
    return load_experiment("acme_patrol", [f"duration={path.read_text().strip()}", *overrides])


def import_patrol(path: Path, folder: Path, overrides: Sequence[str]) -> Mapping[str, object]:
    """Write a file of the laboratory as an experiment of this platform, and return notes."""
    folder.mkdir(parents=True, exist_ok=True)
    text = f"extends: acme_patrol\nduration: {path.read_text().strip()}\n"
    (folder / "experiment.yaml").write_text(text)
    return {"left_out": []}


def write_counts(recording: Recording, path: Path) -> list[Path]:
    """Write the number of spikes of each population, one a line."""
    spikes = Numbers.of(recording).spikes
    path.write_text("".join(f"{name} {len(ids)}\n" for name, (ids, _) in spikes.items()))
    return [path]


COUNTS = Exporter(write_counts, ".counts")
