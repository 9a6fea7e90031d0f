"""What the cockpit reads from a brain while somebody looks."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from nrp_brain_spinnaker.backend import SpinnakerBackend
from nrp_cockpit.session.looks import Looks

from nrp_core.network.rewiring import Rewiring
from nrp_core.pynn import new_simulator


def test_weights_are_those_of_the_synapses_that_there_are_now() -> None:
    sim: Any = new_simulator()
    sim.setup(timestep=1.0)
    ends = [sim.Population(4, sim.IF_curr_exp(), label=label) for label in ("pre", "post")]
    sim.Projection(*ends, sim.OneToOneConnector(), sim.StaticSynapse(weight=1.0, delay=1.0), label="grown")
    network = sim.network()
    everywhere = Rewiring(f_rew=1e3, initial_weight=0.5, s_max=3, p_form_forward=1.0, sigma_form_forward=1e9)
    grows = replace(network.projections[0], rewiring=replace(everywhere, prob_elim_potentiated=0.0))
    backend = SpinnakerBackend()
    options = backend.options()
    with backend.open(replace(network, projections=(grows,)), seed=1, options=options) as brain:
        looks = Looks(cast(Any, SimpleNamespace(brain=brain)))
        assert looks.weights("grown")["summary"] == [1.0, 1.0, 1.0]
        brain.run_until(2_000_000_000)
        seen, found = looks.weights("grown"), brain.read_synapses("grown").weight
    assert np.bincount(found.astype(int)).tolist() == [8, 4]  # all 12 places are taken
    assert sum(seen["counts"]) == 12
    assert seen["summary"] == [0.5, (8 * 0.5 + 4) / 12, 1.0]


@pytest.mark.parametrize("weight", [1e-4, -2.0, 0.0])
def test_equal_weights_have_an_axis_of_their_own_size(weight: float) -> None:
    brain = SimpleNamespace(read_synapses=lambda _label: SimpleNamespace(weight=np.full(3, weight)), now_ns=0)
    seen = Looks(cast(Any, SimpleNamespace(brain=brain))).weights("any")
    assert seen["borders"][0] < weight < seen["borders"][-1]
    assert seen["borders"][-1] - seen["borders"][0] == pytest.approx(abs(weight) or 1.0)
    assert sum(seen["counts"]) == 3
