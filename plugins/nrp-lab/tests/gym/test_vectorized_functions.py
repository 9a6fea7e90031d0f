"""A vectorised function, called once for all copies, computes what it computes in each of them alone."""

import pickle
from contextlib import ExitStack
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_lab.side_by_side import SideBySide

import nrp_core.dsl as nrp
from nrp_core.brain import builder
from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.copies import gathered, rows_of
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import SimulationError
from nrp_core.experiment import Run, load_experiment
from nrp_core.messages.geometry_msgs import Twist, Vector3, WrenchStamped
from nrp_core.messages.std_msgs import Float64, Header

STEP_NS = 20 * NS_PER_MS
NUMBERS = st.floats(-1e6, 1e6)


def computed():
    """Return a function with each kind of parameter, made anew as by each copy."""

    @nrp.MapRobotSubscriber("x", nrp.Topic("/in", Float64), initial_value=Float64(0.5))
    @nrp.MapVariable("total", initial_value=0.0)
    @nrp.MapVariable("trace", initial_value=np.zeros(2))
    @nrp.MapSpikeSource("eyes", nrp.map_neurons(2, lambda i: nrp.brain.cells[i]), nrp.poisson)
    @nrp.MapSpikeSink("rate", nrp.brain.cells, nrp.population_rate)
    @nrp.MapRobotPublisher("also", nrp.Topic("/also", Float64))
    @nrp.MapCSVRecorder("rows", "rows.csv", ["t", "total"])
    @nrp.Neuron2Robot(nrp.Topic("/out", Twist), throttling_rate=30, vectorized=True)
    def compute(t, x, total, trace, eyes, rate, also, rows):
        total.value = 0.9 * total.value + np.sin(x.value.data) + rate.rate
        trace.value = np.stack([total.value, t], axis=1)
        eyes.rate = np.abs(trace.value) % 100.0
        also.send_message(Float64(np.where(x.changed, total.value, -1.0)))
        rows.record_entry(t, total.value)
        return Twist(Vector3(total.value, 1.0), Vector3(0.0, 0.0, eyes.rate[:, 1]))

    return compute


class Copy:
    """A loop between mocks, and what its functions publish."""

    def __init__(self, function, **options):
        self.brain = MockBrain({"cells": 2})
        self.world = MockWorld({"/in": Float64, "/out": Twist, "/also": Float64})
        self.loop = ClosedLoop(self.brain, self.world, [function], period_ns=STEP_NS, **options)
        self.published = []
        self.world.add_observer(
            lambda topic, one: self.published.append((topic, one.t_ns, repr(one.message)))
        )

    def give(self, number):
        if number is not None:
            self.loop.publish("/in", Float64(number))
            self.brain.fire([0], [(self.loop.now_ns + STEP_NS) / NS_PER_MS])

    def state(self):
        return self.published, pickle.dumps(self.loop.save())


@settings(deadline=None, max_examples=30)
@given(st.lists(st.lists(st.none() | NUMBERS, min_size=3, max_size=3), min_size=1, max_size=6), st.data())
def test_copies_compute_what_runs_alone_compute(inputs, data):
    copies, runs = [Copy(computed()) for _ in range(3)], [Copy(computed()) for _ in range(3)]
    with SideBySide() as together:
        for row in inputs:
            stepped = data.draw(st.lists(st.sampled_from(range(3)), min_size=1, unique=True))
            for number in stepped:
                copies[number].give(row[number])
                runs[number].give(row[number])
                runs[number].loop.step()
            assert together.step([copies[number].loop for number in stepped]) == {}
    assert [one.state() for one in copies] == [one.state() for one in runs]


def made_of(body, **options):
    @nrp.MapVariable("own", initial_value=0.0)
    @nrp.MapVariable("memory", initial_value=np.zeros(2))
    @nrp.MapVariable("word", initial_value="go")
    @nrp.Neuron2Robot(nrp.Topic("/also", Float64), vectorized=True, **options)
    def function(t, own, memory, word):
        return body(SimpleNamespace(t=t, own=own, memory=memory, word=word))

    return function


def stepped(body, **options):
    """Return the errors of three copies, whose variable is their number, and the messages of each."""
    with ExitStack() as opened:
        together = opened.enter_context(SideBySide())
        copies = [Copy(made_of(body, **options)) for _ in range(3)]
        for number, copy in enumerate(copies):
            copy.loop.functions[0].own.value = float(number)
        failed = together.step([copy.loop for copy in copies])
    return failed, [len(copy.published) for copy in copies]


def test_a_value_that_a_topic_cannot_carry_fails_its_copy_alone():
    failed, sent = stepped(lambda own: np.where(own.own.value == 1.0, np.nan, own.own.value))
    assert [*failed] == [1]
    assert sent == [1, 0, 1]


@pytest.mark.parametrize(
    "value",
    [
        lambda own: own.astype(int),
        lambda own: 3,
        lambda own: np.float64(0.5),
        lambda own: own > 1.0,
        lambda own: own.astype(np.float32) / 3,
        lambda own: own / 3,
    ],
)
def test_numbers_are_published_as_they_are_by_a_run_alone(value):
    def copy(number):
        made = Copy(made_of(lambda given: Float64(value(given.own.value))))
        made.loop.functions[0].own.value = float(number)
        return made

    copies, runs = [copy(number) for number in range(3)], [copy(number) for number in range(3)]
    with SideBySide() as together:
        assert together.step([one.loop for one in copies]) == {}
    for one in runs:
        one.loop.step()
    assert [one.published for one in copies] == [one.published for one in runs]
    assert all(len(one.published) == 1 for one in copies)


@pytest.mark.parametrize("vectorized", [False, True])
def test_each_copy_has_its_own_time_limit(vectorized):
    def function():
        @nrp.MapVariable("own", initial_value=0.0)
        @nrp.Neuron2Robot(vectorized=vectorized)
        def hang(t, own):
            while np.max(own.value) == 1.0:
                pass

        return hang

    copies = [Copy(function(), function_time_limit_s=limit_s) for limit_s in (60.0, 0.2, None)]
    for number, copy in enumerate(copies):
        copy.loop.functions[0].own.value = 2.0 if number == 2 else float(number)
    with SideBySide() as together:
        failed = together.step([copy.loop for copy in copies])
    assert [*failed] == [1]
    assert "0.2 s" in str(failed[1])


def waits(message):
    while message.data == 1.0:
        pass
    return message


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
@pytest.mark.parametrize(
    ("received", "sent"),
    [(nrp.PreprocessedTopic, nrp.Topic), (nrp.Topic, nrp.PreprocessedTopic)],
    ids=["received", "sent"],
)
def test_a_message_whose_conversion_never_ends_fails_as_it_does_alone(received, sent, on_error):
    def topic(kind, name):
        return kind(name, Float64, waits) if kind is nrp.PreprocessedTopic else kind(name, Float64)

    def make(number):
        @nrp.MapRobotSubscriber("x", topic(received, "/in"), initial_value=Float64(0.0))
        @nrp.Neuron2Robot(topic(sent, "/also"), vectorized=True)
        def passes_on(t, x):
            return Float64(x.value.data)

        copy = Copy(passes_on, on_error=on_error, function_time_limit_s=0.2)
        copy.give(float(number))
        return copy

    def seen(copy):
        return copy.published, list(map(str, copy.loop.failures)), copy.loop.account.function_calls

    copies, alone = [make(number) for number in range(3)], make(1)
    try:
        alone.loop.step()
        expected = {}
    except SimulationError as error:
        expected = {1: str(error)}
    with SideBySide() as together:
        failed = together.step([copy.loop for copy in copies])
        assert {number: str(error) for number, error in failed.items()} == expected
    assert seen(copies[1]) == seen(alone)
    assert len(alone.loop.failures) == 1
    assert "0.2 s" in str(alone.loop.failures[0])
    assert [len(copy.published) for copy in copies] == [2, 1, 2]


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        (lambda own: 1.0 / int(own.own.value[0]), "ZeroDivisionError"),
        (lambda own: own.memory.value.__iadd__(1.0), "ValueError"),  # would be lost
        (lambda own: setattr(own.own, "value", np.zeros(2)), "ValueError"),
        (lambda own: own.own.valeu, "AttributeError"),
        (lambda own: 1.0 if own.word.value == "go" else 2.0, "TypeError"),
        (lambda own: 1.0 if own.word.value else 2.0, "TypeError"),
    ],
)
def test_an_error_in_a_function_is_one_of_all_copies(body, kind):
    failed, sent = stepped(body)
    assert [kind in str(failed[number]) for number in range(3)] == [True] * 3
    assert sent == [0, 0, 0]


def test_a_function_that_one_copy_has_changed_is_called_for_that_copy():
    @nrp.Neuron2Robot(nrp.Topic("/also", Float64), vectorized=True)
    def function(t):
        return Float64(t * 0.0 - 7.0)

    copies = [*(Copy(made_of(lambda own: own.own.value + 1.0)) for _ in range(2)), Copy(function)]
    with SideBySide() as together:
        assert together.step([copy.loop for copy in copies]) == {}
    assert [copy.published[0][2] for copy in copies] == [repr(Float64(x)) for x in (1.0, 1.0, -7.0)]


@given(st.integers(1, 70), st.integers(1, 12), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_the_documented_product_has_the_same_bits_for_any_number_of_copies(n, n_inputs, n_outputs, seed):
    generator = np.random.default_rng(seed)
    x, weights = generator.normal(size=(n, n_inputs)), generator.normal(size=(n_outputs, n_inputs))
    together = (x[:, None, :] * weights).sum(-1)
    alone = [(row[None, None, :] * weights).sum(-1)[0] for row in x]
    assert np.array_equal(together, alone)


def test_none_in_all_copies_is_none_and_parts_of_messages_are_given_to_their_copies():
    assert gathered([None, None]) is None
    headers = gathered([Header(frame_id="one"), Header(frame_id="two")])
    stamped = rows_of(WrenchStamped(header=headers), 2)
    assert [each.header.frame_id for each in stamped] == ["one", "two"]


@pytest.mark.parametrize(
    "imported",
    [
        "import hbp_nrp_client.tf_framework as nrp",
        "import nrp_core.dsl as nrp",
        "from nrp_core import dsl as nrp",
    ],
)
def test_copies_with_other_parameters_and_other_files_of_equal_functions_are_called_apart(tmp_path, imported):
    text = """
from beside import scale
gain = scale * nrp.parameter("gain", 1.0)
@nrp.Neuron2Robot(nrp.Topic("/out", "std_msgs/Float64"), vectorized=True)
def out(t):
    return 0 * t + gain
"""
    (tmp_path / "brain.py").write_text(
        "import nrp_core.pynn as sim\nsim.setup(timestep=1.0)\nsim.Population(1, sim.IF_curr_exp())\n"
    )
    (tmp_path / "copied").mkdir()
    for folder, scale in ((tmp_path, 1), (tmp_path / "copied", 5)):
        (folder / "out.py").write_text(imported + text)
        (folder / "beside.py").write_text(f"scale = {scale}")
    (tmp_path / "more.py").write_text(imported + text.replace("1.0)", "3.0)"))
    (tmp_path / "gains.yaml").write_text(
        "name: gains\nduration: 1 s\nbrain: {backend: event, model: brain.py}\n"
        "world: {backend: mujoco, scene: empty}\ntopics: {/out: std_msgs/Float64}\n"
        "transfer_functions: [out.py]\n"
    )
    files = [f"transfer_functions=[{tmp_path / file}]" for file in ("more.py", "copied/out.py")]
    texts = "seed=1", "function_parameters.gain=2", *files
    with ExitStack() as opened:
        runs = [
            opened.enter_context(Run(load_experiment(str(tmp_path / "gains.yaml"), [setting])))
            for setting in texts
        ]
        heard = [run.world.subscribe("/out") for run in runs]
        assert opened.enter_context(SideBySide()).step([run.loop for run in runs]) == {}
        assert [topic.latest.message.data for topic in heard] == [1.0, 2.0, 3.0, 5.0]


def test_further_calls_are_not_made_after_one_that_fails_in_quarantine():
    def make():
        @nrp.MapRobotSubscriber("x", nrp.Topic("/in", Float64))
        @nrp.Neuron2Robot(nrp.Topic("/also", Float64), triggers=["x"], calls="each", vectorized=True)
        def negative_fails(t, x):
            if np.any(np.asarray(x.value.data) < 0):
                raise ValueError
            return Float64(x.value.data)

        copy = Copy(negative_fails, on_error="quarantine")
        for value in (-1.0, 2.0, 3.0):
            copy.loop.publish("/in", Float64(value))
        return copy

    alone, beside = make(), [make(), make()]
    alone.loop.step()
    with SideBySide() as together:
        assert together.step([copy.loop for copy in beside]) == {}
    for copy in beside:
        assert len(copy.loop.failures) == len(alone.loop.failures) == 1
        assert copy.published == alone.published
        assert copy.loop.account.function_calls == alone.loop.account.function_calls


def changing(name, change, *, vectorized, fails_at=None):
    """Return a function that changes weights at each message."""

    def function(t, w, x):
        if fails_at == "first":
            raise ValueError
        w.values = change(w.values)
        if np.all(np.asarray(x.value.data) == fails_at):
            raise ValueError

    function.__name__ = name
    made = nrp.Robot2Neuron(["x"], calls="each", vectorized=vectorized)(function)
    nrp.MapRobotSubscriber("x", nrp.Topic("/in", Float64))(made)
    return nrp.MapWeights("w", nrp.brain.projection("a -> b"))(made)


def learning(fails_at, *, vectorized, on_error):
    """Return a loop with three functions that change weights, of which the second one fails."""
    sim = builder()
    a, b = (sim.Population(2, sim.IF_curr_exp(), label=name) for name in "ab")
    synapse = sim.StaticSynapse(weight=0.5, delay=1.0)
    sim.Projection(a, b, sim.AllToAllConnector(), synapse, label="a -> b")
    more = np.nan if fails_at == "end" else 1.0
    functions = [
        changing("doubles", lambda values: 2.0 * values, vectorized=vectorized),
        changing("adds", lambda values: values + more, vectorized=vectorized, fails_at=fails_at),
        changing("triples", lambda values: 3.0 * values, vectorized=vectorized),
    ]
    brain, world = MockBrain(sim.network()), MockWorld({"/in": Float64})
    loop = ClosedLoop(brain, world, functions, period_ns=STEP_NS, on_error=on_error)
    for value in (1.0, 2.0):
        loop.publish("/in", Float64(value))
    return loop


def learnt(loop):
    active = [function.active for function in loop.functions]
    return loop.brain.read_weights("a -> b").tolist(), list(map(str, loop.failures)), active


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
@pytest.mark.parametrize("vectorized", [False, True])
@pytest.mark.parametrize("fails_at", ["first", 1.0, 2.0, "end"])
def test_weights_after_a_function_that_changes_them_has_failed_are_those_alone(
    fails_at, vectorized, on_error
):
    alone, *copies = [learning(fails_at, vectorized=vectorized, on_error=on_error) for _ in range(3)]
    expected = []
    try:
        alone.step()
    except SimulationError as error:
        expected = [str(error)]
    with SideBySide() as together:
        assert [*map(str, together.step(copies).values())] == 2 * expected
    assert [learnt(copy) for copy in copies] == 2 * [learnt(alone)]
    assert len(alone.failures) == 1


def test_an_engine_that_fails_at_the_end_of_a_step_ends_its_own_run_alone():
    def make():
        @nrp.Neuron2Robot(nrp.Topic("/also", Float64), vectorized=True)
        def tells_the_time(t):
            return Float64(t)

        return Copy(tells_the_time)

    copies = [make() for _ in range(3)]

    class Failing:
        def deliver(self):
            raise SimulationError("the weights do not change", t_ns=0)

    copies[1].loop.functions[0].deferring["weights"] = Failing()
    with SideBySide() as together:
        failed = together.step([copy.loop for copy in copies])
    assert [*failed] == [1]
    assert isinstance(failed[1], SimulationError)
    assert [copy.loop.is_stepping for copy in copies] == [False] * 3
