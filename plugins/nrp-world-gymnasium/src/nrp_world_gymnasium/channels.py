"""The values of spaces as messages: each number, array, image or text of a space has one topic."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from nrp_core.errors import CapabilityError, TopicError
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import (
    Float64,
    Float64MultiArray,
    Int32,
    MultiArrayDimension,
    MultiArrayLayout,
    String,
)

Path: TypeAlias = tuple[str | int, ...]
"""The keys and numbers that lead to a value within dictionaries and tuples."""
_ENCODINGS = {1: "mono8", 3: "rgb8", 4: "rgba8"}


@dataclass(frozen=True, slots=True)
class Channel:
    """How a value of a simple space becomes a message, and the reverse.

    Args:
        path: where it is in the whole value.
        type: the message class.
        encode: returns the message of a value.
        decode: returns the value of a message; raises a TopicError if it is not in the space.
        first: the value nearest to 0.
        limits: limits of a message that is one number.
    """

    path: Path
    type: type
    encode: Callable[[Any], Any]
    decode: Callable[[Any], Any]
    first: Any
    limits: tuple[float, float] | None = None


def channels_of(space: spaces.Space[Any], example: Any, path: Path = ()) -> Iterator[Channel]:
    """Return the channels of a space: one, or those of the spaces that it consists of.

    Args:
        space: the space.
        example: a value in it.
        path: where the space is in the whole space.

    Raises:
        CapabilityError: it has values that no message carries, such as graphs.
    """
    match space:
        case spaces.Dict() | spaces.Tuple():
            inner = space.items() if isinstance(space, spaces.Dict) else enumerate(space.spaces)
            for key, part in inner:
                yield from channels_of(part, example[key], (*path, key))
        case spaces.Discrete():
            yield _of_integer(space, path)
        case spaces.Box() if is_image(space.shape, space.dtype):
            yield Channel(path, Image, image_of, _not_an_action, None)
        case spaces.Box() if space.shape in ((), (1,)):
            yield _of_number(space, path)
        case spaces.Box() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield _of_array(space, path)
        case _ if isinstance(example, str):
            yield Channel(path, String, String, _not_an_action, None)
        case _:
            raise CapabilityError(
                f"no message carries the values of a {type(space).__name__} space ({space})"
            )


def value_at(value: Any, path: Path) -> Any:
    """Return the part of a value at a path."""
    for key in path:
        value = value[key]
    return value


def assembled(space: spaces.Space[Any], values: dict[Path, Any], path: Path = ()) -> Any:
    """Return the value of a space that consists of the values at these paths."""
    match space:
        case spaces.Dict():
            return {key: assembled(part, values, (*path, key)) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(assembled(part, values, (*path, i)) for i, part in enumerate(space.spaces))
    return values[path]


def is_image(shape: tuple[int, ...], dtype: Any) -> bool:
    """Return whether an array is an image: bytes of 1, 3 or 4 channels."""
    return dtype == np.uint8 and (len(shape) == 2 or (len(shape) == 3 and shape[2] in _ENCODINGS))


def image_of(pixels: npt.NDArray[np.uint8]) -> Image:
    """Return the message of an image, shape ``(height, width)`` or ``(height, width, channels)``."""
    height, width, *rest = pixels.shape
    channels = rest[0] if rest else 1
    data = np.array(pixels, order="C").reshape(height, width, channels)  # environments reuse their arrays
    return Image(height=height, width=width, encoding=_ENCODINGS[channels], step=width * channels, data=data)


def _of_integer(space: spaces.Discrete, path: Path) -> Channel:
    start, last = int(space.start), int(space.start + space.n - 1)
    first = space.dtype.type(min(max(0, start), last))
    kind = space.dtype.type
    return Channel(
        path, Int32, lambda value: Int32(int(value)), lambda message: kind(message.data), first, (start, last)
    )


def _of_number(space: spaces.Box, path: Path) -> Channel:
    def decode(message: Float64) -> Any:
        return np.full(space.shape, message.data, space.dtype)

    low, high = float(space.low.item()), float(space.high.item())
    return Channel(
        path,
        Float64,
        lambda value: Float64(float(np.asarray(value).item())),
        decode,
        np.clip(np.zeros(space.shape, space.dtype), space.low, space.high),
        (low, high),
    )


def _of_array(space: spaces.Box | spaces.MultiDiscrete | spaces.MultiBinary, path: Path) -> Channel:
    low, high = _bounds(space)
    layout = _layout(space.shape)

    def encode(value: Any) -> Float64MultiArray:
        return Float64MultiArray(layout, np.array(value, np.float64).ravel())

    def decode(message: Float64MultiArray) -> Any:
        given = np.asarray(message.data, np.float64)
        if given.size != low.size:
            raise TopicError(f"a value of this space has {low.size} numbers, not {given.size}")
        values = given.reshape(space.shape)
        for index in np.argwhere((values < low) | (values > high))[:1]:
            at = tuple(index.tolist())
            raise TopicError(
                f"number {list(at)} must be from {low[at]:g} to {high[at]:g}, not {values[at]:g}"
            )
        return values.astype(space.dtype)

    first = np.clip(np.zeros(space.shape), low, high).astype(space.dtype)
    return Channel(path, Float64MultiArray, encode, decode, first)


def _bounds(space: spaces.Space[Any]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    match space:
        case spaces.Box():
            return space.low.astype(np.float64), space.high.astype(np.float64)
        case spaces.MultiDiscrete():
            return space.start.astype(np.float64), (space.start + space.nvec - 1).astype(np.float64)
    return np.zeros(space.shape or ()), np.ones(space.shape or ())


def _layout(shape: tuple[int, ...]) -> MultiArrayLayout:
    if len(shape) < 2:
        return MultiArrayLayout()
    strides = np.cumprod((1, *reversed(shape)))[:0:-1].tolist()
    return MultiArrayLayout([MultiArrayDimension("", *each) for each in zip(shape, strides, strict=True)])


def _not_an_action(message: Any) -> Any:
    raise TopicError(f"a {type(message).__name__} is not accepted as an action")
