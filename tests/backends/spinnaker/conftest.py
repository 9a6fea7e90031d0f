"""Networks for the spinnaker backend, made of few words."""

from collections.abc import Callable

import numpy as np
import pytest
from nrp_brain_spinnaker import SpinnakerBackend, SpinnakerOptions

from nrp_core.brain.interface import Brain
from nrp_core.brain.network import STATIC, Network, Population, Projection

_LEAKY = {
    "v_rest": -65.0, "cm": 1.0, "tau_m": 20.0, "tau_refrac": 2.0, "v_reset": -65.0, "v_thresh": -50.0,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "e_rev_E": 0.0, "e_rev_I": -70.0, "i_offset": 0.0,
}  # fmt: skip
_ADAPTIVE = _LEAKY | {
    "cm": 0.281, "tau_m": 9.3667, "v_rest": -70.6, "v_reset": -70.6, "v_thresh": -50.4, "v_spike": -40.0,
    "delta_T": 2.0, "a": 4.0, "b": 0.0805, "tau_w": 144.0, "e_rev_I": -80.0,
}  # fmt: skip
_HODGKIN_HUXLEY = {
    "gbar_Na": 20.0, "gbar_K": 6.0, "g_leak": 0.01, "cm": 0.2, "v_offset": -63.0, "e_rev_Na": 50.0,
    "e_rev_K": -90.0, "e_rev_leak": -65.0, "e_rev_E": 0.0, "e_rev_I": -80.0, "tau_syn_E": 0.2,
    "tau_syn_I": 2.0, "i_offset": 0.0,
}  # fmt: skip
_IZHIKEVICH = {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "i_offset": 0.0}
_DEFAULTS = {
    "IF": _LEAKY,
    "EIF": _ADAPTIVE,
    "HH": _HODGKIN_HUXLEY,
    "Izhikevich": _IZHIKEVICH,
    "IZK": _IZHIKEVICH,
}


@pytest.fixture
def cells() -> Callable[..., Population]:
    """Make cells of a type; parameters and initial values (``v0``, ``u0``) are the same for all."""

    def make(label: str, cell_type: str, size: int = 1, **given: float) -> Population:
        parameters = _DEFAULTS[cell_type.split("_")[0]] | {k: v for k, v in given.items() if k[1:] != "0"}
        initial = {"v": given.get("v0", parameters.get("v_rest", -65.0))}
        if cell_type.startswith(("Izhikevich", "IZK")):
            initial |= {"v": given.get("v0", -70.0), "u": given.get("u0", -14.0)}
        return Population(
            label, size, cell_type,
            {name: np.full(size, float(value)) for name, value in parameters.items()},
            {name: np.full(size, float(value)) for name, value in initial.items()},
        )  # fmt: skip

    return make


@pytest.fixture
def spike_source() -> Callable[..., Population]:
    """Make cells that emit given spikes (ms)."""

    def make(label: str, *trains: list[float]) -> Population:
        arrays = tuple(np.array(train, dtype=float) for train in trains)
        return Population(label, len(trains), "SpikeSourceArray", {}, {}, arrays)

    return make


@pytest.fixture
def connect() -> Callable[..., Projection]:
    """Make synapses from ``(pre, post)`` pairs; numbers are the same for all."""

    def make(
        pre: str, post: str, weight: object, delay: object = 1.0, *,
        pairs: list[tuple[int, int]] | None = None, receptor: str = "excitatory",
        kind: str = STATIC, label: str = "", plasticity: object = None, **parameters: float,
    ) -> Projection:  # fmt: skip
        pre_index, post_index = np.array(pairs or [(0, 0)], np.int32).T
        n = len(pre_index)
        return Projection(
            label or f"{pre}-{post}-{receptor}", pre, post, receptor, pre_index, post_index,
            np.broadcast_to(np.asarray(weight, float), n).copy(),
            np.broadcast_to(np.asarray(delay, float), n).copy(),
            kind, {name: np.full(n, value) for name, value in parameters.items()}, plasticity or {},
        )  # fmt: skip

    return make


@pytest.fixture
def open_brain() -> Callable[..., Brain]:
    """Open a network of populations and projections; options as in an experiment file."""

    def make(*parts: Population | Projection, seed: int = 1, **options: object) -> Brain:
        populations = {part.label: part for part in parts if isinstance(part, Population)}
        projections = tuple(part for part in parts if isinstance(part, Projection))
        chosen = SpinnakerOptions.model_validate(options)
        return SpinnakerBackend().open(Network(populations, projections), seed=seed, options=chosen)

    return make
