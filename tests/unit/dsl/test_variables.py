"""Variables keep their values, alone or shared, until a reset."""

from __future__ import annotations

from collections.abc import Callable

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import Variable
from nrp_core.dsl.testing import MockBrain, MockWorld, Rig

Load = Callable[[str], list[TransferFunction]]


def test_a_value_stays_from_run_to_run_and_reset_restores_the_first(load: Load) -> None:
    (function,) = load(
        """
        @nrp.MapVariable("seen", initial_value=[])
        @nrp.Robot2Neuron()
        def f(t, seen):
            seen.value.append(t)
        """
    )
    rig = Rig(function)
    rig.run(0.02)
    rig.run(0.04)
    assert function.seen.value == [0.02, 0.04]
    function.reset()
    assert function.seen.value == []


def test_changing_the_initial_value_elsewhere_changes_nothing() -> None:
    initial = [1]
    variable = Variable("x", initial)
    initial.append(2)
    variable.reset()
    assert variable.value == [1]


def test_a_shared_variable_is_one_for_functions_bound_together(load: Load) -> None:
    first, second, alone = load(
        """
        @nrp.MapVariable("a", global_key="n", initial_value=1, scope=nrp.GLOBAL)
        @nrp.Robot2Neuron()
        def first(t, a):
            a.value += 1

        @nrp.MapVariable("n", initial_value=100, scope=nrp.GLOBAL)
        @nrp.Robot2Neuron()
        def second(t, n):
            return n.value

        @nrp.MapVariable("n", initial_value=7, scope=nrp.TRANSFER_FUNCTION_LOCAL)
        @nrp.Robot2Neuron()
        def alone(t, n):
            return n.value
        """
    )
    brain, world = MockBrain({}), MockWorld()
    variables: dict[str, object] = {}
    for function in (first, second, alone):
        function.bind(brain, world, variables=variables)
    first.run(0)
    assert second.run(0) == 2
    assert alone.run(0) == 7
    second.reset()
    assert second.run(0) == 1
