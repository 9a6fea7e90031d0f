"""A closed loop between a spiking brain and a simulated body, with any simulator on either side.

::

    import nrp_core

    result = nrp_core.run("braitenberg_husky", ["seed=3"], until_s=5.0)
    print(result.passed, result.final_pose["husky"])

Users need the names here; :mod:`nrp_core.brain` and :mod:`nrp_core.world` have the names that authors of
backends need. A name is imported when it is first used.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # known to type checkers; typing itself takes 5 ms to import
if TYPE_CHECKING:
    from nrp_core.brain.backends import brains as brains
    from nrp_core.brain.interface import Brain as Brain
    from nrp_core.checks.validate import validate as validate
    from nrp_core.dsl.functions import TransferFunction as TransferFunction
    from nrp_core.dsl.loading import load_transfer_functions as load_transfer_functions
    from nrp_core.dsl.loading import provide_messages as provide_messages
    from nrp_core.errors import NrpError as NrpError
    from nrp_core.experiment.model.experiment import Experiment as Experiment
    from nrp_core.experiment.reading.find import load_experiment as load_experiment
    from nrp_core.experiment.reading.find import shipped as shipped
    from nrp_core.experiment.running.result import Result as Result
    from nrp_core.experiment.running.run import Run as Run
    from nrp_core.findings import Code as Code
    from nrp_core.findings import Finding as Finding
    from nrp_core.findings import InvalidExperimentError as InvalidExperimentError
    from nrp_core.findings import Level as Level
    from nrp_core.findings import Weight as Weight
    from nrp_core.messages import builtin_interfaces as builtin_interfaces
    from nrp_core.messages import control_msgs as control_msgs
    from nrp_core.messages import gazebo_msgs as gazebo_msgs
    from nrp_core.messages import geometry_msgs as geometry_msgs
    from nrp_core.messages import message as message
    from nrp_core.messages import nav_msgs as nav_msgs
    from nrp_core.messages import nrp_msgs as nrp_msgs
    from nrp_core.messages import sensor_msgs as sensor_msgs
    from nrp_core.messages import std_msgs as std_msgs
    from nrp_core.messages import trajectory_msgs as trajectory_msgs
    from nrp_core.network.data import Network as Network
    from nrp_core.network.data import Population as Population
    from nrp_core.network.data import Projection as Projection
    from nrp_core.network.files import read_network as read_network
    from nrp_core.network.files import save_network as save_network
    from nrp_core.network.files.script import load_network as load_network
    from nrp_core.recording.layout import Images as Images
    from nrp_core.recording.recording import Recording as Recording
    from nrp_core.running import open_run as open_run
    from nrp_core.running import open_world as open_world
    from nrp_core.running import run as run
    from nrp_core.scene.model import Model as Model
    from nrp_core.scene.model import Scene as Scene
    from nrp_core.scene.rigid import Pose as Pose
    from nrp_core.scene.sdf import read_model as read_model
    from nrp_core.scene.sdf import read_scene as read_scene
    from nrp_core.world.backends import worlds as worlds
    from nrp_core.world.world import World as World
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
