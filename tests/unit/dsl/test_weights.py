"""A function reads, sets and freezes the weights of a projection as a NumPy array and an attribute."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from golden import Golden

from nrp_core.brain import builder
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import MockBrain, MockWorld, Rig
from nrp_core.errors import ExperimentError, NetworkError, TransferFunctionError
from nrp_core.network.data import Network

Load = Callable[[str], list[TransferFunction]]


def network() -> Network:
    sim = builder()
    a, b = (sim.Population(n, sim.IF_curr_exp(), label=name) for name, n in (("a", 2), ("b", 3)))
    sim.Projection(a, b, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.5, delay=1.0), label="static")
    rule = sim.STDPMechanism(sim.SpikePairRule(), sim.AdditiveWeightDependence(), weight=0.5, delay=1.0)
    sim.Projection(a, b, sim.OneToOneConnector(), rule, label="learned")
    own = sim.EquationSynapse(
        "dx/dt = -x/tau : 1", on_pre="weight += rate*x", on_post="x += 1",
        parameters={"tau": "20 ms", "rate": 0.1},
    )  # fmt: skip
    sim.Projection(a, b, sim.OneToOneConnector(), own(weight=0.5, delay=1.0), label="own")
    return sim.network()


def function_with(load: Load, body: str, projection: str = "static") -> TransferFunction:
    lines = "\n            ".join(body.splitlines())
    (function,) = load(
        f"""
        import numpy as np

        @nrp.MapWeights("w", nrp.brain.projection("{projection}"))
        @nrp.Robot2Neuron()
        def f(t, w):
            {lines}
        """
    )
    return function


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("w.values = 0.25", [0.25] * 6),
        ("w.values = [0, 1, 2, 3, 4, 5]", [0, 1, 2, 3, 4, 5]),
        ("w.values[3] = 2.0", [0.5, 0.5, 0.5, 2.0, 0.5, 0.5]),
        ("w.values[w.pre_index == 1] = 0.0", [0.5, 0.0, 0.5, 0.0, 0.5, 0.0]),
        ("w.values[w.post_index == 2] += 1.0", [0.5, 0.5, 0.5, 0.5, 1.5, 1.5]),
        ("w.values *= 2", [1.0] * 6),
        ("seen = w.values\nseen -= 0.5\nseen[::2] = 1", [1, 0, 1, 0, 1, 0]),
        ("np.clip(w.values, 0.0, 0.25, out=w.values)", [0.25] * 6),
        ("w.values = 3.0\nw.values[0] = 1.0", [1, 3, 3, 3, 3, 3]),
        ("w.values.sum()", [0.5] * 6),
    ],
)
def test_values_are_an_array_whose_changes_are_the_weights(
    load: Load, body: str, expected: list[float]
) -> None:
    brain = MockBrain(network())
    order = [brain.network.projections[0].ends(k) for k in range(6)]
    assert order == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]
    rig = Rig(function_with(load, body), brain)
    rig.run()
    assert brain.read_weights("static").tolist() == expected
    assert rig.function.w.values.tolist() == expected


def test_the_array_is_read_anew_in_each_run_and_untouched_weights_are_not_written(load: Load) -> None:
    function = function_with(load, "f.seen = w.values\nw.plastic")
    brain = MockBrain(network())
    rig = Rig(function, brain)
    written = []
    brain._do_set_weights = lambda projection, weights: written.append(weights)  # type: ignore[method-assign]
    rig.run()
    first = function.seen
    first[0] = 7.0
    rig.run()
    assert function.seen[0] == 0.5
    assert written == []


def test_a_function_that_fails_changes_no_weight(load: Load) -> None:
    brain = MockBrain(network())
    with pytest.raises(ZeroDivisionError):
        Rig(function_with(load, "w.values[0] = 9.0\n1 / 0"), brain).run()
    assert (brain.read_weights("static") == 0.5).all()


def test_learning_stops_and_continues(load: Load) -> None:
    brain = MockBrain(network())
    function = function_with(load, "w.plastic = t > 0.03\nreturn w.plastic", "learned")
    rig = Rig(function, brain)
    assert [rig.run(), rig.run()] == [False, True]
    rig.run(0.0)
    assert not brain.is_plastic("learned")
    brain.reset()
    assert brain.is_plastic("learned")


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("w.values = [1.0, 2.0]", r"w.values.*'static'.*\(2,\)"),
        ("w.values = np.ones((2, 3))", r"\(2, 3\)"),
        ("w.values = 'high'", "'high'"),
        ("w.plastic = False", "'static'"),
        ("w.values[2] = np.nan", "'w'.*'f'.*'static'"),
        ("w.value = 1.0", "no attribute 'value'"),
    ],
)
def test_an_impossible_change_is_one_clear_error(load: Load, body: str, message: str, golden: Golden) -> None:
    brain = MockBrain(network())
    with golden.raises((ValueError, NetworkError, AttributeError), match=message):
        Rig(function_with(load, body), brain).run()
    assert (brain.read_weights("static") == 0.5).all()


def test_an_unknown_projection_is_an_error_at_the_line_of_the_mapping(load: Load, golden: Golden) -> None:
    function = function_with(load, "pass", "learnt")
    with golden.raises(NetworkError, match="'learnt'.*'learned'") as caught:
        function.bind(MockBrain(network()), MockWorld())
    assert caught.value.line is not None


def test_neurons_are_not_a_projection(load: Load, golden: Golden) -> None:
    (function,) = load(
        """
        @nrp.MapWeights("w", nrp.brain.a)
        @nrp.Robot2Neuron()
        def f(t, w):
            pass
        """
    )
    with golden.raises(ExperimentError, match="nrp.brain.projection"):
        function.bind(MockBrain(network()), MockWorld())


def test_a_rig_has_every_projection_that_a_function_names(load: Load, golden: Golden) -> None:
    rig = Rig(function_with(load, "w.values[w.values > 2] = 2.0\nw.plastic = False", "any → name"))
    rig.set(w=np.linspace(0.0, 4.0, 1000))
    rig.run()
    assert rig.function.w.values.max() == 2.0
    assert rig.function.w.values[100] == pytest.approx(400 / 999)
    assert not rig.function.w.plastic
    with golden.raises(TransferFunctionError, match="'w'"):
        rig.set(ww=1.0)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("w.set_parameters(rate=0.0)", {"rate": [0.0, 0.0]}),
        ("w.set_parameters(rate=0.2)\nw.set_parameters(tau=[5, 10])", {"rate": [0.2] * 2, "tau": [5, 10]}),
        ("w.values = 2.0", {}),
    ],
)
def test_parameters_of_equations_change_once_the_function_has_returned(
    load: Load, body: str, expected: dict[str, list[float]], golden: Golden
) -> None:
    brain = MockBrain(network())
    rig = Rig(function_with(load, body, "own"), brain)
    rig.run()
    found = brain.synapse_parameters.get("own", {})
    assert {name: values.tolist() for name, values in found.items()} == expected
    brain.reset()
    with golden.raises(RuntimeError):
        Rig(function_with(load, f"{body}\nraise RuntimeError('late')", "own"), brain).run()
    assert brain.synapse_parameters == {}


@pytest.mark.parametrize(
    ("body", "projection"),
    [
        ("w.set_parameters(rates=0.0)", "own"),
        ("w.set_parameters(tau=0.0)", "own"),
        ("w.set_parameters(A_plus=0.0)", "learned"),
    ],
)
def test_impossible_parameters_of_equations_are_refused(
    load: Load, body: str, projection: str, golden: Golden
) -> None:
    with golden.raises(NetworkError):
        Rig(function_with(load, body, projection), MockBrain(network())).run()
