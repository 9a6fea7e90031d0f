"""True and false are refused for numbers, and taken where they mean something."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import pytest
from pydantic import Field, PlainValidator, ValidationError

from nrp_core._support.plain_numbers import PlainNumbers
from nrp_core.quantities import LengthM


class _Settings(PlainNumbers):
    number: float = 0.0
    count: Annotated[int, Field(ge=0)] = 0
    maybe: int | float | None = None
    named: dict[str, float] = Field(default_factory=dict)
    several: list[float] = Field(default_factory=list)
    length: LengthM | None = None
    own: Annotated[float, PlainValidator(lambda value: -1.0 if value is False else value)] = 0.0
    flag: bool = False
    either: bool | float = 0.0
    anything: Any = None
    file: Path | None = None


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("number", True, "should be a valid number, not True"),
        ("count", False, "should be a valid integer, not False"),
        ("maybe", True, "should be a valid number, not True"),
        ("named", {"a": 1.0, "b": True}, "'b' should be a valid number, not True"),
        ("several", [1.0, False], "should be a valid number, not False"),
        ("length", True, "a length is a number with a unit"),
    ],
)
def test_a_flag_is_not_a_number(name: str, value: object, words: str) -> None:
    with pytest.raises(ValidationError) as caught:
        _Settings.model_validate({name: value})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("flag", True, True),
        ("either", True, True),
        ("anything", True, True),
        ("own", False, -1.0),
        ("number", 1, 1.0),
        ("number", "2.5", 2.5),
        ("named", {"a": 1}, {"a": 1.0}),
        ("length", "1 m", 1.0),
    ],
)
def test_other_values_are_taken_as_before(name: str, value: object, expected: object) -> None:
    assert getattr(_Settings.model_validate({name: value}), name) == expected
