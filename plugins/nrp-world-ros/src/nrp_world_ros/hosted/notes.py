"""What a loop asks of its own body, and what that answers, as bytes that travel with their turns.

They are Python pickles, which can do anything to who reads them; so each carries a code that only the two
can make (HMAC, RFC 2104), and no other is read.
"""

from __future__ import annotations

import hmac
import pickle
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import SimulationError

_HASH, _LENGTH = "sha256", 32


@dataclass(frozen=True, slots=True)
class Question:
    """What to do or to tell: the name of it, and with what."""

    name: str
    arguments: tuple[Any, ...] = ()


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of it: a value, or why there is none, and what was noticed meanwhile."""

    value: Any = None
    error: Exception | None = None
    warnings: tuple[str, ...] = ()

    def taken(self) -> Any:
        """Return the value.

        Raises:
            Exception: what was raised there instead.
        """
        if self.error is not None:
            raise self.error
        return self.value


def portable(error: Exception) -> Exception:
    """Return an error as it can travel: as one of ours if not as it is."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001  whatever its own code does then
        return SimulationError(f"{type(error).__name__}: {error}")
    return error


class Notes:
    """Writes and reads them.

    Args:
        key: what only the two know.
    """

    def __init__(self, key: bytes) -> None:
        self._key = key

    def write(self, said: Question | Answer) -> bytes:
        """Return it as bytes."""
        data = pickle.dumps(said)
        return hmac.digest(self._key, data, _HASH) + data

    def read(self, note: bytes) -> Any:
        """Return the question or the answer.

        Raises:
            SimulationError: somebody else wrote it.
        """
        code, data = note[:_LENGTH], note[_LENGTH:]
        if not hmac.compare_digest(code, hmac.digest(self._key, data, _HASH)):
            raise SimulationError(
                "somebody else in ROS speaks to a body that is not theirs; nothing was done"
            )
        return pickle.loads(data)
