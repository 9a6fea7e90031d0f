"""Brain scripts are ordinary PyNN scripts; loading one gives its network, or one clear error."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.errors import CapabilityError, ExperimentError, NetworkError, NeuronSelectionError, NrpError
from nrp_core.network.data import Network
from nrp_core.network.files.script import load_network
from nrp_core.network.picking import Selection

HEAD = "import pyNN.nest as sim\nsim.setup(timestep=0.1)\n"
CIRCUIT = HEAD + "circuit = sim.Population(8, sim.IF_cond_alpha(), label='cells')\n"
RANDOM = HEAD + (
    "from pyNN.random import RandomDistribution\n"
    "cells = sim.Population(9, sim.IF_cond_exp(tau_m=RandomDistribution('uniform', (5.0, 9.0))))\n"
    "sim.Projection(cells, cells, sim.FixedProbabilityConnector(0.5), sim.StaticSynapse(weight=0.1))\n"
)


def load(folder: Path, source: str, **options: Any) -> Network:
    path = folder / "brain.py"
    path.write_text(source)
    return load_network(path, **options)


def error_of(folder: Path, source: str, **options: Any) -> NrpError:
    with pytest.raises(NrpError) as caught:
        load(folder, source, **options)
    return caught.value


@pytest.mark.parametrize(
    "import_it",
    [
        "import nrp_core.pynn as sim",
        "from nrp_core import pynn as sim",
        "import pyNN.nest as sim",
        "import pyNN.neuron as sim",
        "import pyNN.brian2 as sim",
        "import pyNN.spiNNaker as sim",
        "import pyNN.mock as sim",
        "from pyNN import nest as sim",
        "import pyNN\nimport pyNN.nest\nsim = pyNN.nest",
        "from pyNN.utility import get_simulator\nsim, options = get_simulator()",
        "import pyNN.utility\nsim, _ = pyNN.utility.get_simulator(('--debug', 'Print more'))",
        "from importlib import import_module\nsim = import_module('pyNN.nest')",
        "from pyNN.utility import get_script_args\nexec('import pyNN.%s as sim' % get_script_args(1)[0])",
    ],
)
def test_every_import_of_a_simulator_gives_the_builder(tmp_path: Path, import_it: str) -> None:
    network = load(tmp_path, f"{import_it}\nsim.setup()\ncells = sim.Population(2, sim.IF_curr_exp())")
    assert network.views["cells"].tolist() == [0, 1]


def test_names_can_be_taken_from_a_simulator_and_from_pynn_itself(tmp_path: Path) -> None:
    source = (
        "from pyNN.nest import *\nfrom pyNN.random import NumpyRNG\nfrom pyNN.space import Grid2D\n"
        "from pyNN.connectors import OneToOneConnector\nfrom pyNN.standardmodels.cells import IF_cond_exp\n"
        "setup()\ncells = Population(4, IF_cond_exp(), structure=Grid2D())\n"
        "Projection(cells, cells, OneToOneConnector(), StaticSynapse(weight=0.1))\n"
    )
    assert load(tmp_path, source).projections[0].size == 4


def test_a_simulator_has_the_standard_models_of_pynn_as_a_package(tmp_path: Path) -> None:
    source = (
        "import pyNN.neuron as sim\nsim.setup()\nmodels = sim.standardmodels\n"
        "cells = sim.Population(2, models.cells.IF_cond_exp())\n"
        "synapse = models.synapses.StaticSynapse(weight=0.1)\n"
        "sim.Projection(cells, cells, sim.AllToAllConnector(), synapse)\n"
        "models.electrodes.DCSource(amplitude=0.1).inject_into(cells)\n"
    )
    assert load(tmp_path, source).projections[0].size == 4


def test_the_arguments_a_script_asks_for_have_their_defaults(tmp_path: Path) -> None:
    source = (
        "from pyNN.utility import get_simulator\n"
        "sim, options = get_simulator(('--plot-figure', 'Plot', {'action': 'store_true'}),\n"
        "                             ('--size', 'Cells', {'type': int, 'default': 3}))\n"
        "assert not options.plot_figure\ncells = sim.Population(options.size, sim.IF_curr_exp())\n"
    )
    assert load(tmp_path, source).size == 3
    needs = "from pyNN.utility import get_simulator\nget_simulator(('size', 'Cells'))"
    assert "gets no command line: the following arguments are required: size" in str(
        error_of(tmp_path, needs)
    )


def test_loading_leaves_the_modules_of_the_program_alone(tmp_path: Path) -> None:
    load(tmp_path, CIRCUIT)  # imports PyNN itself
    before = set(sys.modules)
    load(tmp_path, CIRCUIT)
    assert set(sys.modules) == before
    assert "pyNN.nest" not in sys.modules


def test_the_loader_itself_does_not_import_pynn() -> None:
    code = "import sys, nrp_core.network.files.script; sys.exit('pyNN' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_two_loads_do_not_see_each_other(tmp_path: Path) -> None:
    counting = CIRCUIT + "sim.loads = getattr(sim, 'loads', 0) + 1\nassert sim.loads == 1\n"
    assert load(tmp_path, counting).digest == load(tmp_path, counting).digest


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**63))
def test_a_seed_gives_one_network_and_another_seed_another(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    folder = tmp_path_factory.getbasetemp()
    first = load(folder, RANDOM, seed=seed)
    assert load(folder, RANDOM, seed=seed).digest == first.digest
    assert load(folder, RANDOM, seed=seed + 1).digest != first.digest


def test_the_network_remembers_the_time_step_of_the_script(tmp_path: Path) -> None:
    assert load(tmp_path, "import pyNN.nest as sim\nsim.setup(timestep=0.5)").timestep_ms == 0.5


# -- names for neurons


@pytest.mark.parametrize(
    ("selection", "expected"),
    [
        ("0:5", [0, 1, 2, 3, 4]),
        ("0:6:2", [0, 2, 4]),
        (":", [0, 1, 2, 3, 4, 5, 6, 7]),
        ("-2:", [6, 7]),
        ("::-4", [7, 3]),
        ("3", [3]),
        (3, [3]),
        (-1, [7]),
        ([5, 2, 5], [5, 2, 5]),
        (None, [0, 1, 2, 3, 4, 5, 6, 7]),
        ({"from": 1, "to": 7, "step": 3}, [1, 4]),
        ({"from": 6, "to": 8}, [6, 7]),
        ({"list": [7, 0]}, [7, 0]),
    ],
)
def test_a_selection_picks_from_the_circuit(
    tmp_path: Path, selection: Selection, expected: list[int]
) -> None:
    source = HEAD + "sim.Population(2, sim.IF_curr_exp())\n" + CIRCUIT.removeprefix(HEAD)
    views = load(tmp_path, source, populations={"picked": selection}).views
    assert (views["picked"] - 2).tolist() == expected


@settings(max_examples=40, deadline=None)
@given(
    start=st.none() | st.integers(-9, 9), stop=st.none() | st.integers(-9, 9),
    step=st.none() | st.integers(-3, 3),
)  # fmt: skip
def test_a_slice_picks_what_it_picks_from_an_array_or_is_refused(
    tmp_path_factory: pytest.TempPathFactory, start: int | None, stop: int | None, step: int | None
) -> None:
    texts = ["" if bound is None else str(bound) for bound in (start, stop, step)]
    inside = all(bound is None or -8 <= bound <= 8 for bound in (start, stop))
    expected = np.arange(8)[slice(start, stop, step)].tolist() if step != 0 else []
    folder = tmp_path_factory.getbasetemp()
    if inside and expected:
        views = load(folder, CIRCUIT, populations={"picked": ":".join(texts)}).views
        assert views["picked"].tolist() == expected
    else:
        error = error_of(folder, CIRCUIT, populations={"picked": ":".join(texts)})
        assert isinstance(error, NeuronSelectionError)
        assert "population 'picked'" in str(error)


@pytest.mark.parametrize(
    ("circuit", "expected"),
    [("a[1:]", [1, 2]), ("b + a[::2]", [3, 4, 0, 2]), ("sim.Assembly(b, a)[1:4]", [4, 0, 1])],
)
def test_a_circuit_may_be_a_view_or_an_assembly(tmp_path: Path, circuit: str, expected: list[int]) -> None:
    source = HEAD + "a = sim.Population(3, sim.IF_curr_exp())\nb = sim.Population(2, sim.IF_curr_exp())\n"
    views = load(tmp_path, source + f"circuit = {circuit}", populations={"all": None}).views
    assert sorted(views["all"].tolist()) == sorted(expected)
    assert views["circuit"].tolist() == views["all"].tolist()


def test_a_circuit_of_named_populations_gives_them_their_names(tmp_path: Path, golden: Golden) -> None:
    source = CIRCUIT + "circuit = {'eyes': circuit[:2], 'legs': circuit[2:]}\n"
    assert {k: v.tolist() for k, v in load(tmp_path, source).views.items()} == {
        "eyes": [0, 1], "legs": [2, 3, 4, 5, 6, 7],
    }  # fmt: skip
    error = error_of(tmp_path, source, populations={"eye": "0:1"})
    assert "'eye'" in str(error)
    golden(str(error))
    assert "(eyes, legs)" in str(error)


def test_populations_in_variables_are_known_by_their_names(tmp_path: Path) -> None:
    source = (
        CIRCUIT + "eyes = circuit[0:2]\nends = circuit[:1] + circuit[7:]\n_hidden = circuit[3:4]\nnumber = 5"
    )
    views = {name: ids.tolist() for name, ids in load(tmp_path, source).views.items()}
    assert views == {"circuit": [0, 1, 2, 3, 4, 5, 6, 7], "eyes": [0, 1], "ends": [0, 7]}


def test_an_experiment_may_give_a_name_of_the_script_another_meaning(tmp_path: Path) -> None:
    network = load(tmp_path, CIRCUIT + "eyes = circuit[0:2]", populations={"eyes": "4:8"})
    assert network.neurons("eyes").tolist() == [4, 5, 6, 7]


# -- errors


def test_an_error_in_the_script_has_its_line(tmp_path: Path, golden: Golden) -> None:
    error = error_of(tmp_path, CIRCUIT + "\ncircuit.set(tau_n=3.0)\n")
    assert isinstance(error, NetworkError)
    assert (error.path, error.line) == (tmp_path / "brain.py", 5)
    golden(error.message)


@pytest.mark.parametrize(
    ("line", "kind", "says"),
    [
        ("circuit.set(cm=-1.0)", NetworkError, ":4.*'cells'.*-1"),
        ("sim.IF_facets_hardware1()", CapabilityError, ":4: IF_facets_hardware1"),
        ("sim.IF_cond_alph()", NetworkError, "PyNN.*'IF_cond_alph'.*'IF_cond_alpha'"),
        ("sim.run(100.0)", NetworkError, ":4"),
        ("circuit.get_data()", NetworkError, ":4.*'cells'"),
        ("raise SystemExit(3)", NetworkError, ":4: SystemExit: 3"),
        ("import nosuchmodule", NetworkError, "ModuleNotFoundError.*'nosuchmodule'"),
        ("import pyNN.neest", NetworkError, "'pyNN.neest'"),
        ("from pyNN.nest import Populatio", NetworkError, "'Populatio'"),
        ("while True print", NetworkError, ":4:12"),
        ("sim.Projection(circuit, circuit, sim.AllToAllConnector(), sim.StaticSynapse(weight=-1.0),\n"
         "               receptor_type='excitatory')", NetworkError, "-1"),
    ],
)  # fmt: skip
def test_a_wrong_line_gets_one_clear_error(
    tmp_path: Path, line: str, kind: type, says: str, golden: Golden
) -> None:
    error = error_of(tmp_path, CIRCUIT + line)
    assert isinstance(error, kind)
    with golden.raises(kind, match=says):
        raise error
    assert str(error).startswith(str(tmp_path / "brain.py"))


@pytest.mark.parametrize(
    ("selection", "says"),
    [
        ("0:9", "'0:9' reaches outside the circuit, whose cells are 0..7"),
        (8, "8 reaches outside"),
        ([0, -9], r"\[0, -9\] reaches outside"),
        ("5:5", "'5:5' picks no cell"),
        ([], r"\[\] picks no cell"),
        ("0:5:0", "cells are picked by '0:5'"),
        ("eyes", "not by 'eyes'"),
        ("0:1:2:3", "not by '0:1:2:3'"),
        ({"form": 0}, "cells are picked by"),
        (1.5, "not by 1.5"),
        ([True, False], r"not by \[True, False\]"),
    ],
)
def test_a_selection_that_cannot_be_names_population_and_circuit(
    tmp_path: Path, selection: Any, says: str
) -> None:
    error = error_of(tmp_path, CIRCUIT, populations={"eyes": selection})
    with pytest.raises(NeuronSelectionError, match=f"population 'eyes': .*{says}"):
        raise error
    assert str(error).startswith(str(tmp_path / "brain.py"))


def test_a_circuit_that_is_missing_is_missed_only_if_it_is_needed(tmp_path: Path, golden: Golden) -> None:
    source = HEAD + "cells = sim.Population(2, sim.IF_curr_exp())\n"
    assert load(tmp_path, source).views["cells"].tolist() == [0, 1]
    error = error_of(tmp_path, source, populations={"eyes": "0:1"})
    golden(str(error))


def test_a_population_from_before_the_last_setup_is_refused(tmp_path: Path, golden: Golden) -> None:
    error = error_of(tmp_path, CIRCUIT + "sim.setup()\n")
    assert "'circuit'" in str(error)
    golden(str(error))


def test_a_missing_script_gets_the_nearest_file(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "brain.py").write_text(CIRCUIT)
    with golden.raises(NetworkError, match="'brain.py'"):
        load_network(tmp_path / "brian.py")


def test_a_script_that_is_not_text_is_not_python(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "brain.py").write_bytes(b"\x00\xff\x00")
    with golden.raises(NetworkError, match="brain.py:1:2.*UTF-8.*0xff"):
        load_network(tmp_path / "brain.py")


@pytest.mark.parametrize(("name", "reader"), [("a.nir", "load_nir"), ("a.nrpnet", "read_network")])
def test_a_file_of_a_network_is_not_executed(tmp_path: Path, name: str, reader: str, golden: Golden) -> None:
    (tmp_path / name).write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    with golden.raises(NetworkError, match=f"{reader}"):
        load_network(tmp_path / name)
    assert not (tmp_path / "ran").exists()


AS_DATA = (
    "import numpy as np\nfrom nrp_core import Network, Population\n"
    "network = Network({'cells': Population('cells', 3, 'SpikeSourceArray', {}, {}, (np.empty(0),) * 3)})\n"
)


def test_a_script_can_make_its_network_as_data(tmp_path: Path) -> None:
    network = load(tmp_path, AS_DATA, populations={"first": 0})
    assert network.populations["cells"].size == 3
    assert network.neurons("first").tolist() == [0]


def test_a_network_is_made_as_data_or_with_pynn_but_not_both(tmp_path: Path, golden: Golden) -> None:
    golden(error_of(tmp_path, CIRCUIT + AS_DATA).message)


@pytest.mark.parametrize("seed", [1.5, "7", True, None])
def test_a_seed_that_is_not_an_integer_is_refused(tmp_path: Path, seed: Any, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        load(tmp_path, RANDOM, seed=seed)
    one, same = (load(tmp_path, RANDOM, seed=number) for number in (np.int64(3), 3))
    assert one.digest == same.digest
