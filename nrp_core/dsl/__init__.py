"""The transfer function language: the module ``nrp`` in files.

::

    @nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
    @nrp.Neuron2Robot(Topic("/robot/cmd_vel", geometry_msgs.msg.Twist))
    def drive(t, left):
        return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(20 * left.voltage, 0, 0))
"""

from __future__ import annotations

from nrp_core.dsl import tf_lib
from nrp_core.dsl.devices.custom import CustomDevice
from nrp_core.dsl.devices.kinds import (
    ac_source,
    conductance_recorder,
    dc_source,
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
from nrp_core.dsl.functions.decorators import Neuron2Robot, Robot2Neuron
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.mappings import (
    MapCSVRecorder,
    MapRobotPublisher,
    MapRobotSubscriber,
    MapSpikeSink,
    MapSpikeSource,
    MapVariable,
)
from nrp_core.dsl.functions.monitors import NeuronMonitor
from nrp_core.dsl.functions.variables import GLOBAL, TRANSFER_FUNCTION_LOCAL
from nrp_core.dsl.parameters.topics import PreprocessedTopic, Topic
from nrp_core.dsl.selection.regions import Box, Sphere
from nrp_core.dsl.selection.selectors import brain, chain_neurons, map_neurons, nrange, resolve
from nrp_core.parameters import GivenParameters

parameter = GivenParameters().parameter
"""Declares a parameter; in a file of an experiment it has the value that the experiment gives."""

__all__ = [
    "GLOBAL",
    "TRANSFER_FUNCTION_LOCAL",
    "Box",
    "CustomDevice",
    "MapCSVRecorder",
    "MapRobotPublisher",
    "MapRobotSubscriber",
    "MapSpikeSink",
    "MapSpikeSource",
    "MapVariable",
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
    "fixed_frequency",
    "injector",
    "leaky_integrator_alpha",
    "leaky_integrator_exp",
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
