"""The messages of a recording as a page holds them: packed, and thinned until they fit."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from nrp_cockpit.streaming.packing import packed_parts
from nrp_cockpit.streaming.recorded import LATEST
from nrp_cockpit.streaming.stored import Stored, StoredMessages
from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import ExperimentError
from nrp_core.messages.base import type_name
from nrp_core.messages.cdr import Codec
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.recording import RecordedTopic, Role, values_of
from nrp_core.recording.images import compress, compressible

MOST_UNPACKED_BYTES = 300_000_000
"""The maximum size of all messages in a browser."""
_RAREST_HZ = 1.0
"""A topic that would be thinned to fewer messages is left out."""
_IMAGE, _FILE, _JPEG = type_name(Image), type_name(CompressedImage), "jpeg"
_WEBP_LOSSLESS = 101  # the quality above 100, in OpenCV


@dataclass(frozen=True, eq=False)
class Track:
    """The messages of one topic.

    Args:
        topic: the topic.
        times_ns: their times, ascending.
        messages: their bytes.
        every: the number of recorded messages of which one is kept.
        jpegs: the number of images with small losses.
    """

    topic: RecordedTopic
    times_ns: list[int]
    messages: list[bytes] = field(repr=False)
    every: int = 1
    jpegs: int = 0

    @cached_property
    def packed(self) -> bytes:
        """All messages in one piece, compressed by gzip."""
        packer = zlib.compressobj(wbits=31)
        parts = packed_parts(self.times_ns, self.messages)
        return b"".join(map(packer.compress, parts)) + packer.flush()

    @cached_property
    def size(self) -> int:
        """Size of the messages, bytes."""
        return sum(map(len, self.messages))

    @property
    def shown(self) -> str:
        """The part of the past that a moment shows: the last message, all changes, or some seconds."""
        if self.topic.role == Role.SCENE:
            return "changes"
        return "last" if self.topic.role in LATEST else "seconds"

    @property
    def can_be_thinned(self) -> bool:
        """Whether messages can be omitted; a scene without its changes would be wrong."""
        return bool(self.messages) and self.topic.role != Role.SCENE

    @property
    def loss(self) -> str | None:
        """A sentence on the omitted messages of the topic; None if it is complete."""
        name = self.topic.name
        if self.every == 0:
            return f"{name}: its messages are not in this file, to limit its size"
        if self.every > 1:
            return f"{name}: 1 of {self.every} messages is in this file, to limit its size"
        return f"{name}: {self.jpegs} images are JPEG, with small losses" if self.jpegs else None

    def thinned(self) -> Track:
        """Return every second message; none if too few would be left, or for spikes, which are counted."""
        left = self.times_ns[::2]
        if self.topic.role == Role.SPIKES or len(left) <= _RAREST_HZ * seconds(left[-1] - left[0]) + 1:
            return Track(self.topic, [], [], every=0)
        return replace(self, times_ns=left, messages=self.messages[::2], every=2 * self.every)


def read_tracks(messages: StoredMessages, topics: Iterable[RecordedTopic]) -> list[Track]:
    """Return the messages of these topics, with each image as an image file."""
    return [_track(messages, topic) for topic in topics]


def fitted(tracks: Iterable[Track], most_bytes: int) -> list[Track]:
    """Return tracks thinned until they fit, always the largest first.

    Args:
        tracks: the tracks.
        most_bytes: the maximum size of all, packed.

    Raises:
        ExperimentError: they do not fit even without omissible messages.
    """
    fitting = list(tracks)
    for size_of, most in ((_unpacked, MOST_UNPACKED_BYTES), (_packed, most_bytes)):
        while (total := sum(map(size_of, fitting))) > most:
            largest = max((track for track in fitting if track.can_be_thinned), key=size_of, default=None)
            if largest is None:
                raise ExperimentError(
                    f"its scene takes {total / 1e6:.1f} MB, and {most / 1e6:.1f} MB are left"
                )
            fitting[fitting.index(largest)] = largest.thinned()
    return fitting


def _unpacked(track: Track) -> int:
    return track.size


def _packed(track: Track) -> int:
    return len(track.packed)


def _track(messages: StoredMessages, topic: RecordedTopic) -> Track:
    if topic.type_name != _IMAGE:
        stored = list(_stored(messages, topic.name))
        return Track(topic, [one.t_ns for one in stored], [one.data for one in stored])
    codec = Codec({topic.type_name: topic.definition})
    times_ns, files, jpegs, are_files = [], [], 0, True
    for one in _stored(messages, topic.name):
        image = codec.decode(one.data, topic.type_name)
        are_files = are_files and compressible(image)
        file = _as_file(image) if are_files else None
        times_ns.append(one.t_ns)
        files.append(one.data if file is None else bytes(codec.encode(file)))
        jpegs += file is not None and file.format == _JPEG
    if are_files:
        definition = codec.definition(_FILE)
        topic = replace(topic, type_name=_FILE, definition=definition)
    return Track(topic, times_ns, files, jpegs=jpegs)


def _stored(messages: StoredMessages, topic: str) -> Iterator[Stored]:
    """Yield all messages of a topic, a second at a time, because images are large."""
    begin_ns, end_ns = messages.span_ns
    for after_ns in range(begin_ns - 1, end_ns, NS_PER_S):
        yield from messages.between([topic], after_ns, min(after_ns + NS_PER_S, end_ns))


def _as_file(image: Image) -> CompressedImage:
    """Return an image as lossless WebP, or as JPEG if that is smaller."""
    import cv2  # slow

    pixels = values_of(image)
    bgr = pixels if pixels.ndim == 2 else np.ascontiguousarray(pixels[..., ::-1])
    _, webp = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, _WEBP_LOSSLESS])
    jpeg = compress(image)
    return jpeg if len(jpeg.data) < len(webp) else CompressedImage(image.header, "webp", webp.reshape(-1))
