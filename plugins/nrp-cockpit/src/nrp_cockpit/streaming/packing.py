"""The messages of a topic in one piece, which the page's ``Messages`` reads."""

from __future__ import annotations

import base64
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from nrp_core.clock import NS_PER_S, seconds

MOST_BYTES = 4_000_000
"""The size at which a portion is complete."""

Timed = tuple[int, bytes]
"""A message: its time, ns, and its bytes."""


def packed_parts(times_ns: Sequence[int], messages: Sequence[bytes]) -> list[bytes]:
    """Return the bytes of all messages, in parts.

    Their number as 64 bits, their times in ns as 64-bit floats, their lengths as 32 bits, and themselves.
    """
    lengths = np.fromiter(map(len, messages), "<u4", len(messages))
    head = [len(lengths).to_bytes(8, "little"), np.array(times_ns, "<f8").tobytes(), lengths.tobytes()]
    return [*head, *messages]


def portion(
    between: Callable[[int, int], Iterable[Timed]], from_ns: int, after_ns: int, end_ns: int
) -> dict[str, Any]:
    """Return the messages of a topic after a time, as many whole seconds of them as one answer takes.

    Args:
        between: returns the messages after one time and up to another, ns.
        from_ns: the time from which the topic is known.
        after_ns: the time.
        end_ns: the time of the last message.
    """
    found: list[Timed] = []
    until_ns, size = max(after_ns, from_ns - 1), 0
    while until_ns < end_ns and size < MOST_BYTES:
        begin_ns, until_ns = until_ns, min(until_ns + NS_PER_S, end_ns)
        more = list(between(begin_ns, until_ns))
        found += more
        size += sum(len(data) for _, data in more)
    parts = packed_parts([t_ns for t_ns, _ in found], [data for _, data in found])
    return {
        "from_s": seconds(from_ns),
        "until_ns": until_ns,
        "is_all": until_ns >= end_ns,
        "packed": base64.b64encode(b"".join(parts)).decode(),
    }


def between_in(messages: Sequence[Timed]) -> Callable[[int, int], Sequence[Timed]]:
    """Return a function that finds the messages between two times in a sequence in order of time."""

    def between(after_ns: int, until_ns: int) -> Sequence[Timed]:
        first, last = (bisect_right(messages, t_ns, key=itemgetter(0)) for t_ns in (after_ns, until_ns))
        return messages[first:last]

    return between
