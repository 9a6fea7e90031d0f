"""Errors of pydantic in the words of an experiment file."""

from typing import Annotated, Any, Literal

import pytest
from pydantic import Field, TypeAdapter, ValidationError

from nrp_core.experiment.model.collector import describe_fault

CASES: list[tuple[Any, Any, str]] = [
    (int, "seven", "should be a valid integer, not 'seven'"),
    (int, 1.5, "should be a valid integer, not 1.5"),
    (float, [], "should be a valid number, not []"),
    (bool, "maybe", "should be a valid boolean, not 'maybe'"),
    (str, 3, "should be a valid string, not 3"),
    (list[int], "a", "should be a valid list, not 'a'"),
    (tuple[int, ...], "a", "should be a valid list, not 'a'"),
    (dict[str, int], 5, "should be a valid mapping, not 5"),
    (Annotated[float, Field(gt=0)], -1.0, "should be greater than 0, not -1.0"),
    (Annotated[float, Field(ge=0, le=1)], 1.5, "should be less than or equal to 1, not 1.5"),
    (Annotated[float, Field(allow_inf_nan=False)], float("inf"), "should be a finite number, not inf"),
    (Annotated[list[int], Field(min_length=2)], [1], "should have at least 2 items, not [1]"),
    (Literal["stop", "quarantine"], "ignore", "should be 'stop' or 'quarantine', not 'ignore'"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "value", "message"), CASES)
def test_the_reason_is_made_of_the_type_and_context_of_the_error(kind: Any, value: Any, message: str) -> None:
    with pytest.raises(ValidationError) as raised:
        TypeAdapter(kind).validate_python(value)
    (detail,) = raised.value.errors()
    assert describe_fault(detail) == message
    assert describe_fault({**detail, "msg": "reworded by a later version"}) == message
