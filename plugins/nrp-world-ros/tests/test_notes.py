"""Requests of a loop to its own body, and the answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_core.errors import SimulationError

from nrp_world_ros.hosted.dialogue import Answer, Notes, Question, portable


@given(st.binary(min_size=1), st.data())
def test_a_note_that_changed_in_transit_is_not_read(key: bytes, data: st.DataObject) -> None:
    notes = Notes(key)
    note = notes.write(Question("place", ("box", 1.0)))
    assert notes.read(note) == Question("place", ("box", 1.0))
    at_byte = data.draw(st.integers(0, len(note) - 1))
    changed = note[:at_byte] + bytes([note[at_byte] ^ data.draw(st.integers(1, 255))]) + note[at_byte + 1 :]
    for wrong in (changed, note[:at_byte]):
        with pytest.raises(SimulationError, match="unknown sender"):
            notes.read(wrong)


class StubbornError(Exception):
    """An error that cannot be made of what it was made of."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(one + two)


def test_an_error_that_cannot_be_pickled_is_still_reported() -> None:
    raised = Answer(error=portable(StubbornError("no ", "way")))
    with pytest.raises(SimulationError, match="StubbornError: no way"):
        raised.taken()
    assert Answer(np.float64(3.0)).taken() == 3.0
