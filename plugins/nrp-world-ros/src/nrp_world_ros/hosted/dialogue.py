"""Lockstep with a body that has no other loop, with requests and answers."""

from __future__ import annotations

import hmac
import pickle
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import SimulationError
from nrp_core.world import Finding, Findings

from nrp_world_ros.node import Node
from nrp_world_ros.timekeeping import Lockstep, Sent, Turn

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
            SimulationError: another sender has sent it.
        """
        code, data = note[:_LENGTH], note[_LENGTH:]
        if not hmac.compare_digest(code, hmac.digest(self._key, data, _HASH)):
            raise SimulationError("a message from an unknown sender in ROS was refused by this body")
        return pickle.loads(data)


class Dialogue(Lockstep):
    """See :class:`~nrp_world_ros.timekeeping.Lockstep`; here both begin at time 0.

    Args:
        node: of this process; its check tells when the body's process has ended.
        patience_s: time limit of an answer, s.
        notes: reads and writes requests and answers.
        warnings: receives the warnings of the body.

    Attributes:
        broken: whether the last turn did not end, so that the body cannot be used any more.
    """

    _origin_ns = 0

    def __init__(self, node: Node, patience_s: float, notes: Notes, warnings: Findings) -> None:
        super().__init__(node, patience_s)
        self._notes, self._warnings = notes, warnings
        self.broken = False

    def start(self, sent: Sent) -> None:
        """Do nothing, because the body is known."""

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        turn = self._exchange(t_ns, sent, b"", heard)
        self._answer_in(turn)
        return turn.sent

    def ask(self, sent: Sent, question: Question) -> Any:
        """Send a request to the body, after the messages sent so far.

        Args:
            sent: the messages sent since the last turn; cleared afterwards.
            question: the request.

        Returns:
            The answer.

        Raises:
            SimulationError: its process has ended, or hangs.
            Exception: the exception raised there.
        """
        answer = self._answer_in(self._exchange(0, sent, self._notes.write(question), ()))
        self._node.inbox.take()
        return answer

    def _exchange(self, t_ns: int, sent: Sent, note: bytes, heard: Collection[str]) -> Turn:
        self.broken = True
        self._turns.end(t_ns, sent, note)
        turn = self._turns.wait(self._patience_s, heard=heard, meanwhile=self._node.check)
        if turn is None:
            raise SimulationError(
                f"the process that simulates the body hangs: it has not answered for {self._patience_s:g} s; "
                "the option patience sets how long it may take"
            )
        self.broken = False
        return turn

    def _answer_in(self, turn: Turn) -> Any:
        if not turn.note.size:
            return None
        answer: Answer = self._notes.read(turn.note.tobytes())
        self._warnings += answer.warnings
        if answer.error is not None:
            self._node.inbox.take()
        return answer.taken()
