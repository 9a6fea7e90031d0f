"""The supported models of NEST: cells, generators, recorders and synapses, and cells of PyNN as nodes.

The defaults are the documented defaults of NEST 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Final

import numpy as np

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.cells import CELLS as CELL_TYPES
from nrp_core.network.equations.model import CELL_TYPE
from nrp_core.network.nest_models import LEAK_NS, NEST_CELLS, CellModel, NestParameter
from nrp_core.network.pynn.export import cell_type_of
from nrp_core.network.synapses import ELECTRICAL, STATIC, STDP, TSODYKS_MARKRAM
from nrp_pynest.equations import EQUATIONS

PARROT: Final = "parrot_neuron"
POISSON: Final = "poisson_generator"
SPIKES: Final = "spike_generator"
CURRENT: Final = "dc_generator"
PRECISE: Final = {f"{name}_ps": name for name in ("iaf_psc_exp", "iaf_psc_alpha", "iaf_psc_delta")}
"""The models whose cells spike between grid points, and those whose cells spike at them."""
TSODYKS_CELL: Final = "iaf_tum_2000"
"""The model whose cells determine the short-term plasticity of their synapses with receptor type 1."""
FOREVER_MS: Final = 1e12

_KILO = 1e-3
_PAIRS: Mapping[str, tuple[str, float, float]] = {
    "gbar_Na": ("g_Na", _KILO, 20_000.0), "gbar_K": ("g_K", _KILO, 6000.0), "g_leak": ("g_L", _KILO, 10.0),
    "cm": ("C_m", _KILO, 200.0), "v_offset": ("V_T", 1.0, -63.0), "e_rev_Na": ("E_Na", 1.0, 50.0),
    "e_rev_K": ("E_K", 1.0, -90.0), "e_rev_leak": ("E_L", 1.0, -60.0), "e_rev_E": ("E_ex", 1.0, 0.0),
    "e_rev_I": ("E_in", 1.0, -80.0), "tau_syn_E": ("tau_syn_ex", 1.0, 5.0),
    "tau_syn_I": ("tau_syn_in", 1.0, 10.0), "i_offset": ("I_e", _KILO, 0.0),
}  # fmt: skip
_REPEATING: Mapping[str, tuple[str, float, float]] = {
    "v_rest": ("E_L", 1.0, 0.0), "v_reset": ("V_reset", 1.0, 0.0), "v_thresh": ("V_th", 1.0, 1e-9),
    "tau_refrac": ("t_ref", 1.0, 0.0), "tau_m": ("tau_m", 1.0, 1.0), "cm": ("C_m", 1e-3, 1000.0),
}  # fmt: skip
_IZHIKEVICH = {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0}

STANDARD: Final[Mapping[str, CellModel]] = {
    **NEST_CELLS,
    "iaf_neuron": NEST_CELLS["iaf_psc_alpha"],
    "iaf_psc_exp_multisynapse": NEST_CELLS["iaf_psc_exp"],
    "iaf_psc_alpha_multisynapse": NEST_CELLS["iaf_psc_alpha"],
    "izhikevich": CellModel(
        "Izhikevich",
        {**{name: NestParameter(name, 1.0, value) for name, value in _IZHIKEVICH.items()},
         "i_offset": NestParameter("I_e", _KILO, 0.0)},
    ),
    "hh_cond_exp_traub": CellModel(
        "HH_cond_exp", {name: NestParameter(*pair) for name, pair in _PAIRS.items()}, _KILO
    ),
    PARROT: CellModel("IF_curr_delta", {name: NestParameter(*pair) for name, pair in _REPEATING.items()}),
    **{name: NEST_CELLS[plain] for name, plain in PRECISE.items()},
    TSODYKS_CELL: NEST_CELLS["iaf_psc_exp"],
}  # fmt: skip
"""The models that are standard cells of PyNN; a parrot is one that any weight makes spike."""
CELLS: Final[Mapping[str, CellModel]] = {
    **STANDARD,
    **{
        name: CellModel(
            CELL_TYPE,
            {
                own: NestParameter("I_e" if own == "i_offset" else own, 1.0, default)
                for own, default in model.numbers.items()
            },
        )
        for name, model in EQUATIONS.items()
    },
}
"""All models of cells."""
SPIKE_RECORDERS: Final = ("spike_detector", "spike_recorder")
MULTIMETERS: Final = ("multimeter", "voltmeter")
_WINDOW: Final[Mapping[str, Any]] = {"start": 0.0, "stop": FOREVER_MS, "origin": 0.0}
RECORDER_DEFAULTS: Final[Mapping[str, Mapping[str, Any]]] = {
    **{name: {**_WINDOW, "record_to": "memory", "label": ""} for name in SPIKE_RECORDERS},
    "multimeter": {**_WINDOW, "interval": 1.0, "record_from": (), "record_to": "memory", "label": ""},
    "voltmeter": {**_WINDOW, "interval": 1.0, "record_from": ("V_m",), "record_to": "memory", "label": ""},
}
IDLE: Final[Mapping[str, str]] = {
    **dict.fromkeys(("weight_recorder", "correlation_detector", "spin_detector"), "it records nothing"),
    "volume_transmitter": "no dopamine reaches the synapses",
}
"""The effect of leaving out models that are known, but not supported."""
RECORDERS: Final = frozenset({*RECORDER_DEFAULTS, *IDLE})
"""Models that only record; a network does not need them."""
CURRENTS: Final[Mapping[str, Mapping[str, Any]]] = {
    CURRENT: {"amplitude": 0.0, **_WINDOW},
    "ac_generator": {"amplitude": 0.0, "offset": 0.0, "frequency": 0.0, "phase": 0.0, **_WINDOW},
    "step_current_generator": {"amplitude_times": (), "amplitude_values": (), **_WINDOW},
    "noise_generator": {"mean": 0.0, "std": 0.0, "std_mod": 0.0, "dt": 1.0, "frequency": 0.0, "phase": 0.0,
                        **_WINDOW},
}  # fmt: skip
"""Generators of currents, pA."""
POISSONS: Final = (POISSON, "poisson_generator_ps")
"""Generators that send each target a spike train of its own."""
TRAINS: Final = (SPIKES, "pulsepacket_generator")
"""Generators that send all targets the same spikes, which are known in advance."""
GENERATORS: Final[Mapping[str, Mapping[str, Any]]] = {
    POISSON: {"rate": 0.0, **_WINDOW},
    "poisson_generator_ps": {"rate": 0.0, "dead_time": 0.0, **_WINDOW},
    SPIKES: {"spike_times": (), "spike_weights": (), "spike_multiplicities": (), "precise_times": False,
             "allow_offgrid_times": False, "shift_now_spikes": False, **_WINDOW},
    "pulsepacket_generator": {"pulse_times": (), "activity": 0, "sdev": 0.0, **_WINDOW},
    **CURRENTS,
}  # fmt: skip
"""Models that only emit, with their parameters."""
LISTS: Final = frozenset(
    {
        "spike_times", "spike_weights", "spike_multiplicities", "tau_syn", "amplitude_times",
        "amplitude_values", "pulse_times", "record_from",
        *(name for one in EQUATIONS.values() for name in one.lists),
    }
)  # fmt: skip
"""Parameters that are lists."""
STATES: Final[Mapping[str, tuple[str, float]]] = {
    "V_m": ("v", 1.0), "w": ("w", 1e-3), "U_m": ("u", 1.0), "g_ex": ("gsyn_exc", 1e-3),
    "g_in": ("gsyn_inh", 1e-3), "I_syn_ex": ("isyn_exc", 1e-3), "I_syn_in": ("isyn_inh", 1e-3),
    "Act_m": ("m", 1.0), "Inact_h": ("h", 1.0), "Act_n": ("n", 1.0),
}  # fmt: skip
"""State variables of cells: the name in a network, and the factor to its unit."""
WITHOUT_EFFECT: Final = frozenset(
    {"gsl_error_tol", "frozen", "tau_minus", "tau_minus_triplet", "node_uses_wfr", "local"}
)
"""Parameters of cells that need no counterpart; ``tau_minus`` is one of their STDP synapses."""

_STDP = {"tau_plus": 20.0, "lambda": 0.01, "alpha": 1.0, "mu_plus": 1.0, "mu_minus": 1.0, "Wmax": 100.0}
_TSODYKS = {"U": 0.5, "tau_rec": 800.0, "tau_fac": 0.0, "tau_psc": 3.0}


@dataclass(frozen=True, slots=True)
class SynapseModel:
    """A model of synapses.

    Args:
        kind: the synapse type in a network.
        defaults: defaults of its parameters, including weight and delay, in NEST's names and units.
    """

    kind: str
    defaults: Mapping[str, Any]

    def changed(self, values: Mapping[str, Any]) -> SynapseModel:
        """Return the model with other defaults."""
        return SynapseModel(self.kind, {**self.defaults, **values})


AT_ONCE_MS = 1e-6
"""The time constant of recovery that one of 0 means: a nanosecond, so synapses recover at once."""


def valid_recovery_ms(tau_rec_ms: Any) -> Any:
    """Return time constants of recovery (ms, a number or an array) that synapses can have."""
    return np.where(np.less_equal(tau_rec_ms, 0), AT_ONCE_MS, tau_rec_ms)[()]


_OF_TSODYKS_CELLS = {
    "U": 0.5, "tau_psc": 2.0, "tau_rec": 400.0, "tau_fac": 1000.0, "x": 0.0, "y": 0.0, "u": 0.0, "rho": 0.01,
    "delta": 0.0,
}  # fmt: skip
_PLAIN = {"weight": 1.0, "delay": 1.0}
SYNAPSES: Final[Mapping[str, SynapseModel]] = {
    "static_synapse": SynapseModel(STATIC, _PLAIN),
    "static_synapse_hom_w": SynapseModel(STATIC, _PLAIN),
    "tsodyks_synapse": SynapseModel(TSODYKS_MARKRAM, {**_PLAIN, **_TSODYKS}),
    "tsodyks_synapse_hom": SynapseModel(TSODYKS_MARKRAM, {**_PLAIN, **_TSODYKS}),
    "tsodyks2_synapse": SynapseModel(TSODYKS_MARKRAM, {**_PLAIN, **_TSODYKS}),
    "static_synapse_hpc": SynapseModel(STATIC, _PLAIN),
    "static_synapse_hom_w_hpc": SynapseModel(STATIC, _PLAIN),
    "gap_junction": SynapseModel(ELECTRICAL, _PLAIN),
    "stdp_synapse": SynapseModel(STDP, {**_PLAIN, **_STDP}),
    "stdp_synapse_hom": SynapseModel(STDP, {**_PLAIN, **_STDP}),
    "stdp_pl_synapse_hom": SynapseModel(STDP, {**_PLAIN, **_STDP}),
}


def defaults_of(name: str) -> dict[str, Any]:
    """Return the parameters of a model of cells, generators or recorders, NEST's names and units."""
    if name not in CELLS:
        return dict(GENERATORS.get(name, RECORDER_DEFAULTS.get(name, {})))
    if name in EQUATIONS:
        return dict(EQUATIONS[name].defaults)
    values: dict[str, Any] = {one.name: one.default for one in CELLS[name].parameters.values()}
    values |= _OF_TSODYKS_CELLS if name == TSODYKS_CELL else {}
    if name in LEAK_NS:
        values["g_L"] = LEAK_NS[name]
        values.pop("tau_m")
    return values


def initial_mv(model: str) -> float:
    """Return the initial voltage of cells, mV: the default resting potential of the model.

    As in NEST 3.10, ``E_L`` does not change the initial ``V_m`` of a cell.
    """
    if model in EQUATIONS:
        return EQUATIONS[model].initial.get("V_m", 0.0)
    rest = CELLS[model].parameters.get("v_rest")
    return -65.0 if rest is None else rest.default


NEST_OF = {model.cell_type: name for name, model in reversed(list(STANDARD.items()))}
"""NEST's name of each cell type."""


class PyNNCells:
    """The cells of a script's populations, by the numbers that PyNN gives them, in NEST's names and units.

    Args:
        sim: the simulator of PyNN.
    """

    def __init__(self, sim: ModuleType) -> None:
        self._sim = sim

    def __len__(self) -> int:
        return int(self._sim.state.n_cells)

    def get(self, cell: int) -> dict[str, Any]:
        """Return the parameters of a cell."""
        population, place = self._found(cell)
        base, model = model_of(population)
        own = {name: float(values[place]) for name, values in population.parameter_arrays.items()}
        found = {theirs.name: own[ours] / theirs.scale for ours, theirs in model.parameters.items()}
        if base in LEAK_NS:
            found["g_L"] = own["cm"] * 1e3 / own["tau_m"]
        return {"global_id": cell, "model": base, "element_type": "neuron", **found}

    def set(self, cell: int, values: Mapping[str, Any]) -> None:
        """Change parameters of a cell, and its first voltage ``V_m``.

        Raises:
            NetworkError: cells of its type do not have them.
        """
        population, place = self._found(cell)
        base, model = model_of(population)
        ours = {theirs.name: (own, theirs.scale) for own, theirs in model.parameters.items()}
        known = {*ours, "V_m"} | ({"g_L"} if base in LEAK_NS else set())
        for name in values:
            if name not in known:
                raise NetworkError(
                    f"nest: cells of the population '{population.label}' have no '{name}'"
                    f"{did_you_mean(name, known)}"
                )
        changed = {ours[name][0]: value * ours[name][1] for name, value in values.items() if name in ours}
        if base in LEAK_NS and {"C_m", "g_L"} & values.keys():
            conductance = values.get("g_L", self.get(cell)["g_L"])
            changed["tau_m"] = values.get("C_m", self.get(cell).get("C_m")) / conductance
        view = population[place : place + 1]
        view.set(**changed)
        if "V_m" in values:
            view.initialize(v=values["V_m"])

    def _found(self, cell: int) -> tuple[Any, int]:
        for population in self._sim.state.populations:
            if 0 <= cell - int(population.first_id) < population.size:
                return population, cell - int(population.first_id)
        raise NetworkError(f"nest: node {cell} does not exist")


def model_of(population: Any) -> tuple[str, CellModel]:
    """Return the model of NEST that the cells of a population have.

    Raises:
        NetworkError: none was found.
    """
    kind = cell_type_of(population)
    if kind not in NEST_OF:
        raise NetworkError(
            f"nest: cells of the population '{population.label}' are {kind}, which NEST has not"
        )
    return NEST_OF[kind], STANDARD[NEST_OF[kind]]


def scale_of(population: Any) -> float:
    """Return the factor from NEST's unit of weights to PyNN's: nS to µS, pA to nA, or mV to mV."""
    kind = cell_type_of(population)
    return STANDARD[NEST_OF[kind]].weight_scale if kind in NEST_OF else 1e-3


def recordables(model: str) -> tuple[str, ...]:
    """Return the state variables of a model that a multimeter can record."""
    return tuple(states_of(model))


def states_of(model: str) -> dict[str, tuple[str, float]]:
    """Return the state variables of a model: the name in a network, and the factor to its unit."""
    if model in EQUATIONS:
        return {name: ("v" if name == "V_m" else name, 1.0) for name in EQUATIONS[model].recordables}
    cell = CELL_TYPES[CELLS[model].cell_type]
    return {name: (own, scale) for name, (own, scale) in STATES.items() if own in cell.state}
