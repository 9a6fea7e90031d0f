"""Opens another run for a session: next to its own, or in place of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nrp_cockpit.session.beside import Beside
from nrp_cockpit.session.controls import asked, prefixed, services_of
from nrp_cockpit.session.findings import finding_data
from nrp_cockpit.session.functions import Functions
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.wire.hub import Service, Services
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError, ExperimentError, LifecycleError, NrpError
from nrp_core.experiment import Experiment, Run
from nrp_core.findings import Code, Finding, InvalidExperimentError

Read = Callable[[Sequence[str]], Experiment]
"""Reads the experiment of a session anew, with further overrides."""


class Opening:
    """Opens and closes further runs of a session. All methods belong to the thread of the session.

    Args:
        session: the session.
        read: reads its experiment anew.

    Attributes:
        session: the session.
        read_with: reads its experiment again, with these further overrides.
        on_exchange: called when the session continues with another run.
    """

    def __init__(self, session: LiveSession, read: Read) -> None:
        self.session, self.read_with = session, read
        self._settings: list[str] = []
        self.on_exchange: Callable[[], None] = lambda: None

    def anew(self, settings: Sequence[str], texts: Mapping[str, str]) -> dict[str, Any]:
        """Begin again with a changed experiment, which applies from then on.

        Args:
            settings: ``dotted.key=value``, added to the earlier ones.
            texts: the texts of its transfer functions, by file.

        Returns:
            Whether the new run is open, and the findings that prevent it; then the old one continues.

        Raises:
            LifecycleError: a second run is open.
        """
        self._require_alone()
        before, self._settings = self._settings, [*settings, "transfer_functions=[]"]
        found = self._exchanged(texts)
        if found["applied"]:
            self.on_exchange()
        else:
            self._settings = before
        return found

    def _exchanged(self, texts: Mapping[str, str]) -> dict[str, Any]:
        with ExitStack() as unless_used:
            try:
                run = unless_used.enter_context(Run(self._read([])))
            except InvalidExperimentError as error:
                return {"applied": False, "findings": [finding_data(each) for each in error.findings]}
            except NrpError as error:
                return {"applied": False, "findings": [finding_data(Finding(Code.NRP210, str(error)))]}
            functions = Functions(run, self.session.functions)
            unless_used.callback(functions.close)
            found = _with_texts(functions, texts)
            if found["applied"]:
                self.session.exchange(run, functions)
                unless_used.pop_all()
        return found

    def _read(self, overrides: Sequence[str]) -> Experiment:
        return self.read_with([*self._settings, *overrides])

    def reseed(self, seed: int) -> None:
        """Restart with another seed and the present functions.

        Raises:
            CapabilityError: the edited functions cannot be used.
            ExperimentError: it is not a seed.
            LifecycleError: a second run is open.
        """
        self._require_alone()
        setting, texts = f"seed={seed}", self.session.functions.texts
        with ExitStack() as unless_used:
            run = unless_used.enter_context(Run(self._read([setting])))
            functions = Functions(run, self.session.functions)
            unless_used.callback(functions.close)
            _take_texts(functions, texts)
            self.session.exchange(run, functions)
            unless_used.pop_all()
        self._settings = [*self._settings, setting]
        self.on_exchange()

    def branch(self, t_s: float | None = None, id: str | None = None) -> None:  # noqa: A002
        """Open a second future of the run.

        Args:
            t_s: the time from which both continue; by default now.
            id: the snapshot from which both continue.

        Raises:
            CapabilityError: the run cannot be saved.
            LifecycleError: a second run is already open, or the run has failed.
        """
        session = self.session
        self._require_alone()
        if id is not None:
            session.restore(id)
        elif t_s is not None:
            session.seek(t_s)
        snapshot, texts = session.run.snapshot(), session.functions.texts
        label = f"Branch of {seconds(session.now_ns):.2f} s"
        beside = self._open(session.run.experiment, label, "The run", snapshot, texts)
        beside.reports.all()
        session.reports.all()

    def compare(self, brain: str | None = None, world: str | None = None) -> None:
        """Begin again, with a second run of the experiment on other engines.

        Args:
            brain: the name of its brain backend; by default that of the run.
            world: the name of its world backend; by default that of the run.

        Raises:
            ExperimentError: a backend is not installed, or neither is given.
        """
        self._require_alone()
        given = {"brain": brain, "world": world}
        overrides = [f"{side}.backend={name}" for side, name in given.items() if name]
        if not overrides:
            raise ExperimentError("a comparison needs a different brain or world")
        other = self._read(overrides)
        lead, texts = self.session.run.experiment, self.session.functions.texts
        beside = self._open(other, _pair(other), _pair(lead), texts=texts)
        self.session.reset()
        beside.reports.all()

    def part(self) -> None:
        """Close the second run; the first continues alone.

        Raises:
            LifecycleError: no second run is open.
        """
        session = self.session
        if session.beside is None:
            raise LifecycleError("there is no second run")
        beside, session.beside, session.hub.beside = session.beside, None, None
        beside.end()
        session.reports.all()

    def _require_alone(self) -> None:
        if self.session.beside is not None:
            raise LifecycleError("a second run is already open: close it first")
        if self.session.run.error is not None:
            raise LifecycleError("the run has failed: step back or reset")

    def _open(
        self,
        experiment: Experiment,
        label: str,
        lead_label: str,
        snapshot: bytes | None = None,
        texts: dict[str, str] | None = None,
    ) -> Beside:
        session, run = self.session, Run(experiment)
        try:
            functions = Functions(run, self.session.functions)
            _take_texts(functions, functions.texts if texts is None else texts)
            if snapshot is not None:
                _take_over(run, session.run, snapshot)
            hub = session.hub.open_second()
            beside = Beside(run, hub, session, label, lead_label, functions)
            hub.services = services_of(beside)
        except BaseException:
            session.hub.beside = None
            run.close()
            raise
        session.beside = beside
        return beside


def _take_texts(functions: Functions, texts: Mapping[str, str]) -> None:
    """Use the texts of another run of the experiment.

    Raises:
        CapabilityError: that is not possible.
    """
    if texts == functions.texts:
        functions.doubt()
    elif not _with_texts(functions, texts)["applied"]:
        raise CapabilityError("the other run cannot use the edited functions")


def _with_texts(functions: Functions, texts: Mapping[str, str]) -> dict[str, Any]:
    """Apply the texts of other functions, whose files may be new here."""
    for name in texts:
        functions.include(Path(name))
    return functions.apply(texts)


def _take_over(run: Run, lead: Run, snapshot: bytes) -> None:
    """Bring a run to the state of another run of the same experiment."""
    there = {function.name for function in lead.loop.functions}
    run.loop.change(remove=[one.name for one in run.loop.functions if one.name not in there])
    run.restore(snapshot)


def _pair(experiment: Experiment) -> str:
    return f"{experiment.brain.backend} + {experiment.world.backend}"


def with_opening(services: Services, opening: Opening) -> Services:
    """Return the services of a run, with those that open a second run."""
    session = opening.session
    more: dict[str, Service] = {
        "branch": asked(session, opening.branch, "opening a branch"),
        "compare": asked(session, opening.compare, "opening the other engines"),
        "part": asked(session, opening.part, "closing the second run"),
        "reseed": asked(session, opening.reseed, "beginning with another seed"),
    }
    return services | prefixed(more, {})
