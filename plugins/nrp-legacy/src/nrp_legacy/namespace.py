"""The initial names of transfer functions, and the modules that they can import."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from nrp_pynest.api import nest_module
from nrp_pynest.built import BuiltBrain
from nrp_pynest.kernel import Kernel, random_of

from nrp_core.brain import Network
from nrp_core.dsl import file_names, file_scope
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion
from nrp_core.messages.std_msgs import Float32, Int32, String
from nrp_legacy import python2
from nrp_legacy.code import Notes, compiled_file
from nrp_legacy.files import Library
from nrp_legacy.framework import BrainRoot, framework, topic
from nrp_legacy.shims.actions import action_modules
from nrp_legacy.shims.graph import ClientLogger, Graph, log, log_modules
from nrp_legacy.shims.libraries import futurized_modules, old_libraries
from nrp_legacy.shims.modules import (
    CvBridge,
    StandIns,
    cv_bridge_module,
    message_modules,
    module,
    service_modules,
    with_missing_parts,
)
from nrp_legacy.shims.paths import ImportPath, Paths
from nrp_legacy.shims.processes import Started, process_modules
from nrp_legacy.shims.rospy import rospy_module, sleep
from nrp_legacy.shims.services import Services
from nrp_legacy.shims.smach import smach_module
from nrp_legacy.shims.states import nrp_states_module, smach_ros_module
from nrp_legacy.shims.transformations import tf_module, transformations_module

_STATES = "hbp_nrp_excontrol.nrp_states"
_FILES_OF_STATES = (
    "ClientLogState", "ClockMonitorState", "LifecycleState", "LightServiceState", "MaterialServiceState",
    "ModelServiceState", "MonitoringListenerState", "RobotMonitorState", "WaitForClientLogState",
    "WarningState",
)  # fmt: skip
"""The files in which the platform defined its states; some machines import from them."""
_INCOMPLETE = (
    "rospy", "smach", "smach_ros", _STATES, "tf", "future.utils",
    *(f"{root}.brainsim{part}" for root in ("hbp_nrp_cle", "python_cle") for part in ("", ".simulator")),
)  # fmt: skip
"""Modules that are implemented only as far as experiments are known to use them."""


class Namespace:
    """One module that all transfer functions of an experiment share.

    Args:
        notes: receives a note about each omitted part.
        library: the search path for files that code names.
        folders: the folders whose modules can be imported.
        nest_units: whether devices are set in the units of NEST.
        seed: the seed of random numbers in code.
        network: the brain; None before it is built.
        parameters: the values that ``nrp.parameter`` returns.

    Attributes:
        graph: the state of the run for the shims.
        started: the processes, threads and programs of the code.
        services: the services of the run and of the experiment.
        brain_root: the module of the brain file.
        module: the names.
        scope: the modules that can be imported.
        import_path: the folders whose modules can be imported.
    """

    def __init__(
        self,
        notes: Notes,
        library: Library,
        folders: Iterable[Path] = (),
        *,
        nest_units: bool = False,
        seed: int = 0,
        network: Network | None = None,
        parameters: Mapping[str, object] = MappingProxyType({}),
    ) -> None:
        self.graph = Graph()
        self.started = Started(self.graph)
        self.services = services = Services(self.graph)
        self.brain_root = BrainRoot(network)
        nrp = framework(notes, self._noting(notes), nest_units=nest_units, brain_root=self.brain_root)
        own = file_names(parameters)["nrp"]
        vars(nrp).update(tf_lib=own.tf_lib, parameter=own.parameter)
        logger, messages = ClientLogger(self.graph), message_modules()
        vars(nrp).update(clientLogger=logger)
        built: BuiltBrain = getattr(network, "built", None) or BuiltBrain()
        self._libraries = old_libraries(
            library.environment(), partial(sleep, self.graph), seed, built.import_path, Paths(library)
        )
        vars(self._libraries["os"]).update(fork=self.started.fork, system=self.started.system)
        nest = built.nest or nest_module(Kernel(random_of(seed), is_lenient=True))
        substitutes = {
            **self._libraries,
            **messages,
            **service_modules(),
            **_cle(nrp, logger, nrp_states_module(self.graph, services), nest),
            "rospy": (rospy := rospy_module(self.graph, services)),
            **{f"rospy.{name}": getattr(rospy, name) for name in ("rostime", "names")},
            "rospy.numpy_msg": module("rospy.numpy_msg", numpy_msg=lambda message: message),
            **dict.fromkeys(("smach", "smach.state", "smach.state_machine"), smach_module()),
            "smach_ros": smach_ros_module(self.graph, services),
            "cv_bridge": cv_bridge_module(),
            "nest": nest,
            "roslib": module("roslib", load_manifest=lambda _name: None),
            **action_modules(self.graph),
            **process_modules(self.started),
            "tf": tf_module(),
            **futurized_modules(),
            "tf.transformations": transformations_module(),
        }
        for name in _INCOMPLETE:
            with_missing_parts(substitutes[name])
        for name, child in substitutes.items():
            parent, _, last = name.rpartition(".")
            if parent in substitutes:
                vars(substitutes[parent]).setdefault(last, child)
        self.import_path = ImportPath(built.import_path, folders, library)
        stand_ins = StandIns(self._noting(notes))
        self.scope = file_scope(nrp, substitutes, self.import_path, stand_ins, compiled_file)
        self.module = module("transfer_functions", **self._names(nrp, logger, messages))

    def _noting(self, notes: Notes) -> Notes:
        """Return a function that takes notes before the run and in it."""

        def note(code: Code, message: str, *, subject: str | None = None) -> None:
            (self.graph.warn if self.graph.has_begun else notes)(code, message, subject=subject)

        return note

    def fresh(self) -> ModuleType:
        """Return a module with the initial names, for a file with a separate namespace."""
        return module("state_machine", **self._first_names)

    def _names(
        self, nrp: ModuleType, logger: ClientLogger, messages: dict[str, ModuleType]
    ) -> dict[str, Any]:
        packages = {
            name.partition(".")[0]: module(name.partition(".")[0], msg=one) for name, one in messages.items()
        }
        framework_names = {name: value for name, value in vars(nrp).items() if not name.startswith("_")}
        packages["hbp_nrp_cle"] = module("hbp_nrp_cle", tf_framework=nrp, tf_lib=nrp.tf_lib)
        self._first_names = {
            **python2.names(), **packages, **framework_names,
            "nrp": nrp, "Topic": topic, "clientLogger": logger, "logger": log,
            "np": self._libraries["numpy"],
            **{name: self._libraries[name] for name in ("numpy", "cv2", "sys", "logging")},
            "CvBridge": CvBridge,
            "Point": Point, "Pose": Pose, "Quaternion": Quaternion,
            "Float32": Float32, "Int32": Int32, "String": String,
        }  # fmt: skip
        return dict(self._first_names)


def _cle(
    nrp: ModuleType, logger: ClientLogger, states: ModuleType, nest: ModuleType
) -> dict[str, ModuleType]:
    """Return the packages of the platform itself, by the names in all of its versions."""
    interface = module("RobotInterface", Topic=topic, PreprocessedTopic=nrp.PreprocessedTopic)
    found: dict[str, ModuleType] = {}
    for root in ("hbp_nrp_cle", "python_cle"):
        found[f"{root}.tf_framework"] = nrp
        found[f"{root}.tf_framework.tf_lib"] = found[f"{root}.tf_lib"] = nrp.tf_lib
        found[f"{root}.robotsim"] = module("robotsim", RobotInterface=interface)
        found[f"{root}.robotsim.RobotInterface"] = interface
        found[f"{root}.brainsim"] = module("brainsim")
        found[f"{root}.brainsim.simulator"] = module("simulator", nest=nest)
        found[f"{root}.tf_framework.config"] = nrp.config
    return {
        **found,
        **log_modules(logger),
        _STATES: states,
        **{f"{_STATES}._{file}": states for file in _FILES_OF_STATES},
    }
