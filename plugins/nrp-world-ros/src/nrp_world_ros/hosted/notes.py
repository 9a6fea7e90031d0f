"""Requests of a loop to its body, and the answers, as bytes that are sent at the end of turns.

They are Python pickles, which can run any code in their reader; so each carries a code that only the two can
make (HMAC, RFC 2104), and others are refused.
"""

from __future__ import annotations

import hmac
import pickle
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import SimulationError
from nrp_core.world import Finding

_HASH, _LENGTH = "sha256", 32


@dataclass(frozen=True, slots=True)
class Question:
    """A request: the name of an operation, and its arguments."""

    name: str
    arguments: tuple[Any, ...] = ()


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer: a value or an error, and the warnings meanwhile."""

    value: Any = None
    error: Exception | None = None
    warnings: tuple[Finding, ...] = ()

    def taken(self) -> Any:
        """Return the value.

        Raises:
            Exception: the exception raised there.
        """
        if self.error is not None:
            raise self.error
        return self.value


def portable(error: Exception) -> Exception:
    """Return an error that can be pickled: one of ours if the original cannot."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001  whatever its own code does then
        return SimulationError(f"{type(error).__name__}: {error}")
    return error


class Notes:
    """Writes and reads requests and answers.

    Args:
        key: the secret key of the two processes.
    """

    def __init__(self, key: bytes) -> None:
        self._key = key

    def write(self, said: Question | Answer) -> bytes:
        """Return it as bytes."""
        data = pickle.dumps(said)
        return hmac.digest(self._key, data, _HASH) + data

    def read(self, note: bytes) -> Any:
        """Return the request or the answer.

        Raises:
            SimulationError: it is from somebody else.
        """
        code, data = note[:_LENGTH], note[_LENGTH:]
        if not hmac.compare_digest(code, hmac.digest(self._key, data, _HASH)):
            raise SimulationError("a message from an unknown sender in ROS was refused by this body")
        return pickle.loads(data)
