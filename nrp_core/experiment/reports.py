"""Reports of a brain backend about the network of an experiment, without a run."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_core.brain.backends import brains
from nrp_core.brain.capabilities import Report
from nrp_core.errors import CapabilityError
from nrp_core.experiment.backends import named_errors
from nrp_core.experiment.making.maker import build_here, with_parameters
from nrp_core.experiment.making.prepare import build_network, select_backend
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Build, Experiment
from nrp_core.findings import Code


@dataclass(frozen=True, slots=True)
class Account:
    """The reports of one backend about one experiment.

    Args:
        experiment: name of the experiment.
        brain: name of the backend.
        neurons, synapses: the size of the network.
        digest: digest of the network.
        reports: the reports of the backend.
    """

    experiment: str
    brain: str
    neurons: int
    synapses: int
    digest: str
    reports: tuple[Report, ...]


def account_of(experiment: Experiment, build: Build = build_here) -> Account:
    """Build the network of an experiment and return the reports of its brain backend about it.

    Args:
        experiment: the experiment.
        build: makes the network; by default in this process.

    Raises:
        BackendError: the backend is missing or broken.
        CapabilityError: it does not report, or cannot simulate the network.
        InvalidExperimentError: anything else about the brain is wrong.
    """
    collector, name = Collector(experiment.source), experiment.brain.backend
    side = select_backend(collector, brains(), "brain", experiment.brain)
    collector.raise_errors()
    assert side is not None
    if not side.backend.has_reports(side.options):
        others = ", ".join(reporting()) or "none of the installed ones"
        raise CapabilityError(
            f"the brain backend '{name}' has no reports about networks; these have: {others}"
        )
    experiment, _ = with_parameters(experiment, collector)
    network = build_network(experiment, collector, build)
    collector.raise_errors()
    assert network is not None
    side.capabilities.require(network, name)
    with collector.during(Code.NRP216, "brain", "model"), named_errors(name, "report about the network"):
        reports = side.backend.reports(network, side.options)
    collector.raise_errors()
    synapses = sum(projection.size for projection in network.projections)
    return Account(experiment.name, name, network.size, synapses, network.digest, tuple(reports))


def reporting() -> list[str]:
    """Return the names of the installed brain backends that report about networks."""
    return [name for name in brains().names() if _reports(name)]


def _reports(name: str) -> bool:
    try:
        backend = brains().load(name)
        return backend.has_reports(backend.options())
    except Exception:  # noqa: BLE001  a broken backend does not hide the others
        return False
