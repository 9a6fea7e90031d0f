"""The builder offers all of PyNN's names, and says clearly what networks cannot hold."""

import inspect
from types import ModuleType

import pyNN.mock
import pytest
from golden import Golden
from pyNN import standardmodels

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.cells import CELLS
from nrp_core.network.pynn import builder


@pytest.fixture
def sim() -> ModuleType:
    return builder()


def test_every_model_connector_and_function_of_a_pynn_simulator_has_its_name_here(sim: ModuleType) -> None:
    names = {
        name
        for name, value in vars(pyNN.mock).items()
        if (inspect.isclass(value) or inspect.isfunction(value)) and value.__module__.startswith("pyNN.")
        and not value.__module__.startswith("pyNN.recording") and "Mock" not in name
    }  # fmt: skip
    internal = {
        "build_translations",
        "AbstractRNG",
        "IndexBasedExpression",
        "LazyArray",
        "StandardSynapseType",
    }
    assert {name for name in names - internal if not hasattr(sim, name)} == set()


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("IF_facets_hardware1", "IF_cond_exp"),
        ("SpikeSourceInhGamma", "SpikeSourcePoisson"),
    ],
)
def test_a_model_that_is_not_supported_names_the_nearest_that_is(
    sim: ModuleType, name: str, nearest: str, golden: Golden
) -> None:
    with golden.raises(CapabilityError, match=f"{name}.*{nearest}"):
        getattr(sim, name)(tau_m=1.0)


def test_every_standard_model_of_pynn_is_supported_or_refused_by_name(sim: ModuleType) -> None:
    bases = (
        standardmodels.StandardCellType, standardmodels.StandardSynapseType,
        standardmodels.STDPTimingDependence, standardmodels.STDPWeightDependence,
    )  # fmt: skip
    modules = (standardmodels.cells, standardmodels.synapses)
    names = {
        name for module in modules for name, value in vars(module).items()
        if inspect.isclass(value) and issubclass(value, bases) and value not in bases
    }  # fmt: skip
    assert {name for name in names if not hasattr(sim, name)} == set()


@pytest.mark.parametrize(
    ("native", "nearest"),
    [("iaf_psc_exp", "IF_curr_exp"), ("iaf_cond_alpha", "IF_cond_alpha"), ("izhikevich", "Izhikevich")],
)
def test_a_model_of_one_simulator_names_the_nearest_standard_cell(
    sim: ModuleType, native: str, nearest: str, golden: Golden
) -> None:
    with golden.raises(CapabilityError, match=f"'{native}'.*{nearest}$"):
        sim.native_cell_type(native)


def test_a_misspelt_name_gets_the_right_one(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(AttributeError, match="PyNN.*'IF_cond_alph'.*'IF_cond_alpha'"):
        _ = sim.IF_cond_alph
    assert not hasattr(sim, "something_else_entirely")


def test_the_standard_models_are_listed(sim: ModuleType) -> None:
    further = ["IF_cond_exp_gsfa_grr", "GIF_cond_exp", "Izhikevich_cond_dual", "IF_curr_dual_exp"]
    glif = [f"GLIF{level}_curr_alpha" for level in range(1, 6)]
    assert sim.list_standard_models() == [*CELLS, *further, "IF_curr_exp_sEMD", *glif]


def test_setup_forgets_what_was_built_and_keeps_the_time_step(sim: ModuleType) -> None:
    sim.Population(3, sim.IF_cond_exp(), label="old")
    assert sim.setup(timestep=0.25, min_delay=0.5, max_delay=10.0, threads=4) == 0
    sim.Population(2, sim.IF_cond_exp(), label="new")
    network = sim.network()
    assert list(network.populations) == ["new"]
    assert network.timestep_ms == sim.get_time_step() == 0.25
    assert (sim.get_min_delay(), sim.get_max_delay(), sim.get_current_time()) == (0.5, 10.0, 0.0)
    assert (sim.rank(), sim.num_processes()) == (0, 1)


def test_a_time_step_must_be_positive(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(NetworkError):
        sim.setup(timestep=0)


def test_two_builders_know_nothing_of_each_other() -> None:
    first, second = builder(), builder()
    first.Population(3, first.IF_cond_exp(), label="a")
    second.setup(timestep=1.0)
    assert first.network().size == 3
    assert first.get_time_step() == 0.1
    assert second.network().size == 0


def test_reset_and_end_are_harmless_while_building(sim: ModuleType) -> None:
    cells = sim.Population(2, sim.IF_cond_exp())
    cells.record("v", to_file="nowhere.pkl")
    sim.reset()
    sim.end()
    assert sim.network().size == 2
