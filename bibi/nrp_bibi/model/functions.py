"""The transfer functions, and the model that holds them."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from nrp_bibi.model.channels import DeviceChannel, DeviceGroupChannel, Local, TopicChannel
from nrp_bibi.model.metamodel import Node, attribute, child, children, choice, content
from nrp_bibi.model.selectors import MultiNeuronSelector
from nrp_bibi.model.synapses import NeuronConnector, SynapseDynamics
from nrp_bibi.model.values import CODE, FILE, NAME, NATURAL, POSITIVE, RATE, TRUTH, WORD


class Calls(Enum):
    """How often the messages of a step make a function run."""

    ONCE = "Once"
    EACH = "Each"


CALLS = choice("Calls", Calls)


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferFunction(Node, abstract=True):
    """A connection of brain and robot; within a step, higher priorities run first."""

    active: bool = attribute(TRUTH, True)
    priority: int = attribute(NATURAL, 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PythonTransferFunction(TransferFunction):
    """A transfer function in Python, in a file or inline.

    Args:
        src: the file, relative to the model.
        code: the inline code.
        code_line: the first line of the inline code.
    """

    src: str | None = attribute(FILE, None)
    code: str = content(CODE, "")
    code_line: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class BIBITransferFunction(TransferFunction, abstract=True):
    """A transfer function made of building blocks: locals, then values for devices and topics."""

    name: str = attribute(NAME)
    local: tuple[Local, ...] = children(Local)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelTransferFunction(BIBITransferFunction, abstract=True):
    """A transfer function with channels; its return value has a channel of its own.

    Args:
        throttling_rate: the largest number of runs per second.
        trigger: names of topics and spike recorders that it reads; a message or spike of one of them makes it
            run. By default it runs every step.
        calls: whether the messages of a step make it run once, or each of them makes it run.
    """

    throttling_rate: float | None = attribute(RATE, None, unit="Hz")
    calls: Calls = attribute(CALLS, Calls.ONCE)
    trigger: tuple[str, ...] = children(NAME, aliases={"triggers": ""})
    device: tuple[DeviceChannel, ...] = children(DeviceChannel)
    device_group: tuple[DeviceGroupChannel, ...] = children(DeviceGroupChannel)
    topic: tuple[TopicChannel, ...] = children(TopicChannel)
    return_value: TopicChannel | DeviceChannel | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Neuron2Robot(ChannelTransferFunction):
    """A transfer function from the brain to the robot."""

    return_value: TopicChannel | None = child(TopicChannel, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot2Neuron(ChannelTransferFunction):
    """A transfer function from the robot to the brain; its return value drives one more device."""

    return_value: DeviceChannel | None = child(DeviceChannel, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Neuron2Monitor(BIBITransferFunction):
    """A monitor that shows the values of a device."""

    device: DeviceChannel = child(DeviceChannel)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelFile(Node, abstract=True):
    """A file of the brain or of a robot, and its source."""

    model: str | None = attribute(WORD, None)
    is_custom: bool = attribute(TRUTH, False)
    custom_model_path: str | None = attribute(FILE, None)
    custom_asset: bool = attribute(TRUTH, False)
    asset_path: str | None = attribute(FILE, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class BrainModel(ModelFile):
    """The brain and its named populations."""

    file: str | None = child(FILE, None, bare=True)
    populations: tuple[MultiNeuronSelector, ...] = children(MultiNeuronSelector, aliases={"neuronGroup": ""})


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyModel(ModelFile):
    """A robot."""

    robot_id: str | None = attribute(WORD, None)
    file: str = content(FILE, "")


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration(Node):
    """A file for a part of the platform, such as ``retina`` or ``brainvisualizer``."""

    type: str = attribute(WORD)
    src: str = attribute(FILE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bibi(Node):
    """A whole model: the integration of a brain and a body.

    Args:
        timestep: the time step of the loop, ms.
        mode: the kind of brain simulation that a legacy experiment asks for.
        ext_robot_controller: a script that a legacy experiment starts beside the robot.
    """

    timestep: int | None = child(POSITIVE, None, unit="ms")
    brain_model: BrainModel | None = child(BrainModel, None)
    body_model: tuple[BodyModel, ...] = children(BodyModel)
    mode: str | None = child(WORD, None)
    ext_robot_controller: str | None = child(FILE, None)
    configuration: tuple[Configuration, ...] = children(Configuration)
    connectors: tuple[NeuronConnector, ...] = children(NeuronConnector)
    synapse_dynamics: tuple[SynapseDynamics, ...] = children(SynapseDynamics)
    transfer_function: tuple[TransferFunction, ...] = children(
        TransferFunction,
        aliases={
            "transferFunctionImport": "PythonTransferFunction",
            "transferFunctionInline": "PythonTransferFunction",
        },
    )
