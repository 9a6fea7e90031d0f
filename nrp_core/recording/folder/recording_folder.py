"""The recording of a run as a folder: its description, the files it used, and every message."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from nrp_core._support import machine
from nrp_core._support.jsonable import to_jsonable
from nrp_core.clock import NS_PER_S
from nrp_core.dsl.functions.csv_recorder import write_csv
from nrp_core.errors import CapabilityError, ExperimentError, RecordingError
from nrp_core.experiment.backends import code_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Findings
from nrp_core.recording.folder.calls import CallNoter
from nrp_core.recording.folder.parts import groups_data, lights_data, mounts_data, projection_data
from nrp_core.recording.folder.self_contained import write_experiment
from nrp_core.recording.folder.used_files import FilesRead
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
from nrp_core.recording.sealing import file_digest, sealed
from nrp_core.recording.writing.hashes import Chain
from nrp_core.recording.writing.recorder import Recorder
from nrp_core.world.messages.nrp_msgs import Called
from nrp_core.world.scene.model import Mesh, Scene

FORMAT, OLDEST_FORMAT = 4, 3
"""Version of the layout of a recording, and the oldest version that can be read."""

SNAPSHOTS_NS = 10 * NS_PER_S
"""Simulated time between two snapshots; one takes about as long as a step."""


class RecordingFolder:
    """Records a run into a folder, from now until it is closed.

    Args:
        run: the run, between two steps, usually at time 0.
        folder: the new folder; it may exist if it is empty.
        images: how camera images are kept.
        files: the files that were read; None: only the files that the experiment names and the meshes of
            its scene are kept.
        snapshots_ns: simulated time between two snapshots; None: no snapshots.
        origin: the recording that the run continues, and its chain of hashes there.
        calls: earlier changes of its transfer functions, which are not in the experiment.

    Raises:
        ExperimentError: the folder is not empty, or cannot be created.
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
        origin: Origin | None = None,
        calls: Iterable[Called] = (),
    ) -> None:
        self._run, self._folder, self._files = run, folder, files
        self._snapshots_ns, self._warnings = snapshots_ns, Findings(general=Code.NRP284)
        _make(folder)
        try:
            self._begin(images, origin)
            self._recorder = Recorder(
                run.brain, run.world, folder, period_ns=run.experiment.timestep, images=images,
                chain=Chain(origin.chain) if origin else None, steps=run.loop.steps,
                calls=calls,
            )  # fmt: skip
        except KeyboardInterrupt:  # nothing has run: the folder would look like that of a killed run
            shutil.rmtree(folder, ignore_errors=True)
            raise
        if run.loop.now_ns:
            self._snapshot()
        run.on_step.append(self._after_step)
        run.reporters.append(self._reported)
        run.loop.hooks.from_outside.append(self._recorder.observer.note_from_outside)
        self._calls = CallNoter(run, self._recorder.observer.note_call, self._warnings)

    def _begin(self, images: Images, origin: Origin | None) -> None:
        """Write everything that is known before the first message."""
        with self._on_disk("begun"):
            self._root = _copy_files(self._used(), self._folder)
            self._about = _about(self._run, self._root) | {
                "images": images, "snapshots_ns": self._snapshots_ns, "continues": origin
            }  # fmt: skip
            self._write(RUNNING, None)

    @property
    def warnings(self) -> Findings:
        """Warnings about data that could not be recorded."""
        return Findings([*self._recorder.warnings, *self._warnings])

    def _reported(self) -> Findings:
        return self.warnings

    def close(self, state: str) -> None:
        """Complete the recording; call it before the run is closed.

        Args:
            state: how the run ended: ``finished``, ``failed`` or ``interrupted``.

        Raises:
            RecordingError: the disk refused a write.
        """
        self._calls.close()
        self._run.on_step.remove(self._after_step)
        self._run.loop.hooks.from_outside.remove(self._recorder.observer.note_from_outside)
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
                _copy_files(self._used(), self._folder, self._root)
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

    def _after_step(self, run: Run) -> None:
        self._recorder.step()
        if self._snapshots_ns is not None and run.loop.now_ns % self._snapshots_ns == 0:
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

    def _used(self) -> list[Path]:
        named = {path for path in named_files(self._run.experiment) if path.is_file()}
        folders = {path.parent for path in named} | set(self._run.experiment.models)
        read = self._files.below(folders) if self._files else []
        used = {*named, *_meshes(self._run.world.scene), *read}
        own = self._folder.resolve()  # it may be beside the experiment, and is read to be completed
        return sorted(path for path in used if own not in path.resolve().parents)

    def _write(self, state: str, result: dict[str, Any] | None) -> None:
        """Replace ``run.json`` in one operation, so that a kill leaves a complete file."""
        write_experiment(self._run.experiment, self._folder, self._used(), self._root)
        path = self._folder / RUN_NAME
        draft = path.with_suffix(".draft")
        digests = _digests(self._folder) | ({} if state == RUNNING else self._recorder.digests)
        data = {**self._about, "files": digests, "state": state, "result": result}
        draft.write_bytes(sealed(to_jsonable(data)))
        draft.replace(path)


@dataclass(frozen=True, slots=True)
class Origin:
    """The start of a continued run: the name of a recording, the time, and its chain of hashes there."""

    recording: str
    t_ns: int
    chain: str


def named_files(experiment: Experiment) -> Iterator[Path]:
    """Return the files that an experiment was read from and those that it names."""
    yield from _places(experiment.source)
    yield from _paths(experiment)


def _places(tree: Tree) -> Iterator[Path]:
    if tree.place.path is not None:
        yield tree.place.path
    children = tree.value.values() if isinstance(tree.value, dict) else tree.value
    for child in children if isinstance(tree.value, (dict, list)) else ():
        yield from _places(child)


def _paths(value: Any) -> Iterator[Path]:
    match value:
        case Path():
            yield value
        case BaseModel():
            for name in type(value).model_fields:
                yield from _paths(getattr(value, name))
        case dict():
            for item in value.values():
                yield from _paths(item)
        case list() | tuple():
            for item in value:
                yield from _paths(item)


def _meshes(scene: Scene) -> Iterator[Path]:
    for _, link in scene.links():
        shapes = [visual.geometry for visual in link.visuals]
        shapes += [collision.geometry for collision in link.collisions]
        yield from (shape.path for shape in shapes if isinstance(shape, Mesh))


def _make(folder: Path) -> None:
    """Create the folder, and the file in it exclusively, in case a second process does the same."""
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
            "network": run.brain.network.digest,
            **groups_data(run.brain.network),
            "projections": [projection_data(each) for each in run.brain.network.projections],
        },
        "world": {
            "backend": experiment.world.backend,
            "capabilities": run.world.capabilities,
            "scene": run.world.scene.digest,
            "mounts": list(mounts_data(run.world)),
            "lights": lights_data(run.world.scene),
        },
        "parameters": run.parameters.as_data(),
        "aliases": experiment.aliases,
        "settings": experiment,
        "machine": machine.describe(),
        "distributions": machine.distributions(),
        "code": code_of(experiment.brain.backend, experiment.world.backend),
    }
