"""The modules that a script of sPyNNaker imports, over one PyNN simulator."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cached_property, partial
from numbers import Real
from types import MappingProxyType, ModuleType, SimpleNamespace
from typing import Any, ClassVar, Final

from pyNN import common, space

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.pynn.arguments import InvalidValueError
from nrp_spynnaker.dialect import neo_compare, neo_convertor, unsupported
from nrp_spynnaker.dialect.cells import IN_EQUATIONS, cell_types, spike_injector, variable_poisson
from nrp_spynnaker.dialect.connections import Hub, RatesConnection, SpikesConnection
from nrp_spynnaker.dialect.connectors import (
    AllButMeConnector,
    ConvolutionConnector,
    KernelConnector,
    OneToOneOffsetConnector,
    index_based,
    of_fixed_number,
)
from nrp_spynnaker.dialect.other_modules import (
    NoEquivalentError,
    exceptions,
    models,
    module,
    no_equivalent,
    tools,
    utilities,
)
from nrp_spynnaker.dialect.panels import SpynnakerPanel
from nrp_spynnaker.dialect.plasticity import (
    RULES,
    nearest_pair_rule,
    static_synapse,
    stdp_mechanism,
    structural_mechanisms,
    triplet_rule,
    vogels_rule,
)
from nrp_spynnaker.dialect.populations import (
    Population,
    PopulationView,
    Projection,
    Splitter,
    cells_per_core,
    convolution,
)
from nrp_spynnaker.dialect.spynnaker7 import pynn07_names

_DEVICES: Final = "spynnaker_external_devices_plugin"
_MODELS: Final = "spynnaker_extra_pynn_models"
_SIMULATORS: Final = ("pyNN.spiNNaker", "spynnaker.pyNN", "spynnaker7.pyNN", "spynnaker8", "spynnaker")
_OTHERS: Final = {f"{_DEVICES}.pyNN": ("external_devices",), _MODELS: ("extra_models",)}
"""Packages of version 7, and the parts of the simulator that they are."""
_THEMSELVES: Final = ("spynnaker8", "spynnaker", _MODELS)
"""Packages with names of their own, besides modules."""
NAME: Final = "SpiNNaker"
_logger = logging.getLogger(__name__)
_TOOLS: Final = {
    "plot_utils": "sPyNNaker 7 does not have it; pyNN.utility.plotting draws data",
    "spike_checker": "it checks the results of sPyNNaker's own tests",
}
_PANELS: Final = ("spynnaker_plotting", "spynakker_plotting")
"""Its module of panels; the second spelling is that of version 8."""
DEFAULT_TIMESTEP_MS: Final = 1.0
_MACHINE: Final = (
    "n_chips_required", "n_boards_required", "time_scale_factor", "machine_time_step", "hostname",
    "database_socket_addresses", "graph_label", "machine",
)  # fmt: skip
"""Arguments of ``setup`` that concern the machine alone."""
_SETTINGS: Final = ("timestep", "min_delay", "max_delay", *_MACHINE)
_SIZES: Final = frozenset({"n_chips_required", "n_boards_required", "time_scale_factor", "machine_time_step"})
"""Those of them that are numbers above 0."""
_ALIKE: Final = 0.75
_EXTRA: Final = (OneToOneOffsetConnector, AllButMeConnector)
_OF_FIXED_NUMBER: Final = (
    "FixedNumberPreConnector", "FixedNumberPostConnector", "FixedTotalNumberConnector",
)  # fmt: skip
_CONNECTORS: Final = (*_EXTRA, ConvolutionConnector, KernelConnector)
_SPLITTERS: Final = (
    "SplitterAbstractPopulationVertexNeuronsSynapses", "SplitterAbstractPopulationVertexFixed",
    "SplitterPopulationVertexNeuronsSynapses", "SplitterPopulationVertexFixed", "SplitterPoissonDelegate",
    "SplitterAbstractPopulationVertexSlice", "SplitterDelayVertexSlice", "SplitterPopulationVertex",
)  # fmt: skip
_CONNECTIONS: Final = (
    "connections", "spynnaker_live_spikes_connection", "spynnaker_poisson_control_connection",
)  # fmt: skip
"""Modules of live connections, which are that of all devices here."""
_MESSAGES: Final = SimpleNamespace(KEY_16_BIT=0, KEY_PAYLOAD_16_BIT=1, KEY_32_BIT=2, KEY_PAYLOAD_32_BIT=3)
"""Kinds of packets of live output."""


def _require_size(name: str, value: Any) -> None:
    """Check an argument of ``setup`` that a machine would refuse, though it has no effect here."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if value is not None and not (is_number and value > 0):
        raise InvalidValueError(f"setup: {name} is {value!r:.60}; it must be a number above 0, or None")


class Dialect:
    """sPyNNaker's modules over a PyNN simulator.

    Args:
        pynn: the simulator; the modules build its network.
        more: further names of the simulator's module, such as those that run.
        devices: further names of its ``external_devices``.
        hub: the script's live connections.
        of_script: whether the script is surely one of sPyNNaker, so that PyNN's library has its names, too.
    """

    runner: ClassVar[str] = "spinnaker"

    def __init__(
        self,
        pynn: ModuleType,
        more: Mapping[str, Any] = MappingProxyType({}),
        devices: Mapping[str, Any] = MappingProxyType({}),
        hub: Hub | None = None,
        of_script: bool = False,
    ) -> None:
        self._pynn, self._more, self._devices, self._hub = pynn, more, devices, hub or Hub()
        self.missing = tools(Splitter)
        self._of_script = of_script

    @property
    def library_names(self) -> Mapping[str, Any]:
        """The names that replace those of PyNN's library, such as ``pyNN.random.RandomDistribution``."""
        return vars(self.simulator if self._of_script else self._pynn)

    def network(self, _variables: Mapping[str, Any]) -> None:
        """Return None, because scripts of sPyNNaker build their networks with PyNN."""

    def module(self, name: str) -> ModuleType | None:
        """Return the module of a dotted name; None if it is not one of sPyNNaker's.

        Raises:
            NoEquivalentError: sPyNNaker may have it, but it has no equivalent here.
        """
        if name in _SIMULATORS:
            return self.simulator
        package = next((each for each in (*_SIMULATORS, *_OTHERS) if name.startswith(f"{each}.")), name)
        if package not in _SIMULATORS and package not in _OTHERS:
            return None
        found: Any = self.simulator
        for part in (*_OTHERS.get(package, ()), *name.removeprefix(package).split(".")[1:]):
            found = vars(found).get(part) if isinstance(found, ModuleType) else getattr(found, part, None)
        if isinstance(found, ModuleType):
            return found
        if (last := name.rpartition(".")[2]) in _TOOLS:
            raise NoEquivalentError(f"'{name}' has no equivalent: {_TOOLS[last]}")
        if found is not None or package == name.rpartition(".")[0] in _THEMSELVES:
            return None  # a name of the simulator
        raise no_equivalent(name)

    @cached_property
    def simulator(self) -> ModuleType:
        """The simulator with sPyNNaker's names."""
        simulator = self._pynn.simulator
        api = ModuleType("pyNN.spiNNaker", self._pynn.__doc__)
        names = vars(self._pynn)
        own = {**names, **cell_types(names)}
        own |= unsupported.stand_ins(unsupported.SIMULATOR)
        own["STDPMechanism"] = stdp_mechanism(own["STDPMechanism"])
        own["StaticSynapse"] = static_synapse(own["StaticSynapse"])
        own["IndexBasedProbabilityConnector"] = index_based(own["IndexBasedProbabilityConnector"])
        own |= {name: of_fixed_number(own[name]) for name in _OF_FIXED_NUMBER}
        own |= {each.__name__: simulator.bind(each) for each in (Population, PopulationView, Projection)}
        own |= pynn07_names(own, simulator.state)
        own["SpiNNakerProjection"] = own["Projection"]
        own |= structural_mechanisms(simulator, own["STDPMechanism"]) | {
            rule.__name__: rule for rule in RULES
        }
        own |= {
            "create": common.build_create(own["Population"]),
            "connect": common.build_connect(
                own["Projection"], own["FixedProbabilityConnector"], own["StaticSynapse"]
            ),
            **{each.__name__: simulator.bind(each) for each in _CONNECTORS},
            "Convolution": convolution(own["StaticSynapse"]),
            "MultapseConnector": own["FixedTotalNumberConnector"],
            "register_database_notification_request": self._notify,
            "distance": space.distance,
            "name": lambda: NAME,
            "setup": self._setup(names["setup"]),
            **self._settings(own),
            **self._more,
        }
        for kind in [each for each in own.values() if hasattr(each, "cell_type")]:
            kind.set_model_max_atoms_per_dimension_per_core = partial(_limit, own, kind)
            kind.set_model_max_atoms_per_core = partial(_limit, own, kind)
        vars(api).update(own)
        devices = self._external_devices(own)
        vars(api).update(
            extra_models=self._extra_models(own),
            external_devices=devices,
            connections=devices,
            utilities=utilities(neo_convertor=neo_convertor, neo_compare=neo_compare),
            models=models(own, devices.SpikeInjector),
            extra_algorithms=module(
                "extra_algorithms",
                splitter_components=module(
                    "splitter_components",
                    **dict.fromkeys(_SPLITTERS, Splitter),
                    **unsupported.stand_ins(unsupported.SPLITTERS),
                ),
            ),
            protocols=devices.protocols,
            exceptions=exceptions(),
            **{name: module(name, SpynnakerPanel=SpynnakerPanel) for name in _PANELS},
            __getattr__=unsupported.unknown_name("sPyNNaker", own),
        )
        return api

    def _setup(self, begin: Callable[..., int]) -> Callable[..., int]:
        def setup(
            timestep: float | None = None,
            min_delay: float | str | None = None,
            max_delay: Any = None,
            **extra: Any,
        ) -> int:
            """Discard the network and start again; times in ms, a time step of 1 ms by default.

            sPyNNaker ignores ``max_delay``, so delays may be longer, and settings that it does not have.
            """
            for name in [one for one in extra if one not in _MACHINE]:
                if get_close_matches(name, _SETTINGS, 1, _ALIKE):
                    del extra[name]
                    hint = did_you_mean(name, _SETTINGS)
                    _logger.warning("setup: sPyNNaker ignores '%s', which is not a setting%s", name, hint)
            for name in extra.keys() & _SIZES:
                _require_size(name, extra[name])
            step = DEFAULT_TIMESTEP_MS if timestep is None else timestep
            given = {name: value for name, value in extra.items() if name not in _MACHINE}
            if max_delay:
                _logger.warning("setup: sPyNNaker ignores max_delay, so delays may be longer")
            self._hub.clear()
            return begin(step, "auto" if min_delay is None else min_delay, **given)

        return setup

    def _settings(self, names: Mapping[str, Any]) -> dict[str, Callable[..., None]]:
        state = self._pynn.state

        def set_number_of_neurons_per_core(neuron_type: Any, max_permitted: Any) -> None:
            """Set the largest number of cells on a core, for populations of a type that are made later."""
            cell = _cell_class(neuron_type, names)
            hints = state.hints_by_cell.setdefault(cell, {})
            hints.pop("neurons_per_core", None)
            if max_permitted is not None:
                owner = f"set_number_of_neurons_per_core({cell.__name__})"
                hints["neurons_per_core"] = cells_per_core(owner, max_permitted)

        def set_number_of_synapse_cores(neuron_type: Any, n_synapse_cores: int | None) -> None:
            """Set the number of synapse-only cores for each core, for populations that are made later."""
            hints = state.hints_by_cell.setdefault(_cell_class(neuron_type, names), {})
            hints.pop("synapse_cores", None)
            if n_synapse_cores is not None:
                hints["synapse_cores"] = float(n_synapse_cores)

        def set_allow_delay_extensions(neuron_type: Any, _allow: bool) -> None:
            """Have no effect: delays of any length are extended."""
            _cell_class(neuron_type, names)

        return {
            function.__name__: function
            for function in (
                set_number_of_neurons_per_core, set_number_of_synapse_cores, set_allow_delay_extensions,
            )
        }  # fmt: skip

    def _extra_models(self, names: Mapping[str, Any]) -> ModuleType:
        cells = (*IN_EQUATIONS, "Izhikevich_cond", "IFCurDelta", "IF_curr_delta", "IZK_cond_exp")
        own = {name: names[name] for name in (*cells, *(c.__name__ for c in _EXTRA))}
        own["WTAConnector"] = own["AllButMeConnector"]  # its name before 7.4
        own["Vogels2011Rule"] = vogels_rule(names["Vogels2011Rule"])
        own["SpikeNearestPairRule"] = nearest_pair_rule(names["SpikePairRule"])
        own["PfisterSpikeTriplet"], own["WeightDependenceAdditiveTriplet"] = triplet_rule(
            names["PfisterSpikeTripletRule"], names["AdditiveWeightDependence"]
        )
        own["SpikeSourcePoissonVariable"] = variable_poisson(names["SpikeSourceArray"])
        own["Neuromodulation"] = names["Neuromodulation"]
        unknown = unsupported.unknown_name("extra_models", own)
        return module(
            "extra_models", **own, **unsupported.stand_ins(unsupported.EXTRA_MODELS), __getattr__=unknown
        )

    def _external_devices(self, names: Mapping[str, Any]) -> ModuleType:
        devices = ModuleType("external_devices", "Live input and output.")
        own: dict[str, Any] = {
            "EIEIOType": _MESSAGES,
            "SpikeInjector": self._injector(names),
            "SpynnakerLiveSpikesConnection": partial(SpikesConnection, self._hub),
            "SpynnakerPoissonControlConnection": partial(RatesConnection, self._hub),
            "activate_live_output_for": self._hub.activate_live_output_for,
            "add_poisson_live_rate_control": self._hub.add_poisson_live_rate_control,
            "add_database_socket_address": self._add_database_socket_address,
            "register_database_notification_request": self._notify,
            **self._devices,
            **unsupported.stand_ins(unsupported.DEVICES),
        }
        own["protocols"] = module("protocols", **{name: own[name] for name in unsupported.PROTOCOLS})
        own |= dict.fromkeys(_CONNECTIONS, devices)
        vars(devices).update(own)
        return devices

    def _notify(self, hostname: str | None, notify_port: int | None, ack_port: int | None = None) -> None:
        """Tell a program of the database of keys."""
        self._hub.notify(notify_port, hostname)

    def _add_database_socket_address(self, address: Any, notify_port: int | None = None, *_: Any) -> None:
        """Tell a program of the database of keys; versions before 7 gave its host and port."""
        if isinstance(address, str) or address is None:
            self._hub.notify(notify_port, address)
        else:
            self._hub.notify(address.notify_port_no, address.notify_host_name)

    def _injector(self, names: Mapping[str, Any]) -> type:
        cell = spike_injector(names["SpikeSourceArray"])
        cell.hub = self._hub  # type: ignore[attr-defined]
        return cell


def _limit(names: Mapping[str, Any], cell: type, n_atoms: Any = None) -> None:
    """Set the largest number of cells of a type on a core, for populations that are made later."""
    names["set_number_of_neurons_per_core"](cell, n_atoms)


def _cell_class(cell: Any, names: Mapping[str, Any]) -> type:
    found = names.get(cell) if isinstance(cell, str) else cell
    if not isinstance(found, type) or not hasattr(found, "cell_type"):
        shown = getattr(cell, "__name__", repr(cell))
        known = [name for name, kind in names.items() if hasattr(kind, "cell_type")]
        raise NetworkError(f"{shown} is not a cell type{did_you_mean(shown, known)}")
    return found
