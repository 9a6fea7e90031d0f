"""Whether a behaviour is due to the wiring, the decoder or the simulator.

The experiment runs with its own wiring and with each control from the same seeds. A control is the name of a
variant and the settings that make it; each is judged by the statistics of a comparison of wirings.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from nrp_core.errors import ExperimentError, NrpError
from nrp_lab.comparison.decoder import Decoder
from nrp_lab.comparison.grid import (
    DECODER,
    MATCHED,
    ORIGINAL,
    SILENCE,
    WIRINGS,
    GridCell,
    Progress,
    RunGrid,
    run_grid,
)
from nrp_lab.comparison.judgement import Contrast, JudgedPart, Judgement, Relation, controls_of, holm
from nrp_lab.comparison.metric import Margins, Metric
from nrp_lab.comparison.result import GridDiff
from nrp_lab.comparison.signals import RunSignals


class Kind(StrEnum):
    """What a control exchanges."""

    WIRING = "wiring"
    CELLS = "cells"
    DECODER = "decoder"
    ANIMAL = "animal"
    SIMULATOR = "simulator"


MOST_SEEDS = 1000
"""The largest number of seeds that is recommended."""

Variant = tuple[str, Sequence[str]]
"""The name of a control and the settings that make it."""


def other_animal(path: str) -> Variant:
    """Return the control with the network in another file."""
    return f"animal: {Path(path).name}", [f"brain.model={Path(path).resolve()}"]


def other_brain(backend: str) -> Variant:
    """Return the control with another brain backend."""
    return f"brain: {backend}", [f"brain.backend={backend}"]


def other_world(backend: str) -> Variant:
    """Return the control with another world backend."""
    return f"world: {backend}", [f"world.backend={backend}"]


def other_timestep(step: str) -> Variant:
    """Return the control with another step of the loop."""
    return f"timestep: {step}", [f"timestep={step}"]


OTHERS: Mapping[str, tuple[Kind, Callable[[str], Variant]]] = {
    "animal": (Kind.ANIMAL, other_animal),
    "brain": (Kind.SIMULATOR, other_brain),
    "world": (Kind.SIMULATOR, other_world),
    "timestep": (Kind.SIMULATOR, other_timestep),
}
"""The controls that are settings: their kind, and the function that makes one."""

_ABOUT: Mapping[str, str] = {
    "rewire": "every cell keeps its numbers of synapses, and has other partners, drawn at random",
    "shuffle: signs": "as many cells inhibit, but others, drawn at random",
    "shuffle: weights": "every cell keeps its partners; the strengths of synapses are exchanged at random",
    SILENCE: "the synapses from the named cells are cut",
    MATCHED: "the synapses from as many other cells are cut, drawn from the same population and quarter of "
    "out-degrees",
    DECODER: "no brain: a linear formula computes what the functions read from what they gave to the brain "
    "in the last 200 ms; it is fitted to the original runs of the other seeds",
    "animal": "the network of another file",
    "brain": "another simulator of the brain",
    "world": "another simulator of the world",
    "timestep": "another step of the loop",
}


def kind_of(name: str) -> Kind:
    """Return what a control exchanges, by its name."""
    word = name.partition(":")[0]
    if name == DECODER:
        return Kind.DECODER
    if word in (SILENCE, MATCHED):
        return Kind.CELLS
    return OTHERS[word][0] if word in OTHERS else Kind.WIRING


def about(name: str) -> str:
    """Return a sentence about a control."""
    return _ABOUT.get(name) or _ABOUT.get(name.partition(":")[0], "")


class Doing(StrEnum):
    """The cause of a behaviour."""

    WIRING = "The behaviour needs the wiring: a random network of its kind and a linear decoder change it"
    DECODER = "The behaviour needs only the decoder"
    SIMULATOR = "The behaviour depends on the simulator"
    BRAIN = "The behaviour needs a brain, but not this wiring"
    OPEN = "{n} runs do not decide what the behaviour needs"


def doing_of(parts: Iterable[Mapping[str, Relation]]) -> Doing:
    """Return the cause of a behaviour.

    A simulator that changes it comes first, because then no other answer holds in general. It needs the
    wiring if one and the same part of it is changed by a random network and by the decoder alone.

    Args:
        parts: for each part of the finding, the relation of each control to the original.
    """
    found = {_doing_of_part(part) for part in parts}
    order = (Doing.SIMULATOR, Doing.WIRING, Doing.OPEN, Doing.BRAIN, Doing.DECODER)
    return next((doing for doing in order if doing in found), Doing.OPEN)


def _doing_of_part(controls: Mapping[str, Relation]) -> Doing:
    found = {kind: [r for name, r in controls.items() if kind_of(name) is kind] for kind in Kind}
    if Relation.DIFFERENT in found[Kind.SIMULATOR]:
        return Doing.SIMULATOR
    if Relation.EQUIVALENT in found[Kind.DECODER]:
        return Doing.DECODER
    if Relation.DIFFERENT not in found[Kind.DECODER] or not found[Kind.WIRING]:
        return Doing.OPEN
    if Relation.DIFFERENT in found[Kind.WIRING]:
        return Doing.WIRING
    return Doing.OPEN if Relation.OPEN in found[Kind.WIRING] else Doing.BRAIN


@dataclass(frozen=True)
class Evidence:
    """The comparison of an experiment with its controls.

    Args:
        diff: the comparison.
        without_decoder: why the decoder was not run; empty if it was.
        left_out: the controls that the network does not allow, and why.
    """

    diff: GridDiff
    without_decoder: str = ""
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def finding(self) -> list[Judgement]:
        """The criteria and events; rates do not count, because a decoder alone never fires."""
        return [judged for judged in self.diff.finding if judged.metric.is_finding]

    @property
    def doing(self) -> Doing:
        """What the finding needs."""
        parts = [part for judged in self.finding for part in judged.parts]
        return doing_of({one.other: one.relation(part.margin) for one in part.contrasts} for part in parts)

    @property
    def seeds_to_decide(self) -> int | None:
        """About how many seeds decide what the finding needs, if the others are like these.

        None if it is decided already, or would not be by :data:`MOST_SEEDS`.
        """
        parts = [part for judged in self.finding for part in judged.parts]
        now = seeds = len(self.diff.grid.seeds)
        while self.doing is Doing.OPEN and seeds < MOST_SEEDS:
            seeds = max(seeds + 1, round(1.1 * seeds))
            later = [[one.estimate.scaled(seeds / now) for one in part.contrasts] for part in parts]
            p_values = iter(holm([estimate.p_different for row in later for estimate in row]))
            relations = (
                {
                    one.other: replace(one, estimate=estimate, p_different=next(p_values)).relation(
                        part.margin
                    )
                    for one, estimate in zip(part.contrasts, row, strict=True)
                }
                for part, row in zip(parts, later, strict=True)
            )
            if doing_of(relations) is not Doing.OPEN:
                return seeds
        return None

    @property
    def sentence(self) -> str:
        """The verdict in a sentence, which begins with the controls that were left out."""
        why = "" if self.finding else ", because the experiment has no criteria and no events"
        text = self.doing.format(n=len(self.diff.runs)) + why
        absent = [*self.left_out, *([DECODER] if self.without_decoder else [])]
        names = " and ".join(f"'{name}'" for name in absent)
        return f"Compared without {names}, {text[0].lower()}{text[1:]}" if absent else text

    @property
    def controls(self) -> list[str]:
        """The names of the controls."""
        return [name for name in self.diff.grid.wirings if name != ORIGINAL]

    @property
    def command(self) -> str:
        """The command that repeats the runs."""
        grid = self.diff.grid
        tried = (*self.controls, *self.left_out)
        controls = [name for name in tried if name != DECODER and name not in grid.others]
        named = [name for name in controls if not name.startswith(MATCHED)]
        parts = ["nrp", "diff", grid.experiment, "--evidence", "--seeds", str(len(grid.seeds))]
        parts += ["--controls", ", ".join(named)] if named else []
        values: dict[str, list[str]] = {}
        for name, changes in grid.others.items():
            values.setdefault(name.partition(":")[0], []).append(changes[0].partition("=")[2])
        for animal in values.pop("animal", ()):
            parts += ["--animal", animal]
        for kind, several in values.items():
            parts += [f"--{kind}s", ", ".join(several)]
        for key, drawn in grid.varied.items():
            parts += ["--vary", f"{key}={drawn}"]
        parts += [part for text in grid.overrides for part in ("-s", text)]
        return shlex.join(parts)

    @property
    def explained(self) -> dict[str, float]:
        """The share of the variance of each sink that decoders explain in the runs they were fitted to."""
        found = [one.explained_by_sink for one in self.diff.grid.decoders.values()]
        return {name: sum(one[name] for one in found) / len(found) for name in (found or [{}])[0]}

    def relation(self, name: str) -> Relation:
        """Return the relation of a control to the original, over all parts of the finding."""
        return controls_of(self.finding).get(name, Relation.OPEN)

    def effects(self, name: str) -> Iterator[tuple[Judgement, JudgedPart, Contrast]]:
        """Yield the effect of a control on each part of the finding."""
        for judged in self.finding:
            for part in judged.parts:
                for one in part.contrasts:
                    if one.other == name:
                        yield judged, part, one

    def runs(self, name: str) -> dict[GridCell, RunSignals]:
        """Return the runs of a control, or of the original."""
        return {cell: run for cell, run in self.diff.runs.items() if cell.wiring == name}

    def folder(self, cell: GridCell) -> Path:
        """Return the folder of the recording of a run."""
        return self.diff.grid.folder(self.diff.folder, cell)


def evidence_grid(
    experiment: str, controls: Sequence[str], others: Mapping[str, Sequence[str]], seeds: int,
    settings: Sequence[str], varied: Mapping[str, Any],
) -> RunGrid:  # fmt: skip
    """Return the grid of the runs without the decoder.

    Args:
        experiment: its name, file or folder.
        controls: controls of the wiring; by default the experiment's own, and all random ones.
        others: values of ``animal``, ``brain``, ``world`` and ``timestep`` that replace the experiment's own.
        seeds: number of seeds.
        settings: overrides of all runs.
        varied: settings that are drawn with each seed.

    Raises:
        ExperimentError: two files of animals have one name; or as for :meth:`RunGrid.of`.
    """
    grid = RunGrid.of(experiment, (), (), seeds, settings, varied, controls)
    wirings = dict.fromkeys([*grid.wirings, *(() if controls else WIRINGS)])
    for name in [*wirings]:
        kind, _, cells = name.partition(": ")
        if kind == SILENCE:
            wirings[f"{MATCHED}: {cells}"] = None
    own = {grid.brains[0], grid.worlds[0]}
    made: dict[str, Sequence[str]] = {}
    for name, changes in (
        OTHERS[key][1](value) for key, values in others.items() for value in values if value not in own
    ):
        if made.setdefault(name, changes) != changes:
            raise ExperimentError(f"two files have the name of '{name}', and each needs a name of its own")
    return replace(grid, wirings=(*wirings, *made), others=made, shows_voltages=True)


def gather(
    grid: RunGrid, results: Path, workers: int, on_progress: Progress, metrics: Sequence[Metric],
    margins: Margins,
) -> Evidence:  # fmt: skip
    """Make the runs, fit a decoder for each seed on the intact runs of the others, and judge all controls."""
    left_out: dict[str, str] = {}
    runs, missing = run_grid(grid, results, workers, on_progress, left_out), ""
    grid = replace(grid, wirings=tuple(name for name in grid.wirings if name not in left_out))
    try:
        decoders = _decoders({cell.seed: run for cell, run in runs.items() if cell.wiring == ORIGINAL})
        alone = replace(grid, wirings=(DECODER,), decoders=decoders)
        runs |= run_grid(alone, results, workers, on_progress)
        grid = replace(alone, wirings=(*grid.wirings, DECODER))
    except NrpError as error:
        missing = str(error)
    return Evidence(GridDiff.of(grid, runs, metrics, margins, results), missing, left_out)


def _decoders(intact: Mapping[int, RunSignals]) -> dict[int, Decoder]:
    if len(intact) < 2:
        raise ExperimentError("a decoder is fitted on the runs of other seeds, so it needs two seeds")
    return {seed: Decoder.fit([run for other, run in intact.items() if other != seed]) for seed in intact}
