"""Topics that are created while other nodes come and go."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import pytest
from nrp_core.messages import message
from nrp_core.messages.std_msgs import String

from conftest import Ros2, needs_ros2
from nrp_world_ros.joining import join
from nrp_world_ros.options import Ros

CREATE = """
import sys, time
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.nav_msgs import Odometry
from nrp_world_ros.joining import join
from nrp_world_ros.options import Ros
print("start", flush=True)
end_s = time.monotonic() + float(sys.argv[2])
while time.monotonic() < end_s:
    with join(Ros.TWO, "under_test", domain=int(sys.argv[1])) as node:
        for number in range(50):
            node.publisher(f"/topic{number}", (Twist, Odometry)[number % 2])
            node.listen(f"/other{number}", (Twist, Odometry)[number % 2])
            if time.monotonic() > end_s:
                break
"""


@message("test_msgs/msg/Late")
@dataclass(slots=True)
class Late:
    value: float = 0.0


@pytest.mark.heavy
@needs_ros2
@pytest.mark.slow
def test_topics_are_created_while_others_come_and_go(ros2: Ros2) -> None:
    strangers = [ros2.ready_peer("stranger") for _ in range(2)]
    creating = ros2.start(sys.executable, "-X", "faulthandler", "-c", CREATE, str(ros2.domain), "15")
    said, _ = creating.communicate(timeout=120)
    assert (creating.returncode, said) == (0, "start\n")
    assert [stranger.poll() for stranger in strangers] == [None, None]  # they came and went until the end


@needs_ros2
def test_nodes_can_be_opened_and_closed_in_turn(ros2: Ros2) -> None:
    """DDS deletes the topics of a closed node in its own time."""
    script = """
import sys
from nrp_world_ros.ros2.node import Ros2Node
for number in range(20):
    Ros2Node("under_test", domain=int(sys.argv[1])).close()
print("closed")
"""
    opening = ros2.start(sys.executable, "-X", "faulthandler", "-c", script, str(ros2.domain))
    said, _ = opening.communicate(timeout=120)
    assert (opening.returncode, said) == (0, "closed\n")


@needs_ros2
def test_a_type_may_appear_when_the_node_has_begun(ros2: Ros2) -> None:
    @message("test_msgs/msg/Later")
    @dataclass(slots=True)
    class Later:
        value: float = 0.0

    with join(Ros.TWO, "one", domain=ros2.domain) as one, join(Ros.TWO, "two", domain=ros2.domain) as two:
        for cls in (Later, Late, String):
            publisher = one.publisher(f"/{cls.__name__}", cls)
            two.listen(f"/{cls.__name__}", cls)
            ros2.until(lambda publisher=publisher: publisher.peers() == 1)  # type: ignore[misc]
        one.publisher("/Later", Later).publish(Later(2.5))
        assert two.inbox.wait(lambda: two.inbox.last("/Later") is not None, 30.0, two.check)
        (letter,) = two.inbox.take()
        assert letter.message == Later(2.5)
