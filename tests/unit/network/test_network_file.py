"""A network that was saved is the network that is read, or there is one clear error."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import h5py
import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network, Population
from nrp_core.network.files import read_network, save_network
from nrp_core.network.files.script import load_network
from nrp_core.network.pynn import builder


def everything(sim: ModuleType, seed: int = 1) -> Network:
    """A network with something of everything that a network can hold."""
    sim.setup(timestep=0.5)
    drawn = sim.RandomDistribution("uniform", low=5.0, high=9.0)
    cells = sim.Population(12, sim.IF_cond_exp(tau_m=drawn), label="cells/äöü", structure=sim.Line(dx=3.0))
    targets = sim.Population(4, sim.IF_curr_alpha(), label="targets", initial_values={"v": -60.0})
    trains = sim.Population(3, sim.SpikeSourceArray(), label="trains")
    trains[1:2].set(spike_times=[1.0, 2.5])
    random = sim.RandomDistribution("normal_clipped", mu=0.5, sigma=0.1, low=0.0, high=1.0)
    sim.Projection(
        trains, cells, sim.FixedProbabilityConnector(0.7), sim.StaticSynapse(weight=random), label="in"
    )
    tired = sim.TsodyksMarkramSynapse(weight=1.0, delay=2.0, U=0.3)
    sim.Projection(cells, targets, sim.AllToAllConnector(), tired)
    rule = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(), weight_dependence=sim.AdditiveWeightDependence(w_max=2.0),
        weight=-1.0,
    )  # fmt: skip
    sim.Projection(cells, targets, sim.OneToOneConnector(), rule, receptor_type="inhibitory")
    sim.Projection(trains, targets, sim.FixedProbabilityConnector(0.0), sim.StaticSynapse(), label="none")
    network: Network = sim.network()
    return Network(network.populations, network.projections, {"eyes": np.array([3, 1])}, network.timestep_ms)


@pytest.fixture(scope="module")
def network() -> Network:
    return everything(builder(1))


@pytest.fixture(scope="module")
def saved(network: Network, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("networks") / "all.nrpnet"
    save_network(network, path)
    return path


def test_reading_a_saved_network_gives_the_same_network(network: Network, saved: Path) -> None:
    again = read_network(saved)
    assert again.digest == network.digest
    assert list(again.populations) == ["cells/äöü", "targets", "trains"]
    assert again.views["eyes"].tolist() == [3, 1]
    assert again.timestep_ms == 0.5
    assert [train.tolist() for train in again.populations["trains"].spike_times_ms] == [[], [1.0, 2.5], []]
    positions = again.populations["cells/äöü"].positions_um
    assert positions is not None
    assert positions[:, 0].tolist() == [3.0 * i for i in range(12)]
    for one, other in zip(again.projections, network.projections, strict=True):
        assert one.origin == other.origin
        assert one.plasticity == other.plasticity
    assert again.projections[0].origin.weight == "normal_clipped(mu=0.5, sigma=0.1, low=0.0, high=1.0)"


def test_equal_values_take_no_memory_and_no_room(network: Network, saved: Path) -> None:
    delays = read_network(saved).projections[1].delay_ms
    assert (len(delays), delays.strides) == (48, (0,))
    with h5py.File(saved) as file:
        assert file["projections/1/delay_ms"].shape == (1,)


def alike(n: int, first: list[float]) -> Network:
    """Sources of one train each, of which the first has another."""
    trains = (np.array(first), *(np.arange(1000.0) for _ in range(n - 1)))
    return Network({"sources": Population("sources", n, "SpikeSourceArray", {}, spike_times_ms=trains)})


def test_sources_with_equal_spikes_share_memory_and_room(tmp_path: Path, golden: Golden) -> None:
    path, many = tmp_path / "many.nrpnet", alike(400, [2.0])
    save_network(many, path)
    again = read_network(path)
    assert again.digest == many.digest
    first, second, *_, last = again.populations["sources"].spike_times_ms
    assert (first.tolist(), second is last) == ([2.0], True)
    save_network(alike(2, [2.0]), tmp_path / "few.nrpnet")
    assert path.stat().st_size < 2 * (tmp_path / "few.nrpnet").stat().st_size
    with h5py.File(path, "r+") as file:
        file["populations/0/spike_train"][3] = 2
    with golden.raises(NetworkError):
        read_network(path)


def test_currents_are_kept_and_are_part_of_the_identity(network: Network, tmp_path: Path) -> None:
    current = InjectedCurrent(np.array([3, 1]), np.array([0.5, 7.0]), np.array([0.25, -1.0]))
    driven = replace(network, currents=(current,))
    save_network(driven, tmp_path / "driven.nrpnet")
    (again,) = read_network(tmp_path / "driven.nrpnet").currents
    assert again.neurons.tolist() == [3, 1]
    assert (again.times_ms.tolist(), again.amplitudes_na.tolist()) == ([0.5, 7.0], [0.25, -1.0])
    assert driven.digest != network.digest
    with h5py.File(tmp_path / "driven.nrpnet") as file:
        assert file.attrs["version"] == 7


@pytest.mark.parametrize(
    ("neurons", "times_ms"),
    [
        ([18], [0.0]),
        ([19], [0.0]),
        ([1], [2.0, 1.0]),
        ([1], [-1.0]),
        ([1], [np.nan]),
    ],
)
def test_impossible_currents_are_refused(
    network: Network, neurons: list[int], times_ms: list[float], golden: Golden
) -> None:
    def driven() -> Network:
        current = InjectedCurrent(np.array(neurons), np.array(times_ms), np.ones(len(times_ms)))
        return replace(network, currents=(current,))

    with golden.raises(NetworkError):
        driven()


def test_only_a_file_with_shared_spikes_needs_a_version_that_knows_them(saved: Path, tmp_path: Path) -> None:
    save_network(alike(3, []), tmp_path / "shared.nrpnet")
    with h5py.File(saved) as plain, h5py.File(tmp_path / "shared.nrpnet") as shared:
        assert (plain.attrs["version"], shared.attrs["version"]) == (1, 2)


def test_an_empty_network_can_be_kept(tmp_path: Path) -> None:
    save_network(Network({}), tmp_path / "empty.nrpnet")
    assert read_network(tmp_path / "empty.nrpnet").size == 0


def test_neurons_of_a_file_can_be_named_anew(saved: Path, golden: Golden) -> None:
    network = read_network(saved, populations={"left": "0:3", "last": -1})
    assert network.views["left"].tolist() == [0, 1, 2]
    assert network.views["last"].tolist() == [18]
    with golden.raises(NeuronSelectionError, match="'left': '0:30'"):
        read_network(saved, populations={"left": "0:30"})


@given(cut=st.floats(0, 1, exclude_max=True))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
def test_a_file_cut_short_is_one_clear_error(saved: Path, tmp_path: Path, cut: float) -> None:
    whole = saved.read_bytes()
    path = tmp_path / "cut.nrpnet"
    path.write_bytes(whole[: int(cut * len(whole))])
    with pytest.raises(NetworkError, match=r"cut short or damaged|is not an HDF5 file") as caught:
        read_network(path)
    assert caught.value.path == path


@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
def test_a_damaged_bit_is_an_error_or_does_no_harm(
    network: Network, saved: Path, tmp_path: Path, place: float, bit: int
) -> None:
    damaged = bytearray(saved.read_bytes())
    damaged[int(place * len(damaged))] ^= 1 << bit
    path = tmp_path / "damaged.nrpnet"
    path.write_bytes(damaged)
    try:
        read = read_network(path)
    except NetworkError:
        return
    assert read.digest == network.digest


def changed(change: Callable[[h5py.File], None], saved: Path, tmp_path: Path) -> Path:
    path = tmp_path / "changed.nrpnet"
    path.write_bytes(saved.read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def _replace(name: str, values: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = values

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.attrs.__delitem__("format"), "HDF5"),
        (lambda file: file.attrs.__setitem__("version", 8), ""),
        (lambda file: file.attrs.__setitem__("version", "new"), "'version'"),
        (lambda file: file.move("projections", "projection"),
         "'projections'.*'projection'"),
        (lambda file: file["populations/1/parameters"].__delitem__("tau_m"), ""),
        (lambda file: file["projections/0"].__delitem__("weight"), "'/projections/0'"),
        (lambda file: file["projections/0"].attrs.__setitem__("post", "cell"),
         "'in'.*'cell'"),
        (lambda file: file["projections/0"].attrs.__setitem__("origin", "{"), "'origin' .* is not JSON"),
        (_replace("populations/1/parameters/tau_m", [1.0, -1.0, 1.0, 1.0]),
         "'targets': tau_m.*-1"),
        (_replace("populations/1/parameters/cm", [1.0, 2.0]), r"'cm'.*\(2,\).*\(4,\)"),
        (_replace("projections/0/pre_index", ["a"]), "'/projections/0/pre_index'"),
        (_replace("projections/0/weight", [1.0, 2.0]), r"'in'.*\(2,\)"),
    ],
)  # fmt: skip
def test_a_file_that_contradicts_itself_says_where(
    change: Callable[[h5py.File], None], message: str, saved: Path, tmp_path: Path, golden: Golden
) -> None:
    path = changed(change, saved, tmp_path)
    with golden.raises(NetworkError, match=message) as caught:
        read_network(path)
    assert caught.value.path == path


def test_a_file_that_is_not_a_network_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError):
        read_network(tmp_path / "nothing.nrpnet")
    (tmp_path / "text.nrpnet").write_text("a network")
    with golden.raises(NetworkError, match="HDF5"):
        read_network(tmp_path / "text.nrpnet")
    with golden.raises(NetworkError):
        save_network(Network({}), tmp_path / "nowhere" / "all.nrpnet")


def test_a_file_that_is_there_stays_until_the_new_one_is_complete(
    network: Network, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "net.nrpnet"
    save_network(network, path)
    before = path.read_bytes()

    def fail(*_: object, **__: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(h5py.Group, "create_dataset", fail)
    with pytest.raises(NetworkError, match="disk full"):
        save_network(network, path, overwrite=True)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["net.nrpnet"]


def test_networks_need_h5py_only_in_files() -> None:
    program = "import sys; import nrp_core.network.files, nrp_formats.sonata; print('h5py' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_the_digest_distinguishes_networks_by_all_their_contents(network: Network) -> None:
    same = everything(builder(1))
    assert same.digest == network.digest
    assert everything(builder(2)).digest != network.digest
    assert Network(network.populations, network.projections, network.views).digest != network.digest


SCRIPT = """
import pyNN.nest as sim
cells = sim.Population(20, sim.IF_curr_exp(tau_m=sim.RandomDistribution("uniform", low=5.0, high=9.0)))
sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.3), sim.StaticSynapse(weight=0.1))
"""


def test_a_network_has_one_digest_in_every_process(tmp_path: Path) -> None:
    (tmp_path / "brain.py").write_text(SCRIPT)
    program = (
        "from nrp_core.network.files import save_network\n"
        "from nrp_core.network.files.script import load_network\n"
        "network = load_network('brain.py', seed=3)\n"
        "save_network(network, 'net.nrpnet')\nprint(network.digest)\n"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    digest = load_network(tmp_path / "brain.py", seed=3).digest
    assert done.stdout.strip() == digest == read_network(tmp_path / "net.nrpnet").digest
    assert load_network(tmp_path / "brain.py", seed=4).digest != digest


def test_an_array_that_does_not_fit_into_memory_is_refused_before_it_is_read(
    saved: Path, tmp_path: Path, golden: Golden
) -> None:
    def grow(file: h5py.File) -> None:
        del file["projections/0/weight"]
        file.create_dataset("projections/0/weight", (10**15,), "f8", chunks=(1000,))

    with golden.raises(NetworkError, match=r"1000000000000000.*7\.1 PiB"):
        read_network(changed(grow, saved, tmp_path))


def test_remarks_on_the_script_are_kept(tmp_path: Path) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_curr_exp(), label="cells")
    sim.Population(1, sim.IF_curr_exp(), label="cells")
    sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1, delay=1.0))
    network = sim.network()
    assert "two populations have the label 'cells'" in network.remarks[0]
    save_network(network, tmp_path / "cells.nrpnet")
    assert read_network(tmp_path / "cells.nrpnet").remarks == network.remarks


def test_a_file_without_remarks_has_none(tmp_path: Path) -> None:
    sim = builder()
    sim.Population(2, sim.IF_curr_exp(), label="cells")
    save_network(sim.network(), tmp_path / "cells.nrpnet")
    assert read_network(tmp_path / "cells.nrpnet").remarks == ()


def test_values_that_cells_share_in_memory_are_shared_when_they_are_read(tmp_path: Path) -> None:
    values = {"tau_m": np.broadcast_to(np.float64(20.0), (3,)), "v_rest": np.array([-65.0, -64.0, -63.0])}
    cells = Population("cells", 3, "IF_curr_exp", values, {"v": np.broadcast_to(np.float64(-65.0), (3,))})
    save_network(Network({"cells": cells}), tmp_path / "cells.nrpnet")

    read = read_network(tmp_path / "cells.nrpnet").populations["cells"]

    assert read.parameters["tau_m"].tolist() == [20.0] * 3
    assert read.parameters["tau_m"].strides == read.initial_values["v"].strides == (0,)
    assert read.parameters["v_rest"].tolist() == [-65.0, -64.0, -63.0]
