"""Events that change nothing, and conditions on measured values that are hardly ever exact."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Final

from nrp_core.checks.checks.conditions import asked, read_topics
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.errors import NrpError
from nrp_core.experiment.events.values import to_message
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.messages.sensor_msgs import Imu, JointState

_MEASURED: Final = (Imu, JointState, LinkStates, ModelStates, Odometry)
"""Messages whose numbers follow from forces, so that none but 0 is met exactly."""


@checks_experiment(Code.NRP248)
def measured_values_are_compared_with_bounds(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events and criteria that wait for an exact value of a position, velocity or force."""
    for keys, wanted in asked(static.experiment, "topic", "topic_stays"):
        info = static.topics.get(static.experiment.aliases.get(wanted.name, wanted.name))
        exact = wanted.equals
        if info is not None and info.type in _MEASURED and type(exact) in (int, float) and exact:
            message = (
                f"'{wanted.field}' of '{wanted.name}' is measured and hardly ever exactly {exact:g}; "
                "write 'above' and 'below'"
            )
            yield static.experiment.place(*keys, "equals").finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP279, Code.NRP324)
def own_topics_are_used(static: StaticExperiment) -> Iterator[Finding]:
    """Look for topics of the experiment that nothing uses or that only events publish on.

    Such a topic may be for people and recordings; it is doubted if its name is nearly that of another one.
    """
    if not static.is_complete:
        return
    experiment, functions = static.experiment, [declared.function for declared in static.declared]
    aliases = experiment.aliases

    def named(topics: Iterable[str]) -> set[str]:
        return {name for topic in topics for name in (topic, aliases.get(topic, topic))}

    read = named(read_topics(static))
    spoken = named(topic.name for function in functions for topic in function.published)
    events = {
        topic: name
        for name, event in experiment.events.items()
        for topic in named(one.topic for one in event.publish)
    }
    for topic in sorted(experiment.topics.keys() - read - spoken):
        event = events.get(topic)
        others = read if event else read | spoken | events.keys()
        meant = next(iter(get_close_matches(topic, others, n=1, cutoff=0.8)), None)
        place = experiment.place("topics", topic)
        if meant:
            message = f"nothing {'reads' if event else 'uses'} the topic '{topic}'; did you mean '{meant}'?"
            yield place.finding(Code.NRP324, message, Level.WARNING)
        else:
            said = f"only '{event}' publishes on" if event else "nothing publishes on"
            message = f"{said} the topic '{topic}' and nothing reads it"
            yield place.finding(Code.NRP279, message, Level.NOTE)


@checks_experiment(Code.NRP279)
def aliases_are_used(static: StaticExperiment) -> Iterator[Finding]:
    """Look for further names of topics that no function, event or criterion uses."""
    if not static.is_complete:
        return
    experiment = static.experiment
    used = {topic.name for one in static.declared for topic in one.function.published} | read_topics(static)
    used |= {one.topic for event in experiment.events.values() for one in event.publish}
    used |= set(experiment.world.sensors) | set(experiment.aliases.values())
    for alias in sorted(experiment.aliases.keys() - used):
        message = f"no function, event or criterion uses the alias '{alias}'"
        yield experiment.place("aliases", alias).finding(Code.NRP279, message, Level.NOTE)


@checks_experiment(Code.NRP320)
def colors_change(static: StaticExperiment) -> Iterator[Finding]:
    """Look for visuals to which all events give the colour that they have in their file."""
    if static.scene is None or not static.is_complete:
        return
    experiment = static.experiment
    own = {f"/{path}/color": tuple(visual.rgba) for path, visual in static.scene.visuals.items()}
    spoken = {topic.name for declared in static.declared for topic in declared.function.published}
    given: dict[str, dict[str, object]] = defaultdict(dict)
    for name, event in experiment.events.items():
        for one in event.publish:
            topic = experiment.aliases.get(one.topic, one.topic)
            if topic in own and not {topic, one.topic} & spoken:
                given[topic][name] = one.value
    for topic, values in given.items():
        try:
            messages = [to_message(static.topics[topic], value) for value in values.values()]
        except (NrpError, KeyError):  # reported by the check of events
            continue
        if all((one.r, one.g, one.b, one.a) == own[topic] for one in messages):
            message = f"'{topic}' has this colour from the start, and no event gives it another"
            place = experiment.place("events", next(iter(values)), "publish")
            yield place.finding(Code.NRP320, message, Level.WARNING)
