"""The real rviz (ROS 1) draws a robot from its description and transforms."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import Ros, needs_ros, needs_rviz

SETTINGS = """
Panels:
  - {Class: rviz/Displays, Name: Displays}
Visualization Manager:
  Class: ""
  Displays:
    - {Class: rviz/RobotModel, Name: RobotModel, Enabled: true, Robot Description: robot_description}
    - {Class: rviz/TF, Name: TF, Enabled: true, Show Names: false}
  Enabled: true
  Global Options: {Background Color: 48; 48; 48, Fixed Frame: FRAME, Frame Rate: 10}
  Name: root
  Tools: [{Class: rviz/Interact}]
  Value: true
  Views:
    Current: {Class: rviz/Orbit, Distance: 4, Name: Current View, Pitch: 0.6, Yaw: 0.8,
              Target Frame: husky/base_link}
Window Geometry: {Width: 1000, Height: 700}
"""
PANEL, VIEW = (slice(62, 560), slice(0, 342)), (slice(62, 670), slice(366, 984))
"""Rows and columns of the list of displays with their states, and of the view."""


def screen(file: Path) -> Any:
    """Return what a screen of Xvfb shows, RGB, from its file in the format of xwd."""
    data = file.read_bytes()
    header = struct.unpack(">25I", data[:100])
    start, width, height, stride, colors = (header[field] for field in (0, 4, 5, 12, 19))
    rows = np.frombuffer(data, np.uint8, height * stride, start + 12 * colors).reshape(height, -1, 4)
    return rows[:, :width, 2::-1].astype(int)


def count(part: Any, *, red: tuple[int, int], green: tuple[int, int], blue: tuple[int, int]) -> int:
    """Return how many pixels have a colour between these values."""
    ends = np.array([red, green, blue])
    return int(((part >= ends[:, 0]) & (part <= ends[:, 1])).all(axis=2).sum())


@needs_ros
@needs_rviz
@pytest.mark.heavy
@pytest.mark.parametrize("frame", ["world", "nowhere"])
def test_rviz_draws_the_robot_without_an_error_unless_its_frame_is_nowhere(ros: Ros, frame: str) -> None:
    ros.body()
    settings = ros.folder / "my.rviz"
    settings.write_text(SETTINGS.replace("FRAME", frame))
    display = f":{100 + ros.port % 30000}"
    ros.start("Xvfb", display, "-screen", "0", "1024x768x24", "-fbdir", str(ros.folder))
    ros.until((Path("/tmp/.X11-unix") / f"X{display[1:]}").exists)
    ros.env |= {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1", "XDG_RUNTIME_DIR": str(ros.folder)}
    rviz = ros.start("rviz", "-d", str(settings))

    def seen() -> tuple[int, int, int]:
        """Return the pixels of the yellow of a Husky, of white links, and of red and orange states."""
        image = screen(ros.folder / "Xvfb_screen0")
        return (
            count(image[VIEW], red=(100, 200), green=(80, 160), blue=(0, 60)),
            count(image[VIEW], red=(250, 255), green=(250, 255), blue=(250, 255)),
            count(image[PANEL], red=(180, 255), green=(0, 160), blue=(0, 60)),
        )

    def shown() -> bool:
        yellow, white, errors = seen()
        if frame == "world":
            return yellow > 2000 and max(white, errors) < 100
        return yellow == 0 and white > 2000 and errors > 400

    ros.until(shown, timeout_s=180)
    rviz.terminate()
    said = rviz.communicate(timeout=60)[0]
    assert "rviz version" in said
    assert "ERROR" not in said
    assert " WARN" not in said
