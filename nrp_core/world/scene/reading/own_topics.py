"""A topic for each sensor: in real files the sensors of a robot often share one, such as a row of sonars."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from nrp_core.findings import Code
from nrp_core.world.scene.bodies import free_name
from nrp_core.world.scene.model import Link
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import MountedSensor


def with_own_topics(links: Iterable[Link], model: Element, notes: Notes) -> tuple[Link, ...]:
    """Return links of a model in which no two sensors have a topic in common; each new name is a warning.

    Two topics of one sensor may be the same: a sonar has its ranges instead of its scans.
    """
    owners: dict[str, str] = {}
    taken = {topic for link in links for sensor in link.sensors for topic in sensor.topics}

    def own(sensor: MountedSensor, link: str) -> MountedSensor:
        topics = sensor.topics_by_field
        others: dict[str, str] = {}
        for topic in dict.fromkeys(topics.values()):
            if topic in owners:
                others[topic] = free_name(topic, taken)
                taken.add(others[topic])
                message = (
                    f"the sensors {owners[topic]} and '{sensor.name}' of '{link}' have the topic '{topic}': "
                    f"that of the second is '{others[topic]}'"
                )
                notes.warn(model, Code.NRP266, message, subject=sensor.name)
            else:
                owners[topic] = f"'{sensor.name}' of '{link}'"
        renamed: dict[str, Any] = {name: others[topic] for name, topic in topics.items() if topic in others}
        return replace(sensor, **renamed) if renamed else sensor

    return tuple(
        replace(link, sensors=tuple(own(each, link.name) for each in link.sensors)) for link in links
    )
