"""Rooms and robots that were read before, and what changes between two runs of one process."""

import os
import time
from pathlib import Path

import pytest

import nrp_core.experiment.making.maker as making
from nrp_core import load_experiment
from nrp_core._support.used_files import SETTLED_NS
from nrp_core.experiment import prepare
from nrp_core.recording import FilesRead
from nrp_core.scene.model import Scene

_LONG_AGO_S = 3 * SETTLED_NS / 1e9

_ROOM = """<sdf version="1.7"><world name="w">
  <include><uri>model://post</uri></include>
</world></sdf>"""
_POST = """<sdf version="1.7"><model name="post"><static>true</static><link name="l">
  <collision name="c"><geometry><box><size>{0} {0} {0}</size></box></geometry></collision>
</link></model></sdf>"""
_EXPERIMENT = """name: kept
timestep: 20 ms
duration: 1 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
models: [first, second]
transfer_functions: []
"""
_BRAIN = """import nrp_core.pynn as sim
sim.setup()
cells = sim.Population(1, sim.IF_curr_exp())
"""


def _write(path: Path, text: str, age_s: float = _LONG_AGO_S) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    os.utime(path, (time.time() - age_s,) * 2)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    _write(tmp_path / "room.sdf", _ROOM)
    _write(tmp_path / "second" / "post" / "model.sdf", _POST.format(1))
    _write(tmp_path / "brain.py", _BRAIN)
    _write(tmp_path / "experiment.yaml", _EXPERIMENT)
    (tmp_path / "first").mkdir()
    for path in tmp_path.rglob("*"):
        os.utime(path, (time.time() - _LONG_AGO_S,) * 2)
    return tmp_path


def _scene(folder: Path) -> Scene:
    return prepare(load_experiment(folder / "experiment.yaml")).scene


def _size(scene: Scene) -> float:
    (model,) = scene.models
    return model.links[0].collisions[0].geometry.size[0]


def test_a_room_is_read_once_for_many_runs(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, reads = _scene(folder), []
    original = making.read_scene
    monkeypatch.setattr(
        making, "read_scene", lambda *given, **more: reads.append(given) or original(*given, **more)
    )
    _scene(folder)
    assert len(reads) == 1  # a function of its own
    assert _scene(folder).digest == first.digest
    assert len(reads) == 1


def test_a_run_after_a_file_was_changed_has_the_changed_room(folder: Path) -> None:
    assert _size(_scene(folder)) == 1
    _write(folder / "second" / "post" / "model.sdf", _POST.format(2), age_s=2 * _LONG_AGO_S)
    assert _size(_scene(folder)) == 2


def test_a_file_changed_twice_within_the_resolution_of_its_time_is_read_twice(folder: Path) -> None:
    now_s, file = time.time(), folder / "second" / "post" / "model.sdf"
    for size in (3, 4, 5):
        file.write_text(_POST.format(size))
        os.utime(file, (now_s, now_s))
        assert _size(_scene(folder)) == size


def test_a_model_that_appears_in_an_earlier_folder_is_used(folder: Path) -> None:
    assert _size(_scene(folder)) == 1
    _write(folder / "first" / "post" / "model.sdf", _POST.format(2))
    assert _size(_scene(folder)) == 2


def test_a_folder_named_in_the_environment_later_is_used(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _write(folder / "experiment.yaml", _EXPERIMENT.replace("models: [first, second]", "models: [first]"))
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(folder / "second"))
    assert _size(_scene(folder)) == 1
    _write(folder / "third" / "post" / "model.sdf", _POST.format(2))
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(folder / "third"))
    assert _size(_scene(folder)) == 2


def test_a_room_that_is_not_read_again_counts_as_read(folder: Path) -> None:
    _scene(folder)
    with FilesRead() as files:
        _scene(folder)
    read = {path.relative_to(folder).as_posix() for path in files.below([folder])}
    assert {"room.sdf", "second/post/model.sdf", "brain.py", "experiment.yaml"} <= read
    assert "GZ_SIM_RESOURCE_PATH" in files.variables
