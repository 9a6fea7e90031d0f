"""Services of ROS package gazebo_msgs as pairs of messages, a request and a response; SI units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from nrp_core.messages.base import message
from nrp_core.messages.builtin_interfaces import Duration, Time
from nrp_core.messages.gazebo_msgs import LinkState, ModelState, ODEPhysics
from nrp_core.messages.geometry_msgs import Point, Pose, Twist, Vector3, Wrench
from nrp_core.messages.std_msgs import ColorRGBA, Header


@dataclass(slots=True)
class _Outcome:
    """The fields of most answers: whether the request was granted, or else the reason."""

    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/ApplyBodyWrenchRequest")
class ApplyBodyWrenchRequest:
    """Apply a wrench to a link, ``model::link``, for some time; forever if negative."""

    body_name: str = ""
    reference_frame: str = "world"
    reference_point: Point = field(default_factory=Point)
    wrench: Wrench = field(default_factory=Wrench)
    start_time: Time = field(default_factory=Time)
    duration: Duration = field(default_factory=Duration)


@message("gazebo_msgs/msg/ApplyBodyWrenchResponse")
class ApplyBodyWrenchResponse(_Outcome):
    """The answer to :class:`ApplyBodyWrenchRequest`."""


@message("gazebo_msgs/msg/ApplyJointEffortRequest")
class ApplyJointEffortRequest:
    """Apply an effort to a joint, ``model::joint``, for some time; forever if negative."""

    joint_name: str = ""
    effort: float = 0.0
    start_time: Time = field(default_factory=Time)
    duration: Duration = field(default_factory=Duration)


@message("gazebo_msgs/msg/ApplyJointEffortResponse")
class ApplyJointEffortResponse(_Outcome):
    """The answer to :class:`ApplyJointEffortRequest`."""


@message("gazebo_msgs/msg/BodyRequestRequest")
class BodyRequestRequest:
    """Name a link, ``model::link``."""

    body_name: str = ""


@message("gazebo_msgs/msg/BodyRequestResponse")
class BodyRequestResponse:
    """The answer to :class:`BodyRequestRequest`."""


@message("gazebo_msgs/msg/DeleteLightRequest")
class DeleteLightRequest:
    """Delete a light."""

    light_name: str = ""


@message("gazebo_msgs/msg/DeleteLightResponse")
class DeleteLightResponse(_Outcome):
    """The answer to :class:`DeleteLightRequest`."""


@message("gazebo_msgs/msg/DeleteModelRequest")
class DeleteModelRequest:
    """Delete a model."""

    model_name: str = ""


@message("gazebo_msgs/msg/DeleteModelResponse")
class DeleteModelResponse(_Outcome):
    """The answer to :class:`DeleteModelRequest`."""


@message("gazebo_msgs/msg/GetJointPropertiesRequest")
class GetJointPropertiesRequest:
    """Get the state of a joint, ``model::joint``."""

    joint_name: str = ""


@message(
    "gazebo_msgs/msg/GetJointPropertiesResponse",
    definition=(
        "uint8 REVOLUTE=0\n"
        "uint8 CONTINUOUS=1\n"
        "uint8 PRISMATIC=2\n"
        "uint8 FIXED=3\n"
        "uint8 BALL=4\n"
        "uint8 UNIVERSAL=5\n"
        "uint8 type\n"
        "float64[] damping\n"
        "float64[] position\n"
        "float64[] rate\n"
        "bool success\n"
        "string status_message\n"
    ),
)
class GetJointPropertiesResponse:
    """The answer to :class:`GetJointPropertiesRequest`."""

    REVOLUTE: ClassVar[int] = 0
    CONTINUOUS: ClassVar[int] = 1
    PRISMATIC: ClassVar[int] = 2
    FIXED: ClassVar[int] = 3
    BALL: ClassVar[int] = 4
    UNIVERSAL: ClassVar[int] = 5

    type: int = 0
    damping: list[float] = field(default_factory=list)
    position: list[float] = field(default_factory=list)
    rate: list[float] = field(default_factory=list)
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetLightPropertiesRequest")
class GetLightPropertiesRequest:
    """Get the properties of a light."""

    light_name: str = ""


@message("gazebo_msgs/msg/GetLightPropertiesResponse")
class GetLightPropertiesResponse:
    """The answer to :class:`GetLightPropertiesRequest`."""

    diffuse: ColorRGBA = field(default_factory=ColorRGBA)
    attenuation_constant: float = 0.0
    attenuation_linear: float = 0.0
    attenuation_quadratic: float = 0.0
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetLightsNameRequest")
class GetLightsNameRequest:
    """Get the names of the lights."""


@message("gazebo_msgs/msg/GetLightsNameResponse")
class GetLightsNameResponse:
    """The answer to :class:`GetLightsNameRequest`."""

    light_names: list[str] = field(default_factory=list)
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetLinkStateRequest")
class GetLinkStateRequest:
    """Get pose and velocity of a link, ``model::link``."""

    link_name: str = ""
    reference_frame: str = "world"


@message("gazebo_msgs/msg/GetLinkStateResponse")
class GetLinkStateResponse:
    """The answer to :class:`GetLinkStateRequest`."""

    link_state: LinkState = field(default_factory=LinkState)
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetModelPropertiesRequest")
class GetModelPropertiesRequest:
    """Get the parts of a model."""

    model_name: str = ""


@message("gazebo_msgs/msg/GetModelPropertiesResponse")
class GetModelPropertiesResponse:
    """The answer to :class:`GetModelPropertiesRequest`."""

    parent_model_name: str = ""
    canonical_body_name: str = ""
    body_names: list[str] = field(default_factory=list)
    geom_names: list[str] = field(default_factory=list)
    joint_names: list[str] = field(default_factory=list)
    child_model_names: list[str] = field(default_factory=list)
    is_static: bool = False
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetModelStateRequest")
class GetModelStateRequest:
    """Get pose and velocity of a model, relative to ``relative_entity_name``."""

    model_name: str = ""
    relative_entity_name: str = "world"


@message("gazebo_msgs/msg/GetModelStateResponse")
class GetModelStateResponse:
    """The answer to :class:`GetModelStateRequest`."""

    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)
    twist: Twist = field(default_factory=Twist)
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetPhysicsPropertiesRequest")
class GetPhysicsPropertiesRequest:
    """Get the settings of physics."""


@message("gazebo_msgs/msg/GetPhysicsPropertiesResponse")
class GetPhysicsPropertiesResponse:
    """The answer to :class:`GetPhysicsPropertiesRequest`."""

    time_step: float = 0.0
    pause: bool = False
    max_update_rate: float = 0.0
    gravity: Vector3 = field(default_factory=Vector3)
    ode_config: ODEPhysics = field(default_factory=ODEPhysics)
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/GetWorldPropertiesRequest")
class GetWorldPropertiesRequest:
    """Get the names of the models."""


@message("gazebo_msgs/msg/GetWorldPropertiesResponse")
class GetWorldPropertiesResponse:
    """The answer to :class:`GetWorldPropertiesRequest`."""

    sim_time: float = 0.0
    model_names: list[str] = field(default_factory=list)
    rendering_enabled: bool = True
    success: bool = True
    status_message: str = ""


@message("gazebo_msgs/msg/JointRequestRequest")
class JointRequestRequest:
    """Name a joint, ``model::joint``."""

    joint_name: str = ""


@message("gazebo_msgs/msg/JointRequestResponse")
class JointRequestResponse:
    """The answer to :class:`JointRequestRequest`."""


@message("gazebo_msgs/msg/SetLightPropertiesRequest")
class SetLightPropertiesRequest:
    """Set the colour of a light; its attenuation stays."""

    light_name: str = ""
    diffuse: ColorRGBA = field(default_factory=ColorRGBA)
    attenuation_constant: float = 0.0
    attenuation_linear: float = 0.0
    attenuation_quadratic: float = 0.0


@message("gazebo_msgs/msg/SetLightPropertiesResponse")
class SetLightPropertiesResponse(_Outcome):
    """The answer to :class:`SetLightPropertiesRequest`."""


@message("gazebo_msgs/msg/SetLinkStateRequest")
class SetLinkStateRequest:
    """Set pose and velocity of the base link of a model."""

    link_state: LinkState = field(default_factory=LinkState)


@message("gazebo_msgs/msg/SetLinkStateResponse")
class SetLinkStateResponse(_Outcome):
    """The answer to :class:`SetLinkStateRequest`."""


@message("gazebo_msgs/msg/SetModelConfigurationRequest")
class SetModelConfigurationRequest:
    """Set positions of joints of a model."""

    model_name: str = ""
    urdf_param_name: str = ""
    joint_names: list[str] = field(default_factory=list)
    joint_positions: list[float] = field(default_factory=list)


@message("gazebo_msgs/msg/SetModelConfigurationResponse")
class SetModelConfigurationResponse(_Outcome):
    """The answer to :class:`SetModelConfigurationRequest`."""


@message("gazebo_msgs/msg/SetModelStateRequest")
class SetModelStateRequest:
    """Set pose and velocity of a model."""

    model_state: ModelState = field(default_factory=ModelState)


@message("gazebo_msgs/msg/SetModelStateResponse")
class SetModelStateResponse(_Outcome):
    """The answer to :class:`SetModelStateRequest`."""


@message("gazebo_msgs/msg/SetPhysicsPropertiesRequest")
class SetPhysicsPropertiesRequest:
    """Set gravity; a ``time_step`` of 0 keeps the present one, and all other fields have no effect."""

    time_step: float = 0.0
    max_update_rate: float = 0.0
    gravity: Vector3 = field(default_factory=Vector3)
    ode_config: ODEPhysics = field(default_factory=ODEPhysics)


@message("gazebo_msgs/msg/SetPhysicsPropertiesResponse")
class SetPhysicsPropertiesResponse(_Outcome):
    """The answer to :class:`SetPhysicsPropertiesRequest`."""


@message("gazebo_msgs/msg/SetVisualPropertiesRequest")
class SetVisualPropertiesRequest:
    """Set the look of a visual: ``material:script:name``, ``material:diffuse``, ``material:emissive``."""

    model_name: str = ""
    link_name: str = ""
    visual_name: str = ""
    property_name: str = "material:script:name"
    property_value: str = ""


@message("gazebo_msgs/msg/SetVisualPropertiesResponse")
class SetVisualPropertiesResponse(_Outcome):
    """The answer to :class:`SetVisualPropertiesRequest`."""


@message("gazebo_msgs/msg/SpawnModelRequest")
class SpawnModelRequest:
    """Add a model from the text of its file, ``model_xml``."""

    model_name: str = ""
    model_xml: str = ""
    robot_namespace: str = ""
    initial_pose: Pose = field(default_factory=Pose)
    reference_frame: str = "world"


@message("gazebo_msgs/msg/SpawnModelResponse")
class SpawnModelResponse(_Outcome):
    """The answer to :class:`SpawnModelRequest`."""
