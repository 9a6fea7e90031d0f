"""Callbacks of a run, each of which returns the time of its next call."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from numbers import Real
from typing import Any, Final

from nrp_core.brain.pynn.invalid import InvalidValueError, WrongKindError

_ROUNDING_MS: Final = 1e-9
_MOST_CALLS: Final = 1000
"""At one time; a callback may name the present time some times, as one with a list of times does."""


class Callback:
    """A callback whose answers let a run advance.

    Args:
        function: returns the time (ms) at which it is to be called next.
        until_ms: the end of the run, from which on nobody reads the answers.
    """

    def __init__(self, function: Callable[[float], Any], until_ms: float) -> None:
        self._function, self._until_ms = function, until_ms
        self._called_ms, self._calls = float("nan"), 0

    def __call__(self, now_ms: float) -> Any:
        """Call it.

        Raises:
            InvalidValueError: the answer is no time, or the present or a past one again and again.
        """
        answer = self._function(now_ms)
        self._calls = self._calls + 1 if now_ms == self._called_ms else 1
        self._called_ms = now_ms
        is_time = isinstance(answer, Real) and float(answer) >= now_ms - _ROUNDING_MS
        if now_ms < self._until_ms - _ROUNDING_MS and (not is_time or self._calls > _MOST_CALLS):
            raise InvalidValueError(
                f"run: the callback {self._function!r:.60} returned {answer!r:.40} at {now_ms:g} ms; it "
                "returns the time of its next call, after the present one"
            )
        return answer


def checked(functions: Sequence[Callable[[float], Any]] | None, until_ms: float) -> list[Callback] | None:
    """Return callbacks of a run until a time, ms, with their answers checked.

    Raises:
        WrongKindError: they are not a list of functions.
    """
    if functions is None:
        return None
    given = [*functions] if isinstance(functions, Iterable) else [None]
    if not all(map(callable, given)):
        raise WrongKindError(
            f"run: callbacks are a list of functions, which are called with the time, not {functions!r:.60}"
        )
    return [Callback(function, until_ms) for function in given] or None
