"""Drives by plugins of Gazebo itself: they get the commands and move the robot; or nrp-core does, alone."""

from math import cos, hypot, pi, sin

import pytest
from golden import Golden
from nrp_world_gazebo import GazeboBackend
from nrp_world_gazebo.own_files import own_sdf
from nrp_world_gazebo.plugin_drives import leave_out, turns_of

from nrp_core.errors import SceneError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.world import Code, Level, Scene, read_model
from nrp_core.world.engine_kit.simulated import simulated_bodies

GROUND = """<sdf version="1.6"><model name="ground"><static>1</static><link name="link">
  <collision name="c"><geometry><plane><normal>0 0 1</normal><size>90 90</size></plane></geometry>
  </collision></link></model></sdf>"""
WHEEL = """
  <link name="{side}"><pose>0 {y} 0.1 -1.5707963 0 0</pose>
    <inertial><mass>1</mass><inertia><ixx>0.003</ixx><iyy>0.003</iyy><izz>0.005</izz></inertia></inertial>
    <collision name="tyre"><geometry><cylinder><radius>0.1</radius><length>0.04</length></cylinder></geometry>
    </collision></link>
  <joint name="{side}_axle" type="revolute"><parent>body</parent><child>{side}</child>
    <axis><xyz>0 0 1</xyz></axis></joint>"""
CART = f"""<sdf version="1.6"><model name="cart">
  <link name="body"><pose>0 0 0.12 0 0 0</pose>
    <inertial><mass>6</mass><inertia><ixx>0.05</ixx><iyy>0.1</iyy><izz>0.12</izz></inertia></inertial>
    <collision name="box"><geometry><box><size>0.4 0.25 0.1</size></box></geometry></collision>
    <collision name="front"><pose>0.17 0 -0.08 0 0 0</pose><geometry><sphere><radius>0.04</radius></sphere>
      </geometry><surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision>
    <collision name="rear"><pose>-0.17 0 -0.08 0 0 0</pose><geometry><sphere><radius>0.04</radius></sphere>
      </geometry><surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision>
  </link>{WHEEL.format(side="left", y=0.15)}{WHEEL.format(side="right", y=-0.15)}
  <plugin name="drive" filename="libDiffDrivePlugin.so">
    <left_joint>left_axle</left_joint><right_joint>right_axle</right_joint><torque>5</torque></plugin>
</model></sdf>"""
OTHER = '<plugin name="spin" filename="libspin.so"><joint>left_axle</joint></plugin></model>'


@pytest.fixture
def read(tmp_path):
    def model(text=CART, name="cart"):
        file = tmp_path / f"{name}.sdf"
        file.write_text(text)
        return read_model(file, name=name)

    return model


def given(model):
    return own_sdf(model, simulated_bodies(model, 0.002, False))


def test_a_drive_of_nrp_core_takes_the_place_of_gazebos_plugin_which_is_noted(read):
    model = read()
    sdf = given(model)
    (note,) = leave_out(model, sdf)
    assert sdf.find(".//plugin") is None
    assert (note.code, note.level, note.line) == (
        Code.NRP376,
        Level.NOTE,
        CART[: CART.index("<plugin")].count("\n") + 1,
    )
    assert "'drive' (libDiffDrivePlugin.so) of 'cart' does not run" in note.message


def test_another_plugin_that_names_a_driven_joint_is_warned_of(read):
    model = read(CART.replace("</model>", OTHER))
    sdf = given(model)
    _, warning = leave_out(model, sdf)
    assert [each.get("name") for each in sdf.iter("plugin")] == ["spin"]
    assert (warning.code, warning.level) == (Code.NRP376, Level.WARNING)
    assert "'spin' (libspin.so) of 'cart' names the joint 'left_axle'" in warning.message
    harmless = read(CART.replace("</model>", OTHER.replace("left_axle", "arm")))
    assert len(list(leave_out(harmless, given(harmless)))) == 1


def test_a_drive_that_is_not_a_plugin_of_gazebo_itself_is_refused_in_plugin_mode(read, golden: Golden):
    model = read()
    assert dict(turns_of(model, given(model))) == {("cart", "drive"): -1.0}
    with golden.raises(SceneError, match="'drive'.*'cart'"):
        dict(turns_of(model, None))
    names = CART.replace("libDiffDrivePlugin", "libgazebo_ros_diff_drive").replace("left_joint", "leftJoint")
    ros = read(names.replace("right_joint", "rightJoint"))
    with golden.raises(SceneError, match="libgazebo_ros_diff_drive.so"):
        dict(turns_of(ros, given(ros)))


def driven(models, drive, forward, turn, seconds=4.0):
    """Return where a second of rest and some seconds of a command bring the cart."""
    backend = GazeboBackend()
    options = backend.options(drive=drive)
    with backend.open(Scene(models), seed=1, options=options) as world:
        commands = world.advertise("/cart/vel_cmd")
        world.run_until(1_000_000_000)
        commands.publish(Twist(Vector3(forward), Vector3(z=turn)))
        world.run_until(1_000_000_000 + round(seconds * 1e9))
        assert [each.code for each in world.warnings] == ([] if drive == "plugin" else [Code.NRP376])
        pose = world.model_motion("cart").pose
        return (*pose.position[:2], pose.yaw)


@pytest.mark.heavy
@pytest.mark.usefixtures("gazebo")
@pytest.mark.parametrize(
    ("drive", "forward", "turn"),
    [("planar", 0.2, -0.3), ("plugin", 0.25, 0.0), ("plugin", 0.0, 0.3)],
)
def test_the_cart_goes_where_a_unicycle_would(read, drive, forward, turn):
    far = 0.01 if drive == "planar" else 0.05
    x, y, yaw = driven((read(GROUND, "ground"), read()), drive, forward, turn)
    angle = 4.0 * turn
    ideal = (forward / turn * sin(angle), forward / turn * (1 - cos(angle))) if turn else (4 * forward, 0)
    assert hypot(x - ideal[0], y - ideal[1]) < far
    assert abs(yaw - angle) < far


@pytest.mark.heavy
@pytest.mark.usefixtures("gazebo")
def test_a_cart_whose_plugin_names_its_wheels_the_other_way_round_turns_left_too(read):
    swapped = CART.replace("<left_joint>left", "<left_joint>RIGHT").replace(
        "<right_joint>right", "<right_joint>left"
    )
    turned = driven((read(GROUND, "ground"), read(swapped.replace("RIGHT", "right"))), "plugin", 0.0, 0.3)
    assert turned[2] == pytest.approx(1.2, abs=0.1)


@pytest.mark.heavy
@pytest.mark.usefixtures("gazebo")
def test_commands_reach_the_plugin_at_once_and_runs_are_equal_to_the_bit(read):
    models = read(GROUND, "ground"), read()
    one, other = (driven(models, "plugin", 0.3, 0.2, 2.0) for _ in range(2))
    assert one == other
    backend = GazeboBackend()
    with backend.open(Scene(models), seed=1, options=backend.options(drive="plugin")) as world:
        world.advertise("/cart/vel_cmd").publish(Twist(Vector3(0.3)))
        world.run_until(2_000_000)  # one physics step
        assert (world.joint_states("cart").velocities > 1.0).all()  # of 3 rad/s


@pytest.mark.heavy
@pytest.mark.usefixtures("gazebo")
def test_a_reset_stops_the_plugin_and_starts_again(read):
    backend = GazeboBackend()
    options = backend.options(drive="plugin")
    with backend.open(Scene((read(GROUND, "ground"), read())), seed=1, options=options) as world:
        commands = world.advertise("/cart/vel_cmd")
        commands.publish(Twist(Vector3(0.5), Vector3()))
        world.run_until(1_000_000_000)
        assert world.model_motion("cart").pose.position[0] > 0.4
        world.reset()
        world.run_until(1_000_000_000)
        assert abs(world.model_motion("cart").pose.position[0]) < 0.01
        assert abs(world.model_motion("cart").pose.yaw) < pi / 180
