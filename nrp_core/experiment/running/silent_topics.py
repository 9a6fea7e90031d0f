"""Topics without a publisher that functions read which came into a run later."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from nrp_core.dsl.functions import TransferFunction
from nrp_core.experiment.making.watch import declare_missing_topics, silent_topic
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.world import World


class SilentTopics:
    """Declares the topics of functions that are exchanged while an experiment that is not strict runs.

    Args:
        experiment: the experiment.
        world: its world.
        functions: returns the transfer functions at the time of a finding.
    """

    def __init__(
        self, experiment: Experiment, world: World, functions: Callable[[], Iterable[TransferFunction]]
    ) -> None:
        self._experiment, self._world, self._functions = experiment, world, functions
        self._said: dict[str, str] = {}

    def declare(self, functions: Sequence[TransferFunction]) -> None:
        """Add the topics that functions expect and that the world does not have."""
        served = dict(self._world.topics)
        for topic in declare_missing_topics(self._experiment, self._world, functions):
            self._said[topic] = silent_topic(topic, served)

    def findings(self) -> Iterator[Finding]:
        """Yield a finding for each of these topics that a function reads and none publishes."""
        functions = list(self._functions())
        published = {topic.name for function in functions for topic in function.published}
        for topic, message in self._said.items():
            readers = [
                one for one in functions if topic in {subscribed.name for subscribed in one.subscribed}
            ]
            if readers and topic not in published:
                place = readers[0].place
                yield Finding(
                    Code.NRP268, message, Level.WARNING, Path(place.path), place.line, subject=topic
                )
