"""Recordings as objects of pandas and Neo: the numbers are those that were sent."""

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.messages.geometry_msgs import WrenchStamped
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import Imu, JointState, PointCloud2, PointField
from nrp_core.messages.std_msgs import Float64MultiArray, MultiArrayDimension, MultiArrayLayout
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, spikes_topic
from nrp_core.recording.reading.tables import number_values, numbers_in, values_in
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal

STEPS = 10
RUN = {
    "experiment": "driving",
    "brain": {"populations": {"eyes": {"size": 3}, "wheels": {"size": 2}}},
    "result": {"events": {"late": 2.5, "never": None, "early": 0.5}},
}


@pytest.fixture
def recording(rig: Any) -> Recording:
    """Ten steps of 20 ms with a command, and a spike of the first eye and the last wheel in each."""
    for number in range(STEPS):
        rig.step(forward=0.1 * number, turn=0.2)
    rig.recorder.close()
    (rig.folder / RUN_NAME).write_bytes(seal(RUN))
    return Recording(rig.folder)


def test_a_topic_is_a_frame_over_simulated_time_with_units(recording: Recording) -> None:
    frame = recording.frame("/husky/cmd_vel")
    np.testing.assert_allclose(frame.index, 0.02 * np.arange(1, STEPS + 1))
    assert frame.index.name == "time_s"
    np.testing.assert_allclose(frame["linear.x"], 0.1 * np.arange(STEPS))
    assert set(frame["angular.z"]) == {0.2}
    units = frame.attrs["units"]
    assert (units["linear.x"], units["angular.z"]) == ("m/s", "rad/s")
    assert list(units) == list(frame.columns)


def test_models_and_devices_have_their_names_and_units(recording: Recording) -> None:
    models = recording.frame("/gazebo/model_states")
    assert models["pose.husky.position.x"].is_monotonic_increasing
    assert models.attrs["units"]["pose.husky.position.x"] == "m"
    assert models.attrs["units"]["twist.husky.linear.x"] == "m/s"
    assert recording.frame("/brain/devices/steer/left/voltage").attrs["units"] == {"data": "mV"}


def test_all_numbers_are_a_dataset_with_units_over_the_times_of_their_topics(recording: Recording) -> None:
    data = recording.to_xarray()
    speed = data["husky.cmd_vel.linear.x"]
    frame = recording.frame("/husky/cmd_vel")
    np.testing.assert_array_equal(speed, frame["linear.x"])
    np.testing.assert_array_equal(speed[speed.dims[0]], frame.index)
    assert speed.attrs["units"] == "m/s"
    assert data[speed.dims[0]].attrs["units"] == "s"
    assert data["brain.devices.steer.left.voltage.data"].attrs["units"] == "mV"
    assert data.attrs["experiment"] == "driving"
    assert speed.attrs["topic"] == "/husky/cmd_vel"
    assert not any("/" in str(name) for name in data.variables)  # NetCDF refuses these names
    models = recording.frame("/gazebo/model_states")
    x_m = data["gazebo.model_states.pose.husky.position.x"]
    np.testing.assert_array_equal(x_m, models["pose.husky.position.x"])


def test_items_of_arrays_have_the_names_that_the_message_gives_them() -> None:
    joints = JointState(name=["hip", "knee"], position=np.array([0.5, -1.0]))
    assert {one.path: one.value for one in values_in(joints)} == {"position.hip": 0.5, "position.knee": -1.0}


def test_numbers_in_arrays_have_the_names_of_their_topic_or_of_the_axes_of_their_layout() -> None:
    controls = Float64MultiArray(data=np.array([0.25, 0.5]))
    assert dict(numbers_in(controls)) == {"data.0": 0.25, "data.1": 0.5}
    named = [one.path for one in number_values(controls, ["flexor", "extensor"])]
    assert named == ["data.flexor", "data.extensor"]
    assert [one.path for one in number_values(controls, ["flexor"])] == ["data.0", "data.1"]
    axes = [MultiArrayDimension("row", 2, 4), MultiArrayDimension("", 2, 2)]
    table = Float64MultiArray(MultiArrayLayout(axes), np.arange(4.0))
    assert list(dict(numbers_in(table))) == ["data.row0.0", "data.row0.1", "data.row1.0", "data.row1.1"]
    axes[0].size = 3
    assert list(dict(numbers_in(table))) == ["data.0", "data.1", "data.2", "data.3"]


def test_covariances_bytes_and_lists_of_messages_are_not_numbers() -> None:
    assert not any("covariance" in path for path, _ in numbers_in(Odometry()))
    assert not any("covariance" in path for path, _ in numbers_in(Imu()))
    cloud = PointCloud2(data=np.zeros(16, np.uint8), fields=[PointField(name="x")])
    assert {path.split(".")[0] for path, _ in numbers_in(cloud)}.isdisjoint({"data", "fields"})


def test_units_are_those_of_the_definitions_of_ros() -> None:
    units = {one.path: one.unit for message in (WrenchStamped(), Imu()) for one in number_values(message)}
    assert units["wrench.torque.z"] == "N m"
    assert (units["angular_velocity.x"], units["linear_acceleration.x"]) == ("rad/s", "m/s^2")
    assert units["orientation.x"] == ""


def test_an_unknown_topic_is_refused_with_the_nearest_name(recording: Recording, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=r"\{'/husky/cmd_vel'\}"):
        next(recording.messages("/husky/cmd_vel"))
    assert next(recording.messages({"/husky/cmd_vel"})).topic == "/husky/cmd_vel"
    with golden.raises(ExperimentError, match="'/husky/cmd_val'.*'/husky/cmd_vel'"):
        recording.frame("/husky/cmd_val")
    with golden.raises(ExperimentError):
        recording.frame(spikes_topic("eyes"))
    with golden.raises(ExperimentError):
        recording.frame("/husky/camera/compressed")


def test_spikes_are_trains_of_every_neuron_with_units(recording: Recording) -> None:
    segment = recording.spikes()
    assert segment.name == "driving"
    eyes = segment.filter(population="eyes", objects="SpikeTrain")
    assert [(train.annotations["neuron"], len(train)) for train in eyes] == [(0, STEPS), (1, 0), (2, 0)]
    np.testing.assert_allclose(eyes[0].rescale("s").magnitude, 0.02 * np.arange(1, STEPS + 1) - 0.0055)
    _, wheel = segment.filter(population="wheels", objects="SpikeTrain")
    assert wheel.t_stop.rescale("ms").item() == 200.0 == wheel.magnitude[-1]


def test_spikes_of_a_file_by_itself_are_those_of_the_neurons_that_fired(
    recording: Recording, tmp_path: Path
) -> None:
    alone = tmp_path / "alone" / MCAP_NAME
    alone.parent.mkdir()
    alone.write_bytes(recording.file.read_bytes())
    trains = Recording(alone).spikes().spiketrains
    assert [(t.annotations["population"], len(t)) for t in trains] == [
        ("eyes", STEPS), ("wheels", 0), ("wheels", STEPS)
    ]  # fmt: skip


def test_events_are_a_frame_in_the_order_of_time(recording: Recording) -> None:
    times_s = recording.events()["time_s"]
    assert list(times_s.index) == ["early", "late", "never"]
    assert times_s["late"] == 2.5
    assert math.isnan(times_s["never"])


def test_events_of_a_run_that_was_killed_are_refused(recording: Recording, golden: Golden) -> None:
    (recording.folder / RUN_NAME).write_bytes(seal({**RUN, "result": None}))
    with golden.raises(ExperimentError):
        Recording(recording.folder).events()


@pytest.mark.parametrize(
    ("package", "ask"),
    [
        ("pandas", lambda recording: recording.frame("/husky/cmd_vel")),
        ("neo", lambda recording: recording.spikes()),
        ("pandas", lambda recording: recording.events()),
        ("xarray", lambda recording: recording.to_xarray()),
    ],
)
def test_a_missing_package_is_named_with_the_command_that_installs_it(
    recording: Recording, package: str, ask: Callable[[Recording], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(CapabilityError, match=rf"{package}: pip install 'nrp-core\[analysis\]'"):
        ask(recording)
