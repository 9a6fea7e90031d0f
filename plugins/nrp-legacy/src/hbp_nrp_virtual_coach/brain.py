"""The brain of a simulation and its populations: read and exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nrp_legacy.code import Source
from nrp_legacy.maker import ShimmedMaker

from hbp_nrp_virtual_coach.functions import Functions
from hbp_nrp_virtual_coach.once import log
from hbp_nrp_virtual_coach.populations import Selection, populations_of, with_brain
from hbp_nrp_virtual_coach.runner import STARTED, Runner
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code


class BrainEdits(Functions):
    """The part of a simulation that deals with its brain."""

    _model: Path | None = None
    _populations: Mapping[str, Selection] | None = None

    def get_brain(self) -> str:
        """Return the source of the brain.

        Raises:
            ExperimentError: it is not a script.
        """
        path = self._runner.call(lambda run: run.experiment.brain.model)
        if path.suffix != ".py":
            raise ExperimentError("the brain is not a script", path=path)
        return Source.of_file(path).text

    def edit_brain(self, source: str) -> None:
        """Build another brain; the simulation begins again at time 0 with the transfer functions that it has.

        Raises:
            NrpError: the brain cannot be built; the simulation begins again with the one that it had.
        """
        self._rebuild(self._draft("brain.py", source), self._populations)

    def get_populations(self) -> dict[str, Selection]:
        """Return the neurons of each population, as places in the brain's circuit."""
        return self._runner.call(lambda run: populations_of(run.experiment))

    def edit_populations(self, populations: Mapping[str, Selection]) -> None:
        """Name other neurons; the simulation begins again at time 0.

        Raises:
            NrpError: there are no such neurons; the simulation begins again with the names that it had.
        """
        if not isinstance(populations, Mapping):
            raise ExperimentError(f"populations are a dict of names and neurons, not {populations!r:.60}")
        self._rebuild(self._model, populations)

    def save_brain(self) -> None:
        """Write a changed brain into the files of the experiment.

        Raises:
            ExperimentError: these are not yours.
            LifecycleError: the simulation is stopped.
        """
        if self._model is not None:
            self._save(self._read().brain.model, self.get_brain())

    def _rebuild(self, model: Path | None, populations: Mapping[str, Selection] | None) -> None:
        was_running, began = self.get_state() == STARTED, self._runner.call(lambda run: run.loop.now_ns)
        machines = self._runner.call(_machines)
        before = self._runner.call(lambda run: run.brain.network.digest)
        if began:
            log.warning("another brain: the simulation begins again at time 0")
        self._runner.stop(silently=True)
        try:
            self._open(model, populations, machines)
        except Exception:
            self._open(self._model, self._populations, machines)
            raise
        self._model, self._populations = model, populations
        if self._runner.call(lambda run: run.brain.network.digest) == before:
            log.warning("the brain is as it was: the same cells, synapses and names of neurons")
        if was_running:
            self.start()

    def _open(
        self, model: Path | None, populations: Mapping[str, Selection] | None, machines: list[Path]
    ) -> None:
        """Go on with another brain, with the functions and machines that there are."""

        def read() -> Experiment:
            experiment = with_brain(self._read(), model, populations)
            if isinstance(experiment.maker, ShimmedMaker):
                experiment.maker.machines[:] = machines
            return experiment

        self._runner = Runner(read, self._tell, self._finish, self._launched)
        left_out = [one for one in self._runner.call(lambda run: run.found) if one.code in _NO_BRAIN]
        if left_out:
            self._runner.stop(silently=True)
            raise ExperimentError(left_out[0].message)
        self._runner.call(self._reapply)


_NO_BRAIN = (Code.NRP269, Code.NRP271)
"""Findings that there is not such a brain, or are not such neurons."""


def _machines(run: Run) -> list[Path]:
    maker = run.experiment.maker
    return list(maker.machines) if isinstance(maker, ShimmedMaker) else []
