"""Experiments in our own format whose files still need the platform, as ``nrp import`` writes them.

Their ``experiment.yaml`` declares it: ``compatibility: {platform: hbp_nrp}``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from nrp_core.brain import Network
from nrp_core.dsl import Listing, PythonSource, TransferFunction, load_transfer_functions
from nrp_core.experiment import Build, Collector, Experiment, Omission, Platform, Section, build_here
from nrp_core.findings import Code
from nrp_core.paths import ExistingFile
from nrp_legacy.brains import load_script
from nrp_legacy.code import Source
from nrp_legacy.files import Library
from nrp_legacy.maker import ShimmedMaker
from nrp_legacy.reader import read_described
from nrp_legacy.state_machines import check_machine_file

RESOURCES = "resources"
"""The folder, beside transfer functions, whose modules they can import."""


class Options(Section):
    """The platform options of an experiment, except names and modules."""

    nest_units: bool = False
    """Whether transfer functions set devices in pA, nS and pF, as where NEST is used without PyNN."""
    state_machines: tuple[ExistingFile, ...] = ()
    """Files with state machines, which run beside the loop."""


class ImportedMaker(ShimmedMaker):
    """Makes one experiment.

    Args:
        experiment: the experiment.
        options: its platform options.
    """

    def __init__(self, experiment: Experiment, options: Options) -> None:
        files = (*experiment.transfer_functions, *options.state_machines)
        folders = dict.fromkeys(path.parent for path in files)
        super().__init__(
            experiment.place("compatibility").path,
            Library(experiment.place("name").folder, experiment.models),
            options.state_machines,
            [place for folder in folders for place in (folder / RESOURCES, folder)],
            nest_units=options.nest_units,
        )
        for path in options.state_machines:
            self._notes += check_machine_file(path)

    def network(self, experiment: Experiment, build: Build = build_here) -> Network:
        brain = experiment.brain
        if isinstance(brain.model, dict) or brain.model.suffix != ".py":
            return super().network(experiment, build)
        script = partial(
            load_script, brain.model, experiment.seed, brain.populations, self._folders, self.library,
            brain.parameters,
        )  # fmt: skip
        return self._known(build(script), brain.model)

    def _codes(self, experiment: Experiment) -> Iterator[str]:
        return (Source.of_file(path).text for path in experiment.transfer_functions)

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        self.names = self._begun(experiment)
        loaded: list[TransferFunction] = []
        for i, path in enumerate(experiment.transfer_functions):
            omission = Omission(Code.NRP272, "file", path.name)
            with collector.during(Code.NRP210, "transfer_functions", i, omission=omission):
                loaded += self._load(path)
        yield from self._ready(loaded, collector)

    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        names = self._begun(experiment)  # a run may use those of its functions
        sources: list[PythonSource] = []
        for i, path in enumerate(experiment.transfer_functions):
            omission = Omission(Code.NRP272, "file", path.name)
            with collector.during(Code.NRP210, "transfer_functions", i, omission=omission):
                tree = Source.of_file(path).tree(self._note)
                sources.append(PythonSource(path, tree))
        yield self._listing(names, sources, collector)

    def _load(self, path: Path) -> list[TransferFunction]:
        """Return the functions of a file; the names of a file without functions are shared with others."""
        code = Source.of_file(path).compiled(self._note)
        return load_transfer_functions(path, module=self.names.module, code=code, scope=self.names.scope)


PLATFORM = Platform(Options, ImportedMaker, read_described)
