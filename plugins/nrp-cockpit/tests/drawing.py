"""Somebody who draws a model beside a Husky."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_bibi.model.functions import Bibi
from nrp_cockpit.designer.document import Document
from nrp_cockpit.designer.surroundings import Surroundings, Topic

ROOT = Path(__file__).parents[3]
HUSKY = Surroundings(
    {
        topic.name: topic
        for topic in (
            Topic("/husky/camera", "sensor_msgs.msg.Image", rate_hz=30.0),
            Topic("/husky/odom", "nav_msgs.msg.Odometry", rate_hz=100.0),
            Topic("/husky/cmd_vel", "geometry_msgs.msg.Twist", is_sent=False, is_heard=True),
            Topic("/screen/color", "std_msgs.msg.ColorRGBA", is_heard=True),
        )
    },
    {"sensors": 5, "actors": 2, "circuit": 8},
)


class Drawing:
    """A document, and the commands of somebody who draws."""

    def __init__(self, document: Document) -> None:
        self.document = document

    @property
    def model(self) -> Bibi:
        return self.document.model

    def do(self, command: str, **arguments: Any) -> str:
        """Give a command; return the path of what it made."""
        self.document.do(command, **arguments)
        return self.document.selected or ""

    def function(self, kind: str, name: str) -> str:
        path = self.do("add", path="", field="transfer_function", type=kind)
        self.do("set", path=path, field="name", text=name)
        return path

    def wired(self, source: str, target: str, name: str = "") -> str:
        path = self.do("connect", source=source, target=target)
        if name:
            self.do("set", path=path, field="name", text=name)
        return path

    def local(self, function: str, name: str, text: str) -> None:
        path = self.do("add", path=function, field="local")
        self.do("set", path=path, field="name", text=name)
        self.do("write", path=path, field="body", text=text)
