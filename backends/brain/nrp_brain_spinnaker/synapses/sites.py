"""The cores on which synapses form and vanish, and the seeds of their random numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.host.cells import Layout
from nrp_brain_spinnaker.host.wiring import Wires, slots_available
from nrp_brain_spinnaker.machine.generator import valid_state
from nrp_brain_spinnaker.machine.rewired_rows import Rewired
from nrp_brain_spinnaker.options import cells_per_core, slices_of
from nrp_core._support.arrays import IntArray
from nrp_core.errors import CapabilityError
from nrp_core.network.rewiring import Rewiring
from nrp_core.network.synapses import STATIC, STDP

_ALIKE = ("partner", "f_rew", "initial_weight", "initial_delay_low", "initial_delay_high", "s_max")


@dataclass(frozen=True, slots=True)
class Group:
    """A projection at a site.

    Args:
        number: its index among the synapses of all sites.
        part: the projection.
        inside: whether each of its first synapses is at the site.
    """

    number: int
    part: Wires
    inside: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Site:
    """The core with the synapses onto a slice of a population.

    Args:
        label: the population.
        first, last: its cells, ``last`` excluded.
        rewiring: how synapses form and vanish there; its projections share these settings.
        groups: the projections.
    """

    label: str
    first: int
    last: int
    rewiring: Rewiring
    groups: list[Group] = field(default_factory=list)

    def sources_of(self, part: Wires) -> IntArray:
        """Return the source cells of a projection that have a row at this site."""
        if any(group.part is part for group in self.groups):
            return np.arange(part.n_pre)
        post = part.projection.post_index
        return np.unique(part.projection.pre_index[(post >= self.first) & (post < self.last)]).astype(
            np.int64
        )


def sites_of(wires: Sequence[Wires], layout: Layout) -> list[Site]:
    """Return the sites of all projections whose synapses form and vanish.

    Raises:
        CapabilityError: projections onto one population differ in a setting that a core has only once.
    """
    own = [part for part in wires if part.projection.rewiring is not None]
    sites, numbers = [], count()
    targets = {part.projection.post for part in own}
    for label in (each for each in layout.network.populations if each in targets):
        parts = [part for part in own if part.projection.post == label]
        _check(parts, [part for part in wires if part.projection.post == label], layout)
        target = layout.network.populations[label]
        for first, last in slices_of(target.size, cells_per_core(target, layout.options)):
            site = Site(label, first, last, _rewiring_of(parts[-1]))
            for part in parts:
                post = part.projection.post_index
                site.groups.append(Group(next(numbers), part, (post >= first) & (post < last)))
            sites.append(site)
    return sites


def _rewiring_of(part: Wires) -> Rewiring:
    assert part.projection.rewiring is not None
    return part.projection.rewiring


def _check(parts: Sequence[Wires], onto: Sequence[Wires], layout: Layout) -> None:
    """Check the settings that a core of the machine has only once."""
    settings = [_rewiring_of(part) for part in parts]
    target = layout.network.populations[parts[0].projection.post]
    most = slots_available(min(target.size, cells_per_core(target, layout.options)))
    for part, one in zip(parts, settings, strict=True):
        where = f"projection '{part.projection.label}'"
        for name in _ALIKE:
            if getattr(one, name) != getattr(settings[0], name):
                raise CapabilityError(
                    f"{where}: {name} is {getattr(one, name)}; on the machine all structural plasticity onto "
                    f"one population has the same, and '{parts[0].projection.label}' has "
                    f"{getattr(settings[0], name)}"
                )
        if part.projection.synapse_type not in (STATIC, STDP) or part.factor is not None:
            raise CapabilityError(
                f"{where}: on the machine synapses form and vanish with constant weights or STDP, in nA or uS"
            )
        low, high = part.new_ticks
        if not 1 <= low <= high <= most:
            raise CapabilityError(
                f"{where}: initial_delay goes from {one.initial_delay_low:g} to {one.initial_delay_high:g} "
                f"ms; on the machine it is 1 to {most} time steps"
            )
    sources = [part.projection.pre for part in parts]
    if len(set(sources)) < len(sources):
        raise CapabilityError(
            f"population '{target.label}': on the machine only one projection between two populations has "
            "structural plasticity"
        )
    if any(part.projection.synapse_type == STDP for part in onto) and any(
        part.projection.synapse_type == STATIC for part in parts
    ):
        raise CapabilityError(
            f"population '{target.label}': on the machine structural plasticity with constant weights and "
            "STDP do not end on one population; StructuralMechanismSTDP has both"
        )


def seed_sites(rewired: Rewired, sites: Sequence[Site], drawn: Callable[[str], IntArray]) -> None:
    """Set the random numbers of all sites to their beginning.

    The host draws the words of a population and then those of each core; cores with the same cells of
    populations with one stream have the same words.

    Args:
        rewired: the synapses.
        sites: their sites.
        drawn: returns the state of a generator by name, for populations without a seed.
    """
    streams: dict[str, np.random.RandomState] = {}
    words: dict[tuple[str, str | tuple[int, int]], IntArray] = {}
    for number, site in enumerate(sites):
        if site.rewiring.seed is None:
            rewired.sites.shared[number] = drawn(site.label)
            rewired.sites.local[number] = drawn(f"{site.label}/{site.first}")
            continue
        stream = site.rewiring.stream or site.label
        random = streams.setdefault(stream, np.random.RandomState(site.rewiring.seed))
        shared, local = (stream, site.label), (stream, (site.first, site.last))
        for key in (shared, local):
            words[key] = words[key] if key in words else _words(random)
        rewired.sites.shared[number], rewired.sites.local[number] = words[shared], words[local]


def _words(random: np.random.RandomState) -> IntArray:
    """Return a state as the host draws it; the largest word is never drawn."""
    return valid_state([int(random.randint(-(2**31), 2**31 - 1)) + 2**31 for _ in range(4)])
