"""What is in a recording, and that it is there whatever happens."""

import subprocess
import sys
import textwrap
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xxhash
from golden import Golden

from nrp_core.errors import SimulationError
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.recording.images import pixels_of
from nrp_core.recording.layout import MCAP_NAME, SCENE, TRANSFORMS, Images, Role, device_topic, spikes_topic
from nrp_core.recording.reading.reader import Recorded
from nrp_core.recording.recording import Recording
from nrp_core.recording.writing.writer import FLUSH_S, McapFile

GLASS = "/wall/body/glass/color"


def recorded(rig: Any, topic: str) -> list[Recorded]:
    """Close the recording and return what it holds on a topic."""
    rig.recorder.close()
    return list(Recording(rig.folder).messages({topic}))


def test_moving_models_are_recorded_every_step_and_still_ones_are_scenery(rig: Any) -> None:
    for _ in range(3):
        rig.step()
    states = recorded(rig, "/gazebo/model_states")
    assert [one.t_ns for one in states] == [0, 20_000_000, 40_000_000, 60_000_000]
    assert all(one.message.name == ["husky"] for one in states)
    assert states[-1].message.pose[0].position.x == pytest.approx(0.02, rel=1e-3)
    (scenery,) = Recording(rig.folder).messages({SCENE})
    frames = {entity.id: entity.frame_id for entity in scenery.message.entities}
    assert frames == {
        "floor/body/ground": "world", "wall/body/glass": "world", "wall/body/stool": "world",
        "wall/body/ball": "world", "husky/base/chassis": "husky",
    }  # fmt: skip


def test_an_entity_of_a_static_model_lies_where_its_visual_is(rig: Any) -> None:
    (scenery,) = recorded(rig, SCENE)
    glass = next(entity for entity in scenery.message.entities if entity.id == "wall/body/glass")
    (cube,) = glass.cubes
    assert (cube.pose.position.x, cube.pose.position.z) == (3.0, 1.0)
    assert (cube.size.x, cube.size.y, cube.size.z) == (0.02, 2.0, 1.0)
    assert (cube.color.r, cube.color.b) == (0.0, 1.0)


def test_a_visual_that_changes_colour_is_recorded_anew_and_the_rest_is_not(rig: Any) -> None:
    rig.step()
    rig.world.advertise("/wall/body/glass/color").publish(ColorRGBA(1.0))
    rig.step()
    rig.step()
    start, change = recorded(rig, SCENE)
    assert len(start.message.entities) == 5
    (glass,) = change.message.entities
    assert (change.t_ns, glass.id, glass.cubes[0].color.r) == (40_000_000, "wall/body/glass", 1.0)


def test_in_an_engine_without_links_a_model_is_a_frame(rig: Any) -> None:
    for _ in range(3):
        rig.step()
    transforms = recorded(rig, TRANSFORMS)
    assert [one.t_ns for one in transforms] == [0, 40_000_000]
    (husky,) = transforms[-1].message.transforms
    assert (husky.header.frame_id, husky.child_frame_id) == ("world", "husky")
    assert husky.transform.translation.x == pytest.approx(0.01, rel=1e-3)


def test_spikes_are_recorded_by_population_with_their_exact_times(rig: Any) -> None:
    rig.step()
    rig.step()
    eyes = recorded(rig, spikes_topic("eyes"))
    wheels = list(Recording(rig.folder).messages({spikes_topic("wheels")}))
    assert [one.message.ids.tolist() for one in eyes] == [[0], [0]]
    assert [one.message.ids.tolist() for one in wheels] == [[1], [1]]
    np.testing.assert_allclose(np.concatenate([one.message.times_ms for one in eyes]), [14.5, 34.5])
    assert [one.message.times_ms.tolist() for one in wheels] == [[20.0], [40.0]]


def test_a_device_is_recorded_when_its_value_changes(rig: Any) -> None:
    topic = device_topic("steer/left", "voltage")
    rig.recorder.step()
    for _ in range(3):
        rig.step()
    voltages = recorded(rig, topic)
    assert [one.t_ns for one in voltages][:2] == [0, 40_000_000]
    about = Recording(rig.folder).topics[topic].about
    assert (about["unit"], about["neurons"], about["role"]) == ("mV", "[3, 4]", Role.SINK)


def test_messages_of_any_publisher_are_recorded_as_they_were_sent(rig: Any) -> None:
    rig.step()
    command = Twist()
    rig.world.add_alias("/glass", GLASS)
    rig.world.advertise("/husky/cmd_vel").publish(command)
    command.linear.x = 9.0
    rig.world.advertise("/glass").publish(ColorRGBA(1.0))
    commands = recorded(rig, "/husky/cmd_vel")
    colours = list(Recording(rig.folder).messages({GLASS}))
    assert [one.message.linear.x for one in commands] == [0.5, 0.0]
    assert [(one.t_ns, one.message) for one in colours] == [(20_000_000, ColorRGBA(1.0))]
    assert Recording(rig.folder).topics[GLASS].role == Role.PUBLISHED


def test_images_are_recorded_at_the_cameras_rate_as_jpeg(rig: Any) -> None:
    for _ in range(5):
        rig.step()
    images = recorded(rig, "/husky/camera/compressed")
    assert [one.t_ns for one in images] == [0, 34_000_000, 68_000_000, 100_000_000]
    assert all(isinstance(one.message, CompressedImage) for one in images)
    assert pixels_of(images[0].message).shape == (2, 2, 3)


def test_exact_images_are_recorded_bit_by_bit(make_rig: Any) -> None:
    rig = make_rig(Images.EXACT)
    rig.step()
    (image,) = recorded(rig, "/husky/camera")
    assert isinstance(image.message, Image)
    assert image.message.data.tolist() == [0] * 12


def test_images_can_be_left_out(make_rig: Any) -> None:
    rig = make_rig(Images.OFF)
    rig.step()
    rig.recorder.close()
    assert not [topic for topic in Recording(rig.folder).topics if "camera" in topic]


def test_hashes_instead_of_images_show_which_images_are_equal(make_rig: Any) -> None:
    rig = make_rig(Images.HASH)
    for _ in range(3):
        rig.step()
    hashes = recorded(rig, "/husky/camera/hash")
    assert "/husky/camera" not in Recording(rig.folder).topics
    assert len(hashes) > 1
    assert {one.message.data for one in hashes} == {xxhash.xxh3_128_hexdigest(bytes(12))}  # all black


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "mono8"])
def test_a_compressed_image_shows_the_same_colours(encoding: str) -> None:
    from nrp_core.recording.images import compress

    channels = 1 if encoding == "mono8" else 3
    pixels = np.full((16, 24, channels), 40, np.uint8)
    pixels[:, :, 0] = 220
    image = Image(height=16, width=24, encoding=encoding, step=24 * channels, data=pixels)
    shown = pixels_of(compress(image)).astype(int)
    np.testing.assert_allclose(shown, pixels_of(image), atol=4)


def test_messages_lie_in_the_order_of_time(rig: Any) -> None:
    for _ in range(10):
        rig.step()
    rig.recorder.close()
    times = [one.t_ns for one in Recording(rig.folder).messages()]
    assert times == sorted(times)
    assert times[-1] == 200_000_000


def test_a_topic_that_is_subscribed_to_later_is_recorded_from_the_next_step_on(make_rig: Any) -> None:
    rig = make_rig()
    rig.step()
    rig.world.subscribe("/husky/odom")
    rig.step()
    rig.step()
    assert [one.t_ns for one in recorded(rig, "/husky/odom")] == [60_000_000]


def test_a_topic_without_a_listener_is_not_recorded(rig: Any) -> None:
    rig.step()
    assert not recorded(rig, "/husky/odom")


def test_closing_removes_the_devices_and_subscriptions_of_the_recorder(rig: Any) -> None:
    devices = len(rig.brain.devices)
    rig.recorder.close()
    rig.recorder.close()
    assert len(rig.brain.devices) == devices - 1
    rig.world.advertise("/husky/cmd_vel").publish(Twist())
    assert "/husky/cmd_vel" not in Recording(rig.folder).topics


def test_steps_before_an_engine_failure_are_on_disk(rig: Any) -> None:
    rig.step()
    rig.brain.run_until(40_000_000)

    def explode(steps: int) -> None:
        raise ZeroDivisionError

    rig.world.engine._do_advance = explode
    with pytest.raises(SimulationError):
        rig.world.run_until(40_000_000)
    rig.recorder.close()
    recording = Recording(rig.folder)
    assert recording.complete
    assert [one.t_ns for one in recording.messages({"/husky/cmd_vel"})] == [20_000_000]


@dataclass
class Odd:
    """A message that no recording can hold."""

    values: dict[str, float] = field(default_factory=dict)


def test_a_message_that_cannot_be_recorded_is_a_warning_and_stops_nothing(rig: Any) -> None:
    rig.world.declare("/odd", Odd)
    for _ in range(2):
        rig.world.advertise("/odd").publish(Odd())
        rig.step()
    assert len(recorded(rig, "/husky/cmd_vel")) == 2
    (warning,) = rig.recorder.warnings
    assert (warning.code, warning.subject) == (Code.NRP284, "/odd")
    assert warning.message.startswith("/odd is not recorded: Odd")


def test_a_full_disk_is_one_clear_error(rig: Any, monkeypatch: pytest.MonkeyPatch, golden: Golden) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(McapFile, "write", full)
    monkeypatch.setattr(McapFile, "is_due", lambda *_: True)
    with golden.raises(SimulationError):
        rig.step()
    rig.recorder.close()


def test_an_error_in_the_writing_thread_is_raised_by_the_next_step(
    rig: Any, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    def break_down(*_: object) -> None:
        raise RuntimeError("no such thing")

    monkeypatch.setattr(McapFile, "write", break_down)
    monkeypatch.setattr(McapFile, "is_due", lambda _, after_s=None: after_s is not None)

    def go_on() -> None:
        for _ in range(200):
            rig.step()
            time.sleep(0.02)

    with golden.raises(RuntimeError):
        go_on()
    rig.recorder.close()


def test_the_file_is_flushed_by_wall_time(tmp_path: Path) -> None:
    times = iter([0.0, 0.2, 0.8, 1.2, 1.2, 1.6, 4.0, 4.0])
    file = McapFile(tmp_path / MCAP_NAME, clock=lambda: next(times) * FLUSH_S)
    file.announce("/a", file.codec.name(Twist), {})
    sizes = []
    for _ in range(5):
        file.write("/a", 0, (file.codec.encode(Twist()),))
        if file.is_due():
            file.flush()
        sizes.append((tmp_path / MCAP_NAME).stat().st_size)
    assert sizes[0] == sizes[1] < sizes[2] == sizes[3] < sizes[4]
    file.close()


def test_a_kill_in_the_middle_of_writing_leaves_what_was_flushed(tmp_path: Path) -> None:
    program = textwrap.dedent("""
        import os, signal, sys
        from pathlib import Path
        from nrp_core.recording.writing.writer import FLUSH_S, McapFile
        from nrp_core.messages.geometry_msgs import Twist
        file = McapFile(Path(sys.argv[1]))
        file.announce("/a", file.codec.name(Twist), {})
        for k in range(1000):
            file.write("/a", k, (file.codec.encode(Twist()),))
            if k == 900:
                file.flush()
        os.kill(os.getpid(), signal.SIGKILL)
    """)
    path = tmp_path / MCAP_NAME
    died = subprocess.run([sys.executable, "-c", program, str(path)], check=False)
    assert died.returncode == -9
    recording = Recording(path)
    assert not recording.complete
    assert [one.t_ns for one in recording.messages()] == list(range(901))
