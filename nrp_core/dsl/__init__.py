"""The transfer function language: the module ``nrp`` in files.

::

    @nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
    @nrp.Neuron2Robot(Topic("/robot/cmd_vel", geometry_msgs.msg.Twist))
    def drive(t, left):
        return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(20 * left.voltage, 0, 0))

``__all__`` is the language. ``EXTENSION_NAMES`` are for authors of readers and of other languages; each is
imported when it is first used.
"""

from __future__ import annotations

from nrp_core._support.lazy import lazily
from nrp_core.dsl import tf_lib
from nrp_core.dsl.device_kinds import (
    CustomDevice,
    ac_source,
    conductance_recorder,
    dc_source,
    device,
    fixed_frequency,
    injector,
    leaky_integrator_alpha,
    leaky_integrator_exp,
    nc_source,
    poisson,
    population_rate,
    spike_recorder,
    voltage_recorder,
)
from nrp_core.dsl.functions import Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.mappings import (
    GLOBAL,
    TRANSFER_FUNCTION_LOCAL,
    MapCSVRecorder,
    MapRobotPublisher,
    MapRobotSubscriber,
    MapSpikeSink,
    MapSpikeSource,
    MapVariable,
)
from nrp_core.dsl.monitors import NeuronMonitor
from nrp_core.dsl.parameters import PreprocessedTopic, Topic
from nrp_core.dsl.proprioception import map_afferents, map_motoneurons
from nrp_core.dsl.rewards import MapReward
from nrp_core.dsl.selection import Box, Sphere, brain, chain_neurons, map_neurons, nrange, resolve
from nrp_core.dsl.weights import MapWeights
from nrp_core.parameters import GivenParameters

parameter = GivenParameters().parameter
"""Declares a parameter; in a file of an experiment it has the value that the experiment gives."""

__all__ = [
    "GLOBAL",
    "TRANSFER_FUNCTION_LOCAL",
    "Box",
    "CustomDevice",
    "MapCSVRecorder",
    "MapReward",
    "MapRobotPublisher",
    "MapRobotSubscriber",
    "MapSpikeSink",
    "MapSpikeSource",
    "MapVariable",
    "MapWeights",
    "Neuron2Robot",
    "NeuronMonitor",
    "PreprocessedTopic",
    "Robot2Neuron",
    "Sphere",
    "Topic",
    "TransferFunction",
    "ac_source",
    "brain",
    "chain_neurons",
    "conductance_recorder",
    "dc_source",
    "device",
    "fixed_frequency",
    "injector",
    "leaky_integrator_alpha",
    "leaky_integrator_exp",
    "map_afferents",
    "map_motoneurons",
    "map_neurons",
    "nc_source",
    "nrange",
    "parameter",
    "poisson",
    "population_rate",
    "resolve",
    "spike_recorder",
    "tf_lib",
    "voltage_recorder",
]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from nrp_core.dsl.calls import Throttle as Throttle
    from nrp_core.dsl.device_kinds import DEVICES as DEVICES
    from nrp_core.dsl.device_kinds import DeviceKind as DeviceKind
    from nrp_core.dsl.devices import CurrentGenerator as CurrentGenerator
    from nrp_core.dsl.devices import Device as Device
    from nrp_core.dsl.devices import LeakyIntegratorDevice as LeakyIntegratorDevice
    from nrp_core.dsl.devices import NoiseCurrentGenerator as NoiseCurrentGenerator
    from nrp_core.dsl.devices import Port as Port
    from nrp_core.dsl.devices import SettableAttribute as SettableAttribute
    from nrp_core.dsl.devices import SineCurrentGenerator as SineCurrentGenerator
    from nrp_core.dsl.devices import SpikeGenerator as SpikeGenerator
    from nrp_core.dsl.functions import TIME as TIME
    from nrp_core.dsl.functions import Flow as Flow
    from nrp_core.dsl.loading import Listing as Listing
    from nrp_core.dsl.loading import PythonSource as PythonSource
    from nrp_core.dsl.loading import file_names as file_names
    from nrp_core.dsl.loading import file_scope as file_scope
    from nrp_core.dsl.loading import load_transfer_functions as load_transfer_functions
    from nrp_core.dsl.loading import provide_messages as provide_messages
    from nrp_core.dsl.mappings import RESET_HEADER as RESET_HEADER
    from nrp_core.dsl.mappings import Variable as Variable
    from nrp_core.dsl.messages import message_packages as message_packages
    from nrp_core.dsl.messages import message_type as message_type
    from nrp_core.dsl.monitors import MonitoringFunction as MonitoringFunction
    from nrp_core.dsl.parameters import Adapter as Adapter
    from nrp_core.dsl.parameters import Binding as Binding
    from nrp_core.dsl.parameters import ParameterMapping as ParameterMapping
    from nrp_core.dsl.parameters import line_in as line_in
    from nrp_core.dsl.selection import Selection as Selection
    from nrp_core.dsl.selection import Selector as Selector
    from nrp_core.dsl.selection import evaluate as evaluate
else:
    __getattr__, __dir__, EXTENSION_NAMES = lazily(__name__)
