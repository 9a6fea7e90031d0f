"""What can be asked of a world while it runs, on both engines: states, models that come and go, looks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError, TopicError
from nrp_core.messages.base import Duration
from nrp_core.messages.gazebo_msgs import LinkState, ModelState
from nrp_core.messages.gazebo_srvs import DeleteModelRequest, GetModelStateRequest
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Twist, Vector3, Wrench
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.model import Box, Light, Scene, Sphere
from nrp_core.scene.rigid import ModelMotion
from nrp_core.scene.rigid import Pose as ScenePose
from nrp_core.scene.sdf import read_scene
from nrp_core.world.sensors.laser import Laser

SPHERE = """
<sdf version="1.6"><model name="any"><link name="link">
  <inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>
  <collision name="c"><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>
  <visual name="v"><geometry><sphere><radius>0.2</radius></sphere></geometry>
    <material><script><name>Gazebo/Red</name></script></material></visual>
</link></model></sdf>"""


def room(parts, *more):
    box = parts.prop("box", Box((0.3, 0.3, 0.3)), ScenePose((2.0, 1.0, 0.15)), mass=2.0)
    return Scene((parts.floor(), parts.wall(4.0), box, parts.husky(), *more), (Light("sun"),))


@pytest.fixture
def world(open_world, parts):
    return open_world(room(parts))


def position(world, model: str):
    answer = world.call("/gazebo/get_model_state", model)
    assert answer.success, answer.status_message
    return np.array([answer.pose.position.x, answer.pose.position.y, answer.pose.position.z])


def at(x: float, y: float, z: float) -> Pose:
    return Pose(Point(x, y, z))


# -- states


def test_a_model_can_be_put_somewhere_and_thrown(world, advance):
    advance(world, 0.2)
    thrown = ModelState("box", at(0.0, 3.0, 2.0), Twist(Vector3(1.0, 0.0, 2.0)))
    assert world.call("/gazebo/set_model_state", thrown).success
    assert position(world, "box") == pytest.approx([0.0, 3.0, 2.0])
    advance(world, 0.1)
    assert position(world, "box") == pytest.approx([0.1, 3.0, 2.0 + 0.2 - 0.049], abs=2e-3)


def test_a_robot_stands_where_it_was_put_and_drives_on_from_there(world, driver, advance):
    driver(world).drive(0.5, 0.0, 0.4)
    turned = Pose(Point(-1.0, 2.0, 0.14275), Quaternion(0.0, 0.0, 1.0, 1.0))
    world.call("/gazebo/set_model_state", ModelState("husky", turned))
    pose = driver(world).drive(0.5, 0.0, 1.0)
    assert pose.position[:2] == pytest.approx((-1.0, 2.5), abs=0.02)


def test_static_models_can_be_moved_too(world, parts, advance):
    advance(world, 0.1)
    world.call("/gazebo/set_model_state", ModelState("wall", at(-3.0, 0.0, 1.0)))
    assert position(world, "wall") == pytest.approx([-3.0, 0.0, 1.0])
    assert np.allclose(position(world, "husky")[:2], 0.0, atol=1e-3)
    advance(world, 0.1)
    world.reset()
    assert position(world, "wall") == pytest.approx([4.1, 0.0, 1.0])


def test_states_can_be_reported_relative_to_another_model(world):
    turned = Pose(Point(1.0, 1.0, 0.14275), Quaternion(0.0, 0.0, 1.0, 1.0))
    world.call("/gazebo/set_model_state", ModelState("husky", turned))
    state = world.call("/gazebo/get_model_state", "box", "husky")
    assert (state.pose.position.x, state.pose.position.y) == pytest.approx((0.0, -1.0), abs=1e-6)
    world.call("/gazebo/set_model_state", ModelState("box", at(2.0, 0.0, 0.1), Twist(), "husky"))
    assert position(world, "box") == pytest.approx([1.0, 3.0, 0.24275], abs=1e-6)


def test_links_and_joints_report_their_state(world, driver):
    driver(world).drive(0.5, 0.0, 0.5)
    state = world.call("/gazebo/get_link_state", "husky::eye", "world").link_state
    assert state.pose.position.x == pytest.approx(position(world, "husky")[0] - 0.16, abs=1e-3)
    assert state.twist.linear.x == pytest.approx(0.5, abs=0.02)
    joint = world.call("/gazebo/get_joint_properties", "husky::front_left")
    assert joint.rate[0] == pytest.approx(0.5 / 0.17775, rel=0.1)


def test_the_base_link_can_be_put_somewhere_and_others_cannot(world):
    assert world.call("/gazebo/set_link_state", LinkState("box::link", at(0, -2, 1))).success
    assert position(world, "box") == pytest.approx([0.0, -2.0, 1.0])
    refused = world.call("/gazebo/set_link_state", LinkState("husky::eye", at(0, 0, 1)))
    assert not refused.success
    assert "base_link" in refused.status_message


def test_joints_can_be_put_at_positions(open_world, parts):
    world = open_world(parts.hanging("revolute", (0, 1, 0)))
    world.call("/gazebo/set_model_configuration", "hanging", "", ["joint"], [0.7])
    assert world.joint_states("hanging").positions == pytest.approx([0.7])
    assert world.call(
        "/gazebo/get_link_state", "hanging::bob"
    ).link_state.pose.orientation.y == pytest.approx(np.sin(0.35))


NESTED = """<sdf version="1.9"><world name="w"><gravity>0 0 0</gravity>
  <model name="cart"><link name="frame">{inertial}</link>
    <model name="arm"><pose>0 0 1 0 0 0</pose><link name="a">{inertial}</link>
      <model name="hand"><pose>0.5 0 0 0 0 0</pose><link name="b">{inertial}</link></model>
      <joint name="j" type="revolute"><parent>a</parent><child>hand::b</child>
        <axis><xyz>0 0 1</xyz></axis></joint></model>
    <joint name="fix" type="fixed"><parent>frame</parent><child>arm::a</child></joint></model>
  <model name="other"><pose>5 0 0 0 0 0</pose><link name="a">{inertial}</link></model></world></sdf>"""
INERTIAL = "<inertial><mass>1</mass></inertial>"


@pytest.fixture
def nested(open_world, tmp_path):
    file = tmp_path / "nested.sdf"
    file.write_text(NESTED.format(inertial=INERTIAL))
    return open_world(read_scene(file))


@pytest.mark.parametrize("name", ["cart::arm::hand::b", "cart/arm/hand/b", "arm::hand::b", "b"])
def test_links_of_nested_models_have_the_names_of_gazebo(nested, advance, name):
    state = nested.call("/gazebo/get_link_state", name, "cart::arm::a").link_state
    place = state.pose.position
    assert (place.x, place.y, place.z) == pytest.approx((0.5, 0.0, 0.0), abs=1e-6)
    push = Wrench(Vector3(0.0, 0.0, 3.0))
    assert nested.call("/gazebo/apply_body_wrench", name, wrench=push, duration=Duration(-1)).success
    advance(nested, 0.2)
    nested.call("/gazebo/clear_body_wrenches", name)
    assert nested.call("/gazebo/get_link_state", name).link_state.twist.linear.z > 0.1
    assert not nested.warnings


@pytest.mark.parametrize("name", ["cart::arm::j", "cart/arm/j", "arm::j", "j"])
def test_joints_of_nested_models_have_the_names_of_gazebo(nested, name):
    assert nested.call("/gazebo/set_model_configuration", "cart", "", [name], [0.5]).success
    assert nested.call("/gazebo/get_joint_properties", name).position == pytest.approx([0.5])
    assert nested.call("/gazebo/apply_joint_effort", name, 1.0, duration=Duration(-1)).success
    nested.call("/gazebo/clear_joint_forces", name)
    assert not nested.warnings


def test_a_link_that_several_models_have_or_none_has_is_refused(nested, golden: Golden):
    for name in ("a", "cart::arm::c", "card::arm::a", "cart::hand::a"):
        golden(nested.call("/gazebo/get_link_state", name).status_message)
    state = LinkState("other::a", at(0, -2, 1))
    assert nested.call("/gazebo/set_link_state", state).success
    assert position(nested, "other") == pytest.approx([0.0, -2.0, 1.0])


@pytest.mark.parametrize("position", [float("nan"), float("inf")])
def test_a_joint_position_that_is_not_a_number_is_refused(
    open_world, parts, advance, position, golden: Golden
):
    world = open_world(parts.hanging("continuous", (0, 1, 0)))
    answer = world.call("/gazebo/set_model_configuration", "hanging", "", ["joint"], [position])
    assert answer.status_message == f"the joint 'joint' of 'hanging' cannot be set to {position}"
    advance(world, 0.1)
    with golden.raises(SceneError, match="'hanging'.*'joynt'.*'joint'"):
        world.set_joints("hanging", {"joynt": 0.0})


def test_a_model_pose_that_is_not_a_number_is_refused(world, advance, golden: Golden):
    with golden.raises(SceneError, match="'box'"):
        world.place("box", ModelMotion(ScenePose((0.0, float("nan"), 1.0))))
    advance(world, 0.1)


# -- models that come and go


def test_a_spawned_model_may_have_any_name(world):
    for name in ("a/b", "x" * 300, "\N{SNOWMAN} with blanks"):
        assert world.call("/gazebo/spawn_sdf_entity", name, SPHERE, "", at(0.0, -3.0, 2.0)).success
        assert world.call("/gazebo/delete_model", name).success


def test_a_model_can_be_spawned_and_deleted(world, advance):
    advance(world, 0.1)
    before = position(world, "box")
    assert world.call("/gazebo/spawn_sdf_entity", "ball", SPHERE, "", at(0.0, -3.0, 2.0)).success
    assert np.array_equal(position(world, "box"), before)
    advance(world, 2.0)
    assert position(world, "ball") == pytest.approx([0.0, -3.0, 0.2], abs=0.02)
    assert "/ball/link/v/color" in world.topics
    assert world.call("/gazebo/get_world_properties").model_names[-1] == "ball"
    world.call("/gazebo/delete_model", "ball")
    assert "/ball/link/v/color" not in world.topics
    assert not world.call("/gazebo/get_model_state", "ball").success
    advance(world, 0.1)


def test_a_robot_spawned_while_others_drive_does_not_disturb_them(open_world, parts, driver):
    alone, disturbed = open_world(room(parts)), open_world(room(parts))
    for world in (alone, disturbed):
        driver(world).drive(0.6, 0.4, 0.5)
    disturbed.spawn(parts.husky("second", ScenePose((0.0, -3.0, parts.standing))))
    poses = [driver(world).drive(0.6, 0.4, 1.0) for world in (alone, disturbed)]
    assert poses[0].position == pytest.approx(poses[1].position, abs=1e-3)
    driven = driver(disturbed, "second").drive(0.5, 0.0, 1.0)
    assert driven.position[0] == pytest.approx(0.5, abs=0.02)


def test_spawned_models_are_seen_by_cameras_and_lasers(open_world, parts, advance):
    laser = Laser("laser", "/scan", 50.0, samples=1, angle_min=0.0, angle_max=0.0)
    husky = parts.husky()
    eye = replace(husky.links[1], sensors=(*husky.links[1].sensors, laser))
    world = open_world(Scene((parts.floor(), replace(husky, links=(husky.links[0], eye, *husky.links[2:])))))
    scans, images = world.subscribe("/scan"), world.subscribe("/husky/camera")
    advance(world, 0.1)
    assert scans.latest.message.ranges[0] == np.inf
    before = images.latest.message.data
    red = (1.0, 0.0, 0.0, 1.0)
    world.spawn(parts.prop("ball", Sphere(0.3), ScenePose((2.0, 0.0, 0.5)), rgba=red))
    advance(world, 0.1)
    assert scans.latest.message.ranges[0] == pytest.approx(2.0 + 0.16 - 0.3, abs=0.02)
    seen = images.latest.message.data
    assert not np.array_equal(seen, before)
    assert (seen == (255, 0, 0)).all(axis=2).any()


def test_colours_and_commands_outlive_a_change_of_the_scene(open_world, parts, advance):
    world = open_world(room(parts))
    world.advertise("/wall/link/visual/color").publish(ColorRGBA(1.0, 0.0, 0.0, 1.0))
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(0.5)))
    advance(world, 0.04)
    world.spawn(parts.prop("ball", Sphere(0.1), ScenePose((0.0, -3.0, 0.1)), mass=1.0))
    image = world.engine.render("husky", "eye", "camera")
    assert (image == (255, 0, 0)).all(axis=2).any()
    advance(world, 0.04)
    assert world.model_motion("husky").linear[0] == pytest.approx(0.5, rel=0.05)
    advance(world, 0.5)  # the time-out of the command still counts
    assert world.model_motion("husky").linear[0] == pytest.approx(0.0, abs=0.02)


def test_snapshots_hold_what_was_spawned_and_what_was_deleted(open_world, parts, advance):
    def seen(world):
        return {m.name: world.model_motion(m.name) for m in world.scene.models if not m.static}

    world, fresh = open_world(room(parts)), open_world(room(parts))
    world.delete("box")
    world.spawn(parts.prop("ball", Sphere(0.2), ScenePose((0.0, 3.0, 1.0)), mass=1.0))
    advance(world, 0.3)
    snapshot = world.snapshot()
    advance(world, 0.4)
    expected = seen(world)
    assert set(expected) == {"ball", "husky"}
    world.delete("ball")
    for again in (world, fresh):
        again.restore(snapshot)
        advance(again, 0.4)
        assert seen(again) == expected


def test_a_reset_brings_back_what_was_deleted_and_forgets_what_was_spawned(open_world, parts, advance):
    fresh, world = open_world(room(parts)), open_world(room(parts))
    world.delete("box")
    world.spawn(parts.prop("ball", Sphere(0.2), ScenePose((0.0, 3.0, 1.0)), mass=1.0))
    advance(world, 0.3)
    world.reset()
    for each in (fresh, world):
        advance(each, 0.3)
    assert [model.name for model in world.scene.models] == ["floor", "wall", "box", "husky"]
    assert world.model_motion("box") == fresh.model_motion("box")
    assert world.model_motion("husky") == fresh.model_motion("husky")


def test_a_subscriber_of_a_removed_model_receives_messages_when_it_returns(
    open_world, parts, advance, golden: Golden
):
    world = open_world(room(parts))
    heard = world.subscribe("/husky/odom", depth=1000)
    commands = world.advertise("/husky/cmd_vel")
    advance(world, 0.1)
    world.delete("husky")
    advance(world, 0.1)
    silent = len(heard.since(-1))
    with golden.raises(TopicError):
        commands.publish(Twist())
    world.spawn(parts.husky())
    advance(world, 0.1)
    assert len(heard.since(-1)) > silent == len([s for s in heard.since(-1) if s.t_ns <= 100_000_000])
    commands.publish(Twist())


def test_two_models_of_one_name_and_nonsense_are_refused_and_change_nothing(
    world, parts, advance, golden: Golden
):
    before = [model.name for model in world.scene.models]
    with golden.raises(SceneError, match="'box'"):
        world.spawn(parts.prop("box", Sphere(0.1), mass=1.0))
    answer = world.call("/gazebo/spawn_sdf_model", "thing", "<sdf version='1.6'><model")
    assert not answer.success
    with golden.raises(SceneError, match="'box'"):
        world.delete("bax")
    assert [model.name for model in world.scene.models] == before
    advance(world, 0.1)


# -- looks


def test_a_visual_gets_another_material_or_colour(world, advance):
    colors = world.subscribe("/wall/link/visual/color")
    world.call(
        "/gazebo/set_visual_properties", "wall", "link", "visual", "material:script:name", "Gazebo/GreenGlow"
    )
    assert colors.latest.message == ColorRGBA(0.0, 1.0, 0.0, 1.0)
    world.call("/gazebo/set_visual_properties", "wall", "link", "visual", "material:diffuse", "0 0 1 1")
    assert colors.latest.message == ColorRGBA(0.0, 0.0, 1.0, 1.0)
    wrong = world.call("/gazebo/set_visual_properties", "wall", "link", "visul", "", "Red")
    assert "did you mean" in wrong.status_message


def test_lights_can_be_asked_for_changed_and_taken_out(world):
    assert world.call("/gazebo/get_lights_name").light_names == ["sun"]
    world.call("/gazebo/set_light_properties", "sun", ColorRGBA(0.5, 0.4, 0.3, 1.0))
    assert world.call("/gazebo/get_light_properties", "sun").diffuse == ColorRGBA(0.5, 0.4, 0.3, 1.0)
    world.call("/gazebo/delete_light", "sun")
    assert world.call("/gazebo/get_lights_name").light_names == []
    world.reset()
    assert world.call("/gazebo/get_light_properties", "sun").diffuse == ColorRGBA(1.0, 1.0, 1.0, 1.0)


# -- time


def test_while_paused_time_goes_on_but_nothing_moves(world, driver, advance):
    driver(world).drive(0.5, 0.0, 0.4)
    before, now = world.model_motion("husky"), world.now_ns
    world.call("/gazebo/pause_physics")
    advance(world, 0.4)
    assert world.model_motion("husky") == before
    assert world.now_ns == now + 400_000_000
    world.call("/gazebo/unpause_physics")
    advance(world, 0.02)
    assert world.model_motion("husky") != before


def test_reset_world_brings_everything_home_while_time_goes_on(world, driver, advance):
    driver(world).drive(0.5, 0.5, 1.0)
    advance(world, 0.2)
    world.call("/gazebo/set_model_state", ModelState("wall", at(-3.0, 0.0, 1.0)))
    now = world.now_ns
    world.call("/gazebo/reset_world")
    assert world.now_ns == now
    assert position(world, "husky") == pytest.approx([0.0, 0.0, 0.14275], abs=1e-6)
    assert position(world, "wall") == pytest.approx([4.1, 0.0, 1.0])
    assert world.joint_states("husky").velocities == pytest.approx(np.zeros(4), abs=1e-9)
    advance(world, 1.0)
    assert position(world, "husky")[:2] == pytest.approx([0.0, 0.0], abs=0.01)


def test_reset_simulation_starts_everything_over_while_time_goes_on(world, parts, driver):
    def driven():
        driver(world).drive(0.5, 0.5, 0.5)
        return [world.model_motion(name) for name in ("husky", "box")]

    first, now = driven(), world.now_ns
    world.spawn(parts.prop("ball", Sphere(0.2), ScenePose((2.0, 0, 1.0)), mass=1.0))
    world.delete("wall")
    world.call("/gazebo/delete_light", "sun")
    world.engine.set_color("box/link/visual", (0.0, 0.0, 1.0, 1.0))
    world.call("/gazebo/apply_body_wrench", "box::link", wrench=Wrench(Vector3(50.0)), duration=Duration(-1))
    driven()
    world.call("/gazebo/reset_simulation")
    assert world.now_ns == 2 * now
    assert [model.name for model in world.scene.models] == ["floor", "wall", "box", "husky"]
    assert world.call("/gazebo/get_lights_name").light_names == ["sun"]
    assert driven() == first


def test_a_robot_that_was_commanded_stands_still_after_reset_simulation(world, driver, advance):
    driver(world).drive(0.5, 0.5, 0.5)
    world.call("/gazebo/reset_simulation")
    advance(world, 0.2)
    assert position(world, "husky")[:2] == pytest.approx([0.0, 0.0], abs=1e-3)


# -- the calls themselves


def test_a_service_is_a_topic_as_well(world, advance):
    seen = []
    world.add_observer(lambda topic, stamped: seen.append(topic))
    world.advertise("/gazebo/delete_model").publish(DeleteModelRequest("box"))
    assert [model.name for model in world.scene.models] == ["floor", "wall", "husky"]
    world.advertise("/gazebo/delete_model").publish(DeleteModelRequest("box"))
    assert "no model 'box'" in str(world.warnings[-1])
    world.call("/gazebo/get_model_state", GetModelStateRequest("husky"))
    assert seen == ["/gazebo/delete_model", "/gazebo/delete_model", "/gazebo/get_model_state"]
    advance(world, 0.1)


def test_an_unknown_service_or_a_wrong_request_is_refused(world, golden: Golden):
    with golden.raises(TopicError, match="'/gazebo/get_model_state'"):
        world.call("/gazebo/get_model_stat")
    with pytest.raises(TopicError, match="model_nam"):
        world.call("/gazebo/get_model_state", model_nam="box")
    with golden.raises(TopicError, match="model_name"):
        world.call("/gazebo/get_model_state", 3)
    missing = world.call("/gazebo/get_model_state", "bax")
    assert (missing.success, "did you mean 'box'" in missing.status_message) == (False, True)


def test_motions_seen_from_a_moving_frame_come_back_as_they_were():
    from hypothesis import given
    from hypothesis import strategies as st

    from nrp_core.world.model_states import relative_motion, world_motion

    numbers = st.tuples(*[st.floats(-3, 3)] * 3)
    poses = st.builds(lambda p, a: ScenePose.from_rpy(p, *a), numbers, numbers)
    motions = st.builds(ModelMotion, poses, numbers, numbers)

    @given(motions, motions)
    def comes_back(frame, motion):
        again = world_motion(frame, relative_motion(frame, motion))
        assert again.pose.position == pytest.approx(motion.pose.position, abs=1e-6)
        assert again.linear == pytest.approx(motion.linear, abs=1e-6)
        assert again.angular == pytest.approx(motion.angular, abs=1e-6)

    comes_back()


def test_moving_a_model_does_not_disturb_drives_and_a_later_snapshot_continues(
    open_world, parts, driver, advance
):
    box = parts.prop("box", Box((0.3, 0.3, 0.3)), ScenePose((0.0, 5.0, 0.15)), mass=2.0)
    world, alone = (
        open_world(parts.floor(), box, parts.husky()),
        open_world(parts.floor(), box, parts.husky()),
    )
    for step in range(10):
        world.call("/gazebo/set_model_state", ModelState("box", at(0.1 * step, 5.0, 0.15)))
        for each in (world, alone):
            driver(each).drive(0.2 * (-1) ** step, 0.0, 0.1)
    assert position(world, "husky") == pytest.approx(position(alone, "husky"), abs=1e-6)
    world.call("/gazebo/set_model_state", ModelState("husky", at(0.0, 0.0, 0.14275)))
    middle = world.snapshot()
    driver(world).drive(0.8, 0.0, 0.3)
    end = world.model_motion("husky")
    world.restore(middle)
    driver(world).drive(0.8, 0.0, 0.3)
    assert world.model_motion("husky") == end


def test_a_spawned_robot_obeys_its_first_command_at_once(open_world, parts, driver, advance):
    world = open_world(parts.floor())
    advance(world, 0.1)
    world.spawn(parts.husky())
    pose = driver(world).drive(0.5, 0.0, 1.0)
    assert pose.position[0] == pytest.approx(0.5, abs=1e-3)


def test_a_light_is_spawned_like_a_model_and_deleted(world):
    lamp = '<sdf version="1.6"><light name="any" type="spot"><direction>1 0 0</direction></light></sdf>'
    turned = Pose(Point(0.0, 1.0, 2.0), Quaternion(0.0, 0.0, 1.0, 1.0))
    assert world.call("/gazebo/spawn_sdf_model", "lamp", lamp, "", turned).success
    light = world.scene.lights[-1]
    assert (light.name, light.kind, light.pose.position) == ("lamp", "spot", (0.0, 1.0, 2.0))
    assert light.direction == pytest.approx((0.0, 1.0, 0.0))
    again = world.call("/gazebo/spawn_sdf_model", "lamp", lamp, "", turned)
    assert again.status_message == "the scene already has a light 'lamp'"
    assert world.call("/gazebo/delete_light", "lamp").success
    assert world.call("/gazebo/get_lights_name").light_names == ["sun"]
