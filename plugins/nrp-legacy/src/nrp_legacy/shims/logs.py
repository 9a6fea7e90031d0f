"""``hbp_nrp_excontrol.logs``: texts for the user, which state machines can wait for."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_core.world.messages.std_msgs import String
from nrp_legacy.shims.graph import Graph, log
from nrp_legacy.shims.modules import OpenMessage, module

LOGS = "/ros_cle_simulation/logs"
"""The topic of the texts, which is there if somebody listens."""


class ClientLoggerMessage(OpenMessage):
    """A text for the user, as ``message``."""


def shown(topic: str, message: Any, graph: Graph) -> bool:
    """Show a message of the topic of texts to the user; return whether nobody else listens to it."""
    if topic != LOGS:
        return False
    log.info("%s", getattr(message, "data", getattr(message, "message", message)))
    if not graph.has_begun:
        return True
    graph.declare(LOGS, type(message))
    return LOGS not in graph.world.subscribed


class ClientLogger:
    """Shows texts to the user.

    Args:
        graph: the graph of the run.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def info(self, *words: object) -> None:
        """Show a text."""
        text = " ".join(map(str, words))
        log.info("%s", text)
        if LOGS in self._graph.topics:  # some files take its messages for strings
            takes_strings = self._graph.world.topics[LOGS].type is String
            message = String(text) if takes_strings else ClientLoggerMessage(message=text)
            self._graph.publish(LOGS, type(message), message)

    advertise = info

    def clear_advertisements(self) -> None:
        """Do nothing, because shown texts stay."""


def log_modules(logger: ClientLogger) -> dict[str, ModuleType]:
    """Return the module with a logger, by its name."""
    return {"hbp_nrp_excontrol.logs": module("logs", clientLogger=logger)}
