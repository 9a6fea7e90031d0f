"""Settings that are drawn anew with each seed."""

import pytest
from golden import Golden

from nrp_core.experiment.model.section import Range, keyed_range


def test_a_setting_is_drawn_from_its_range_and_is_the_same_for_a_seed() -> None:
    key, values = keyed_range("events.go.at = 4 .. 8 s")
    assert (key, str(values)) == ("events.go.at", "4..8 s")
    drawn = [values.override(key, seed) for seed in range(200)]
    assert drawn == [values.override(key, seed) for seed in range(200)]
    numbers = [float(text.split("=")[1].removesuffix(" s")) for text in drawn]
    assert 4 <= min(numbers) < 4.2
    assert 7.8 < max(numbers) <= 8


def test_two_settings_are_drawn_independently() -> None:
    values = Range(0, 1, "")
    assert [values.override("a", s)[2:] for s in range(5)] != [values.override("b", s)[2:] for s in range(5)]


@pytest.mark.parametrize("text", ["go", "go=4", "go=4..", "go=8..4 s", "=1..2", "go=a..b"])
def test_an_invalid_range_is_refused(text: str, golden: Golden) -> None:
    with golden.raises(ValueError):
        keyed_range(text)
