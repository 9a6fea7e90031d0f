"""The entry point: the capabilities of the backend. Importing it does not load ROS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar

from nrp_core.errors import BackendLoadError
from nrp_core.simulation import Determinism
from nrp_core.world import Diagnosis, Engine, Scene, TopicInfo, WorldBackend, WorldCapabilities, WorldOptions

from nrp_world_ros import ros1
from nrp_world_ros.options import RosOptions, Simulator, TimeSource
from nrp_world_ros.ros2.node import INSTALL, load_rclpy


class RosBackend(WorldBackend):
    """The body is any subscriber of the topics: a robot, Gazebo, another process of this platform."""

    interface_version = 2
    options: ClassVar[type[WorldOptions]] = RosOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, RosOptions)
        if options.body is not None:
            simulator = Simulator.named(options.body, options.body_options)
            return replace(simulator.capabilities, releases_gil=True)
        is_bag = options.bag is not None
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.BITWISE if is_bag else Determinism.STATISTICAL,
            releases_gil=not is_bag,
            ball_joints=True,
            loops=True,
            coupled_joints=True,
            own_scene=True,
            real_time=options.time is not TimeSource.LOCKSTEP and not is_bag,
        )

    def topics(self, options: WorldOptions) -> Sequence[TopicInfo]:
        assert isinstance(options, RosOptions)
        if options.bag is None:
            return ()
        from nrp_world_ros.bag import Bag

        with Bag(options.bag) as bag:
            return list(bag.topics.values())

    def diagnose(self) -> list[Diagnosis]:
        found = [
            _look("ROS 1", "rospy", ros1.load_rospy, ros1.INSTALL),
            _look("ROS 2", "rclpy", load_rclpy, INSTALL),
        ]
        none = not any(each.present for each in found)  # one of the two suffices
        return [replace(each, needed=none) for each in found]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_ros.engine import RosEngine

        assert isinstance(options, RosOptions)
        capabilities = self.capabilities(options)
        if options.body is not None:
            from nrp_world_ros.hosted.engine import HostedEngine

            return HostedEngine(scene, seed, capabilities, options)
        if options.bag is not None:
            from nrp_world_ros.bag import BagEngine

            return BagEngine(scene, seed, capabilities, options)
        return RosEngine(scene, seed, capabilities, options)


def _look(ros: str, library: str, load: Callable[[], object], remedy: str) -> Diagnosis:
    try:
        load()
    except BackendLoadError as error:
        return Diagnosis(ros, False, f"{library} cannot be loaded: {error.__cause__}", remedy)
    return Diagnosis(ros, True, f"{library} is installed", remedy)
