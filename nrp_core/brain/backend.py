"""What a distribution provides of a spiking simulator: its capabilities, its options, and brains."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import ConfigDict

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.diagnosis import Diagnosis
from nrp_core._support.plain_numbers import PlainNumbers
from nrp_core.brain.capabilities import BrainCapabilities, Report
from nrp_core.findings import Finding
from nrp_core.network.data import Network

if TYPE_CHECKING:
    from nrp_core.brain.interface import Brain

BRAIN_INTERFACE_VERSION = 1
"""Version of this interface; a backend states the one it was written for as ``interface_version``."""


class BrainOptions(PlainNumbers):
    """Base class of a backend's options in an experiment file; unknown names are errors.

    Attributes:
        before: for each option whose default changed results when the option was added, the value that gives
            the earlier results; recordings without the option are replayed with it.
    """

    before: ClassVar[Mapping[str, Any]] = {}
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @property
    def inner(self) -> Mapping[str, BrainOptions]:
        """Options of other backends in these, by their place: a dotted name."""
        return {}

    def names(self) -> list[str]:
        """Return the names of all options, those of other backends with their places."""
        more = (f"{place}.{name}" for place, inner in self.inner.items() for name in inner.names())
        return sorted([*type(self).model_fields, *more])

    def earlier(self) -> dict[str, Any]:
        """Return :attr:`before`, with that of other backends in these."""
        more = ((place, *item) for place, inner in self.inner.items() for item in inner.earlier().items())
        return {**self.before, **{f"{place}.{name}": value for place, name, value in more}}


class BrainBackend(ABC):
    """The entry point of a brain simulator. It must be cheap to import and construct.

    Attributes:
        interface_version: the version of this interface that it was written for; 1 by default.
        options: the class of its options.
    """

    interface_version: ClassVar[int] = 1
    options: ClassVar[type[BrainOptions]] = BrainOptions

    def __init_subclass__(cls, **named: Any) -> None:
        """Let the ``open`` of each backend check its arguments."""
        super().__init_subclass__(**named)
        if "open" in vars(cls):
            setattr(cls, "open", checks_arguments(options=cls.options)(vars(cls)["open"]))  # noqa: B010

    @abstractmethod
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        """Return the backend's capabilities with these options, without loading the simulator."""

    def diagnose(self) -> list[Diagnosis]:
        """Check this machine for the requirements of the backend; may load the simulator."""
        return []

    def warnings(self, network: Network, options: BrainOptions) -> Sequence[Finding | str]:
        """Return the parts of a network that the simulator would change or ignore: findings, or texts.

        Called before every run.

        Raises:
            NetworkError, CapabilityError: the simulator cannot run the network.
        """
        return []

    def has_reports(self, options: BrainOptions) -> bool:
        """Return whether :meth:`reports` reports with such options; by default, whether it is overridden."""
        return type(self).reports is not BrainBackend.reports

    def reports(self, network: Network, options: BrainOptions) -> list[Report]:
        """Return reports about a network on this backend, before it runs; none by default.

        Raises:
            NetworkError, CapabilityError: the simulator cannot run the network.
        """
        return []

    @abstractmethod
    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        """Load a network into the simulator, at time 0."""
