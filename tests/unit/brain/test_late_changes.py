"""Dictionaries of scripts that are changed too late, and networks that stay as they were checked."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nrp_core import Network, Population, Projection, load_network
from nrp_core.brain.network.rewiring import Rewiring
from nrp_core.brain.pynn.late_changes import late_changes
from nrp_core.errors import NetworkError

HEAD = "import nrp_core.pynn as sim\nsim.setup()\nvalues = {'tau_m': 20.0}\n"
MADE = HEAD + "cells = sim.Population(4, sim.IF_curr_exp(**values), label='cells')\n"

LATE = [
    "values['tau_m'] = 10.0",
    "values['tau_m'] *= 2.0",
    "values |= {'cm': 2.0}",
    "values.update(cm=2.0)",
    "values.pop('tau_m')",
]
IN_TIME = [
    "values['tau_m'] = 10.0\nmore = sim.Population(4, sim.IF_curr_exp(**values), label='more')",
    "values['tau_m'] = 10.0\nprint(values)",
    "def again():\n    return sim.IF_curr_exp(**values)\n"
    "values['tau_m'] = 10.0\nmore = sim.Population(2, again())",
    "for n in range(2):\n    sim.Population(2, sim.IF_curr_exp(**values), label=str(n))\n"
    "    values['cm'] = 2.0",
    "if len(cells) > 5:\n    values['tau_m'] = 10.0",
    "values = {'tau_m': 10.0}\nvalues['cm'] = 2.0\nmore = sim.Population(2, sim.IF_curr_exp(**values))",
    "",
]


@pytest.mark.parametrize("line", LATE)
def test_a_change_of_a_dictionary_after_its_use_is_told_with_its_line(line: str, tmp_path: Path) -> None:
    script = tmp_path / "brain.py"
    script.write_text(f"{MADE}{line}\n")
    (remark,) = load_network(script).remarks
    assert remark == f"line 5: '{line}' has no effect: 'values' was already copied in line 4"


def test_a_dictionary_as_an_argument_of_pynn_is_copied_too() -> None:
    script = f"{HEAD}cells = sim.Population(4, sim.IF_curr_exp, values)\nvalues['cm'] = 2.0\n"
    (found,) = late_changes(script.encode())
    assert "line 5" in found


@pytest.mark.parametrize("lines", IN_TIME)
def test_a_dictionary_that_is_used_again_is_not_doubted(lines: str) -> None:
    assert list(late_changes(f"{MADE}{lines}\n".encode())) == []


def test_a_function_of_the_script_may_keep_its_dictionary() -> None:
    script = "import nrp_core.pynn as sim\nfrom mine import build\nv = dict(a=1)\nbuild(v)\nv['a'] = 2\n"
    assert list(late_changes(script.encode())) == []


def test_a_program_that_runs_by_itself_is_told_too(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(f"{MADE}values['tau_m'] = 10.0\nsim.run(1.0)\nsim.end()\n")
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert "'values' was already copied in line 4" in ended.stderr


def _values(n: int = 3) -> dict[str, np.ndarray]:
    names = {"cm": 1.0, "tau_m": 20.0, "tau_refrac": 0.1, "tau_syn_E": 5.0, "tau_syn_I": 5.0, "i_offset": 0.0}
    voltages = {"v_rest": -65.0, "v_reset": -65.0, "v_thresh": -50.0}
    return {name: np.full(n, value) for name, value in (names | voltages).items()}


def test_a_network_keeps_what_was_checked() -> None:
    values = _values()
    cells = Population("cells", 3, "IF_curr_exp", values)
    populations = {"cells": cells}
    network = Network(populations)
    values["cm"] = np.full(7, -1.0)
    populations["more"] = cells
    assert network.populations["cells"].parameters["cm"].tolist() == [1.0] * 3
    assert network.size == 3


def test_a_network_refuses_changes_of_its_mappings_and_arrays() -> None:
    values, weight = _values(), np.array([0.1])
    cells = Population("cells", 3, "IF_curr_exp", values)
    ends = np.zeros(1, np.int32)
    wires = Projection("w", "cells", "cells", "excitatory", ends, ends, weight, np.ones(1))
    network = pickle.loads(pickle.dumps(Network({"cells": cells}, (wires,))))
    with pytest.raises(NetworkError, match="is not changed once it is made"):
        network.populations["cells"].parameters["cm"] = np.ones(3)
    for array in (values["cm"], weight):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = -1.0
    assert replace(cells, parameters={**cells.parameters, "cm": np.ones(3) * 2}).parameters["cm"][0] == 2.0


def test_projections_from_a_generator_are_all_kept() -> None:
    cells, ends = Population("cells", 3, "IF_curr_exp", _values()), np.zeros(1, np.int32)
    wires = Projection("w", "cells", "cells", "excitatory", ends, ends, np.array([0.1]), np.ones(1))
    network = Network({"cells": cells}, (one for one in [wires]))  # type: ignore[arg-type]
    assert [one.label for one in network.projections] == ["w"]


def test_lists_of_numbers_become_arrays_and_other_things_are_refused() -> None:
    lists = {name: array.tolist() for name, array in _values().items()}
    assert Population("cells", 3, "IF_curr_exp", lists).parameters["cm"].tolist() == [1.0] * 3  # type: ignore[arg-type]
    with pytest.raises(
        NetworkError, match="population 'cells': its parameters are None; they must be values"
    ):
        Population("cells", 3, "IF_curr_exp", None)  # type: ignore[arg-type]


def test_rewiring_keeps_the_parameters_that_it_got() -> None:
    parameters = {"U": 0.5}
    rewiring = Rewiring(parameters=parameters)
    parameters["U"] = 0.1
    assert rewiring.parameters["U"] == 0.5
