"""The completions of an editor of transfer functions."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core import dsl
from nrp_core.dsl import message_packages
from nrp_core.experiment import Run
from nrp_core.messages.base import type_name


def words_of(run: Run) -> Iterator[dict[str, str]]:
    """Yield topics, populations, messages and the words of the language."""
    network = run.brain.network
    for name, topic in run.world.topics.items():
        if topic.response is None:
            yield {"label": name, "type": "constant", "detail": type_name(topic.type)}
    for name, neurons in network.views.items():
        yield {"label": f"nrp.brain.{name}", "type": "variable", "detail": f"{len(neurons)} neurons"}
    for label, population in network.populations.items():
        yield {
            "label": f"nrp.brain.{label}",
            "type": "variable",
            "detail": f"{population.size} {population.cell_type}",
        }
    for word in dsl.__all__:
        yield {"label": f"nrp.{word}", "type": "function", "detail": "transfer functions"}
    for package, module in message_packages().items():
        for name in module.msg.__all__:
            yield {"label": f"{package}.msg.{name}", "type": "class", "detail": "message"}
