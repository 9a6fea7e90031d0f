"""One step after another: who sees what when, and what comes from outside."""

from __future__ import annotations

import threading
from itertools import accumulate
from typing import Any, Literal, cast

import numpy as np
import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import LifecycleError, TimestepError, TopicError
from nrp_core.messages.std_msgs import Float64, String
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.synapses import STDP

PERIOD = 20 * NS_PER_MS


class ListeningBrain(MockBrain):
    """Keeps what arrives at its neurons."""

    def __init__(self) -> None:
        super().__init__({"cells": 2})
        self.arrivals_ms: list[float] = []

    def _do_inject(self, events: SynapticEvents) -> None:
        self.arrivals_ms += events.times_ms.tolist()


def loop_of(*functions: nrp.TransferFunction, brain: MockBrain | None = None, **options: Any) -> ClosedLoop:
    brain = MockBrain({"cells": 2}) if brain is None else brain
    world = MockWorld({"/in": Float64, "/out": Float64})
    return ClosedLoop(brain, world, functions, period_ns=PERIOD, **options)


@pytest.mark.parametrize(("tf_time", "times"), [
    ("end", [0.02 * k for k in range(1, 101)]),
    ("start", [0.02 * k for k in range(100)]),
    ("summed", list(accumulate([0.02] * 99, initial=0.0))),
])  # fmt: skip
def test_functions_get_the_end_or_the_start_of_the_step(
    tf_time: Literal["end", "start", "summed"], times: list[float]
) -> None:
    told: list[float] = []

    @nrp.Robot2Neuron()
    def f(t: float) -> None:
        told.append(t)

    loop = loop_of(f, tf_time=tf_time)
    loop.run_until(100 * PERIOD)
    assert told == times if tf_time == "summed" else told == pytest.approx(times, abs=1e-12)
    loop.reset()
    loop.run_until(2 * PERIOD)
    assert told[100:] == times[:2]


def test_functions_see_both_sides_at_the_end_of_the_step() -> None:
    seen: list[tuple[int, int, list[float]]] = []

    @nrp.MapSpikeSink("spikes", nrp.brain.cells, nrp.spike_recorder)
    @nrp.Neuron2Robot()
    def f(t: float, spikes: Any) -> None:
        seen.append((loop.brain.now_ns, loop.world.now_ns, spikes.times[:, 1].tolist()))

    brain = MockBrain({"cells": 2})
    loop = loop_of(f, brain=brain)
    brain.fire([0, 1], [1.0, 20.0])
    loop.run_until(2 * PERIOD)
    assert seen == [(PERIOD, PERIOD, [1.0, 20.0]), (2 * PERIOD, 2 * PERIOD, [])]


@pytest.mark.parametrize("concurrent", [True, False])
def test_the_output_of_a_function_acts_from_the_next_step_on(concurrent: bool) -> None:
    @nrp.MapSpikeSource("x", nrp.brain.cells[0], nrp.fixed_frequency, delay=0.0)
    @nrp.Robot2Neuron()
    def f(t: float, x: Any) -> None:
        x.rate = 100.0

    brain = ListeningBrain()
    with loop_of(f, brain=brain, concurrent=concurrent) as loop:
        loop.run_until(3 * PERIOD)
    assert brain.arrivals_ms == [30.0, 40.0, 50.0, 60.0]


def test_a_message_from_a_function_reaches_all_functions_in_the_next_step() -> None:
    early: list[Any] = []
    late: list[Any] = []

    @nrp.MapRobotSubscriber("x", "/x")
    @nrp.Neuron2Robot()
    def before(t: float, x: Any) -> None:
        early.append((x.value and x.value.data, x.changed))

    @nrp.Neuron2Robot(nrp.Topic("/x", Float64))
    def sends(t: float) -> Float64:
        return Float64(round(t / 0.02))

    @nrp.MapRobotSubscriber("x", "/x")
    @nrp.Neuron2Robot()
    def after(t: float, x: Any) -> None:
        late.append((x.value and x.value.data, x.changed))

    loop_of(before, sends, after).run_until(3 * PERIOD)
    assert early == late == [(None, False), (1, True), (2, True)]


def test_each_message_calls_a_function_and_its_changes_add_up() -> None:
    seen: list[tuple[float, float]] = []

    @nrp.MapWeights("w", nrp.brain.projection("s"))
    @nrp.MapRobotSubscriber("x", nrp.Topic("/x", Float64))
    @nrp.Robot2Neuron(triggers=["x"], calls="each")
    def counts(t: float, w: Any, x: Any) -> None:
        w.values[x.value.data.is_integer() * 1] += 1.0
        seen.append((t, x.value.data))

    weights = []

    @nrp.MapWeights("w", nrp.brain.projection("s"))
    @nrp.Robot2Neuron()
    def reads(t: float, w: Any) -> None:
        weights.append(w.values.tolist())

    def sends(loop: ClosedLoop) -> None:
        for number in (loop.steps, loop.steps + 0.5, loop.steps + 1.0):
            world.put("/x", Float64(float(number)))

    index = np.arange(2, dtype=np.int32)
    synapses = Projection("s", "p", "p", "excitatory", index, index, np.zeros(2), np.ones(2), STDP)
    brain = MockBrain(Network({"p": Population("p", 2, "MockCell", {})}, (synapses,)))
    world = MockWorld({"/x": Float64})
    for functions in ((counts, reads), (reads, counts)):
        with ClosedLoop(brain, world, functions, period_ns=PERIOD) as loop:
            loop.hooks.before_functions.append(sends)
            loop.run_until(2 * PERIOD)
            assert loop.account.function_calls == {"counts": 6, "reads": 2}
            loop.reset()
    assert seen == 2 * [(0.02, 1), (0.02, 1.5), (0.02, 2), (0.04, 2), (0.04, 2.5), (0.04, 3)]
    assert weights == 2 * [[0.0, 0.0], [1.0, 2.0]], "changes act when all functions of the step have run"


def test_higher_priority_runs_first_and_equals_run_in_the_order_given() -> None:
    ran: list[str] = []

    def named(name: str, priority: int) -> nrp.TransferFunction:
        def f(t: float) -> None:
            ran.append(name)

        f.__name__ = name
        return nrp.Robot2Neuron(priority=priority)(f)

    functions = [named("a", 0), named("b", 5), named("c", 0), named("d", -1), named("e", 5)]
    loop = loop_of(*functions)
    loop.step()
    assert ran == ["b", "e", "a", "c", "d"]
    assert [function.name for function in loop.functions] == ran


def test_a_throttled_function_keeps_its_rate() -> None:
    ran: list[float] = []

    @nrp.Robot2Neuron(throttling_rate=30)
    def f(t: float) -> None:
        ran.append(t)

    loop_of(f).run_until(100 * PERIOD)
    assert len(ran) == 60
    assert ran[0] == 0.02


def test_variables_are_shared_within_a_loop_and_not_between_loops() -> None:
    @nrp.MapVariable("n", initial_value=0, scope=nrp.GLOBAL)
    @nrp.Robot2Neuron()
    def count(t: float, n: Any) -> None:
        n.value += 1

    @nrp.MapVariable("n", scope=nrp.GLOBAL)
    @nrp.Robot2Neuron()
    def also(t: float, n: Any) -> None:
        n.value += 10

    @nrp.MapVariable("n", initial_value=0, scope=nrp.GLOBAL)
    @nrp.Robot2Neuron()
    def elsewhere(t: float, n: Any) -> None: ...

    first, second = loop_of(count, also), loop_of(elsewhere)
    first.run_until(2 * PERIOD)
    second.step()
    assert count.n.value == 22
    assert elsewhere.n.value == 0


def test_a_function_belongs_to_one_loop_until_it_is_closed(golden: Golden) -> None:
    @nrp.Robot2Neuron()
    def f(t: float) -> None: ...

    with loop_of(f), golden.raises(LifecycleError):
        loop_of(f)
    loop_of(f).step()


def test_loops_in_threads_do_not_disturb_each_other() -> None:
    told: dict[int, list[float]] = {}

    def run(i: int) -> None:
        told[i] = []

        @nrp.Robot2Neuron()
        def f(t: float) -> None:
            told[i].append(t)

        with loop_of(f) as loop:
            loop.run_until((i + 1) * PERIOD)

    threads = [threading.Thread(target=run, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {i: len(times) for i, times in told.items()} == {0: 1, 1: 2, 2: 3, 3: 4}


# -- from outside


def test_a_message_published_by_a_thread_is_delivered_before_the_next_step() -> None:
    loop = loop_of()
    world = loop.world
    assert isinstance(world, MockWorld)
    thread = threading.Thread(target=loop.publish, args=("/in", Float64(3.0)))
    thread.start()
    thread.join()
    assert world.sent("/in") == []
    loop.hooks.before_step.append(lambda _: world.put("/out", Float64(len(world.sent("/in")))))
    loop.step()
    assert world.sent("/in") == [Float64(3.0)]
    assert world.sent("/out") == [Float64(1)]


def test_an_invalid_message_is_refused_when_it_is_published(golden: Golden) -> None:
    loop = loop_of()
    with golden.raises(TopicError, match="'/inn'.*'/in'"):
        loop.publish("/inn", Float64(1.0))
    with golden.raises(TopicError, match="std_msgs/msg/Float64"):
        loop.publish("/in", String("1.0"))
    loop.step()


def test_hooks_are_called_at_their_moments() -> None:
    moments: list[tuple[str, int]] = []

    def note(what: str) -> None:
        moments.append((what, loop.now_ns // PERIOD))

    @nrp.Robot2Neuron()
    def f(t: float) -> None:
        note("function")

    loop = loop_of(f)
    loop.hooks.before_step.append(lambda _: note("before_step"))
    loop.hooks.before_functions.append(lambda _: note("before_functions"))
    loop.hooks.after_step.append(lambda _: note("after_step"))
    loop.hooks.after_reset.append(lambda _: note("after_reset"))
    loop.step()
    loop.reset()
    assert moments == [
        ("before_step", 0), ("before_functions", 1), ("function", 1), ("after_step", 1), ("after_reset", 0)
    ]  # fmt: skip


def test_a_hook_can_end_the_run_and_it_can_go_on() -> None:
    loop = loop_of()
    loop.hooks.after_step.append(lambda loop: loop.stop() if loop.steps == 2 else None)
    loop.run_until(5 * PERIOD)
    assert (loop.steps, loop.now_ns) == (2, 2 * PERIOD)
    loop.run_until(5 * PERIOD)
    assert loop.steps == 5


def test_reset_returns_to_the_beginning() -> None:
    @nrp.MapSpikeSource("x", nrp.brain.cells[0], nrp.fixed_frequency, delay=0.0)
    @nrp.MapVariable("n", initial_value=0)
    @nrp.Robot2Neuron(throttling_rate=10)
    def f(t: float, x: Any, n: Any) -> None:
        n.value += 1
        x.rate = 100.0

    brain = ListeningBrain()
    loop = loop_of(f, brain=brain)
    loop.run_until(10 * PERIOD)
    first, brain.arrivals_ms = brain.arrivals_ms, []
    loop.publish("/in", Float64(1.0))
    loop.reset()
    assert (loop.now_ns, loop.steps, f.n.value, f.x.rate) == (0, 0, 0, 0.0)
    loop.run_until(10 * PERIOD)
    assert brain.arrivals_ms == first
    assert isinstance(loop.world, MockWorld)
    assert loop.world.sent("/in") == []


def test_a_new_seed_reaches_both_sides() -> None:
    loop = loop_of()
    loop.reset(seed=9)
    assert (loop.brain.seed, loop.world.seed) == (9, 9)


# -- what cannot be


def test_steps_that_do_not_divide_are_refused(golden: Golden) -> None:
    with golden.raises(TimestepError, match="20.*.3.*.1"):
        loop_of(brain=MockBrain({}, step_ns=3 * NS_PER_MS))


def test_a_time_between_steps_is_refused(golden: Golden) -> None:
    loop = loop_of()
    with golden.raises(TimestepError, match="0.03.*20"):
        loop.run_until(30 * NS_PER_MS)
    assert loop.now_ns == 0


def test_sides_at_different_times_are_refused(golden: Golden) -> None:
    brain = MockBrain({"cells": 1})
    brain.run_until(PERIOD)
    with golden.raises(LifecycleError, match="0.02"):
        loop_of(brain=brain)


def test_closing_the_loop_gives_everything_back_and_leaves_the_sides_open() -> None:
    @nrp.MapSpikeSource("x", nrp.brain.cells[0], nrp.poisson)
    @nrp.Robot2Neuron()
    def f(t: float, x: Any) -> None: ...

    loop = loop_of(f)
    loop.step()
    loop.close()
    assert not f.is_bound
    assert loop.brain.devices == ()
    loop.brain.run_until(2 * PERIOD)


def test_no_message_of_a_burst_is_lost_and_two_topics_come_in_the_order_of_their_times() -> None:
    """A queue of limited length would drop some; one queue for each topic would mix them up."""
    times: list[float] = []
    together: list[int] = []

    @nrp.MapRobotSubscriber("in_", nrp.Topic("/in", Float64))
    @nrp.MapRobotSubscriber("out", nrp.Topic("/out", Float64))
    @nrp.Robot2Neuron(triggers=["in_", "out"], calls="each")
    def called(t: float, in_: Any, out: Any) -> None:
        times.append(t)

    @nrp.MapRobotSubscriber("in_", nrp.Topic("/in", Float64))
    @nrp.Robot2Neuron()
    def sees(t: float, in_: Any) -> None:
        together.append(len(in_.messages))

    with loop_of(called, sees) as loop:
        world = cast("MockWorld", loop.world)

        def burst(loop: ClosedLoop) -> None:
            for number in range(3000):
                world.put("/in" if number % 2 else "/out", Float64(0.0), loop.now_ns + number * 1000)

        loop.hooks.before_step.append(burst)
        loop.run_until(2 * PERIOD)
    assert together == [1500, 1500]
    assert times == [(step * PERIOD + number * 1000) / 1e9 for step in range(2) for number in range(3000)]
