"""The brain of an experiment may be any file that a reader is installed for."""

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import NetworkError
from nrp_core.experiment.making.maker import network_from
from nrp_core.experiment.making.prepare import load_network_only, prepare
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError
from nrp_core.network.files import save_network
from nrp_core.network.files.script import load_network


@pytest.fixture
def experiment(fakes: None, drive_to_the_wall: Path) -> Path:
    """A folder with an experiment whose brain is a script, and the engines for it."""
    return drive_to_the_wall


def test_a_saved_network_runs_as_its_script_does(experiment: Path) -> None:
    script = load_experiment(experiment)
    network = load_network(script.brain.model, seed=script.seed)
    save_network(network, experiment / "net.nrpnet")
    saved = load_experiment(experiment, [f"brain.model={experiment / 'net.nrpnet'}"])
    with FilesRead() as read:
        plan = prepare(saved)
    assert plan.network.digest == prepare(script).network.digest
    assert experiment / "net.nrpnet" in read.below([experiment])
    with Run(saved) as run:
        run.run()
        assert run.result().passed


def test_a_sonata_circuit_is_a_brain(experiment: Path) -> None:
    with h5py.File(experiment / "nodes.h5", "w") as file:
        file.create_group("nodes/circuit")["node_type_id"] = [1, 1, 1, 1]
    types = "node_type_id model_type model_template\n1 point_neuron pynn:IF_curr_exp\n"
    (experiment / "types.csv").write_text(types)
    nodes = [{"nodes_file": "nodes.h5", "node_types_file": "types.csv"}]
    (experiment / "circuit_config.json").write_text(json.dumps({"networks": {"nodes": nodes}}))
    plan = prepare(load_experiment(experiment, [f"brain.model={experiment / 'circuit_config.json'}"]))
    assert plan.network.populations["circuit"].cell_type == "IF_curr_exp"
    assert plan.network.views["actors"].tolist() == [2, 3]


def test_a_file_that_is_cut_short_is_found_before_the_run(experiment: Path) -> None:
    whole = experiment / "net.nrpnet"
    save_network(load_network(experiment / "brain.py"), whole)
    whole.write_bytes(whole.read_bytes()[:-100])
    with pytest.raises(InvalidExperimentError, match=r"net\.nrpnet"):
        prepare(load_experiment(experiment, [f"brain.model={experiment / 'net.nrpnet'}"]))


def test_a_suffix_without_a_reader_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(NetworkError, match=r"'\.nrpne'.*'\.nrpnet'"):
        network_from(tmp_path / "net.nrpne")


def test_a_package_can_bring_a_reader_of_its_own(install: Callable[..., None], tmp_path: Path) -> None:
    source = (
        "from nrp_core.network.data import Network\n"
        "def read(path, *, populations=None, seed=0):\n"
        "    return Network({}, timestep_ms=float(seed))\n"
    )
    install("neuroml", "[nrp_core.networks]\n.nml = neuroml:read\n", source)
    assert network_from(tmp_path / "net.nml", seed=3).timestep_ms == 3.0


def test_several_models_are_one_network_with_seeds_of_their_own(experiment: Path) -> None:
    script = experiment / "noisy.py"
    script.write_text(
        "import numpy as np\nimport nrp_core.pynn as sim\n"
        "gain = sim.parameter('gain', 1.0, low=0.0)\n"
        "cells = sim.Population(2, sim.IF_curr_exp(i_offset=gain * np.random.rand()), label='cells')\n"
    )

    def made(*settings: str) -> dict[str, float]:
        model = ["brain.model=null", "brain.populations=null", "transfer_functions=[]", *settings]
        network = load_network_only(load_experiment(experiment, model))
        return {label: float(one.parameters["i_offset"][0]) for label, one in network.populations.items()}

    both = made(f"brain.model={{red: {script}, blue: {script}}}")
    assert set(both) == {"red.cells", "blue.cells"}
    assert both["red.cells"] != both["blue.cells"]
    assert made(f"brain.model={{red: {script}}}") == {"red.cells": both["red.cells"]}
    twice = made(f"brain.model={{red: {script}, blue: {script}}}", "brain.parameters={red: {gain: 2.0}}")
    assert twice == {"red.cells": 2 * both["red.cells"], "blue.cells": both["blue.cells"]}


@pytest.mark.parametrize("setting", ["brain.parameters={gain: 2}", "brain.populations={green: {eyes: 3}}"])
def test_a_setting_of_no_model_is_refused(experiment: Path, golden: Golden, setting: str) -> None:
    script = experiment / "brain.py"
    with golden.raises(InvalidExperimentError):
        load_experiment(
            experiment,
            [
                "brain.model=null",
                f"brain.model={{red: {script}, blue: {script}}}",
                "brain.populations=null",
                setting,
            ],
        )
