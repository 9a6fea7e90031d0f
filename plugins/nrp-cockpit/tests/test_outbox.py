"""What waits for a client, against a model of it."""

from __future__ import annotations

from collections import defaultdict

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from nrp_cockpit.wire.channels import Channel, Kind, Sent
from nrp_cockpit.wire.outbox import Outbox

BOUND = 100
EVERY = {number: Channel(number, f"/every/{number}", "cdr", "", "", Kind.EVERY) for number in (1, 2)}
LATEST = {number: Channel(number, f"/latest/{number}", "cdr", "", "", Kind.LATEST) for number in (3, 4)}
CHANNELS = EVERY | LATEST


def sent(channel: Channel, t_ns: int, size: int = 1) -> Sent:
    return Sent(channel, t_ns, (bytes(size),))


def taken(outbox: Outbox) -> list[tuple[int, Sent]]:
    found = []
    while outbox:
        frame = outbox.take()
        assert isinstance(frame, tuple)
        found.append(frame)
    return found


@given(st.lists(st.sampled_from(sorted(LATEST)), min_size=1))
def test_the_latest_message_wins(numbers: list[int]) -> None:
    outbox, last = Outbox(BOUND), {}
    for t_ns, number in enumerate(numbers):
        last[number] = sent(LATEST[number], t_ns)
        outbox.add(number, last[number])
    assert dict(taken(outbox)) == last
    assert outbox.dropped == len(numbers) - len(last)


@given(st.lists(st.tuples(st.sampled_from(sorted(EVERY)), st.integers(0, 60))))
def test_every_message_counts_up_to_the_bound_and_what_exceeds_it_is_counted(
    sizes: list[tuple[int, int]],
) -> None:
    outbox, room, kept = Outbox(BOUND), 0, []
    for t_ns, (number, size) in enumerate(sizes):
        message = sent(EVERY[number], t_ns, size)
        outbox.add(number, message)
        if room == 0 or room + size <= BOUND:
            room += size
            kept.append((number, message))
    assert taken(outbox) == kept
    assert outbox.dropped == len(sizes) - len(kept)


def test_a_message_larger_than_the_bound_waits_alone() -> None:
    outbox = Outbox(BOUND)
    outbox.add(1, sent(EVERY[1], 0, 10 * BOUND))
    outbox.add(1, sent(EVERY[1], 1))
    assert [message.t_ns for _, message in taken(outbox)] == [0]
    assert outbox.dropped == 1


def test_a_channel_of_which_the_latest_counts_is_not_held_up_by_the_others() -> None:
    outbox = Outbox(BOUND)
    outbox.add(1, sent(EVERY[1], 0))
    outbox.add(3, sent(LATEST[3], 1))
    outbox.add(1, sent(EVERY[1], 2))
    outbox.add(3, sent(LATEST[3], 3))
    assert [message.t_ns for _, message in taken(outbox)] == [0, 3, 2]


def test_answers_go_first() -> None:
    outbox = Outbox(BOUND)
    outbox.add(1, sent(EVERY[1], 0))
    outbox.answer("answer")
    assert outbox.take() == "answer"
    assert outbox


def test_nothing_can_be_taken_of_an_empty_one() -> None:
    with pytest.raises(IndexError):
        Outbox().take()


class Waiting(RuleBasedStateMachine):
    """Messages come and go in any order; subscriptions end."""

    def __init__(self) -> None:
        super().__init__()
        self.outbox = Outbox(BOUND)
        self.added = self.taken = self.forgotten = self.now_ns = 0
        self.newest: dict[int, int] = {}
        self.last_taken: defaultdict[int, int] = defaultdict(lambda: -1)

    @rule(number=st.sampled_from(sorted(CHANNELS)), size=st.integers(0, 60))
    def add(self, number: int, size: int) -> None:
        self.now_ns += 1
        self.added += 1
        self.outbox.add(number, sent(CHANNELS[number], self.now_ns, size))
        self.newest[number] = self.now_ns

    @precondition(lambda self: bool(self.outbox))
    @rule()
    def take(self) -> None:
        frame = self.outbox.take()
        assert isinstance(frame, tuple)
        number, message = frame
        self.taken += 1
        assert message.channel is CHANNELS[number]
        assert message.t_ns > self.last_taken[number]
        self.last_taken[number] = message.t_ns
        if number in LATEST:
            assert message.t_ns == self.newest[number]

    @rule(number=st.sampled_from(sorted(CHANNELS)))
    def forget(self, number: int) -> None:
        before = self.count()
        self.outbox.forget(number)
        self.forgotten += before - self.count()

    def count(self) -> int:
        return len(self.outbox._queue)

    @invariant()
    def nothing_is_lost_uncounted(self) -> None:
        assert self.added == self.taken + self.forgotten + self.outbox.dropped + self.count()

    @invariant()
    def it_is_bounded(self) -> None:
        waiting = [message for _, message in self.outbox._queue if message is not None]
        assert len(waiting) <= 1 or sum(len(message.payload) for message in waiting) <= BOUND


TestWaiting = Waiting.TestCase
