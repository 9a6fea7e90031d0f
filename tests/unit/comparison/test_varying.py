"""Settings that are drawn anew with each seed."""

import pytest

from nrp_core.comparison.varying import Varied


def test_a_setting_is_drawn_from_its_range_and_is_the_same_for_a_seed() -> None:
    varied = Varied.parse("events.go.at = 4 .. 8 s")
    assert str(varied) == "events.go.at=4..8 s"
    drawn = [varied.override(seed) for seed in range(200)]
    assert drawn == [varied.override(seed) for seed in range(200)]
    numbers = [float(text.split("=")[1].removesuffix(" s")) for text in drawn]
    assert 4 <= min(numbers) < 4.2
    assert 7.8 < max(numbers) <= 8


def test_two_settings_are_drawn_independently() -> None:
    one, other = Varied.parse("a=0..1"), Varied.parse("b=0..1")
    assert [one.override(s)[2:] for s in range(5)] != [other.override(s)[2:] for s in range(5)]


@pytest.mark.parametrize("text", ["go", "go=4", "go=4..", "go=8..4 s", "=1..2", "go=a..b"])
def test_what_is_no_range_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"range"):
        Varied.parse(text)
