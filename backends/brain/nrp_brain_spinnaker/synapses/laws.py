"""The synapses of every law on the machine, each law in a store of its own.

A law has a module with its arrays, its kernel and their loading. Here it has a field with its name, a line
in the kernels and a loader; :mod:`nrp_brain_spinnaker.models` says whether the released software has it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy.typing as npt

from nrp_brain_spinnaker.host.plastic_rows import load_plastic
from nrp_brain_spinnaker.host.rows import collect
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.neuromodulation import Rewards, deliver_rewards
from nrp_brain_spinnaker.machine.ring import Ring, Rows, deliver
from nrp_brain_spinnaker.machine.stdp import deliver_plastic, remember
from nrp_brain_spinnaker.machine.stdp_rows import StdpRows, changing_rows
from nrp_brain_spinnaker.synapses.layout import Layout
from nrp_brain_spinnaker.synapses.rewards import load_rewards, modulations_of
from nrp_brain_spinnaker.synapses.tsodyks_markram import (
    TsodyksRows,
    deliver_dynamic,
    load_dynamic,
    set_tau_syn,
)
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.network.synapses import STATIC, STDP, TSODYKS_MARKRAM


class Stores(NamedTuple):
    """The arrays of the synapses; a field has the name of its law. Spikes pass through them in this order.

    Those that reward or punish act on those with STDP. Those that form and vanish are apart, because a spike
    copies all that it passes to a function.
    """

    static: Rows
    tsodyks_markram: TsodyksRows
    stdp: StdpRows
    rewards: Rewards | None


@jit
def send(stores: Stores, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) through all its synapses."""
    deliver(stores.static, ring, neuron, tick)
    deliver_dynamic(stores.tsodyks_markram, ring, neuron, tick)
    deliver_plastic(stores.stdp, stores.rewards, ring, neuron, tick)
    deliver_rewards(stores.rewards, stores.stdp, neuron, tick)


@jit
def note_spike(stores: Stores, i: int, tick: int) -> None:
    """Let the synapses onto simulated neuron ``i`` learn that it fired."""
    remember(stores.stdp, i, tick)


def _load_static(wires: Sequence[Wires], layout: Layout) -> Rows:
    return collect(wires, layout.n).rows(layout.n_sources)


def _load_stdp(wires: Sequence[Wires], layout: Layout) -> StdpRows:
    return load_plastic(
        wires, layout.n_sources, layout.n, layout.grid.step_us, layout.options.semantics,
        modulations_of(layout.network),
    )  # fmt: skip


_LOADERS: Final[Mapping[str, Callable[[Sequence[Wires], Layout], Any]]] = {
    STATIC: _load_static,
    TSODYKS_MARKRAM: load_dynamic,
    STDP: _load_stdp,
}


def load_stores(wires: Sequence[Wires], layout: Layout) -> Stores:
    """Return the synapses of projections, without those that form and vanish.

    Raises:
        NetworkError: a parameter does not fit the machine.
        CapabilityError: a plasticity rule that the machine does not have.
    """
    lasting = [part for part in wires if part.projection.rewiring is None]
    return Stores(
        **{
            law: load([part for part in lasting if part.projection.synapse_type == law], layout)
            for law, load in _LOADERS.items()
        },
        rewards=load_rewards(lasting, layout),
    )


def follow_targets(stores: Stores, tau_syn: IntArray, first: int, last: int) -> None:
    """Take over the time constants (s16.15, of each line) of synapses onto neurons from ``first`` on."""
    set_tau_syn(stores.tsodyks_markram, tau_syn, first, last)


def changing(stores: Stores) -> list[npt.NDArray[Any]]:
    """Return the arrays that running changes."""
    return [stores.tsodyks_markram.state, *changing_rows(stores.stdp)]
