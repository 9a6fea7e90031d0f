"""Files changed at random, each change by its number, and what became of whoever used them.

``NRP_MUTATIONS=1000`` sets how many there are of each kind of file; by default few. With
``NRP_MUTATIONS_FROM=1000`` they are others: those that follow the first thousand.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from random import Random
from types import FrameType

from nrp_core.errors import NrpError

COUNT = int(os.environ.get("NRP_MUTATIONS", "8"))
FIRST = int(os.environ.get("NRP_MUTATIONS_FROM", "0"))
PATIENCE_S = 20.0
"""Longer than any sound file takes, by far."""
MOST_RINGS = 6
"""Times :data:`PATIENCE_S` after which a file has taken too long although it computed little."""
ROOM_BYTES = 3 * 2**30
"""What a file may make a program take, besides what it has."""

NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
WORD = re.compile(rb"[A-Za-z_][\w.]*")
ODD = (
    *(b"", b"0", b"-1", b"nan", b"inf", b"-inf", b"1e400", b"1e-320", b"1e200", b"99999999999", b"1.5"),
    *(b"true", b"null", b"~", b"[]", b"{}", b"<a>", b"</a>", b"&amp;", b"&x;", b"'", b'"', b": ", b"x" * 300),
    *(
        "\N{SNOWMAN}".encode(),
        b"\xff\xfe",
        b"\x00",
        b"\n",
        b"\t",
        b"../../..",
        b"/dev/zero",
        b"!!python/name:os",
    ),
)


def mutated(data: bytes, random: Random, *, text: bool) -> bytes:
    """Return the data with one thing changed, or a few; a text mostly in its words and lines."""
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        change = random.choice(_OF_TEXT if text and random.random() < 0.85 else _OF_BYTES)
        data = change(data or b"\n", random)
    return data


def _flip(data: bytes, random: Random) -> bytes:
    place = random.randrange(len(data))
    return data[:place] + bytes([data[place] ^ 1 << random.randrange(8)]) + data[place + 1 :]


def _overwrite(data: bytes, random: Random) -> bytes:
    place, some = random.randrange(len(data)), random.randbytes(random.randint(1, 30))
    return data[:place] + some + data[place + len(some) :]


def _put_in(data: bytes, random: Random) -> bytes:
    place = random.randrange(len(data))
    return data[:place] + random.randbytes(random.randint(1, 30)) + data[place:]


def _cut_out(data: bytes, random: Random) -> bytes:
    place = random.randrange(len(data))
    return data[:place] + data[place + random.randint(1, 60) :]


def _cut_off(data: bytes, random: Random) -> bytes:
    return data[: random.randrange(len(data))]


def _repeat(data: bytes, random: Random) -> bytes:
    place, other = random.randrange(len(data)), random.randrange(len(data))
    return data[:other] + data[place : place + random.randint(1, 200)] + data[other:]


def _odd_number(data: bytes, random: Random) -> bytes:
    return _replaced(data, NUMBER, random, lambda: random.choice(ODD))


def _odd_word(data: bytes, random: Random) -> bytes:
    return _replaced(data, WORD, random, lambda: random.choice(ODD))


def _other_word(data: bytes, random: Random) -> bytes:
    return _replaced(data, WORD, random, lambda: random.choice(WORD.findall(data)))


def _line(data: bytes, random: Random) -> bytes:
    """Remove, repeat, move or indent a line."""
    lines = data.splitlines(keepends=True)
    place, other = random.randrange(len(lines)), random.randrange(len(lines))
    match random.randrange(4):
        case 0:
            del lines[place]
        case 1:
            lines.insert(other, lines[place])
        case 2:
            lines.insert(other, lines.pop(place))
        case _:
            lines[place] = b"  " + lines[place]
    return b"".join(lines)


_OF_BYTES = (_flip, _overwrite, _put_in, _cut_out, _cut_off, _repeat)
_OF_TEXT = (_odd_number, _odd_word, _other_word, _line)


def _replaced(data: bytes, what: re.Pattern[bytes], random: Random, by: Callable[[], bytes]) -> bytes:
    found = list(what.finditer(data))
    if not found:
        return data
    one = random.choice(found)
    return data[: one.start()] + by() + data[one.end() :]


class TookTooLong(BaseException):
    """Raised where a program is when its patience ends."""


@contextmanager
def limits() -> Iterator[None]:
    """Give a block little time and little memory; on a busy machine the time is that of the processor."""
    began_s, rings = time.process_time(), count(1)

    def stop(number: int, frame: FrameType | None) -> None:
        if next(rings) == MOST_RINGS or time.process_time() - began_s > PATIENCE_S / 2:
            raise TookTooLong

    before = signal.signal(signal.SIGALRM, stop)
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + ROOM_BYTES, hard))
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_S, PATIENCE_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@dataclass
class Tally:
    """What became of many files: how many were used, how many refused, and all that went wrong.

    Args:
        kind: what they are.
        is_clear: what an error must look like.
    """

    kind: str
    is_clear: Callable[[NrpError], bool]
    counts: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)

    def take(self, number: int, use: Callable[[], None]) -> None:
        """Use one file; an assertion that fails in it is wrong as well."""
        try:
            with limits():
                use()
            self.counts["used"] += 1
        except NrpError as error:
            self.counts["refused"] += 1
            if not self.is_clear(error):
                self.wrong.append(f"{self.kind} {number}: unclear: {type(error).__name__}: {error}")
        except (Exception, SystemExit, TookTooLong) as error:  # noqa: BLE001 - that is what is looked for
            deepest = traceback.extract_tb(error.__traceback__)[-1]
            self.wrong.append(
                f"{self.kind} {number}: {type(error).__name__}: {error!s:.300} "
                f"({deepest.filename}:{deepest.lineno})"
            )

    def check(self) -> None:
        """Fail if anything went wrong."""
        print(f"{self.kind}: {dict(sorted(self.counts.items()))}, {len(self.wrong)} wrong")
        assert not self.wrong, "\n".join(self.wrong)


def numbers_in(data: object) -> list[float]:
    """Return all numbers in lists and dictionaries."""
    if isinstance(data, dict):
        data = list(data.values())
    if isinstance(data, (list, tuple)):
        return [number for one in data for number in numbers_in(one)]
    return [float(data)] if isinstance(data, (int, float)) else []


def numbered(kind: str, count: int = COUNT) -> Iterator[tuple[int, Random]]:
    """Return the number of each mutation and what draws it: the same for each number, whatever the count."""
    for number in range(FIRST, FIRST + count):
        yield number, Random(f"{kind}/{number}")
