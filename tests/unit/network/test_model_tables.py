"""The tables of cell types and synapse laws say what PyNN says, and one name means one thing."""

from __future__ import annotations

import pytest
from golden import Golden
from pyNN.parameters import Sequence
from pyNN.standardmodels import cells, synapses

from nrp_core.network.cells import CELLS
from nrp_core.network.parameters import FRACTION, POSITIVE, Parameter, limits_of
from nrp_core.network.synapses import EVERY_SYNAPSE, LAWS


@pytest.mark.parametrize("name", [name for name in CELLS if hasattr(cells, name)])
def test_a_cell_type_has_the_defaults_and_units_of_pynn(name: str) -> None:
    ours, theirs = CELLS[name], getattr(cells, name)
    numbers = {key: value for key, value in theirs.default_parameters.items() if value != Sequence([])}
    assert {key: parameter.default for key, parameter in ours.parameters.items()} == numbers
    assert {key: variable.default for key, variable in ours.state.items()} == theirs.default_initial_values
    for key, known in (ours.parameters | ours.state).items():
        assert known.unit == theirs.units[key]
    assert bool(ours.weight_unit) == bool(theirs.receptor_types)


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if hasattr(synapses, law.pynn)])
def test_a_synapse_law_has_the_defaults_of_pynn(name: str) -> None:
    law = LAWS[name]
    theirs = dict(getattr(synapses, law.pynn).default_parameters)
    beyond: set[str] = set()
    for classes in law.parts.values():
        for part, known in classes.items():
            if not hasattr(synapses, part):
                beyond |= set(known.parameters)
                continue
            defaults = getattr(synapses, part).default_parameters
            assert set(known.parameters) == set(defaults)
            theirs |= defaults
    if law.parts:
        theirs["dendritic_delay_fraction"] = 1.0
    theirs = {key: value for key, value in theirs.items() if key not in EVERY_SYNAPSE}
    assert theirs == {key: value for key, value in law.defaults.items() if key in theirs}
    assert law.defaults.keys() - theirs.keys() <= beyond


def test_a_name_with_two_limits_is_refused(golden: Golden) -> None:
    with golden.raises(ValueError, match="'x'"):
        limits_of([{"x": Parameter(1.0, limit=POSITIVE)}, {"x": Parameter(1.0, limit=FRACTION)}])
