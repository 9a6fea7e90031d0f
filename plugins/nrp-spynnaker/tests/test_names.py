"""The names of sPyNNaker's public interface: each works, or is refused by name with a reason.

``spynnaker_names.json`` has them with their version: the ``__all__`` of its modules, and the public
attributes of its classes.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spynnaker_scripts
from golden import Golden
from nrp_spynnaker.dialect import unsupported
from spynnaker_scripts import HEAD, run

from nrp_core.errors import CapabilityError

DATA = json.loads((Path(__file__).parent / "spynnaker_names.json").read_text())
REASONS = [
    unsupported.SIMULATOR, unsupported.EXTRA_MODELS, unsupported.DEVICES, unsupported.SPLITTERS,
    unsupported.POPULATIONS, unsupported.CONNECTIONS,
]  # fmt: skip
OBJECTS = """
cells = p.Population(2, p.IF_curr_exp())
devices = p.external_devices
objects = {
    "Population": cells,
    "PopulationView": cells[:1],
    "Assembly": p.Assembly(cells),
    "Projection": p.Projection(cells, cells, p.OneToOneConnector()),
    "external_devices.SpynnakerLiveSpikesConnection": devices.SpynnakerLiveSpikesConnection([], []),
    "external_devices.SpynnakerPoissonControlConnection": devices.SpynnakerPoissonControlConnection([]),
}
"""


def refusal(owner: Any, name: str) -> str | None:
    """Return with which words a name is refused, or None; fail if there is no such name."""
    try:
        found = getattr(owner, name)
    except CapabilityError as error:
        return str(error)
    if type(found).__name__ == "_Refused":
        with pytest.raises(CapabilityError) as caught:
            found(1, weight=2)
        return str(caught.value)
    return None


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Any:
    imports = "".join(f"import {name}\n" for name in DATA["modules"])
    return run(tmp_path_factory.mktemp("names"), imports + HEAD + OBJECTS)


@pytest.mark.parametrize("module", DATA["modules"])
def test_every_public_name_is_there_or_refused_with_its_reason(module: str, script: Any) -> None:
    owner = script.spynnaker
    for part in module.split(".")[1:]:
        owner = getattr(owner, part)
    require(owner, DATA["modules"][module])


@pytest.mark.parametrize("kind", DATA["classes"])
def test_every_method_is_there_or_refused_with_its_reason(kind: str, script: Any) -> None:
    require(script.objects[kind], DATA["classes"][kind])


def require(owner: Any, names: list[str]) -> None:
    reasons = {name: why for each in REASONS for name, why in each.items()}
    for name in names:
        said = refusal(owner, name)
        if name in reasons:
            assert said is not None
            assert name in said
            assert reasons[name] in said
        else:
            assert said is None, f"{name} is refused without a reason in the list"


def test_an_unknown_name_is_neither_a_device_nor_a_method(script: Any, golden: Golden) -> None:
    for owner in (script.devices, script.p.extra_models, *script.objects.values()):
        with golden.raises(AttributeError):
            owner.SpikeInjecter  # noqa: B018


def test_names_that_only_it_has_do_what_they_say(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(6, p.IF_curr_exp(), initial_values={'v': range(-65, -71, -1)})\n"
        "both = cells.index_to_id(2), cells.index_to_id([0, 5])\n"
        "others = p.Population.create(p.IF_curr_exp, n=4)\n"
        "groups, weak = p.extra_models.AllButMeConnector(3), p.StaticSynapse(weight=0.1)\n"
        "pairs = p.SpiNNakerProjection(cells, cells, groups, weak).get('weight', 'list')\n"
        "v, size = cells[4:].initial_values['v'].tolist(), others.size\n"
        "cells.record('v')\np.run(3)\nrows = cells[4:].spinnaker_get_data('v')\n",
    )  # fmt: skip
    first = int(script.cells.first_id)
    assert (script.both[0], list(script.both[1])) == (first + 2, [first, first + 5])
    groups = [range(3), range(3, 6)]
    assert sorted((i, j) for i, j, _ in script.pairs) == sorted(
        (i, j) for g in groups for i in g for j in g if i != j
    )
    assert script.v == [-69.0, -70.0]
    assert script.size == 4
    assert set(script.rows[:, 0]) == {4, 5}


def test_parameters_have_a_value_for_each_cell(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(3, p.IF_curr_exp(tau_m=[3.0, 4.0, 5.0], cm=0.5))\n"
        "one, both = cells.get('cm'), cells.get(['cm', 'tau_m'])\n"
        "part, more = cells[1:].get('tau_m'), cells[:2].get(['cm'])\n",
    )
    assert list(script.one) == [0.5] * 3
    assert {name: list(values) for name, values in script.both.items()} == {
        "cm": [0.5] * 3, "tau_m": [3.0, 4.0, 5.0],
    }  # fmt: skip
    assert list(script.part) == [4.0, 5.0]
    assert {name: list(values) for name, values in script.more.items()} == {"cm": [0.5] * 2}


def test_the_state_is_set_like_a_parameter_until_the_network_runs(tmp_path: Path) -> None:
    made = "cells = p.Population(2, p.IF_curr_exp()); cells.record('v'); "
    lines = f"{made}cells.set(v=-60.0, tau_m=10.0); p.run(2)"
    script = run(tmp_path, f"{HEAD}{lines}\n")
    assert script.cells.get_data().segments[0].analogsignals[0].magnitude[0].tolist() == [-60.0, -60.0]
    assert list(script.cells.get("tau_m")) == [10.0, 10.0]
    error = spynnaker_scripts.refused(tmp_path, f"{lines}; cells.set(v=-61.0)")
    assert "v is part of the state of its cells, which cannot be set while the network runs" in str(error)


def test_a_connector_has_the_name_of_earlier_versions_too(script: Any) -> None:
    assert script.p.extra_models.WTAConnector is script.p.extra_models.AllButMeConnector


def test_positions_have_a_row_for_each_cell(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "cells = p.Population(6, p.IF_curr_exp(), structure=p.Grid2D(3 / 2))\n"
        "near = p.DistanceDependentProbabilityConnector('d < 1.1', allow_self_connections=False)\n"
        "wires = p.Projection(cells, cells, near).get('weight', 'list')\n"
        "same = p.SpikeSourceArray({}), p.IF_curr_exp({'tau_m': 9.0})\n"
        "one, nearest = cells[4].position, cells.nearest((2.1, 0.2, 0.0))\n"
        "network = p.network()\n",
    )
    places = [[x, y, 0.0] for x in (0.0, 1.0, 2.0) for y in (0.0, 1.0)]
    assert script.cells.positions.tolist() == places
    assert script.cells[1:3].positions.tolist() == places[1:3]
    assert script.one.tolist() == places[4]
    assert script.cells.id_to_index(script.nearest) == 4
    pairs = {(int(pre), int(post)) for pre, post, _ in script.wires}
    near = {(i, j) for i in range(6) for j in range(6) if sum(abs(np.subtract(places[i], places[j]))) == 1.0}
    assert pairs == near
    assert script.network.populations["population0"].positions_um.tolist() == places
    script.cells.save_positions(tmp_path / "places.txt")
    assert np.loadtxt(tmp_path / "places.txt")[:, 1:].tolist() == places
