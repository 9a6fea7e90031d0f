"""A composite brain resets, is restored, changes, and refuses what its parts cannot do."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_composite import CompositeBackend
from nrp_brain_composite.cut import cut_network
from nrp_brain_composite.options import CompositeOptions
from nrp_brain_event import EventBackend
from pydantic import ValidationError

from nrp_core.brain import Brain, DCSource, Network, Population, Projection, SpikeRecorder
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.cells import CELLS

MS = 1_000_000


def cells(label: str, i_offset: float) -> Population:
    kind = CELLS["IF_curr_exp"]
    parameters = {name: np.full(2, float(one.default)) for name, one in kind.parameters.items()}
    return Population(
        label, 2, "IF_curr_exp", parameters | {"i_offset": np.full(2, i_offset)}, {"v": np.full(2, -65.0)}
    )


def network(delay_ms: float = 1.5) -> Network:
    ends, two = np.arange(2), np.ones(2)
    there = Projection("there", "red.a", "blue.b", "excitatory", ends, ends, 5 * two, delay_ms * two)
    back = replace(there, label="back", pre="blue.b", post="red.a", receptor="inhibitory", weight=-two)
    return Network({"red.a": cells("red.a", 1.2), "blue.b": cells("blue.b", 0.0)}, (there, back))


def opened(parts: dict[str, Any], whole: Network | None = None) -> Brain:
    options = CompositeOptions.model_validate({"parts": parts})
    return CompositeBackend().open(whole or network(), seed=1, options=options)


def spikes(brain: Brain, sink: Any, until_ms: int) -> list[tuple[int, float]]:
    brain.run_until(until_ms * MS)
    found = sink.spikes()
    return list(zip(found.neurons.tolist(), found.times_ms.tolist(), strict=True))


GRID = {"backend": "event", "options": {"resolution": "0.1 ms"}}
TWO = {"red": {"backend": "event"}, "blue": GRID}
APART = {"red": {"backend": "event", "process": True}, "blue": GRID}


@pytest.mark.parametrize("parts", [TWO, APART], ids=["here", "in a process"])
def test_a_reset_and_a_snapshot_give_the_same_spikes_again(parts: dict[str, Any]) -> None:
    with opened(parts) as brain:
        sink = brain.add_sink(SpikeRecorder(), [0, 1, 2, 3], name="all")
        brain.run_until(33 * MS)
        snapshot = brain.snapshot()
        whole = spikes(brain, sink, 120)
        assert {neuron for neuron, _ in whole} == {0, 1, 2, 3}
        brain.restore(snapshot)
        assert spikes(brain, sink, 120) == whole
        brain.reset()
        assert spikes(brain, sink, 120) == whole


def test_a_part_in_a_process_of_its_own_gives_the_same_spikes() -> None:
    found = []
    for parts in (TWO, APART):
        with opened(parts) as brain:
            found.append(spikes(brain, brain.add_sink(SpikeRecorder(), [0, 1, 2, 3], name="all"), 100))
    assert found[0] == found[1]


def test_states_parameters_weights_and_currents_reach_their_part() -> None:
    with opened(TWO) as brain:
        brain.add_source(DCSource(amplitude=0.5), [3], name="current")
        brain.set_parameters([1], {"i_offset": 0.0})
        brain.set_weights("there", [0.0, 0.0])
        brain.run_until(10 * MS)
        v = brain.read_state("v", [0, 1, 2, 3])
        assert v[0] > v[1] == pytest.approx(-65.0)
        assert v[3] > v[2] == pytest.approx(-65.0)
        assert brain.read_weights("there").tolist() == [0.0, 0.0]
        assert brain.read_weights("back").tolist() == [-1.0, -1.0]


@pytest.mark.parametrize("delay_ms", [0.6, 2.0])
def test_a_part_that_takes_spikes_only_in_time_gets_them_later_over_shorter_delays(
    monkeypatch: pytest.MonkeyPatch, delay_ms: float
) -> None:
    parts = {"red": GRID, "blue": GRID}
    with opened(parts, network(delay_ms)) as brain:
        whole = spikes(brain, brain.add_sink(SpikeRecorder(), [0, 1, 2, 3], name="all"), 150)
    exact = EventBackend.capabilities
    monkeypatch.setattr(
        EventBackend, "capabilities", lambda self, options: replace(exact(self, options), late_spikes=False)
    )
    with opened(parts, network(delay_ms)) as brain:
        assert {part.shift_ns for part in brain._cut.parts} == {round(delay_ms * MS) - 100_000}
        assert spikes(brain, brain.add_sink(SpikeRecorder(), [0, 1, 2, 3], name="all"), 150) == whole


@pytest.mark.parametrize(
    ("parts", "delay_ms", "error"),
    [
        ({"red": {}, "blue": {"options": {"resolution": "1 ms"}}}, 0.2, CapabilityError),
        ({"red": {"backend": "spinnaker"}, "blue": {}}, 1.0, CapabilityError),
        ({"red": {"populations": ["red.a", "blue"]}, "blue": {}}, 1.0, NetworkError),
        ({"red": {"populations": ["red.x"]}, "blue": {}}, 1.0, NetworkError),
        ({"red": {}}, 1.0, NetworkError),
    ],
    ids=["short", "lag", "twice", "unknown", "none"],
)
def test_a_cut_that_cannot_be_made_is_refused(
    parts: dict[str, Any], delay_ms: float, error: type[Exception], golden: Golden
) -> None:
    with golden.raises(error):
        opened(parts, network(delay_ms))


GRID_1_MS = {"options": {"resolution": "1 ms"}}


@pytest.mark.parametrize(
    ("parts", "delay_ms", "owners"),
    [
        ({"one": {}, "two": {}}, 0.2, ("one", "two")),
        ({"one": GRID_1_MS, "two": GRID_1_MS}, 0.2, ("one", "two")),  # on that grid 0.2 ms are 1 ms
        ({"one": {}, "two": {"backend": "spinnaker"}}, 1.0, ("one", "one")),
        ({"one": {}, "two": {"backend": "spinnaker"}}, 2.0, ("one", "two")),
        ({"one": {"populations": ["blue"]}, "two": {}, "three": {}}, 1.0, ("two", "one")),
    ],
    ids=["apart", "grid", "together", "long", "rest"],
)
def test_parts_without_populations_share_what_can_be_cut(
    parts: dict[str, Any], delay_ms: float, owners: tuple[str, str]
) -> None:
    cut = cut_network(network(delay_ms), CompositeOptions.model_validate({"parts": parts}))
    assert tuple(cut.owners.values()) == owners


def test_parts_that_share_populations_must_all_be_able_to_simulate_them(golden: Golden) -> None:
    kind = CELLS["IF_curr_exp_frozen"]
    values = {name: np.full(2, float(one.default)) for name, one in kind.parameters.items()}
    whole = Network({"a": Population("a", 2, "IF_curr_exp_frozen", values, {"v": np.full(2, -65.0)})})
    with opened({"one": {}, "two": {"options": {"resolution": "1 ms"}}}, whole) as brain:
        brain.run_until(MS)
    with golden.raises(CapabilityError):
        opened({"one": {}, "two": {"backend": "spinnaker"}}, whole)


def test_a_wrong_option_of_a_part_is_named() -> None:
    with pytest.raises(ValidationError, match=r"options\.resolution"):
        CompositeOptions.model_validate({"parts": {"red": {"options": {"resolution": "fast"}}}})


def test_an_operation_that_a_part_lacks_names_the_part(golden: Golden) -> None:
    with opened({"red": {"backend": "spinnaker", "options": {"timestep": "0.1 ms"}}, "blue": {}}) as brain:
        with golden.raises(CapabilityError):
            brain._require_change("plasticity")
        assert brain.capabilities.resolution_ns == 100_000
        assert "plasticity" not in brain.capabilities.changes
