"""The latency of every path from a sensor to an actuator is read off the mappings."""

from __future__ import annotations

from typing import Any

from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.cle import ClosedLoop, LoopPath
from nrp_core.cle.latency import paths
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.messages.std_msgs import Float64

PERIOD = 20 * NS_PER_MS


def function(
    name: str,
    *,
    reads: tuple[str, ...] = (),
    writes: tuple[str, ...] = (),
    drives: bool = False,
    listens: bool = False,
) -> nrp.TransferFunction:
    """A function with these connections, whose body hands on what it reads."""
    mappings: list[Any] = [
        nrp.MapRobotSubscriber(f"r{i}", nrp.Topic(t, Float64)) for i, t in enumerate(reads)
    ]
    mappings += [nrp.MapRobotPublisher(f"w{i}", nrp.Topic(t, Float64)) for i, t in enumerate(writes)]
    mappings += [nrp.MapSpikeSource("source", nrp.brain.cells, nrp.dc_source)] if drives else []
    mappings += [nrp.MapSpikeSink("sink", nrp.brain.cells, nrp.population_rate)] if listens else []
    names = ", ".join(["t", *(mapping.parameter for mapping in mappings)])
    namespace: dict[str, Any] = {}
    body = "".join(f"    w{i}.send_message(r0.value)\n" for i in range(len(writes)) if reads)
    exec(f"def {name}({names}):\n    if not {bool(reads)} or r0.value is None: return\n{body}", namespace)
    made: nrp.TransferFunction = nrp.Robot2Neuron()(namespace[name])
    for mapping in mappings:
        mapping(made)
    return made


def test_through_the_brain_it_takes_two_steps(golden: Golden) -> None:
    see = function("see", reads=("/camera",), drives=True)
    drive = function("drive", listens=True, writes=("/cmd",))
    expected = LoopPath("/camera", "/cmd", 2, ("see", "brain", "drive"))
    assert paths([see, drive]) == paths([drive, see]) == [expected]
    golden(str(expected))


def test_past_the_brain_it_takes_one_step_and_the_shortest_path_counts() -> None:
    both = function("both", reads=("/camera",), drives=True, listens=True, writes=("/cmd",))
    assert paths([both]) == [LoopPath("/camera", "/cmd", 1, ("both",))]


def test_a_message_to_another_function_takes_a_step_in_any_order() -> None:
    first = function("first", reads=("/camera",), writes=("/between",))
    second = function("second", reads=("/between",), writes=("/cmd",))
    assert [path.steps for path in paths([first, second])] == [2]
    assert [path.steps for path in paths([second, first])] == [2]


def test_unconnected_topics_have_no_path() -> None:
    see = function("see", reads=("/camera",), drives=True)
    drive = function("drive", reads=("/laser",), writes=("/cmd",))
    assert [(path.sensor, path.actuator) for path in paths([see, drive])] == [("/laser", "/cmd")]


def test_the_computed_latency_is_the_measured_one() -> None:
    """A number goes from the sensor through two functions, in either order, to the actuator."""
    for reverse in (False, True):
        functions = [
            function("first", reads=("/camera",), writes=("/between",)),
            function("second", reads=("/between",), writes=("/cmd",)),
        ]
        functions = functions[::-1] if reverse else functions
        world = MockWorld({"/camera": Float64, "/cmd": Float64})
        with ClosedLoop(MockBrain({"cells": 1}), world, functions, period_ns=PERIOD) as loop:

            def sense(loop: ClosedLoop, world: MockWorld = world) -> None:
                if loop.steps == 1:
                    world.put("/camera", Float64(1.0))

            loop.hooks.before_functions.append(sense)
            while not world.sent("/cmd"):
                loop.step()
            acts_in_step = loop.steps + 1
            (path,) = loop.latency()
            assert path.steps == acts_in_step - 1
