"""Functions are connected all or none, and topics between them come into being."""

from __future__ import annotations

from typing import Any

import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.cle.wiring import Wiring
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import TopicError, TransferFunctionError
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.std_msgs import Float64, String


def reads(topic: nrp.Topic | str, name: str = "reads") -> nrp.TransferFunction:
    def f(t: float, x: Any) -> None: ...

    f.__name__ = name
    return nrp.MapRobotSubscriber("x", topic)(nrp.Robot2Neuron()(f))


def publishes(topic: nrp.Topic | str, name: str = "publishes") -> nrp.TransferFunction:
    def f(t: float) -> None: ...

    f.__name__ = name
    return nrp.Neuron2Robot(topic)(f)


def connect(functions: list[nrp.TransferFunction], brain: MockBrain, world: MockWorld) -> None:
    Wiring(brain, world).change(functions)


def sides() -> tuple[MockBrain, MockWorld]:
    return MockBrain({"cells": 2}), MockWorld({"/husky/cmd_vel": Twist})


def test_a_topic_that_one_function_publishes_and_one_reads_is_declared() -> None:
    brain, world = sides()
    connect([reads("/speed"), publishes(nrp.Topic("/speed", Float64))], brain, world)
    assert world.topics["/speed"].type is Float64


def test_a_topic_that_is_only_read_is_misspelt(golden: Golden) -> None:
    with golden.raises(TopicError, match="'/husky/cmd_vell'.*'/husky/cmd_vel'"):
        connect([reads(nrp.Topic("/husky/cmd_vell", Twist))], *sides())


def test_a_topic_that_is_only_published_is_misspelt(golden: Golden) -> None:
    with golden.raises(TopicError, match="'publishes'.*'/husky/cmd_vell'"):
        connect([publishes(nrp.Topic("/husky/cmd_vell", Twist))], *sides())


def test_a_topic_that_was_declared_to_the_world_needs_no_reader() -> None:
    brain, world = sides()
    world.declare("/debug", Float64)
    connect([publishes("/debug")], brain, world)
    assert world.topics["/debug"].type is Float64


def test_functions_that_disagree_on_a_type_are_refused(golden: Golden) -> None:
    with golden.raises(TopicError, match="'/x'"):
        connect([publishes(nrp.Topic("/x", Float64)), reads(nrp.Topic("/x", String))], *sides())


def test_two_functions_of_one_name_are_refused_with_both_places() -> None:
    first, second = reads("/husky/cmd_vel", "same"), publishes("/husky/cmd_vel", "same")
    with pytest.raises(TransferFunctionError) as caught:
        connect([first, second], *sides())
    assert str(caught.value).startswith(f"{second.place}: the transfer function 'same' already exists")
    assert str(first.place) in caught.value.message


def test_when_one_cannot_be_bound_none_stays_bound() -> None:
    @nrp.MapSpikeSource("x", nrp.brain.cells, nrp.poisson)
    @nrp.Robot2Neuron()
    def good(t: float, x: Any) -> None: ...

    brain, world = sides()
    with pytest.raises(TopicError):
        connect([good, reads("/nothing")], brain, world)
    assert not good.is_bound
    assert brain.devices == ()
