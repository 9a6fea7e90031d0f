"""The recording of a run as a folder: its description, the files it used, and every message."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError
from ruamel.yaml import YAML

from nrp_core._support import machine
from nrp_core._support.arrays import IntArray
from nrp_core._support.files import replace_file
from nrp_core._support.json_values import to_jsonable
from nrp_core._support.used_files import FilesRead
from nrp_core.brain.backend import BrainOptions
from nrp_core.brain.backends import brains
from nrp_core.clock import NS_PER_S
from nrp_core.dsl.mappings import write_csv
from nrp_core.errors import BackendError, CapabilityError, ExperimentError, RecordingError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Tree
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.observers import RunObserver
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Findings
from nrp_core.messages.nrp_msgs import Called
from nrp_core.network.data import Network, Projection
from nrp_core.recording.folder.calls import CallNoter
from nrp_core.recording.folder.dependencies import dependencies, read_files
from nrp_core.recording.layout import (
    CSV_FOLDER,
    EXPERIMENT_NAME,
    FILES_FOLDER,
    MCAP_NAME,
    RUN_NAME,
    RUNNING,
    Images,
    check_folder,
)
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import file_digest, seal
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.recording.writing.hashes import Chain
from nrp_core.recording.writing.recorder import McapRecorder
from nrp_core.scene.devices import View
from nrp_core.scene.model import Scene
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.world import World

MOST_EDGES = 2_000
"""The individual synapses of larger projections are not described."""


def groups_data(network: Network) -> dict[str, Any]:
    """Return the populations and, for each named view, its ranges of ids by population and its members."""
    populations = {
        label: {"size": population.size, "cell_type": population.cell_type}
        for label, population in network.populations.items()
    }
    members = {name: neurons.tolist() for name, neurons in network.views.items()}
    return {"populations": populations, "views": views_data(network), "members": members}


def views_data(network: Network) -> dict[str, dict[str, list[list[int]]]]:
    """Return the cells of each named view by population, as half-open ranges of their indices in it."""
    views: dict[str, dict[str, list[list[int]]]] = {}
    for name, neurons in network.views.items():
        for label, first in network.offsets.items():
            last = first + network.populations[label].size
            ids = np.unique(neurons[(neurons >= first) & (neurons < last)]) - first
            if ids.size:
                views.setdefault(name, {})[label] = ranges_of(ids)
    return views


def ranges_of(ids: IntArray) -> list[list[int]]:
    """Return ascending ids as half-open ranges."""
    cuts = np.flatnonzero(np.diff(ids) > 1) + 1
    return [[int(part[0]), int(part[-1]) + 1] for part in np.split(ids, cuts)]


def projection_data(projection: Projection) -> dict[str, Any]:
    """Return the description of a projection.

    ``edges`` holds presynaptic index, postsynaptic index (within their populations) and weight of each
    synapse; None for more than :data:`MOST_EDGES`.
    """
    weights = projection.weight
    excites = projection.is_excitatory and not bool(np.any(weights[:1] < 0))
    return {
        "id": projection.label,
        "label": projection.label,
        "pre": projection.pre,
        "post": projection.post,
        "receptor": projection.receptor,
        "synapse": projection.synapse_type,
        "size": projection.size,
        "excites": excites,
        "edges": _edges(projection) if projection.size <= MOST_EDGES else None,
    }


def _edges(projection: Projection) -> list[list[float]]:
    pairs = [(int(a), int(b)) for pre, post in projection.pairs() for a, b in zip(pre, post, strict=True)]
    return [[a, b, float(w)] for (a, b), w in zip(pairs, projection.weight, strict=True)]


def mounts_data(world: World) -> Iterator[dict[str, Any]]:
    """Yield the cameras and laser scanners, each with its pose in its parent frame.

    ``view`` holds the horizontal field of view, rad, and the aspect ratio of a camera; None for a laser
    scanner.
    """
    frames = SceneFrames(world).now
    for model, link in world.scene.links():
        for sensor in link.sensors:
            looks = sensor if isinstance(sensor, Laser) else sensor.view
            if looks is None:
                continue
            frame, place = frames.place(model.name, link.name)
            pose = place @ looks.pose
            yield {
                "topic": sensor.topic,
                "frame": frame,
                "position": list(pose.position),
                "orientation": list(pose.orientation),
                "view": _view_data(looks) if isinstance(looks, View) else None,
            }


def lights_data(scene: Scene) -> list[dict[str, Any]]:
    """Return the lights that are on, in SI units; a range of None has no end."""
    return [
        {
            "kind": light.kind,
            "position": list(light.pose.position),
            "direction": list(light.direction),
            "color": list(light.diffuse[:3]),
            "casts_shadows": light.casts_shadows,
            "range_m": light.attenuation[0] if isfinite(light.attenuation[0]) else None,
            "attenuation": list(light.attenuation[1:]),
            "cone_rad": light.cone[1],
        }
        for light in scene.lights
        if any(light.diffuse[:3])
    ]


def _view_data(view: View) -> dict[str, float]:
    return {"fov_rad": view.horizontal_fov, "aspect": view.width / view.height}


def write_experiment(experiment: Experiment, folder: Path, files: Collection[Path], root: Path) -> None:
    """Write an experiment into its recording, merged with the files that it extends and its overrides.

    An experiment that was not read from YAML is left as its own file and its overrides.

    Args:
        experiment: the experiment.
        folder: the folder of the recording.
        files: the files that were copied into the recording.
        root: their common folder.
    """
    is_ours = experiment.maker is None or experiment.compatibility is not None
    if not is_ours or not experiment.source.value:
        return
    content = _with_copied_files(experiment.source, {file.resolve() for file in files}, root)
    with (folder / EXPERIMENT_NAME).open("w", encoding="utf-8") as file:
        YAML().dump(content, file)


def recorded_experiment(recording: Recording, overrides: Sequence[str] = ()) -> Experiment:
    """Return the experiment of a recording, from the files in it.

    Raises:
        ExperimentError: it is missing, or invalid.
    """
    own, written = recording.folder / EXPERIMENT_NAME, recording.run.get("file")
    if not own.is_file() and not written:
        raise ExperimentError(f"cannot be run again: it has no {EXPERIMENT_NAME}", path=recording.folder)
    before = () if own.is_file() else map(str, recording.run.get("overrides") or ())
    load = partial(load_experiment, own if own.is_file() else recording.folder / str(written))
    given = [*before, *overrides]
    experiment = load(given)
    older = list(_options_before(experiment, (recording.run.get("brain") or {}).get("options", ())))
    return load([*given, *older]) if older else experiment


def _options_before(experiment: Experiment, known: Collection[str]) -> Iterator[str]:
    """Yield overrides for options of the brain backend that did not exist when a run was recorded."""
    with suppress(BackendError, ValidationError):  # reported where the brain is opened
        for name, value in _options(experiment).earlier().items():
            if name not in known:
                yield f"brain.options.{name}={value}"


def _options(experiment: Experiment) -> BrainOptions:
    brain = experiment.brain
    return brains().load(brain.backend).options.model_validate(brain.options)


def _with_copied_files(tree: Tree, files: Collection[Path], root: Path) -> Any:
    """Return the data of a tree, with the names of copied files replaced by those of the copies."""
    if isinstance(tree.value, dict):
        return {key: _with_copied_files(child, files, root) for key, child in tree.value.items()}
    if isinstance(tree.value, list):
        return [_with_copied_files(child, files, root) for child in tree.value]
    if not isinstance(tree.value, str) or not tree.value or "\0" in tree.value:
        return tree.value
    path = (tree.place.folder / Path(tree.value).expanduser()).resolve()
    if path in files or (path != root and any(path in file.parents for file in files)):
        return str(Path(FILES_FOLDER) / path.relative_to(root))
    return str(tree.value)


FORMAT, OLDEST_FORMAT = 4, 3
"""Version of the layout of a recording, and the oldest version that can be read."""

SNAPSHOTS_NS = 10 * NS_PER_S
"""Simulated time between two snapshots; one takes about as long as a step."""


class RecordingFolder(RunObserver[Run]):
    """Records a run into a folder, from now until it is closed.

    Args:
        run: the run, between two steps, usually at time 0.
        folder: the new folder; it may exist if it is empty, or a recording to be replaced.
        images: how camera images are kept.
        files: the files that were read; None: only the files that the experiment names and the meshes of
            its scene are kept.
        snapshots_ns: simulated time between two snapshots; None: no snapshots.
        origin: the recording that the run continues, and its chain of hashes there.
        calls: earlier changes of its transfer functions, which are not in the experiment.
        overwrite: whether to replace a recording.

    Raises:
        ExperimentError: the folder is not empty, cannot be created, or holds files that the run has read.
        RecordingError: the experiment cannot be written.
    """

    def __init__(
        self,
        run: Run,
        folder: Path,
        *,
        images: Images = Images.EXACT,
        files: FilesRead | None = None,
        snapshots_ns: int | None = SNAPSHOTS_NS,
        origin: ContinuedRecording | None = None,
        calls: Iterable[Called] = (),
        overwrite: bool = False,
    ) -> None:
        self._run, self._folder, self._files = run, folder, files or FilesRead()
        self._snapshots_ns, self._warnings = snapshots_ns, Findings(general=Code.NRP284)
        if overwrite and folder.exists():
            _remove(folder, files)
        _make(folder)
        try:
            self._begin(images, origin)
            self._recorder = McapRecorder(
                run.brain, run.world, folder, period_ns=run.experiment.timestep, images=images,
                scope=run.experiment.recording,
                chain=Chain(origin.chain) if origin else None, steps=run.loop.steps,
                calls=calls,
            )  # fmt: skip
        except KeyboardInterrupt:  # no step has run: the folder would look like that of a killed run
            shutil.rmtree(folder, ignore_errors=True)
            raise
        if run.loop.now_ns:
            self._snapshot()
        run.observers.append(self)
        run.reporters.append(self._report)
        run.loop.hooks.from_outside.append(self._recorder.collector.note_from_outside)
        self._calls = CallNoter(run, self._recorder.collector.note_call, self._warnings)

    def _begin(self, images: Images, origin: ContinuedRecording | None) -> None:
        """Write everything that is known before the first message."""
        with self._on_disk("begun"):
            self._root = _copy_files(self._used_files(), self._folder)
            self._about = _about(self._run, self._root) | {
                "images": images, "snapshots_ns": self._snapshots_ns, "continues": origin
            }  # fmt: skip
            self._write(RUNNING, None)

    @property
    def warnings(self) -> Findings:
        """Warnings about data that could not be recorded."""
        return Findings([*self._recorder.warnings, *self._warnings])

    def _report(self) -> Findings:
        return self.warnings

    def close(self, state: str) -> None:
        """Complete the recording; call it before the run is closed.

        Args:
            state: how the run ended: ``finished``, ``failed`` or ``interrupted``.

        Raises:
            RecordingError: the disk refused a write.
        """
        self._calls.close()
        self._run.observers.remove(self)
        self._run.loop.hooks.from_outside.remove(self._recorder.collector.note_from_outside)
        try:
            self._recorder.close()
        except BaseException as error:
            state = "interrupted"  # the recording is incomplete, however the run ended
            self._run.error = self._run.error or error
            raise
        finally:
            self._finish(state)

    def _finish(self, state: str) -> None:
        try:
            with self._on_disk("completed"):
                _copy_files(self._used_files(), self._folder, self._root)
                self._write_csv()
        except RecordingError:
            state = "failed"
            raise
        finally:
            with self._on_disk("completed"):
                self._write(state, self._run.result().to_dict())

    def _write_csv(self) -> None:
        """Write the rows of CSV recorders, all or none: a part would take the space for ``run.json``."""
        folder = self._folder / CSV_FOLDER
        try:
            write_csv(self._run.loop.functions, folder)
        except OSError:
            shutil.rmtree(folder, ignore_errors=True)
            raise

    @contextmanager
    def _on_disk(self, what: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            failure = RecordingError(
                f"the recording cannot be {what}: {error.strerror or error}", t_ns=self._run.loop.now_ns
            )
            self._run.error = self._run.error or failure
            raise failure from error

    def after_step(self, run: Run) -> None:
        """Record the step, and a snapshot in the first step at or after each multiple of their interval."""
        self._recorder.step()
        every_ns = self._snapshots_ns
        if every_ns is not None and run.loop.now_ns % every_ns < run.experiment.timestep:
            self._snapshot()

    def _snapshot(self) -> None:
        """Record the state of the run; if that fails, warn once."""
        try:
            self._recorder.add_snapshot(self._run.snapshot())
        except CapabilityError as error:
            self._snapshots_ns = None
            self._warnings.add(
                Code.NRP284,
                f"no snapshots are recorded: {error}; a replay from a later time has to run from the start",
            )

    def _used_files(self) -> list[Path]:
        return read_files(self._files, self._run.experiment, self._run.world.scene, self._folder)

    def _write(self, state: str, result: dict[str, Any] | None) -> None:
        """Replace ``run.json`` in one operation, so that a kill leaves a complete file."""
        write_experiment(self._run.experiment, self._folder, self._used_files(), self._root)
        path = self._folder / RUN_NAME
        digests = _digests(self._folder) | ({} if state == RUNNING else self._recorder.digests)
        read = dependencies(self._files, self._run.experiment, self._run.world.scene, self._folder)
        data = {
            **self._about, "files": digests, "dependencies": read.to_data(self._root), "state": state,
            "result": result,
        }  # fmt: skip
        replace_file(path, seal(to_jsonable(data)))


@dataclass(frozen=True, slots=True)
class ContinuedRecording:
    """The start of a continued run: the name of a recording, the time, and its chain of hashes there."""

    recording: str
    t_ns: int
    chain: str


def _remove(folder: Path, files: FilesRead | None) -> None:
    """Remove a recording that is to be replaced."""
    check_folder(folder, overwrite=True)
    if files is not None and files.below([folder]):
        raise ExperimentError("the run has read files in this folder, so it cannot replace it", path=folder)
    shutil.rmtree(folder)


def _make(folder: Path) -> None:
    """Create the folder, and the file in it exclusively, so that only one process can succeed."""
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / MCAP_NAME).touch(exist_ok=False)
    except FileExistsError as error:
        raise ExperimentError("another run already records here", path=folder) from error
    except OSError as error:
        raise ExperimentError(f"cannot be made: {error.strerror}", path=folder) from error


def _copy_files(files: Iterable[Path], folder: Path, root: Path | None = None) -> Path:
    """Copy files into their places relative to each other.

    Args:
        files: the files.
        folder: the folder of the recording.
        root: their common folder, if it is known already; files outside it are left out.

    Returns:
        the common folder.
    """
    files = list(files)
    if root is None:
        root = Path(os.path.commonpath([file.parent for file in files])) if files else Path.cwd()
    for file in files:
        target = folder / FILES_FOLDER / file.relative_to(root) if file.is_relative_to(root) else None
        if target is not None and not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
    return root


def _digests(folder: Path) -> dict[str, str]:
    """Return the digest of every file of a recording except ``run.json`` and the messages."""
    inside = (path for name in (FILES_FOLDER, CSV_FOLDER) for path in sorted((folder / name).rglob("*")))
    files = (path for path in (*inside, folder / EXPERIMENT_NAME) if path.is_file())
    return {path.relative_to(folder).as_posix(): file_digest(path) for path in files}


def _about(run: Run, root: Path) -> dict[str, Any]:
    """Return the contents of ``run.json`` at the start of a run."""
    experiment, written = run.experiment, run.experiment.source.place.path
    return {
        "format": FORMAT,
        "experiment": experiment.name,
        "file": None if written is None else Path(FILES_FOLDER) / written.relative_to(root),
        "recorded": datetime.now(UTC).isoformat(timespec="seconds"),
        "overrides": experiment.overrides,
        "seed": run.seed,
        "brain": {
            "backend": experiment.brain.backend,
            "capabilities": run.brain.capabilities,
            "options": _options(experiment).names(),
            "network": run.brain.network.digest,
            **groups_data(run.brain.network),
            "projections": [projection_data(each) for each in run.brain.network.projections],
        },
        "world": {
            "backend": experiment.world.backend,
            "capabilities": run.world.capabilities,
            "scene": run.world.scene.digest,
            "randomized": run.world.randomized,
            "mounts": list(mounts_data(run.world)),
            "lights": lights_data(run.world.scene),
        },
        "parameters": run.parameters.as_data(),
        "aliases": experiment.aliases,
        "settings": experiment,
        "machine": machine.describe_machine(),
        "distributions": machine.distributions(),
    }
