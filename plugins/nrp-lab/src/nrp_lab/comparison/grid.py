"""The grid of runs, an experiment with every brain, world or wiring from every seed, and its execution."""

from __future__ import annotations

import hashlib
import json
import logging
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import product
from math import gcd
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydantic import BaseModel

from nrp_core import InvalidExperimentError, brains, worlds
from nrp_core.brain import StateRecorderPort
from nrp_core.errors import (
    ExperimentError,
    NrpError,
    RecordingError,
    SimulationError,
    did_you_mean,
)
from nrp_core.experiment import Experiment, Plan, Range, Run, load_experiment
from nrp_core.network.controls import CONTROLS
from nrp_core.quantities import time_ns
from nrp_core.recording import RUN_NAME, FilesRead, Images, Recording, RecordingFolder, changes_since
from nrp_core.registry import Registry
from nrp_core.utilities import WorkerDiedError, WorkerPool, join_with_limit
from nrp_lab.comparison.decoder import Decoder, with_decoder
from nrp_lab.comparison.signals import RunSignals
from nrp_lab.copies import (
    Attempt,
    Opened,
    Queue,
    may_step_together,
    perform_alone,
    perform_side_by_side,
    shares,
    why_alone,
)

_logger = logging.getLogger(__name__)

_DEFAULTED = ("options", "parameters", "function_parameters")
"""Mappings whose keys need not be written: they have defaults, and are checked where they are used."""


ORIGINAL = "original"
"""The name of the wiring without a control."""
DECODER = "decoder alone"
"""The name of the variant without a brain."""
WIRINGS = tuple(": ".join(control) for control in CONTROLS)
"""The names of the controls of all cells, as they are written in an experiment file."""
SILENCE, MATCHED = "silence", "silence_matched"
"""Controls of some cells, which are named behind it: these, or as many others like them."""


@dataclass(frozen=True, slots=True)
class GridCell:
    """One run of the grid.

    Args:
        brain, world: names of the backends.
        seed: the seed of every random number.
        wiring: the control of the brain's wiring; or the loop's time step, if these are compared.
    """

    brain: str
    world: str
    seed: int
    wiring: str = ORIGINAL

    def __str__(self) -> str:
        control = "" if self.wiring == ORIGINAL else f"-{re.sub('[^A-Za-z0-9_.]+', '_', self.wiring)}"
        return f"{self.brain}-{self.world}{control}-{self.seed}"


class Condition(NamedTuple):
    """What the runs of the grid that differ only in the seed have in common.

    Args:
        brain, world: names of the backends.
        wiring: the control of the brain's wiring.
    """

    brain: str
    world: str
    wiring: str = ORIGINAL

    def cell(self, seed: int) -> GridCell:
        """Return its run from a seed."""
        return GridCell(self.brain, self.world, seed, self.wiring)


@dataclass(frozen=True)
class RunGrid:
    """All runs that are compared.

    Args:
        experiment: its name, file or folder.
        brains, worlds: names of the backends.
        seeds: the same for every pair of backends.
        overrides: ``dotted.key=value``, applied to the experiment in every run.
        varied: settings that are drawn anew with each seed, by their dotted keys.
        wirings: the brain's own wiring, and controls that are compared with it.
        others: settings of variants that are compared like wirings, by their names among the wirings.
        decoders: the decoder of each seed, which takes the place of the brain in the variant ``DECODER``.
        shows_voltages: whether the membrane voltages that functions read are recorded.
        timesteps: steps of the loop that are compared, such as ``20 ms``, the finest first; or none.
        world_step_ns: the step of the world in all runs, if time steps are compared; None for its own.

    Raises:
        BackendError: the backend does not exist.
        ExperimentError: a name or a seed is repeated or missing; or several of backends, wirings
            and time steps are compared.
    """

    experiment: str
    brains: tuple[str, ...]
    worlds: tuple[str, ...]
    seeds: tuple[int, ...]
    overrides: tuple[str, ...] = ()
    varied: Mapping[str, Range] = field(default_factory=dict)
    wirings: tuple[str, ...] = (ORIGINAL,)
    timesteps: tuple[str, ...] = ()
    world_step_ns: int | None = None
    others: Mapping[str, Sequence[str]] = field(default_factory=dict)
    decoders: Mapping[int, Decoder] = field(default_factory=dict)
    shows_voltages: bool = False

    def __post_init__(self) -> None:
        for what, names in (
            ("brain", self.brains), ("world", self.worlds), ("seed", self.seeds), ("wiring", self.wirings),
        ):  # fmt: skip
            _require_distinct(what, names)
        if self.compares_variants and len(self.brains) * len(self.worlds) > 1:
            raise ExperimentError(
                f"{'time steps' if self.timesteps else 'controls'} are compared on one brain and one world, "
                "so that a difference has one cause; "
                f"not on {', '.join(self.brains)} x {', '.join(self.worlds)}"
            )
        if self.timesteps and self.compares_wirings:
            raise ExperimentError("compare time steps or controls, not both: a difference has one cause")
        for registry, names in self._sides():
            for name in names:
                registry.provider(name)

    @classmethod
    def of(
        cls, experiment: str, brains: Sequence[str], worlds: Sequence[str], seeds: int,
        overrides: Sequence[str] = (), varied: Mapping[str, Range] | None = None,
        controls: Sequence[str] = (), timesteps: Sequence[str] = (),
    ) -> RunGrid:  # fmt: skip
        """Return a grid of consecutive seeds, the experiment's own first; by default with its own backends.

        Settings that the experiment itself varies are varied as well, unless an override says otherwise.
        Its own controls are compared if neither controls nor several backends are given.

        Raises:
            ExperimentError: a varied setting belongs to something that does not exist, such as an event;
                or the brain's wiring is a control already.
        """
        own = load_experiment(experiment, overrides)
        if len(brains) < 2 and len(worlds) < 2 and not timesteps:
            controls = controls or [control.name for control in own.comparison.controls]
        if controls and own.brain.controls:
            named = ", ".join(control.name for control in own.brain.controls)
            raise ExperimentError(
                f"the wiring of '{own.name}' is a control already ({named}); compare the experiment without "
                "'brain.controls'"
            )
        for key in varied or ():
            require_there(own, key)
        fixed = {text.partition("=")[0].strip() for text in overrides}
        if timesteps:
            timesteps = sorted(timesteps, key=time_ns)
            _require_distinct("time step", [time_ns(one) for one in timesteps])
        its_own = {key: values for key, values in own.comparison.vary.items() if key not in fixed}
        return cls(
            experiment,
            tuple(brains) or (own.brain.backend,),
            tuple(worlds) or (own.world.backend,),
            tuple(range(own.seed, own.seed + seeds)),
            tuple(overrides),
            {**its_own, **(varied or {})},
            (ORIGINAL, *controls),
            tuple(timesteps),
            _common_step_ns(own, timesteps),
        )

    @property
    def cells(self) -> list[GridCell]:
        """Every run, seed by seed, so that a part of the grid is already useful."""
        return [condition.cell(seed) for seed, condition in product(self.seeds, self.conditions)]

    @property
    def conditions(self) -> list[Condition]:
        """Every brain in every world with every wiring."""
        return [Condition(*names) for names in product(self.brains, self.worlds, self.variants)]

    @property
    def variants(self) -> tuple[str, ...]:
        """The wirings that are compared, the original first; or the time steps, the finest first."""
        return self.timesteps or self.wirings

    @property
    def compares_variants(self) -> bool:
        """Whether it compares wirings or time steps, not backends."""
        return len(self.variants) > 1

    @property
    def compares_wirings(self) -> bool:
        """Whether it compares wirings."""
        return len(self.wirings) > 1

    def label(self, condition: Condition) -> str:
        """Return the name of a condition in a report."""
        return condition.wiring if self.compares_variants else f"{condition.brain} x {condition.world}"

    def settings(self, cell: GridCell) -> list[str]:
        """Return the overrides of one run."""
        return [
            *self.overrides,
            *(values.override(key, cell.seed) for key, values in self.varied.items()),
            f"brain.backend={cell.brain}",
            f"world.backend={cell.world}",
            *self._variant(cell),
            f"seed={cell.seed}",
            "pace=max",
        ]

    def _variant(self, cell: GridCell) -> list[str]:
        """Return the overrides of a wiring or a time step."""
        if self.timesteps:
            step_ns = self.world_step_ns
            own = [] if step_ns is None else [f"world.options.timestep={step_ns} ns"]
            return [f"timestep={cell.wiring}", *own]
        if cell.wiring in self.others:
            return list(self.others[cell.wiring])
        return [] if cell.wiring in (ORIGINAL, DECODER) else [f"brain.controls=[{{{cell.wiring}}}]"]

    def revise(self, cell: GridCell) -> Callable[[Plan], Plan] | None:
        """Return the replacement of the brain of a run, if any."""
        if cell.wiring != DECODER:
            return None
        return partial(with_decoder, decoder=self.decoders[cell.seed])

    def folder(self, results: Path, cell: GridCell) -> Path:
        """Return the folder of a run; its name has a digest of the settings."""
        sides = zip(self._sides(), (cell.brain, cell.world), strict=True)
        providers = [str(registry.provider(name)) for (registry, _), name in sides]
        described = [str(self.file), *providers, *self.settings(cell)]
        if cell.wiring == DECODER:
            described.append(self.decoders[cell.seed].digest)
        if self.shows_voltages:
            described.append("voltages")
        digest = hashlib.blake2b(json.dumps(described).encode(), digest_size=4).hexdigest()
        return results / f"{cell}-{digest}"

    def load(self, cell: GridCell, *more: str) -> Experiment:
        """Return the experiment of one run, with additional overrides."""
        return load_experiment(self.experiment, [*self.settings(cell), *more])

    @contextmanager
    def open(self, cell: GridCell, revise: Callable[[Plan], Plan] | None) -> Iterator[Run]:
        """Open one run, optionally with another brain."""
        with Run(self.load(cell), revise=revise) as run:
            if self.shows_voltages and (voltages := _recording_voltages(run)):
                run.experiment = self.load(cell, *voltages)
            yield run

    @cached_property
    def file(self) -> Path | None:
        """The file of the experiment, if it has one."""
        return load_experiment(self.experiment, self.overrides).source.place.path

    def _sides(self) -> list[tuple[Registry[object], tuple[str, ...]]]:
        return [(brains(), self.brains), (worlds(), self.worlds)]  # type: ignore[list-item]


def _common_step_ns(experiment: Experiment, timesteps: Sequence[str]) -> int | None:
    """Return the step of the world that divides its own and all steps of the loop; None if its own does."""
    backend = worlds().load(experiment.world.backend)
    if not timesteps or "timestep" not in backend.options.model_fields:
        return None
    options = backend.options.model_validate(experiment.world.options)
    own_ns = backend.capabilities(options).step_ns
    common_ns = gcd(own_ns, *map(time_ns, timesteps))
    return None if common_ns == own_ns else common_ns


def wiring_named(text: str) -> str:
    """Return the control with a name: ``silence: CELLS``, ``shuffle: signs``, or a word of the latter.

    Raises:
        ValueError: none or several have it.
    """
    kind, _, cells = text.partition(":")
    if kind.strip() in (SILENCE, MATCHED) and cells.strip():
        return f"{kind.strip()}: {cells.strip()}"
    words = text.replace(":", " ").split()
    found = [name for name in WIRINGS if words and set(words) <= set(name.split(": "))]
    if len(found) == 1:
        return found[0]
    if found:
        raise ValueError(f"'{text}' is {' or '.join(found)}; give the second word")
    known = (*WIRINGS, *(word for name in WIRINGS for word in name.split(": ")), f"{SILENCE}: CELLS")
    raise ValueError(f"there is no control '{text}'{did_you_mean(text, known)}")


def require_there(experiment: Experiment, key: str) -> None:
    """Refuse a key below a name that the experiment does not have: it would create something new.

    Options that the experiment leaves at their defaults may be varied.

    Raises:
        ExperimentError: the key leads to something that does not exist.
    """
    value: Any = experiment
    names = key.split(".")
    for above, name in zip(["", *names], names, strict=False):
        if isinstance(value, Mapping):
            is_of_named = (
                all(isinstance(one, BaseModel) for one in value.values()) and above not in _DEFAULTED
            )
            if is_of_named and name not in value:
                raise ExperimentError(f"there is no '{name}' to vary '{key}' of{did_you_mean(name, value)}")
            value = value.get(name)
        else:
            value = getattr(value, name, None)


def _require_distinct(what: str, names: Sequence[object]) -> None:
    if not names:
        raise ExperimentError(f"there is no {what} to compare")
    for name in names:
        if names.count(name) > 1:
            raise ExperimentError(f"{what} '{name}' is given twice")


def _recording_voltages(run: Run) -> list[str]:
    """Return the override, if any, that records the voltages that functions read, at the end of each step."""
    ports = [port for port in run.brain.devices if isinstance(port, StateRecorderPort)]
    read = np.concatenate([[-1], *(port.neurons for port in ports if port.variable == "v")])
    known, network = run.experiment.recording.voltages, run.brain.network
    sections: dict[str, Any] = {
        label: {"interval": f"{section.interval} ns"} | ({"cells": section.cells} if section.cells else {})
        for label, section in known.items()
    }
    missing: dict[str, Any] = {}
    for label in network.populations:
        cells = np.flatnonzero(np.isin(network.ids_of(label), read)).tolist()
        section = sections.get(label, {"cells": (), "interval": f"{run.experiment.timestep} ns"})
        if not set(cells) <= set(section.get("cells", cells)):
            missing[label] = section | {"cells": sorted({*section["cells"], *cells})}
    return [f"recording.voltages={json.dumps(sections | missing)}"] if missing else []


Progress = Callable[[int, int, str], None]
"""Called with the number of finished runs, the number of all runs, and the last finished run."""

WHOLE = ("finished", "failed")
"""Final states of a recording, which is then not repeated."""


def run_grid(
    grid: RunGrid, results: Path, workers: int, on_progress: Progress, left_out: dict[str, str] | None = None
) -> dict[GridCell, RunSignals]:
    """Make the runs that are not recorded yet.

    Args:
        grid: the grid.
        results: a folder for the recordings; recordings that are in it are kept.
        workers: number of processes.
        on_progress: called after every run.
        left_out: receives the controls that the network does not allow, and why; None: they are errors.

    Returns:
        Every run, without those of the controls that were left out.

    Raises:
        NrpError: an experiment cannot be opened. Anything else that ends a run is part of its result.
    """
    folders = {cell: grid.folder(results, cell) for cell in grid.cells}
    missing = [cell for cell, folder in folders.items() if not is_reusable(folder, grid.file)]
    done = len(folders) - len(missing)
    on_progress(done, len(folders), "")
    for cell, error in _run_all(grid, {cell: folders[cell] for cell in missing}, workers):
        if error is not None:
            if left_out is None or cell.wiring == ORIGINAL or not isinstance(error, InvalidExperimentError):
                raise error
            left_out[cell.wiring] = re.sub(r"^in the override '.*?': ", "", str(error))  # the grid's own
        done += 1
        on_progress(done, len(folders), str(cell))
    omitted = left_out or ()
    return {cell: RunSignals(Recording(path)) for cell, path in folders.items() if cell.wiring not in omitted}


def record(
    grid: RunGrid, cell: GridCell, folder: Path, *,
    images: Images = Images.HASH, revise: Callable[[Plan], Plan] | None = None,
) -> None:  # fmt: skip
    """Record one run into a folder; an incomplete recording is removed first.

    Args:
        grid: the grid.
        cell: one of its runs.
        folder: the folder.
        images: how images are kept, by default as hashes.
        revise: may exchange a side of the run for a recorded one.

    Raises:
        NrpError: the experiment cannot be opened, or the recording cannot be written.
    """
    perform_alone(_attempt(grid, cell, folder, images, revise))


def _attempt(
    grid: RunGrid, cell: GridCell, folder: Path, images: Images, revise: Callable[[Plan], Plan] | None,
    *, is_shared: bool = False,
) -> Attempt[None]:  # fmt: skip
    """Open a run and record it to its end, as :func:`record`; others may step meanwhile if it is shared.

    One call of a function for all copies fails for all, so a shared run with a failure is repeated alone.
    """
    shutil.rmtree(folder, ignore_errors=True)
    files, state, is_repeated = FilesRead(), "interrupted", False
    with ExitStack() as stack:
        with files:
            run = stack.enter_context(grid.open(cell, revise))
            recording_folder = RecordingFolder(run, folder, images=images, files=files, snapshots_ns=None)
        try:
            yield Opened(run, None, files)
            state = "finished"
        except (
            RecordingError
        ):  # a full disk is not the experiment's fault: with room on the disk the run may succeed
            raise
        except SimulationError:
            state = "failed"
        finally:
            with files:
                recording_folder.close(state)
        is_repeated = is_shared and bool(run.loop.failures) and not why_alone(run)
    if is_repeated:
        record(grid, cell, folder, images=images, revise=revise)


CellTask: TypeAlias = tuple[RunGrid, GridCell, Path]
"""A run, and the folder of its recording."""
Ended: TypeAlias = tuple[GridCell, NrpError | None]
"""A run that has ended, and the error that prevented it."""


def _run_all(grid: RunGrid, folders: dict[GridCell, Path], workers: int) -> Iterator[Ended]:
    """Run cells and yield each when it is done, with the error that prevented it, if any."""
    workers = min(workers, len(folders))
    tasks = [(grid, cell, folder) for cell, folder in folders.items()]
    if workers < 2:
        yield from _record_share(tasks)
        return
    queue = Queue(_shares(grid, tasks, workers))
    with WorkerPool(workers) as pool:
        for outcome in pool.perform(_record_list, queue):
            share, error = outcome.task, outcome.error
            if isinstance(error, WorkerDiedError) and len(share) > 1:  # one of them is the cause
                queue.extend((task,) for task in share)
            elif isinstance(error, WorkerDiedError):
                message = f"a process was killed, or an engine crashed in it, at {share[0][1]} ({error})"
                raise SimulationError(f"{message}; the finished runs are kept", t_ns=0) from error
            elif error is not None:
                raise error
            else:
                yield from outcome.value or ()


def _shares(grid: RunGrid, tasks: list[CellTask], workers: int) -> Iterator[tuple[CellTask, ...]]:
    """Return what a process records side by side; one at a time if the first one steps alone."""
    is_one_pair = len(grid.brains) * len(grid.worlds) == 1
    if is_one_pair and may_step_together(partial(grid.load, tasks[0][1])):
        return shares(tasks, workers)
    return ((task,) for task in tasks)


def _record_share(tasks: Iterable[CellTask]) -> Iterator[Ended]:
    return perform_side_by_side(map(_attempt_cell, tasks))


def _record_list(tasks: Sequence[CellTask]) -> list[Ended]:
    return list(_record_share(tasks))


def _attempt_cell(task: CellTask) -> Attempt[Ended]:
    grid, cell, folder = task
    try:
        yield from _attempt(grid, cell, folder, Images.HASH, grid.revise(cell), is_shared=True)
    except NrpError as error:
        return cell, error
    return cell, None


def is_reusable(folder: Path, file: Path | None) -> bool:
    """Whether a run was recorded to its end, its recording is undamaged, and a new run would be the same.

    If a complete run is not, a log message gives the reason.

    Args:
        folder: the folder of the recording.
        file: the file of the experiment, if it has one.
    """
    if not (folder / RUN_NAME).is_file():
        return False
    try:
        recording = Recording(folder)
        if recording.run.get("state") not in WHOLE or recording.check().flaws:
            return False
        changes = changes_since(recording.run, file)
    except ExperimentError:  # damaged: the run is repeated
        return False
    if changes:
        _logger.warning("%s is run again: %s changed", folder.name, join_with_limit(changes, 3))
    return not changes
