"""Rewards: NEST's ``stdp_dopamine_synapse``, whose dopamine comes through a ``volume_transmitter``.

In NEST each spike that a transmitter receives adds ``1 / tau_n`` to the dopamine, whatever the weight of its
connection. A spike that brings another amount has the same effect if the amplitudes of STDP are larger by
the factor ``amount * tau_n`` and the baseline is lower by it: eligibility then is larger by this factor, and
dopamine smaller.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from nrp_core.brain import (
    DOPAMINE,
    ELIGIBILITY,
    FloatArray,
    Grid,
    IntArray,
    Network,
    Neuromodulation,
    Projection,
    modulations_of,
)
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

MODEL: Final = "stdp_dopamine_synapse"
STATE: Final[Mapping[str, str]] = {ELIGIBILITY: "c", DOPAMINE: "n"}
"""NEST's names of the state of synapses that learn from rewards."""
_UPDATE_NS: Final = NS_PER_MS
"""Time between two updates of all synapses, if steps are shorter; reading shows them as of the last one."""


class Rewards:
    """The dopamine of the populations of a network.

    Args:
        nest: the module.
        network: the network.
        grid: NEST's time grid.

    Raises:
        CapabilityError: NEST does not have such rewards.
    """

    def __init__(self, nest: Any, network: Network, grid: Grid) -> None:
        self._nest, self._grid = nest, grid
        self._update_ns = max(grid.step_ns, _UPDATE_NS - _UPDATE_NS % grid.step_ns)
        self._modulations = modulations_of(network)
        self._transmitters: dict[str, Any] = {}
        self._gains: dict[str, float] = {}
        for label, modulation in self._modulations.items():
            ways = [one for one in network.projections if one.neuromodulation and one.post == label]
            for way in ways:
                _require_same_meaning(way, modulation)
            self._transmitters[label] = nest.Create("volume_transmitter")
            self._transmitters[label].deliver_interval = self._update_ns // grid.step_ns
            amount = _amount([_spikes(way, grid, network.populations[label].size) for way in ways], label)
            self._gains[label] = amount * modulation.tau_d

    def connect(self, projection: Projection, nodes: IntArray, relayed_steps: int) -> None:
        """Let the spikes of a projection reach the transmitter of its target.

        Args:
            projection: it rewards.
            nodes: the NEST ids of its source cells.
            relayed_steps: the steps by which their spikes are late.
        """
        pre, steps, _ = _spikes(projection, self._grid, 1)
        if self._gains[projection.post] == 0.0:
            return
        transmitter = np.full(len(pre), self._transmitters[projection.post].tolist()[0])
        delays = self._grid.time_ms(np.maximum(steps - relayed_steps, 1))
        synapses = {"weight": np.ones(len(pre)), "delay": delays}
        self._nest.Connect(nodes[pre], transmitter, "one_to_one", synapses)

    def model(
        self, projection: Projection, number: int, values: Mapping[str, FloatArray], unit: float
    ) -> str:
        """Return the NEST model of the synapses of a projection that learns, which is made.

        Args:
            projection: the projection.
            number: of this model among those that are made.
            values: the parameters of its STDP, for each synapse.
            unit: its weights in NEST for each of PyNN's.

        Raises:
            CapabilityError: the synapses have different parameters.
        """
        for name, each in values.items():
            if (each != each[0]).any():
                raise CapabilityError(
                    f"projection '{projection.label}': in NEST all synapses that learn from the same rewards "
                    f"have one {name}"
                )
        rule = {name: float(each[0]) for name, each in values.items()}
        modulation, gain = self._modulations[projection.post], self._gains[projection.post] or 1.0
        name = f"{MODEL}_{number}"
        self._nest.CopyModel(MODEL, name, {
            "volume_transmitter": self._transmitters[projection.post],
            "A_plus": gain * rule["A_plus"] * rule["w_max"] * unit,
            "A_minus": gain * rule["A_minus"] * rule["w_max"] * unit,
            "tau_plus": rule["tau_plus"], "tau_c": modulation.tau_c, "tau_n": modulation.tau_d,
            "b": modulation.baseline / gain, "Wmin": modulation.w_min * unit, "Wmax": modulation.w_max * unit,
        })  # fmt: skip
        return name

    def has(self, projection: Projection) -> bool:
        """Return whether a plastic projection learns from rewards."""
        return projection.post in self._modulations

    def baseline(self, projection: Projection) -> float:
        """Return the dopamine at which the weights of a projection stay."""
        return self._modulations[projection.post].baseline

    def amount(self, projection: Projection, amount: float, now_ns: int) -> float:
        """Return dopamine from outside in NEST's units.

        Raises:
            CapabilityError: NEST has no dopamine value for this time.
        """
        if now_ns % self._update_ns:
            raise CapabilityError(
                f"on NEST rewards come from outside at multiples of {self._update_ns / NS_PER_MS:g} ms, when "
                f"all synapses are updated, not at {now_ns / NS_PER_MS:g} ms; 'event' takes any time"
            )
        return amount / self.scale(projection, DOPAMINE, 1.0)

    def scale(self, projection: Projection, variable: str, unit: float) -> float:
        """Return a state variable of a projection for each unit of NEST's."""
        gain = self._gains[projection.post] or 1.0
        return gain if variable == DOPAMINE else 1.0 / (gain * unit)


def _require_same_meaning(way: Projection, modulation: Neuromodulation) -> None:
    where = f"projection '{way.label}'"
    if not modulation.shared or modulation.eligibility_limits:
        raise CapabilityError(
            f"{where}: in NEST all cells share their dopamine, and the eligibility has no limits; give "
            "Neuromodulation shared=True and eligibility_limits=False, or run on 'event'"
        )
    if way.receptor != "reward" or (way.weight < 0).any():
        raise CapabilityError(f"{where}: in NEST spikes only add dopamine; 'event' has punishments")


def _spikes(way: Projection, grid: Grid, cells: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the distinct spikes of each source: its index, their delay in steps, and their amount.

    Args:
        way: the projection.
        grid: the time grid.
        cells: number of cells that share the dopamine.
    """
    keys = np.column_stack([way.pre_index.astype(np.int64), grid.delays(way.delay_ms)])
    kept, of = np.unique(keys, axis=0, return_inverse=True)
    amounts = np.bincount(of.reshape(-1), way.weight, len(kept)) / cells
    return kept[:, 0], kept[:, 1], amounts


def _amount(spikes: list[tuple[IntArray, IntArray, FloatArray]], label: str) -> float:
    """Return the amount of dopamine that every spike releases."""
    amounts = np.concatenate([each for _, _, each in spikes])
    if not len(amounts):
        return 0.0
    if not np.allclose(amounts, amounts[0], rtol=1e-9, atol=0.0):
        raise CapabilityError(
            f"population '{label}': in NEST every spike that rewards brings the same dopamine, not "
            f"{amounts.min():g} to {amounts.max():g}; give all rewards one weight, or run on 'event'"
        )
    return float(amounts[0])
