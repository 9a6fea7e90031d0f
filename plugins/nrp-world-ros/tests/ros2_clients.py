"""A client of ROS 2 of the robot ``arm``, its controllers and its simulator.

python ros2_clients.py follow      JSON: how trajectories ended
python ros2_clients.py again FILE OTHER    JSON: how goals of a robot end that is deleted, and of robots that
                                           are spawned from a file
python ros2_clients.py grip        JSON: what the gripper did
python ros2_clients.py standard    JSON: what the services answered
"""

import json
import sys
from typing import Any

import rclpy
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.action import ActionClient
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ros2_peer import kind, spin, tell

FollowJointTrajectory = kind("control_msgs/action/FollowJointTrajectory")
GripperCommand = kind("control_msgs/action/GripperCommand")
JointTolerance = kind("control_msgs/msg/JointTolerance")
ListControllers = kind("controller_manager_msgs/srv/ListControllers")
SwitchController = kind("controller_manager_msgs/srv/SwitchController")
EntityState = kind("simulation_interfaces/msg/EntityState")
EntityFilters = kind("simulation_interfaces/msg/EntityFilters")
Resource = kind("simulation_interfaces/msg/Resource")
SimulationState = kind("simulation_interfaces/msg/SimulationState")
DeleteEntity = kind("simulation_interfaces/srv/DeleteEntity")
GetEntities = kind("simulation_interfaces/srv/GetEntities")
GetEntityState = kind("simulation_interfaces/srv/GetEntityState")
GetSimulationState = kind("simulation_interfaces/srv/GetSimulationState")
ResetSimulation = kind("simulation_interfaces/srv/ResetSimulation")
SetEntityState = kind("simulation_interfaces/srv/SetEntityState")
GetSimulatorFeatures = kind("simulation_interfaces/srv/GetSimulatorFeatures")
SetSimulationState = kind("simulation_interfaces/srv/SetSimulationState")
SpawnEntity = kind("simulation_interfaces/srv/SpawnEntity")


class Client:
    """Calls services and actions, one after the other."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Any] = {}

    def wait(self, future: Any, timeout_s: float = 60.0) -> Any:
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=timeout_s)
        return future.result()

    def call(self, name: str, cls: Any, /, **fields: Any) -> Any:
        if name not in self._clients:
            self._clients[name] = self._node.create_client(cls, name)
            assert self._clients[name].wait_for_service(60.0), name
            spin(self._node, timeout_s=0.2)  # a server does not wait longer for the caller to be discovered
        return self.wait(self._clients[name].call_async(cls.Request(**fields)))


class Follower(Client):
    """Sends trajectories to two joints."""

    def __init__(self, node: Node, robot: str = "arm") -> None:
        super().__init__(node)
        self.told = 0
        self.actual: list[float] = []
        self._client = ActionClient(node, FollowJointTrajectory, f"/{robot}/follow/follow_joint_trajectory")
        assert self._client.wait_for_server(60.0)

    def hear(self, message: Any) -> None:
        self.told += 1
        self.actual = list(message.feedback.actual.positions)

    def goal(
        self, seconds: float, *positions: float, joints: tuple[str, ...] = ("j1", "j2"), **fields: Any
    ) -> Any:
        after = Duration(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))
        point = JointTrajectoryPoint(positions=list(positions), time_from_start=after)
        trajectory = JointTrajectory(joint_names=list(joints), points=[point])
        goal = FollowJointTrajectory.Goal(trajectory=trajectory, **fields)
        return self.wait(self._client.send_goal_async(goal, feedback_callback=self.hear))

    def end(self, handle: Any) -> dict[str, Any]:
        found = self.wait(handle.get_result_async())
        return {
            "status": found.status,
            "code": found.result.error_code,
            "at": self.actual,
            "feedback": self.told,
        }


def follow(node: Node) -> None:
    client, found = Follower(node), {}
    limits = [JointTolerance(name="j1", position=0.02)]
    found["reached"] = client.end(client.goal(1, 0.5, -0.4, goal_tolerance=limits))
    unknown = client.goal(1, 0.0, joints=("j9",))
    found["unknown joint"] = "accepted" if unknown.accepted else "rejected"
    found["without positions"] = "accepted" if client.goal(1).accepted else "rejected"
    tight = [JointTolerance(name="j1", position=0.05)]  # it is not as fast
    found["narrow"] = client.end(client.goal(0.1, -1.5, 0.0, path_tolerance=tight))
    handle = client.goal(5, 1.5, 0.0)
    spin(node, timeout_s=1.0)
    client.wait(handle.cancel_goal_async())
    found["cancelled"] = client.end(handle)
    first, second = client.goal(5, 1.5, 0.0), client.goal(1, 0.0, 0.0)
    found["replaced"], found["after"] = client.end(first), client.end(second)
    tell(json.dumps(found))


def again(node: Node) -> None:
    client, found = Follower(node), dict[str, Any]()
    hand = ActionClient(node, GripperCommand, "/arm/hand/gripper_cmd")
    assert hand.wait_for_server(60.0)
    handle = client.goal(60, 1.5, 0.0)
    gone = client.call("/nrp_body/delete_entity", DeleteEntity, entity="arm").result.result
    found["running"] = client.end(handle)["status"]
    found["late"] = client.end(client.goal(1, 0.0, 0.0))["status"]
    late = client.wait(hand.send_goal_async(GripperCommand.Goal()))
    found["grip"] = client.wait(late.get_result_async()).status
    found["deleted"] = [
        gone,
        client.call("/nrp_body/delete_entity", DeleteEntity, entity="arm").result.result,
    ]
    place = PoseStamped()
    for robot, uri in (("arm", sys.argv[2]), ("second", sys.argv[2]), ("third", sys.argv[3])):
        request = {"name": robot, "entity_resource": Resource(uri=uri), "initial_pose": place}
        place.pose.position.y += 3.0  # beside the one before
        found[robot] = client.call("/nrp_body/spawn_entity", SpawnEntity, **request).result.result
    for robot in ("arm", "second"):
        follower = Follower(node, robot)
        found[f"{robot} reached"] = follower.end(follower.goal(1, 0.5, -0.4))
    listed = client.call("/second/controller_manager/list_controllers", ListControllers).controller
    found["controllers"] = sorted(each.name for each in listed)
    heard: list[Any] = []
    node.create_subscription(JointState, "/second/joint_states", heard.append, 10)
    spin(node, lambda: bool(heard), 30.0)
    found["joints"] = list(heard[0].name)
    tell(json.dumps(found))


def grip(node: Node) -> None:
    client, found = Client(node), {}
    action = ActionClient(node, GripperCommand, "/arm/hand/gripper_cmd")
    assert action.wait_for_server(60.0)
    for name, position in (("open", -0.3), ("closed", 1.5)):
        goal = GripperCommand.Goal()
        goal.command.position = position
        result = client.wait(client.wait(action.send_goal_async(goal)).get_result_async()).result
        found[name] = {"position": result.position, "reached": result.reached_goal, "stalled": result.stalled}
    tell(json.dumps(found))


BOX = (
    "<sdf version='1.9'><model name='box'><static>true</static><link name='l'><collision name='c'><geometry>"
    "<box><size>1 1 1</size></box></geometry></collision></link></model></sdf>"
)


def standard(node: Node) -> None:
    client, found, services = Client(node), {}, "/nrp_body/"
    manager = "/arm/controller_manager/"
    listed = client.call(f"{manager}list_controllers", ListControllers).controller
    found["controllers"] = {each.name: each.type for each in listed if each.state == "active"}
    found["switch"] = [
        client.call(f"{manager}switch_controller", SwitchController, **{which: ["follow"]}).ok
        for which in ("activate_controllers", "deactivate_controllers")
    ]
    found["parameters"] = list(client.call(f"{services}list_parameters", ListParameters).result.names)
    values = client.call(f"{services}get_parameters", GetParameters, names=["robot_description"]).values
    found["description"] = values[0].string_value
    found["spawned"] = []
    for _ in range(2):
        request = {"name": "box", "allow_renaming": True, "initial_pose": PoseStamped()}
        request["initial_pose"].pose.position.z = 5.0
        answer = client.call(
            f"{services}spawn_entity", SpawnEntity, entity_resource=Resource(resource_string=BOX), **request
        )
        found["spawned"].append(answer.entity_name or answer.result.error_message)
    odd: list[dict[str, Any]] = [
        {"name": "odd", "entity_resource": Resource(uri=uri)} for uri in ("file://[", "file:///a%00b")
    ]
    odd += [
        {},
        {"name": "box"},
        {"name": "odd", "entity_namespace": "here"},
        {"name": "odd", "initial_pose": PoseStamped()},
    ]
    odd[-1]["initial_pose"].header.frame_id = "arm/base"
    for request in odd:
        request = {"entity_resource": Resource(resource_string=BOX)} | request
        answer = client.call(f"{services}spawn_entity", SpawnEntity, **request)
        found.setdefault("refused", []).append(answer.result.result)
    found["filters"] = []
    for text in ("(", "a{99999999999}", 5000 * "("):
        filters = EntityFilters(filter=text)
        found["filters"].append(
            client.call(f"{services}get_entities", GetEntities, filters=filters).result.result
        )
    found["entities"] = list(client.call(f"{services}get_entities", GetEntities).entities)
    state = client.call(f"{services}get_entity_state", GetEntityState, entity="box_1").state
    found["height"] = state.pose.position.z
    moved = EntityState()
    moved.pose.position.x, moved.pose.position.z, moved.pose.orientation.w = 7.0, 1.0, 1.0
    for frame in ("base", "world"):
        moved.header.frame_id = frame
        set_state = client.call(
            f"{services}set_entity_state", SetEntityState, entity="post", state=moved, set_pose=True
        )
        found[f"set in {frame}"] = set_state.result.result
    state = client.call(f"{services}get_entity_state", GetEntityState, entity="post").state
    found["moved"] = [state.pose.position.x, state.pose.position.y, state.pose.position.z]
    for scope in (ResetSimulation.Request.SCOPE_TIME, ResetSimulation.Request.SCOPE_STATE):
        reset = client.call(f"{services}reset_simulation", ResetSimulation, scope=scope)
        found[f"reset {scope}"] = reset.result.result
    state = client.call(f"{services}get_entity_state", GetEntityState, entity="post").state
    found["back"] = [state.pose.position.x, state.pose.position.y, state.pose.position.z]
    found["missing"] = client.call(f"{services}get_entity_state", GetEntityState, entity="ball").result.result
    names = ("box", "box_1")
    found["deleted"] = [
        client.call(f"{services}delete_entity", DeleteEntity, entity=name).result.result for name in names
    ]
    found["states"] = [client.call(f"{services}get_simulation_state", GetSimulationState).state.state]
    for wanted in (2, 2, 1):
        request = {"state": SimulationState(state=wanted)}
        answer = client.call(f"{services}set_simulation_state", SetSimulationState, **request)
        found["states"].append(answer.result.result)
        if len(found["states"]) == 2:
            found["states"].append(
                client.call(f"{services}get_simulation_state", GetSimulationState).state.state
            )
    features = client.call(f"{services}get_simulator_features", GetSimulatorFeatures).features
    found["features"] = list(features.features)
    tell(json.dumps(found))


if __name__ == "__main__":
    rclpy.init(args=[])
    globals()[sys.argv[1]](Node("visitor"))
