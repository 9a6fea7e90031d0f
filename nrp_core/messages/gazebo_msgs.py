"""ROS package gazebo_msgs; SI units."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import array_field, message
from nrp_core.messages.geometry_msgs import Pose, Twist, Vector3, Wrench
from nrp_core.messages.std_msgs import Header


@message("gazebo_msgs/msg/ModelStates")
class ModelStates:
    """Poses and velocities of all models in the frame of the world."""

    name: list[str] = field(default_factory=list)
    pose: list[Pose] = field(default_factory=list)
    twist: list[Twist] = field(default_factory=list)


@message("gazebo_msgs/msg/ModelState")
class ModelState:
    """Pose and velocity of one model, in the frame ``reference_frame`` (the world by default)."""

    model_name: str = ""
    pose: Pose = field(default_factory=Pose)
    twist: Twist = field(default_factory=Twist)
    reference_frame: str = "world"


@message("gazebo_msgs/msg/WheelSpeeds")
class WheelSpeeds:
    """Ground speed of each wheel in m/s: back left, back right, front left, front right."""

    back_left: float = 0.0
    back_right: float = 0.0
    front_left: float = 0.0
    front_right: float = 0.0


@message("gazebo_msgs/msg/LinkStates")
class LinkStates:
    """Poses and velocities of all links, ``model::link``, in the frame of the world."""

    name: list[str] = field(default_factory=list)
    pose: list[Pose] = field(default_factory=list)
    twist: list[Twist] = field(default_factory=list)


@message("gazebo_msgs/msg/LinkState")
class LinkState:
    """Pose and velocity of one link, in the frame ``reference_frame`` (the world by default)."""

    link_name: str = ""
    pose: Pose = field(default_factory=Pose)
    twist: Twist = field(default_factory=Twist)
    reference_frame: str = "world"


@message("gazebo_msgs/msg/ContactState")
class ContactState:
    """A contact of two collisions, ``model::link::collision``; forces on the first, in the world's frame."""

    info: str = ""
    collision1_name: str = ""
    collision2_name: str = ""
    wrenches: list[Wrench] = field(default_factory=list)
    total_wrench: Wrench = field(default_factory=Wrench)
    contact_positions: list[Vector3] = field(default_factory=list)
    contact_normals: list[Vector3] = field(default_factory=list)
    depths: npt.NDArray[np.float64] = array_field()


@message("gazebo_msgs/msg/ContactsState")
class ContactsState:
    """All contacts, one entry for each pair of collisions."""

    header: Header = field(default_factory=Header)
    states: list[ContactState] = field(default_factory=list)


@message("gazebo_msgs/msg/ODEPhysics")
class ODEPhysics:
    """Settings of Gazebo's solver with their defaults; other engines ignore them."""

    auto_disable_bodies: bool = False
    sor_pgs_precon_iters: int = 0
    sor_pgs_iters: int = 50
    sor_pgs_w: float = 1.3
    sor_pgs_rms_error_tol: float = 0.0
    contact_surface_layer: float = 0.001
    contact_max_correcting_vel: float = 100.0
    cfm: float = 0.0
    erp: float = 0.2
    max_contacts: int = 20
