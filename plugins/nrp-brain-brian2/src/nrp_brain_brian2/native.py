"""A script of Brian2 as a network: its groups are populations, whose cells and synapses stay in Brian2."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from nrp_core.brain import Network, Population
from nrp_core.network.picking import Selection, with_views

from nrp_brain_brian2.options import CELL


@dataclass(frozen=True, repr=False)
class NativeNetwork(Network):
    """The populations of a script that runs in Brian2.

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


def read_native(
    path: Path, *, populations: Mapping[str, Selection] | None = None, seed: int = 0
) -> NativeNetwork:
    """Execute a script of Brian2 up to its first ``run`` and return its groups as populations.

    Args:
        path: the script.
        populations: names for neurons, counted over all groups in the order of the script's variables.
        seed: the seed of Brian2's random numbers, unless the script calls ``seed``.

    Raises:
        NetworkError: the script raises, or ends without ``run``; with file and line.
        CapabilityError: it chooses a device of Brian2 that cannot stop between steps.
    """
    from nrp_brain_brian2.script import execute

    built = execute(path, seed)
    network = NativeNetwork(
        {label: Population(label, len(group), CELL, {}) for label, group in built.groups.items()},
        views=built.views,
        remarks=(f"'{path.name}' runs in Brian2 itself, so no other brain backend can run it",),
        script=path,
    )
    found = with_views(network, populations or {})
    assert isinstance(found, NativeNetwork)
    return found
