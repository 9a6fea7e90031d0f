from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import ClassVar

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import TopicError
from nrp_core.messages.base import resolve_name
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.world.topics import (
    Direction,
    Publication,
    Stamped,
    Subscription,
    TopicInfo,
    check_message,
)

COMMAND = TopicInfo("/husky/cmd_vel", Twist, Direction.IN)
NUMBER = TopicInfo("/number", Float64, Direction.BOTH)


@pytest.mark.parametrize(
    ("name", "namespace", "absolute"),
    [
        ("camera", "husky", "/husky/camera"),
        ("front/camera", "husky", "/husky/front/camera"),
        ("/camera", "husky", "/camera"),
        ("~/camera", "husky", "/husky/camera"),
        ("camera", "", "/camera"),
        ("camera/", "/husky/", "/husky/camera"),
    ],
)
def test_a_relative_name_lies_below_the_namespace_and_an_absolute_one_stays(
    name: str, namespace: str, absolute: str
) -> None:
    assert resolve_name(name, namespace) == absolute


@given(st.lists(st.one_of(st.integers(0, 40).map(float), st.sampled_from(["take", "some", "save"]))))
def test_each_message_is_taken_once_in_order(acts: list[float | str]) -> None:
    subscription, sent, taken = Subscription(NUMBER, None), [], []
    for act in acts:
        if act == "save":
            saved, subscription = subscription.save(), Subscription(NUMBER, None)
            subscription.restore(*saved)
        elif isinstance(act, str):
            taken += subscription.take(None if act == "take" else 2)
        else:
            sent.append(Stamped(len(sent), Float64(act)))
            subscription.push(sent[-1])
        assert subscription.latest is (sent[-1] if sent else None)
        assert [*taken, *subscription.messages] == sent
        assert subscription.has_news == (len(taken) < len(sent))


def test_messages_that_are_not_taken_are_dropped_later_and_counted() -> None:
    subscription = Subscription(NUMBER, None)
    subscription.keep_ns = 10
    for t_ns in range(100):
        subscription.push(Stamped(t_ns, Float64(t_ns)))
    assert (len(subscription.messages), subscription.dropped) == (100, 0)  # a step brings any number
    subscription.drop_old(99)
    assert ([one.t_ns for one in subscription.take()], subscription.dropped) == (list(range(89, 100)), 0)
    subscription.push(Stamped(100, Float64(100)))
    subscription.drop_old(200)
    assert subscription.latest == Stamped(100, Float64(100)), "the last message stays"


def test_a_subscription_is_empty_before_the_first_message() -> None:
    subscription = Subscription(NUMBER)
    assert subscription.latest is None
    assert subscription.since(-1) == []


@given(st.integers(1, 5), st.lists(st.integers(0, 100), unique=True).map(sorted), st.integers(-1, 100))
def test_a_subscription_keeps_the_last_messages_and_reading_changes_nothing(
    depth: int, times: list[int], since: int
) -> None:
    subscription = Subscription(NUMBER, depth)
    for t_ns in times:
        subscription.push(Stamped(t_ns, Float64(t_ns)))
    kept = times[-depth:]
    for _ in range(2):
        assert [s.t_ns for s in subscription.messages] == kept
        assert [s.t_ns for s in subscription.since(since)] == [t for t in kept if t > since]
        assert (subscription.latest.t_ns if subscription.latest else None) == (kept[-1] if kept else None)
    subscription.clear()
    assert subscription.latest is None


def test_a_topic_without_a_rate_gives_the_value_now() -> None:
    now = [Stamped(5, Float64(1))]
    subscription = Subscription(NUMBER, current=lambda: now[0])
    assert subscription.latest == Stamped(5, Float64(1))
    assert subscription.since(4) == [Stamped(5, Float64(1))]
    assert subscription.since(5) == []
    now[0] = Stamped(6, Float64(2))
    assert subscription.latest == Stamped(6, Float64(2))


def test_a_publication_delivers_what_fits_and_nothing_else(golden: Golden) -> None:
    delivered: list[object] = []

    class OneTopic:
        def deliver(self, name: str, message: object, *, is_own: bool = False) -> None:
            delivered.append((name, message))

        def deliver_numbers(self, name: str, numbers: Sequence[float]) -> bool:
            return False

    publication = Publication(COMMAND, "/husky/velocity", OneTopic())
    publication.publish(Twist())
    publication.publish_numbers([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    with golden.raises(TopicError, match=r"/husky/cmd_vel.*geometry_msgs/msg/Twist.*\(0\.5\)"):
        publication.publish(0.5)
    with golden.raises(TopicError, match=r"/husky/cmd_vel.*geometry_msgs/msg/Twist, linear\.x"):
        publication.publish(Twist(Vector3(nan)))
    assert delivered == [
        ("/husky/velocity", Twist()),
        ("/husky/velocity", Twist(Vector3(1.0, 2.0, 3.0), Vector3(4.0, 5.0, 6.0))),
    ]


def test_a_class_of_the_same_ros_name_is_the_same_type() -> None:
    @dataclass
    class TheirVector3:
        __msgtype__: ClassVar[str] = "geometry_msgs/msg/Vector3"
        x: float = 0.0

    check_message(TopicInfo("/v", Vector3, Direction.IN), TheirVector3())


def test_a_message_of_another_type_is_named(golden: Golden) -> None:
    with golden.raises(TopicError):
        check_message(COMMAND, Vector3())
