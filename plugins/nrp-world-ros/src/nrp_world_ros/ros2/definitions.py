"""The definitions of control_msgs, controller_manager_msgs and simulation_interfaces, without comments."""

from __future__ import annotations

from nrp_core.messages.cdr import Codec

PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
"""The messages of each kind of type; ours are called ``package/msg/TypePart``."""

_TEXTS = """
control_msgs/msg/JointTolerance
string name; float64 position; float64 velocity; float64 acceleration

control_msgs/msg/JointComponentTolerance
uint16 X_AXIS=1; uint16 Y_AXIS=2; uint16 Z_AXIS=3; uint16 TRANSLATION=4; uint16 ROTATION=5
string joint_name; uint16 component; float64 position; float64 velocity; float64 acceleration

control_msgs/msg/GripperCommand
float64 position; float64 max_effort

control_msgs/action/GripperCommand
GripperCommand command
---
float64 position; float64 effort; bool stalled; bool reached_goal
---
float64 position; float64 effort; bool stalled; bool reached_goal

control_msgs/action/FollowJointTrajectory
trajectory_msgs/JointTrajectory trajectory; trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory
JointTolerance[] path_tolerance; JointComponentTolerance[] component_path_tolerance
JointTolerance[] goal_tolerance; JointComponentTolerance[] component_goal_tolerance
builtin_interfaces/Duration goal_time_tolerance
---
int32 SUCCESSFUL=0; int32 INVALID_GOAL=-1; int32 INVALID_JOINTS=-2; int32 OLD_HEADER_TIMESTAMP=-3
int32 PATH_TOLERANCE_VIOLATED=-4; int32 GOAL_TOLERANCE_VIOLATED=-5
int32 error_code; string error_string
---
std_msgs/Header header; string[] joint_names; trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual; trajectory_msgs/JointTrajectoryPoint error; int32 index
string[] multi_dof_joint_names; trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error; int32 multi_dof_index

controller_manager_msgs/msg/ChainConnection
string name; string[] reference_interfaces

controller_manager_msgs/msg/ControllerState
string name; string state; string type; string[] claimed_interfaces; string[] required_command_interfaces
string[] required_state_interfaces; bool is_chainable; bool is_chained; string[] reference_interfaces
ChainConnection[] chain_connections

controller_manager_msgs/srv/ListControllers
---
ControllerState[] controller

controller_manager_msgs/srv/SwitchController
int32 BEST_EFFORT=1; int32 STRICT=2; int32 AUTO=3; int32 FORCE_AUTO=4
string[] activate_controllers; string[] deactivate_controllers; int32 strictness; bool activate_asap
builtin_interfaces/Duration timeout
---
bool ok; string message

simulation_interfaces/msg/Result
uint8 RESULT_FEATURE_UNSUPPORTED=0; uint8 RESULT_OK=1; uint8 RESULT_NOT_FOUND=2
uint8 RESULT_INCORRECT_STATE=3; uint8 RESULT_OPERATION_FAILED=4; uint8 result; string error_message

simulation_interfaces/msg/SimulationState
uint8 STATE_STOPPED=0; uint8 STATE_PLAYING=1; uint8 STATE_PAUSED=2; uint8 STATE_QUITTING=3; uint8 state

simulation_interfaces/msg/SimulatorFeatures
uint8 SPAWNING=0; uint8 DELETING=1; uint8 SPAWNING_RESOURCE_STRING=9; uint8 ENTITY_STATE_GETTING=10
uint8 ENTITY_STATE_SETTING=11; uint8 SIMULATION_RESET=20; uint8 SIMULATION_RESET_STATE=22
uint8 SIMULATION_STATE_GETTING=24; uint8 SIMULATION_STATE_SETTING=25; uint8 SIMULATION_STATE_PAUSE=26
uint16[] features; string[] spawn_formats; string custom_info

simulation_interfaces/msg/EntityCategory
uint8 category

simulation_interfaces/msg/TagsFilter
string[] tags; uint8 filter_mode

simulation_interfaces/msg/Bounds
uint8 type; geometry_msgs/Vector3[] points

simulation_interfaces/msg/EntityFilters
string filter; EntityCategory[] categories; TagsFilter tags; Bounds bounds

simulation_interfaces/msg/EntityState
std_msgs/Header header; geometry_msgs/Pose pose; geometry_msgs/Twist twist; geometry_msgs/Accel acceleration

simulation_interfaces/msg/Resource
string uri; string resource_string

simulation_interfaces/srv/GetSimulatorFeatures
---
SimulatorFeatures features

simulation_interfaces/srv/GetSimulationState
---
SimulationState state; Result result

simulation_interfaces/srv/SetSimulationState
SimulationState state
---
uint8 ALREADY_IN_TARGET_STATE=101; Result result

simulation_interfaces/srv/ResetSimulation
uint8 SCOPE_DEFAULT=0; uint8 SCOPE_TIME=1; uint8 SCOPE_STATE=2; uint8 SCOPE_SPAWNED=4; uint8 SCOPE_ALL=255
uint8 scope
---
Result result

simulation_interfaces/srv/GetEntities
EntityFilters filters
---
Result result; string[] entities

simulation_interfaces/srv/GetEntityState
string entity
---
Result result; EntityState state

simulation_interfaces/srv/SetEntityState
string entity; EntityState state; bool set_pose; bool set_twist; bool set_acceleration
---
uint8 INVALID_POSE=101; Result result

simulation_interfaces/srv/SpawnEntity
string name; bool allow_renaming; Resource entity_resource; string entity_namespace
geometry_msgs/PoseStamped initial_pose
---
uint8 NAME_NOT_UNIQUE=101; uint8 NAME_INVALID=102; uint8 NO_RESOURCE=104; uint8 RESOURCE_PARSE_ERROR=106
Result result; string entity_name

simulation_interfaces/srv/DeleteEntity
string entity
---
Result result
"""


def define(codec: Codec) -> None:
    """Add these types."""
    for block in _TEXTS.strip().split("\n\n"):
        name, _, text = block.partition("\n")
        package, kind, short = name.split("/")
        text = f"\n{text}".replace("; ", "\n")
        for part, lines in zip(PARTS[kind], text.split("\n---"), strict=True):
            codec.define(f"{package}/msg/{short}{part}", lines.strip())


PACKAGES = tuple(sorted({line.split("/")[0] for line in _TEXTS.splitlines() if line.count("/") == 2}))
