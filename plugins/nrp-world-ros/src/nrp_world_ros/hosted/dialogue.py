"""Lockstep with a body that has no other loop: it can be asked, and is waited for as long as it lives."""

from __future__ import annotations

from collections.abc import Collection
from math import inf
from typing import Any

from nrp_world_ros.hosted.notes import Answer, Notes, Question
from nrp_world_ros.lockstep import Sent, Turn
from nrp_world_ros.node import Node
from nrp_world_ros.times import Lockstep


class Dialogue(Lockstep):
    """See :class:`~nrp_world_ros.times.Lockstep`; here both begin at time 0.

    Args:
        node: of this process; its check tells when the body's process has ended.
        notes: of the two.
        warnings: gets what the body notices.

    Attributes:
        broken: whether the last turn was not ended, so that the body cannot be spoken to any more.
    """

    _origin_ns = 0

    def __init__(self, node: Node, notes: Notes, warnings: list[str]) -> None:
        super().__init__(node, inf)
        self._notes, self._warnings = notes, warnings
        self.broken = False

    def start(self, sent: Sent) -> None:
        """Nobody has to be found."""

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        turn = self._exchange(t_ns, sent, b"", heard)
        self._answer_in(turn)
        return turn.sent

    def ask(self, sent: Sent, question: Question) -> Any:
        """Let the body do or tell something now, after what it was sent.

        Args:
            sent: what it was sent since the last turn; counted anew afterwards.
            question: what it is asked.

        Returns:
            what it answers.

        Raises:
            SimulationError: its process has ended.
            Exception: what was raised there.
        """
        answer = self._answer_in(self._exchange(0, sent, self._notes.write(question), ()))
        self._node.inbox.take()
        return answer

    def _exchange(self, t_ns: int, sent: Sent, note: bytes, heard: Collection[str]) -> Turn:
        self.broken = True
        self._turns.end(t_ns, sent, note)
        turn = self._turns.wait(inf, heard=heard, meanwhile=self._node.check)
        assert turn is not None
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
