from dataclasses import dataclass, field, fields, is_dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core import messages
from nrp_core.errors import TopicError
from nrp_core.messages.base import message, type_name, type_of
from nrp_core.messages.cdr import Codec
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.nrp_msgs import Spikes
from nrp_core.messages.sensor_msgs import Image, JointState
from nrp_core.messages.std_msgs import Float64, Header, Int32, String

MODULES = [import_module(f"{messages.__name__}.{module.name}") for module in iter_modules(messages.__path__)]
CLASSES = sorted({
    value for module in MODULES for value in vars(module).values()
    if isinstance(value, type) and hasattr(value, "__msgtype__") and value.__module__ == module.__name__
}, key=type_name)  # fmt: skip

SCALARS: dict[str, st.SearchStrategy[Any]] = {
    "bool": st.booleans(),
    "string": st.text(st.characters(exclude_categories=["Cs"]), max_size=8),
    "float32": st.floats(width=32, allow_nan=False),
    "float64": st.floats(allow_nan=False),
}
for bits in (8, 16, 32, 64):
    SCALARS[f"int{bits}"] = st.integers(-(1 << bits - 1), (1 << bits - 1) - 1)
    SCALARS[f"uint{bits}"] = st.integers(0, (1 << bits) - 1)


def instances(codec: Codec, name: str) -> st.SearchStrategy[Any]:
    """Return messages of a type with any values that its ROS definition allows."""
    cls = type_of(name)
    assert cls is not None
    lines = codec.definition(codec.name(cls)).split("=" * 80)[0].splitlines()
    pairs = [line.split() for line in lines if "=" not in line and line.strip()]
    return st.builds(cls, **{field_name: values(codec, kind) for kind, field_name in pairs})


def values(codec: Codec, kind: str) -> st.SearchStrategy[Any]:
    base, bracket, length = kind.rstrip("]").partition("[")
    item = SCALARS[base] if base in SCALARS else st.deferred(lambda: instances(codec, base))
    if not bracket:
        return item
    size = {"min_size": int(length), "max_size": int(length)} if length else {"max_size": 4}
    lists = st.lists(item, **size)
    is_numeric = base in SCALARS and base != "string"
    return (
        lists.map(lambda items: np.array(items, "bool" if base == "bool" else base)) if is_numeric else lists
    )


def same(a: Any, b: Any) -> bool:
    if is_dataclass(a):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return np.array_equal(np.asarray(a), np.asarray(b))


CODEC = Codec()
TOLD = Codec({CODEC.name(cls): CODEC.definition(type_name(cls)) for cls in CLASSES})


@pytest.mark.one_of(8)
@pytest.mark.parametrize("cls", CLASSES, ids=type_name)
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_every_message_comes_back_as_it_was_sent(cls: type, data: st.DataObject) -> None:
    sent = data.draw(instances(CODEC, type_name(cls)))
    encoded = CODEC.encode(sent)
    assert same(CODEC.decode(encoded, type_name(cls)), sent)
    assert same(TOLD.decode(encoded, type_name(cls)), sent)


def test_the_hashes_are_those_of_ros_2() -> None:
    codec = Codec()
    codec.name(String)
    assert codec.hash("std_msgs/msg/String") == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )
    assert codec.hash("geometry_msgs/msg/Twist") == (
        "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
    )


def test_the_names_are_those_of_ros_2_and_of_all_message_classes_that_can_be_encoded() -> None:
    @message("test_msgs/msg/Impossible")
    @dataclass
    class Impossible:
        value: complex = 0j

    names = Codec().names()
    assert {"std_msgs/msg/String", "tf2_msgs/msg/TFMessage", type_name(Spikes), type_name(Odometry)} <= {
        *names
    }
    assert type_name(Impossible) not in names


def test_spikes_are_defined_as_two_flat_arrays() -> None:
    codec = Codec()
    lines = codec.definition(codec.name(Spikes)).splitlines()[:4]
    assert lines == ["std_msgs/Header header", "string population", "uint32[] ids", "float64[] times_ms"]


def test_integers_are_taken_for_floats() -> None:
    codec = Codec()
    back = codec.decode(codec.encode(Twist(Vector3(1, 0, 0))), "geometry_msgs/msg/Twist")
    assert back == Twist(Vector3(1.0))


@pytest.mark.parametrize("given_as", [[1.0, 2.0], (1, 2), np.array([1, 2]), np.array([1.0, 9.0, 2.0])[::2]])
def test_arrays_are_taken_from_any_sequence(given_as: Any) -> None:
    codec = Codec()
    back = codec.decode(codec.encode(JointState(position=given_as)), "sensor_msgs/msg/JointState")
    assert back.position.tolist() == [1.0, 2.0]


def test_images_are_flattened_row_by_row() -> None:
    codec = Codec()
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    for data in (pixels, pixels.tobytes(), memoryview(pixels.tobytes())):
        back = codec.decode(codec.encode(Image(Header(), 2, 4, "rgb8", 0, 12, data)), "sensor_msgs/msg/Image")
        assert back.data.tolist() == list(range(24))


@dataclass
class Whisker:
    """A user's own message, which names no package."""

    angles: npt.NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    touched: bool = False
    names: tuple[str, ...] = ()
    where: Vector3 = field(default_factory=Vector3)


def test_a_class_of_the_users_own_needs_no_definition() -> None:
    codec = Codec()
    sent = Whisker(np.array([0.5, 1.5], np.float32), True, ("left", "right"), Vector3(1.0))
    back = codec.decode(codec.encode(sent), codec.name(Whisker))
    assert codec.name(Whisker) == "nrp_msgs/msg/Whisker"
    assert (back.angles.tolist(), back.touched, back.names) == ([0.5, 1.5], True, ["left", "right"])
    assert back.where == Vector3(1.0)


@dataclass
class Unspeakable:
    table: dict[str, int] = field(default_factory=dict)


def test_a_field_that_no_message_can_hold_is_named(golden: Golden) -> None:
    with golden.raises(TopicError, match=r"dict\[str, int\]"):
        Codec().encode(Unspeakable())


def test_a_class_that_takes_a_ros_name_but_not_its_fields_is_refused(golden: Golden) -> None:
    @dataclass
    class Wrong:
        wrong: float = 0.0

    Wrong.__msgtype__ = "geometry_msgs/msg/Accel"  # type: ignore[attr-defined]
    with golden.raises(TopicError, match=r"\['wrong'\].*\['linear', 'angular'\]"):
        Codec().encode(Wrong())


@pytest.mark.parametrize(
    "wrong",
    [Int32(1 << 40), String(data=5), Float64("fast"), Odometry(header=None), JointState(position="abc")],  # type: ignore[arg-type]
)
def test_a_value_that_does_not_fit_is_an_error_that_names_the_type(wrong: Any) -> None:
    with pytest.raises(TopicError, match=type_name(type(wrong))):
        Codec().encode(wrong)


@settings(deadline=None)
@given(st.binary(max_size=40))
def test_bytes_that_are_not_a_message_are_an_error_not_a_crash(data: bytes) -> None:
    codec = Codec()
    codec.name(Spikes)
    try:
        codec.decode(data, "nrp_msgs/msg/Spikes")
    except TopicError:
        return
    assert codec.decode(data, "nrp_msgs/msg/Spikes").population is not None


def test_a_foreign_definition_of_a_known_type_is_read_by_its_own_fields() -> None:
    codec = Codec({"std_msgs/msg/Float64": "float64 data\nfloat64 sigma\n"})
    back = codec.decode(b"\x00\x01\x00\x00" + np.array([1.0, 2.0]).tobytes(), "std_msgs/msg/Float64")
    assert (back.data, back.sigma) == (1.0, 2.0)
    assert message("x/msg/Y") is not None
