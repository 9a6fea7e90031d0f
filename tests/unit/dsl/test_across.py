"""Values of all copies act, bit for bit, as those of each copy alone."""

import math
import operator
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from nrp_core.dsl.across import BUILTINS, Across, NotTogetherError, each_copy

FLOATS = st.floats(-1e6, 1e6)
COPIES = 4
NUMBERS = st.lists(FLOATS, min_size=COPIES, max_size=COPIES)
ROWS = st.sampled_from([np.float32, np.float64]).flatmap(
    lambda dtype: st.lists(
        arrays.arrays(dtype, 5, elements=st.floats(-100, 100, width=32)), min_size=COPIES, max_size=COPIES
    )
)
OPERATORS = [operator.add, operator.sub, operator.mul, operator.truediv, operator.pow, operator.mod,
             operator.lt, operator.ge, operator.eq]  # fmt: skip


def bits(value):
    return type(value), np.asarray(value).dtype, np.asarray(value).tobytes()


def in_each(value):
    return value.each() if isinstance(value, Across) else [value] * COPIES


def require_same(act, *given):
    """Compare one call for all copies with a call for each, errors included."""
    alone, errors = [], []
    for own in zip(*map(in_each, given), strict=True):
        try:
            alone.append(act(*own))
        except (ArithmeticError, TypeError, ValueError) as error:
            errors.append(error)
    try:
        with np.errstate(all="ignore"):
            together = act(*given)
    except (ArithmeticError, TypeError, ValueError):
        assert errors
    except NotTogetherError:
        pass
    else:
        assert not errors
        assert [*map(bits, in_each(together))] == [*map(bits, alone)]


@given(a=NUMBERS, b=NUMBERS | FLOATS, act=st.sampled_from(OPERATORS))
def test_numbers_are_computed_as_python_does(a, b, act):
    first, second = Across.of(a), Across.of(b) if isinstance(b, list) else b
    with np.errstate(all="ignore"):
        require_same(act, first, second)
        require_same(act, second, first)
        require_same(act, second, operator.neg(first))


@given(rows=ROWS, number=NUMBERS | FLOATS, act=st.sampled_from(OPERATORS[:4] + OPERATORS[6:]))
def test_arrays_are_computed_as_numpy_does(rows, number, act):
    values = Across.of(rows)
    with np.errstate(all="ignore"):
        require_same(act, values, Across.of(number) if isinstance(number, list) else number)
        require_same(act, values, np.linspace(-1.0, 1.0, 5))
        require_same(act, values, Across.of([row.max() for row in rows]))


FUNCTIONS = [
    np.cos, np.exp, np.sqrt, np.mean, np.sum, np.argmax, np.abs, np.sort,
    lambda x: np.clip(x, 0.0, 3.0), lambda x: x.max(), lambda x: x.min(), lambda x: x.mean(), lambda x: x[2],
    lambda x: x[1:4].max(), lambda x: x[np.array([True, False, True, True, False])], lambda x: x > 1.0,
    lambda x: (x > 1.0) & (x < 5.0), lambda x: x[x > x[0]], lambda x: len(x), lambda x: x.any(),
    lambda x: np.where(x > 0, x, 0.0), lambda x: x * np.arange(len(x)), lambda x: x.astype(np.float64).sum(),
]  # fmt: skip


@settings(max_examples=25)
@given(rows=ROWS)
@pytest.mark.parametrize("act", FUNCTIONS)
def test_functions_of_arrays_are_those_of_each_copy(act, rows):
    with np.errstate(all="ignore"):
        require_same(act, Across.of(rows))


@given(a=NUMBERS, b=NUMBERS, c=FLOATS)
@pytest.mark.parametrize("alone", [min, max])
def test_the_least_and_greatest_are_those_of_python(alone, a, b, c):
    together = BUILTINS[alone.__name__](Across.of(a), Across.of(b), c)
    assert [*map(bits, in_each(together))] == [bits(alone(x, y, c)) for x, y in zip(a, b, strict=True)]


def test_equal_values_are_one_plain_value():
    assert Across.of([0.5, 0.5]) == 0.5
    assert isinstance(Across.of([0.0, -0.0]), Across)
    assert Across.of([SimpleNamespace(a=1, b=x) for x in (1.0, 2.0)]).a == 1


def test_a_branch_that_differs_is_refused():
    values = Across.of([1.0, -1.0])
    with pytest.raises(NotTogetherError):
        bool(values > 0)
    assert bool(values < 2)


@pytest.mark.parametrize("act", [float, int, list, str, math.sin, np.asarray, np.arange, lambda x: f"{x}"])
def test_what_needs_a_single_value_is_refused(act):
    with pytest.raises(NotTogetherError):
        act(Across.of([1.0, 2.0]))


def test_a_marked_function_is_called_for_each_copy():
    twice = each_copy(lambda x, plus=0.0: 2 * math.floor(x) + plus)
    assert twice(Across.of([1.5, 2.5]), plus=Across.of([0.5, 0.25])).each() == [2.5, 4.25]
    assert twice(1.5) == 2
