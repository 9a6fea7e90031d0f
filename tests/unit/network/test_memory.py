"""What cannot fit into memory is refused before it is tried, with the numbers."""

import resource
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from pyNN.connectors import IndexBasedExpression

from nrp_core.errors import NetworkError
from nrp_core.network import memory
from nrp_core.network.memory import free_bytes, require_memory
from nrp_core.network.pynn import builder, connectors
from nrp_core.network.pynn.connectors import expected_synapses

MIB = 1 << 20


@pytest.fixture
def free(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a function that lets this many bytes be free."""

    def let(n_bytes: int) -> None:
        for module in (memory, connectors):
            monkeypatch.setattr(module, "free_bytes", lambda: n_bytes)

    return let


def test_this_machine_has_something_left() -> None:
    free = free_bytes()
    assert free is None or free > 16 * MIB


@pytest.mark.parametrize(
    ("limit", "used"),
    [("memory.max", "memory.current"), ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes")],
)
def test_a_container_gets_the_rest_of_the_limit_of_its_group(
    limit: str, used: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "_GROUP", tmp_path)
    for name, text in ((limit, "5000000\n"), (used, "3000000\n")):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert free_bytes() == 2_000_000
    (tmp_path / limit).write_text("max\n")
    assert free_bytes() != 2_000_000


def test_a_process_gets_the_rest_of_its_own_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    own = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (own + 8 * MIB, resource.RLIM_INFINITY))
    left = free_bytes()
    assert left is not None
    assert 4 * MIB < left <= 8 * MIB


def test_the_message_names_owner_counts_need_and_what_is_free(free: Any) -> None:
    free(10 * MIB)
    require_memory("projection 'p'", 10 * MIB, "it")
    with pytest.raises(NetworkError) as caught:
        require_memory("projection 'p'", 3 * 1024 * MIB, "about 2e+08 synapses")
    assert caught.value.message.startswith(
        "projection 'p': about 2e+08 synapses would take 3.0 GiB of memory, and 10.0 MiB are free"
    )


@pytest.mark.parametrize(
    ("connector", "number"),
    [
        (lambda sim: sim.AllToAllConnector(), "1e+08"),
        (lambda sim: sim.FixedProbabilityConnector(0.5), "5e+07"),
        (lambda sim: sim.FixedNumberPreConnector(5_000, with_replacement=True), "5e+07"),
        (lambda sim: sim.FixedNumberPostConnector(5_000), "5e+07"),
        (lambda sim: sim.FixedTotalNumberConnector(10**12), "1e+12"),
    ],
)
def test_a_projection_too_large_is_refused_before_it_is_drawn(
    connector: Any, number: str, free: Any, golden: Golden
) -> None:
    sim = builder()
    cells = sim.Population(10_000, sim.SpikeSourcePoisson(), label="cells")
    targets = sim.Population(10_000, sim.IF_curr_delta(), label="targets")
    free(64 * MIB)
    with golden.raises(NetworkError, match="'all'") as caught:
        sim.Projection(cells, targets, connector(sim), sim.StaticSynapse(weight=1.0), label="all")
    assert f"from 10000 to 10000 cells makes about {number} synapses" in caught.value.message


def test_values_that_differ_between_synapses_count(free: Any, golden: Golden) -> None:
    sim = builder()
    cells = sim.Population(100, sim.IF_curr_exp(), label="cells")
    free(100 * 100 * 10)
    sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=1.0))
    weight = sim.RandomDistribution("uniform", low=0.0, high=1.0)
    with golden.raises(NetworkError):
        sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight))


NEAR = "d < 2.5"


class Near(IndexBasedExpression):
    def __call__(self, i: Any, j: Any) -> Any:
        return (abs(i - j) < 3) * 1.0


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("connector", "number"),
    [
        (lambda sim: sim.DistanceDependentProbabilityConnector(NEAR), 5 * 30_000),
        (lambda sim: sim.DistanceDependentProbabilityConnector("0.5 * (d < 2.5)"), 5 * 15_000),
        (lambda sim: sim.IndexBasedProbabilityConnector(Near()), 5 * 30_000),
        pytest.param(
            lambda sim: sim.DisplacementDependentProbabilityConnector(lambda d: abs(d[0]) < 2.5),
            5 * 30_000,
            marks=pytest.mark.heavy,
        ),
        (lambda sim: sim.SmallWorldConnector(2.5, 0.1), 5 * 30_000),
        (lambda sim: sim.SmallWorldConnector(2.5, 0.1, n_connections=2), 2 * 30_000),
        (lambda sim: sim.OneToOneConnector(), 30_000),
    ],
)
def test_synapses_of_near_cells_are_foreseen_from_some_cells(
    connector: Any, number: int, free: Any, golden: Golden
) -> None:
    sim = builder()
    cells = sim.Population(30_000, sim.IF_curr_exp(), structure=sim.Line(), label="cells")
    free(1000)
    with golden.raises(NetworkError, match="'all'") as caught:
        sim.Projection(cells, cells, connector(sim), sim.StaticSynapse(weight=1.0), label="all")
    assert f"from 30000 to 30000 cells makes about {number:.3g} synapses" in caught.value.message


@pytest.mark.parametrize("probability", ["exp(-d / 20.0)", "0.3 * (d < 50)"])
def test_the_expected_number_of_synapses_is_the_actual_one(probability: str) -> None:
    sim = builder()
    cells = sim.Population(400, sim.IF_curr_exp(), structure=sim.Grid2D(), label="cells")
    connector = sim.DistanceDependentProbabilityConnector(probability)
    made = sim.Projection(cells, cells, connector, sim.StaticSynapse(weight=1.0))
    assert expected_synapses(connector, made) == pytest.approx(len(made), rel=0.15)


def test_a_population_too_large_is_refused(golden: Golden) -> None:
    sim = builder()
    with golden.raises(NetworkError, match="'all'.*1000000000000"):
        sim.Population(10**12, sim.IF_curr_exp(), label="all")
