"""Native scripts as networks: their cells are populations, whose models and synapses stay in a simulator."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from nrp_core._support.arrays import IntArray
from nrp_core.network.data import Network, Population
from nrp_core.network.picking import Selection, with_views


@dataclass(frozen=True, repr=False)
class NativeNetwork(Network):
    """The populations of a script that runs in a simulator of its own.

    Args:
        script: the script.
    """

    script: Path = field(kw_only=True)

    @cached_property
    def digest(self) -> str:
        """Hash of the populations and of the script."""
        state = hashlib.blake2b(self.script.read_bytes(), digest_size=16)
        state.update(Network.digest.func(self).encode())  # type: ignore[attr-defined]
        return state.hexdigest()


def native_network(
    script: Path,
    populations: Iterable[Population],
    *,
    views: Mapping[str, IntArray],
    named: Mapping[str, Selection] | None,
    simulator: str,
) -> NativeNetwork:
    """Return a script as a network that says that no other simulator can run it.

    Args:
        script: the script.
        populations: its cells.
        views: its names for some of them.
        named: names of the experiment for neurons, counted over all populations.
        simulator: the simulator, as people write it.

    Raises:
        NeuronSelectionError: the script has no such cells.
    """
    network = NativeNetwork(
        {one.label: one for one in populations},
        views=views,
        remarks=(f"'{script.name}' runs in {simulator} itself, so no other brain backend can run it",),
        script=script,
    )
    found = with_views(network, named or {})
    assert isinstance(found, NativeNetwork)
    return found
