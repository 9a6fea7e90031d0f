"""The quick encoders give the bytes that the library gives."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from nrp_core.messages import nrp_msgs
from nrp_core.messages.base import Time
from nrp_core.messages.cdr import Codec
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.geometry_msgs import Pose as PoseMessage
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Bool, ColorRGBA, Float64, Header, Int32
from nrp_core.recording.images import as_it_was, pixels_of
from nrp_core.recording.writing import encoding
from nrp_core.scene.rigid import ModelMotion, Pose

CODEC = Codec()
ROS = get_typestore(Stores.ROS2_JAZZY)

times_ns = st.integers(0, 2**31 * 10**9 - 1)
names = st.text(min_size=0, max_size=12)
numbers = st.floats(allow_nan=False, width=64)


def joined(parts: encoding.Parts) -> bytes:
    return b"".join(parts)


def decoded(parts: encoding.Parts, kind: type) -> Any:
    return CODEC.decode(joined(parts), CODEC.name(kind))


@given(times_ns, names, st.lists(st.tuples(st.integers(0, 2**32 - 1), numbers), min_size=1, max_size=20))
def test_spikes(now_ns: int, population: str, spikes: list[tuple[int, float]]) -> None:
    ids, times_ms = np.array([i for i, _ in spikes]), np.array([t for _, t in spikes])
    message = nrp_msgs.Spikes(Header(Time.from_ns(now_ns)), population, ids.astype(np.uint32), times_ms)
    encoded = encoding.SpikesEncoder(population)(now_ns, ids, times_ms)
    assert joined(encoded) == bytes(CODEC.encode(message))


@given(st.lists(names, max_size=4), st.data())
def test_model_states(models: list[str], data: st.DataObject) -> None:
    triple = st.tuples(numbers, numbers, numbers)
    motions = [
        ModelMotion(Pose(data.draw(triple), (0.0, 0.0, 0.6, 0.8)), data.draw(triple), data.draw(triple))
        for _ in models
    ]
    states = decoded(encoding.ModelStatesEncoder(models)(motions), ModelStates)
    assert states.name == models
    assert joined(encoding.ModelStatesEncoder(models)(motions)) == bytes(CODEC.encode(states))
    for motion, pose, twist in zip(motions, states.pose, states.twist, strict=True):
        assert (pose.position.x, pose.position.y, pose.position.z) == motion.pose.position
        assert (twist.angular.x, twist.angular.y, twist.angular.z) == motion.angular


@given(times_ns, names, st.integers(0, 5), st.integers(0, 5), st.sampled_from(["rgb8", "mono8", "8UC1"]))
def test_images(now_ns: int, frame: str, height: int, width: int, kind: str) -> None:
    pixels = np.arange(height * width * 3, dtype=np.uint8).reshape(height, width, 3)
    image = Image(Header(Time.from_ns(now_ns), frame), height, width, kind, 0, 3 * width, pixels)
    assert joined(encoding.image(image)) == bytes(CODEC.encode(image))


def test_depths_are_kept_bit_for_bit_and_come_back_as_they_were() -> None:
    depths = np.array([[0.5, np.inf, 3.25], [1e-3, 2.0, np.nan]], np.float32)
    image = Image(Header(), 2, 3, "32FC1", 0, 12, depths)  # type: ignore[arg-type]
    assert joined(encoding.image(image)) == bytes(CODEC.encode(image))
    again = as_it_was(decoded(encoding.image(image), Image))
    np.testing.assert_array_equal(again.data, depths)
    greys = pixels_of(again)
    assert greys.shape == (2, 3, 3)
    assert greys[0, 0, 0] > greys[1, 1, 0] > greys[0, 2, 0]


@given(times_ns, st.integers(0, 2**62), st.binary(max_size=40))
def test_snapshots(now_ns: int, step: int, data: bytes) -> None:
    message = nrp_msgs.Snapshot(Header(Time.from_ns(now_ns)), step, np.frombuffer(data, np.uint8))
    assert joined(encoding.snapshot(now_ns, step, data)) == bytes(CODEC.encode(message))


@given(times_ns, st.integers(0, 2**62))
def test_hashes_of_steps(now_ns: int, step: int) -> None:
    hashes, chain = [f"{i:016x}" for i in range(4)], f"{step:032x}"
    message = nrp_msgs.StepHash(Header(Time.from_ns(now_ns)), step, *hashes, chain)
    assert joined(encoding.step_hash(now_ns, step, hashes, chain)) == bytes(CODEC.encode(message))


@pytest.mark.parametrize(
    "message",
    [
        Twist(Vector3(1.5, -2.0, 1e300), Vector3(0, 1, 2)), ColorRGBA(0.25, 0.5, 0.75, 1.0), Bool(True),
        Int32(-7), Float64(0.1), PoseMessage(), Time(3, 4),
    ],
    ids=lambda message: type(message).__name__,
)  # fmt: skip
def test_messages_of_numbers_alone(message: Any) -> None:
    name = CODEC.name(type(message))
    assert bytes(CODEC.encode(message)) == bytes(ROS.serialize_cdr(message, name))
    assert CODEC.decode(CODEC.encode(message), name) == message
