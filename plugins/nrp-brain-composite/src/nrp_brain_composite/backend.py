"""The entry point. A composite brain knows no simulator: its parts are opened by their entry points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import reduce
from typing import Any, ClassVar

from nrp_brain_composite.cut import Part, cut_network, resolution_ns
from nrp_brain_composite.options import CompositeOptions
from nrp_core.brain import Brain, BrainBackend, BrainCapabilities, BrainOptions, Finding, Network, Report
from nrp_core.simulation import Determinism


@dataclass(frozen=True, slots=True)
class CompositeCapabilities(BrainCapabilities):
    """The capabilities that all parts have.

    What a population needs is required of its own part, or of all parts that share the rest of the network.
    """

    _options: CompositeOptions | None = None

    def require(self, network: Network, name: str) -> None:
        assert self._options is not None
        cut = cut_network(network, self._options)
        for part in cut.parts:
            for one in cut.sharing if part.name in cut.sharing else (part.name,):
                given = self._options.parts[one]
                given.capabilities.require(part.network, f"{name}, {given.title(one)},")


def common_capabilities(every: Iterable[BrainCapabilities]) -> dict[str, Any]:
    """Return the values of the capabilities that all of some backends have, by name.

    Sets are intersected; the cells that are only approximated by one of them are joined.
    """
    parts = list(every)
    found: dict[str, Any] = {}
    for one in fields(BrainCapabilities):
        values = [getattr(part, one.name) for part in parts]
        if isinstance(values[0], frozenset):
            found[one.name] = reduce(frozenset.intersection, values)
        elif isinstance(values[0], bool):
            found[one.name] = all(values)
    found["approximate"] = frozenset[str]().union(*(part.approximate for part in parts)) & found["cells"]
    levels = list(Determinism)
    found["determinism"] = max((part.determinism for part in parts), key=levels.index)
    return found


class CompositeBackend(BrainBackend):
    """Several backends as one: each simulates some of the populations of the network."""

    options: ClassVar[type[BrainOptions]] = CompositeOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, CompositeOptions)
        common = common_capabilities(part.capabilities for part in options.parts.values())
        return CompositeCapabilities(
            **common | {"late_spikes": False},
            resolution_ns=resolution_ns(options),
            _options=options,
        )

    def warnings(self, network: Network, options: BrainOptions) -> list[Finding | str]:
        found: list[Finding | str] = []
        for part in _parts_of(network, options):
            backend, own = part.options.loaded
            for one in backend.warnings(part.network, own):
                if isinstance(one, Finding):
                    found.append(replace(one, message=f"{part.title}: {one.message}"))
                else:
                    found.append(f"{part.title}: {one}")
        return found

    def has_reports(self, options: BrainOptions) -> bool:
        assert isinstance(options, CompositeOptions)
        every = (part.loaded for part in options.parts.values())
        return any(backend.has_reports(own) for backend, own in every)

    def reports(self, network: Network, options: BrainOptions) -> list[Report]:
        found: list[Report] = []
        for part in _parts_of(network, options):
            backend, own = part.options.loaded
            found += (
                replace(one, name=f"{part.name}.{one.name}", title=f"{part.title}: {one.title}")
                for one in backend.reports(part.network, own)
            )
        return found

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        from nrp_brain_composite.brain import CompositeBrain

        assert isinstance(options, CompositeOptions)
        return CompositeBrain(network, seed=seed, capabilities=self.capabilities(options), options=options)


def _parts_of(network: Network, options: BrainOptions) -> tuple[Part, ...]:
    assert isinstance(options, CompositeOptions)
    return cut_network(network, options).parts
