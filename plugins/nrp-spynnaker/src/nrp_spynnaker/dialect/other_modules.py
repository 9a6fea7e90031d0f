"""The modules that scripts of sPyNNaker import in addition to the simulator: its own and its tools'."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any, Final, NoReturn

from nrp_core.errors import CapabilityError, NrpError

_TOOLS: Final = (
    "data_specification", "pacman", "spalloc", "spinn_front_end_common", "spinn_machine", "spinn_utilities",
    "spinnaker_graph_front_end", "spinnman",
)  # fmt: skip
"""The packages that sPyNNaker is made of; what a script needs of them has an equivalent here."""
_SIMULATOR: Final = "spynnaker.pyNN"
_EXCEPTIONS: Final = (
    "SpynnakerException", "ConfigurationException", "DelayExtensionException", "FilterableException",
    "InvalidParameterType", "MemReadException", "PacmanConfigurationException", "SpinnFrontEndException",
    "SpinnmanException", "SpinnmanIOException", "SpinnmanTimeoutException",
    "SpynnakerSplitterConfigurationException", "SynapseRowTooBigException",
    "SynapticBlockGenerationException", "SynapticBlockReadException", "SynapticConfigurationException",
    "SynapticMaxIncomingAtomsSupportException",
)  # fmt: skip
_PLACES: Final = (
    "BoardConstraint", "ChipAndCoreConstraint", "PlacerChipAndCoreConstraint",
    "PlacerRadialPlacementFromChipConstraint", "RadialPlacementFromChipConstraint", "SameChipAsConstraint",
)  # fmt: skip
_SIZES: Final = ("FixedVertexAtomsConstraint", "MaxVertexAtomsConstraint", "PartitionerMaximumSizeConstraint")
_SPLITTERS: Final = (
    "SplitterFixedLegacy", "SplitterOneAppOneMachine", "SplitterOneToOneLegacy", "SplitterSliceLegacy",
)  # fmt: skip
_COMPILED: Final = ("models", "python_models", "DataHolder")
"""Parts of the names of modules of which own cells and synapses are made."""


class NoEquivalentError(CapabilityError, ModuleNotFoundError):
    """A module of sPyNNaker or its tools that works on a machine alone."""


class Constraint:
    """Where cells are to be placed on a machine.

    Attributes:
        size: the largest number of cells on a core, if the constraint is one of that.
    """

    size: Any = None

    def __init__(self, *_values: Any, **_named: Any) -> None:
        """Have no effect: the mapper places the cells."""


class SizeConstraint(Constraint):
    """How many cells a core may hold."""

    def __init__(self, size: Any) -> None:
        super().__init__()
        self.size = size


def exceptions() -> ModuleType:
    """Return sPyNNaker's exceptions, each of which is any error here."""
    return module("exceptions", **dict.fromkeys(_EXCEPTIONS, NrpError))


def module(name: str, **names: Any) -> ModuleType:
    """Return a module with these names."""
    made = ModuleType(name)
    vars(made).update(names)
    return made


def no_equivalent(name: str) -> NoEquivalentError:
    """Return the error for a module of sPyNNaker or its tools."""
    if set(name.split(".")) & {*_COMPILED}:
        return NoEquivalentError(
            f"'{name}' has no equivalent: cells and synapses that are compiled for a machine are not "
            "emulated; sim.EquationCell and sim.EquationSynapse take equations"
        )
    return NoEquivalentError(
        f"'{name}' has no equivalent: it works on the machine, or on the tools that load one; `nrp map` "
        "shows how a network lies on a machine"
    )


def models(names: Mapping[str, Any], injector: type) -> ModuleType:
    """Return the module of sPyNNaker's cells, as far as a script finds the same ones in the simulator.

    Args:
        names: the names of the simulator.
        injector: the source of live spikes.
    """
    return _nested(
        f"{_SIMULATOR}.models",
        {
            "utility_models": {"spike_injector": {"SpikeInjector": injector}, "SpikeInjector": injector},
            "spike_source": {
                "spike_source_array": {"SpikeSourceArray": names["SpikeSourceArray"]},
                "spike_source_poisson": {"SpikeSourcePoisson": names["SpikeSourcePoisson"]},
                **{name: names[name] for name in ("SpikeSourceArray", "SpikeSourcePoisson")},
            },
            "populations": {
                "population": {"Population": names["Population"]},
                "population_view": {"PopulationView": names["PopulationView"]},
                "assembly": {"Assembly": names["Assembly"]},
                **{name: names[name] for name in ("Population", "PopulationView", "Assembly")},
            },
        },
    )


def utilities(**found: ModuleType) -> ModuleType:
    """Return the module of sPyNNaker's utilities, with those given."""
    return _nested(f"{_SIMULATOR}.utilities", {**found, "utility_calls": {"get_n_bits": get_n_bits}})


def get_n_bits(n_values: int) -> int:
    """Return the number of bits that represent this number of values, from 0 on."""
    return max(n_values - 1, int(n_values == 1)).bit_length() if n_values else 0


def _nested(name: str, parts: Mapping[str, Any]) -> ModuleType:
    """Return a module with modules, which refuses all other names."""
    made = {k: _nested(f"{name}.{k}", part) if isinstance(part, dict) else part for k, part in parts.items()}

    def other(attribute: str) -> NoReturn:
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        raise no_equivalent(f"{name}.{attribute}")

    return module(name, **made, __getattr__=other)


def tools(splitter: type) -> Callable[[str, Mapping[str, Any]], ModuleType | None]:
    """Return a function that returns a module of sPyNNaker's tools, or None for others, by name.

    Args:
        splitter: the class of splitters.
    """
    known = {
        "pacman.model.partitioner_splitters": module("splitters", **dict.fromkeys(_SPLITTERS, splitter)),
        "pacman.model.constraints.placer_constraints": module("places", **dict.fromkeys(_PLACES, Constraint)),
        "pacman.model.constraints.partitioner_constraints": module(
            "sizes", **dict.fromkeys(_SIZES, SizeConstraint)
        ),
        **{f"{tool}.exceptions": exceptions() for tool in ("pacman", "spinn_utilities", "spinnman")},
        "spinn_front_end_common.utilities.exceptions": exceptions(),
    }
    for name in list(known):
        child = known[name]
        while "." in name:
            name, _, last = name.rpartition(".")
            parent = known.setdefault(name, ModuleType(name))
            setattr(parent, last, child)
            child = parent

    def missing(name: str, _importer: Mapping[str, Any]) -> ModuleType | None:
        if name.partition(".")[0] not in _TOOLS:
            return None
        if name not in known and "." in name:
            raise no_equivalent(name)
        return known.get(name) or ModuleType(name)

    return missing
