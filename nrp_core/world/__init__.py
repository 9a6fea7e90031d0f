"""The world side: the interface for authors of world backends; names are imported when first used.

A backend derives from :class:`Engine` and :class:`WorldBackend`; it is given a :class:`Scene`.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # known to type checkers; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_core._support.arrays import FloatArray as FloatArray
    from nrp_core._support.arrays import IndexArray as IndexArray
    from nrp_core._support.arrays import IntArray as IntArray
    from nrp_core._support.closing import Closing as Closing
    from nrp_core._support.diagnosis import Diagnosis as Diagnosis
    from nrp_core.findings import Code as Code
    from nrp_core.findings import Finding as Finding
    from nrp_core.findings import Findings as Findings
    from nrp_core.findings import Level as Level
    from nrp_core.findings import Weight as Weight
    from nrp_core.findings.refusals import JOINT_CONTROL as JOINT_CONTROL
    from nrp_core.scene.consistency import WORLD as WORLD
    from nrp_core.scene.devices import JointController as JointController
    from nrp_core.scene.devices import Noise as Noise
    from nrp_core.scene.devices import PairController as PairController
    from nrp_core.scene.devices import Pid as Pid
    from nrp_core.scene.devices import TrajectoryController as TrajectoryController
    from nrp_core.scene.model import Box as Box
    from nrp_core.scene.model import Capsule as Capsule
    from nrp_core.scene.model import Collision as Collision
    from nrp_core.scene.model import ConcaveMesh as ConcaveMesh
    from nrp_core.scene.model import Cylinder as Cylinder
    from nrp_core.scene.model import Finish as Finish
    from nrp_core.scene.model import Geometry as Geometry
    from nrp_core.scene.model import Heightmap as Heightmap
    from nrp_core.scene.model import Inertial as Inertial
    from nrp_core.scene.model import Joint as Joint
    from nrp_core.scene.model import Light as Light
    from nrp_core.scene.model import Link as Link
    from nrp_core.scene.model import Mesh as Mesh
    from nrp_core.scene.model import Mimic as Mimic
    from nrp_core.scene.model import Model as Model
    from nrp_core.scene.model import Plane as Plane
    from nrp_core.scene.model import Rgba as Rgba
    from nrp_core.scene.model import Scene as Scene
    from nrp_core.scene.model import Sphere as Sphere
    from nrp_core.scene.model import Visual as Visual
    from nrp_core.scene.posture import at_start as at_start
    from nrp_core.scene.randomization import Randomization as Randomization
    from nrp_core.scene.reading.context import Element as Element
    from nrp_core.scene.reading.context import Reading as Reading
    from nrp_core.scene.reading.plugins import Actuators as Actuators
    from nrp_core.scene.reading.plugins import ModelParts as ModelParts
    from nrp_core.scene.reading.sensors import Mount as Mount
    from nrp_core.scene.reading.sensors import noise_of as noise_of
    from nrp_core.scene.reading.sensors import rate_of as rate_of
    from nrp_core.scene.reading.sensors import topic_of as topic_of
    from nrp_core.scene.rigid import BodyPath as BodyPath
    from nrp_core.scene.rigid import BodyVelocity as BodyVelocity
    from nrp_core.scene.rigid import JointStates as JointStates
    from nrp_core.scene.rigid import ModelMotion as ModelMotion
    from nrp_core.scene.rigid import Pose as Pose
    from nrp_core.scene.rigid import Quaternion as Quaternion
    from nrp_core.scene.rigid import ServoTarget as ServoTarget
    from nrp_core.scene.rigid import Touch as Touch
    from nrp_core.scene.rigid import Vector as Vector
    from nrp_core.scene.rigid import Wrench as Wrench
    from nrp_core.scene.rigid import matrix_of as matrix_of
    from nrp_core.scene.sdf import read_model as read_model
    from nrp_core.scene.sdf import read_scene as read_scene
    from nrp_core.scene.surroundings import Surroundings as Surroundings
    from nrp_core.scene.tessellation import box_around as box_around
    from nrp_core.scene.tessellation import triangles_of as triangles_of
    from nrp_core.world.backend import WORLD_INTERFACE_VERSION as WORLD_INTERFACE_VERSION
    from nrp_core.world.backend import WorldBackend as WorldBackend
    from nrp_core.world.backend import WorldOptions as WorldOptions
    from nrp_core.world.batch import WorldBatch as WorldBatch
    from nrp_core.world.capabilities import WorldCapabilities as WorldCapabilities
    from nrp_core.world.drives.ackermann import Ackermann as Ackermann
    from nrp_core.world.drives.drive import Drive as Drive
    from nrp_core.world.drives.drive import driven_root as driven_root
    from nrp_core.world.drives.flight import Flight as Flight
    from nrp_core.world.drives.mecanum import MecanumDrive as MecanumDrive
    from nrp_core.world.drives.mecanum import PlanarMove as PlanarMove
    from nrp_core.world.drives.muscles import Muscle as Muscle
    from nrp_core.world.drives.muscles import ViaPoint as ViaPoint
    from nrp_core.world.drives.muscles import muscles_of as muscles_of
    from nrp_core.world.drives.wheels import WheelDrive as WheelDrive
    from nrp_core.world.engine import Engine as Engine
    from nrp_core.world.engine_kit.jointed import JointedEngine as JointedEngine
    from nrp_core.world.engine_kit.jointed import PhysicsBackend as PhysicsBackend
    from nrp_core.world.engine_kit.jointed import PhysicsOptions as PhysicsOptions
    from nrp_core.world.part import Part as Part
    from nrp_core.world.part import PartProxy as PartProxy
    from nrp_core.world.raycast.solids import width_m as width_m
    from nrp_core.world.render.cameras import DepthArray as DepthArray
    from nrp_core.world.render.cameras import ImageArray as ImageArray
    from nrp_core.world.render.cameras import drawn as drawn
    from nrp_core.world.sensors.camera import Camera as Camera
    from nrp_core.world.sensors.contact import ContactSensor as ContactSensor
    from nrp_core.world.sensors.contact import ForceTorque as ForceTorque
    from nrp_core.world.sensors.ground_truth import GroundTruth as GroundTruth
    from nrp_core.world.sensors.laser import Laser as Laser
    from nrp_core.world.sensors.navigation import AirPressure as AirPressure
    from nrp_core.world.sensors.navigation import Imu as Imu
    from nrp_core.world.sensors.navigation import Magnetometer as Magnetometer
    from nrp_core.world.sensors.navigation import NavSat as NavSat
    from nrp_core.world.sensors.sensor import Sensor as Sensor
    from nrp_core.world.sensors.sensor import SensorPart as SensorPart
    from nrp_core.world.service import Service as Service
    from nrp_core.world.topics import Direction as Direction
    from nrp_core.world.topics import Publication as Publication
    from nrp_core.world.topics import Stamped as Stamped
    from nrp_core.world.topics import Subscription as Subscription
    from nrp_core.world.topics import TopicInfo as TopicInfo
    from nrp_core.world.world import World as World
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
