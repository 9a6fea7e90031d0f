"""The synapses of every law on the machine, each law in a store of its own.

A law has a module with its arrays, its kernel and their loading. Here it has a field with its name, a line
in the kernels and a loader; :mod:`nrp_brain_spinnaker.models` says whether the released software has it.

Load the synapses that reward or punish, for :mod:`~nrp_brain_spinnaker.machine.stdp`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.host.cells import Layout
from nrp_brain_spinnaker.host.stdp_rules import load_plastic
from nrp_brain_spinnaker.host.weights import host_raw, is_machine_generated, machine_raw
from nrp_brain_spinnaker.host.wiring import Wires, collect
from nrp_brain_spinnaker.machine.stdp import Rewards, deliver_plastic, deliver_rewards, remember
from nrp_brain_spinnaker.machine.stdp_rows import StdpRows, changing_rows
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, Rows, deliver
from nrp_brain_spinnaker.models import CellModel
from nrp_brain_spinnaker.synapses.tsodyks_markram import (
    TsodyksRows,
    deliver_dynamic,
    load_dynamic,
    set_tau_syn,
)
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core.clock import nanoseconds
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Network, Projection
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

_SHIFT = 4
"""Dopamine is s4.11, like a weight with this left shift."""
_LARGEST = (1 << 15) - 1


def modulations_of(network: Network) -> dict[str, Neuromodulation]:
    """Return the parameters that the rewards and punishments of each population share, by its label.

    Raises:
        CapabilityError: they have not, or no STDP that they decide on.
    """
    found: dict[str, Neuromodulation] = {}
    for one in network.projections:
        if one.neuromodulation is None:
            continue
        if not one.neuromodulation.is_of_machine:
            raise CapabilityError(
                f"projection '{one.label}': baseline, shared and eligibility_limits keep their defaults on "
                "the machine; 'event' has them"
            )
        known = found.setdefault(one.post, one.neuromodulation)
        if known != one.neuromodulation:
            raise CapabilityError(
                f"projection '{one.label}': on the machine all rewards and punishments of one population "
                "have the same tau_c, tau_d, w_min and w_max"
            )
        onto = [other for other in network.projections if other.post == one.post]
        if any(other.rewiring is not None for other in onto):
            raise CapabilityError(
                f"projection '{one.label}': rewards and structural plasticity on one population are not "
                "supported together"
            )
        if not any(other.synapse_type == STDP and other.size for other in onto):
            raise CapabilityError(
                f"projection '{one.label}': rewards and punishments decide on changes by STDP; no synapses "
                f"onto '{one.post}' have it"
            )
        if any(other.pre == one.pre and other.neuromodulation is None for other in onto):
            raise CapabilityError(
                f"projection '{one.label}': on the machine '{one.pre}' cannot reward '{one.post}' and have "
                "other synapses onto it, too; use another source population"
            )
    return found


def load_rewards(wires: Sequence[Wires], layout: Layout) -> Rewards | None:
    """Return the synapses that reward or punish the targets of STDP synapses, or None.

    Raises:
        NetworkError: a weight or a delay is not one of the machine.
    """
    targets = {part.projection.post: part for part in wires if part.projection.synapse_type == STDP}
    ids, to, dopamine = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for one in layout.network.projections:
        if one.neuromodulation is not None and one.size:
            target = targets[one.post]
            ids.append(one.pre_index.astype(np.int64) + layout.network.offsets[one.pre])
            to.append(one.post_index.astype(np.int64) + target.post_first)
            dopamine.append(_dopamine(one, target.model, layout))
    every = np.concatenate(ids)
    if not every.size:
        return None
    order = np.argsort(every, kind="stable")
    start: IntArray = np.searchsorted(every[order], np.arange(layout.n_sources + 1)).astype(np.int64)
    return Rewards(start, np.concatenate(to)[order], np.concatenate(dopamine)[order])


def _dopamine(projection: Projection, model: CellModel, layout: Layout) -> IntArray:
    """Return the change of dopamine by each synapse, s4.11."""
    where, weight = f"projection '{projection.label}'", projection.weight
    step_ms = layout.grid.step_us / 1000
    late = np.flatnonzero(nanoseconds(projection.delay_ms) > 1000 * layout.grid.step_us)
    if late.size:
        raise NetworkError(
            f"{where}: the delay of synapse {late[0]} is {projection.delay_ms[late[0]]:g} ms; rewards and "
            f"punishments act at once on the machine: leave the delay out, or give a step, {step_ms:g} ms"
        )
    wrong = np.flatnonzero((weight < 0) | (np.rint(weight * 2**11) > _LARGEST))
    if wrong.size:
        raise NetworkError(
            f"{where}: the weight of synapse {wrong[0]} is {weight[wrong[0]]:g}; dopamine is a number from 0 "
            "to less than 16 on the machine; a punishment has the receptor 'punishment'"
        )
    on_machine = layout.options.weights == "machine" and is_machine_generated(projection, model)
    raw = (machine_raw if on_machine else host_raw)(weight, _SHIFT, 1).astype(np.int64)
    return raw if projection.receptor == "reward" else -raw


class Stores(NamedTuple):
    """The arrays of the synapses; a field has the name of its law. Spikes pass through them in this order.

    Rewarding and punishing synapses act on those with STDP. Those that form and vanish are separate: a spike
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
