"""When topics with a rate are sampled: exactly, whatever the steps, and only if somebody listens."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import nrp_core.dsl as nrp
from nrp_core.cle import ClosedLoop
from nrp_core.dsl.testing import MockBrain

MS = 1_000_000
STEP = 2 * MS
cuts = st.lists(st.integers(0, 200), max_size=8).map(lambda steps: sorted(k * STEP for k in steps))
rates = st.floats(0.5, 600).map(lambda rate: round(rate, 3))
many = settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def due(rate_hz: float, until_ns: int) -> list[int]:
    """Return the first step at or after k / rate, for every k that is due until then."""
    times, k = [], 0
    while True:
        exact = Fraction(k) / Fraction(repr(rate_hz)) * 10**9
        on_grid = -(-exact // STEP) * STEP
        if on_grid > until_ns:
            return times
        times.append(int(on_grid))
        k += 1


def stamps(subscription: Any) -> list[int]:
    return [sample.t_ns for sample in subscription.messages]


def test_a_camera_of_30_hz_on_steps_of_2_ms_is_sampled_at_the_first_step_at_or_after_k_thirtieths(
    room: Any,
) -> None:
    images = room.subscribe("/husky/camera", depth=100)
    room.run_until(1000 * MS)
    assert stamps(images)[:5] == [0, 34 * MS, 68 * MS, 100 * MS, 134 * MS]
    assert stamps(images) == due(30.0, 1000 * MS)
    assert len(images.messages) == 31
    assert all(image.message.header.stamp.to_ns() == image.t_ns for image in images.messages)
    assert [int(image.message.data[0, 0, 0]) for image in images.messages][:3] == [0, 17, 34]


@many
@given(rate_hz=rates)
def test_every_rate_is_kept_exactly_as_far_as_the_steps_allow(open_world: Any, rate_hz: float) -> None:
    world = open_world(rate_hz=rate_hz)
    images = world.subscribe("/husky/camera", depth=1000)
    world.run_until(400 * MS)
    expected = due(rate_hz, 400 * MS)
    assert stamps(images) == list(dict.fromkeys(expected))


@many
@given(rate_hz=rates, cuts=cuts)
def test_splitting_a_run_does_not_change_samples(open_world: Any, rate_hz: float, cuts: list[int]) -> None:
    whole, parts = open_world(rate_hz=rate_hz), open_world(rate_hz=rate_hz)
    topics = ("/husky/camera", "/husky/odom")
    together = [whole.subscribe(topic, depth=1000) for topic in topics]
    apart = [parts.subscribe(topic, depth=1000) for topic in topics]
    whole.run_until(400 * MS)
    for t_ns in [*cuts, 400 * MS]:
        parts.run_until(t_ns)
    assert list(map(stamps, together)) == list(map(stamps, apart))
    assert whole.engine.steps == parts.engine.steps == 200


def test_nothing_is_sampled_before_the_first_step(room: Any) -> None:
    images = room.subscribe("/husky/camera")
    assert images.latest is None
    room.run_until(STEP)
    assert images.latest.t_ns == 0


def test_a_late_subscriber_gets_the_next_sample(room: Any) -> None:
    room.run_until(50 * MS)
    images = room.subscribe("/husky/camera", depth=10)
    room.run_until(66 * MS)
    assert images.latest is None
    room.run_until(100 * MS)
    assert stamps(images) == [68 * MS, 100 * MS]


def test_a_camera_without_readers_is_never_rendered(room: Any) -> None:
    room.subscribe("/husky/odom")
    room.run_until(1000 * MS)
    assert room.engine.renders == 0


def test_a_camera_whose_only_reader_is_in_quarantine_is_not_rendered(room: Any) -> None:
    @nrp.MapRobotSubscriber("camera", nrp.Topic("/husky/camera"))
    @nrp.Robot2Neuron()
    def look(t: float, camera: Any) -> None:
        assert t < 0.1

    loop = ClosedLoop(MockBrain({}), room, [look], period_ns=20 * MS, on_error="quarantine")
    loop.run_until(1000 * MS)
    assert [failure.function for failure in loop.failures] == ["look"]
    assert room.engine.renders == 4  # at 0, 34, 68 and 100 ms
    loop.reset()
    loop.run_until(80 * MS)
    assert room.engine.renders == 4 + 3


def test_two_readers_share_one_image(room: Any) -> None:
    first, second = (room.subscribe("/husky/camera") for _ in range(2))
    room.run_until(20 * MS)
    assert room.engine.renders == 1
    assert first.latest.message is second.latest.message


def test_an_ended_subscription_costs_nothing_and_ends_once(room: Any) -> None:
    first, second = (room.subscribe("/husky/camera") for _ in range(2))
    room.unsubscribe(first)
    room.unsubscribe(first)
    room.run_until(20 * MS)
    assert (room.engine.renders, first.latest, second.latest.t_ns) == (1, None, 0)
    room.unsubscribe(second)
    room.run_until(1000 * MS)
    assert room.engine.renders == 1
    assert room.subscribed == frozenset()


def test_an_image_is_a_read_only_ros_image(room: Any) -> None:
    images = room.subscribe("/husky/camera")
    room.run_until(40 * MS)
    image = images.latest.message
    assert (image.height, image.width, image.encoding, image.step) == (3, 4, "rgb8", 12)
    assert image.header.frame_id == "husky/base_link/camera_optical_frame"
    with pytest.raises(ValueError, match="read-only"):
        image.data[0] = 0


def test_odometry_and_wheel_speeds_come_at_the_rate_of_their_drive(room: Any) -> None:
    odometry = room.subscribe("/husky/odom", depth=100)
    room.run_until(100 * MS)
    assert [b - a for a, b in pairwise(stamps(odometry))] == [10 * MS] * 10
