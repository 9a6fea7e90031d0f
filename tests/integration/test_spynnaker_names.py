"""The names of sPyNNaker's public interface: each works, or is refused by name with a reason.

``spynnaker_names.json`` has them with their version: the ``__all__`` of its modules, and the public
attributes of its classes.
"""

import json
from pathlib import Path
from typing import Any

import pytest
from spynnaker_scripts import HEAD, run

from nrp_core.brain.pynn.spynnaker import refused
from nrp_core.errors import CapabilityError

DATA = json.loads((Path(__file__).parent / "spynnaker_names.json").read_text())
REASONS = [
    refused.SIMULATOR, refused.EXTRA_MODELS, refused.DEVICES, refused.SPLITTERS, refused.POPULATIONS,
    refused.CONNECTIONS,
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


def test_a_name_that_it_does_not_have_is_no_device_and_no_method(script: Any) -> None:
    for owner in (script.devices, script.p.extra_models, *script.objects.values()):
        with pytest.raises(AttributeError, match="SpikeInjecter"):
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
