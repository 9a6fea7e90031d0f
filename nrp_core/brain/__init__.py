"""The names that authors of brain backends need; each is imported when it is first used.

A backend derives from :class:`Brain` and :class:`BrainBackend`; it receives a :class:`Network`.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core._support.arrays import BoolArray as BoolArray
    from nrp_core._support.arrays import FloatArray as FloatArray
    from nrp_core._support.arrays import IndexArray as IndexArray
    from nrp_core._support.arrays import IntArray as IntArray
    from nrp_core._support.closing import Closing as Closing
    from nrp_core._support.diagnosis import Diagnosis as Diagnosis
    from nrp_core._support.subnormals import flushing_subnormals as flushing_subnormals
    from nrp_core.brain.backend import BRAIN_INTERFACE_VERSION as BRAIN_INTERFACE_VERSION
    from nrp_core.brain.backend import BrainBackend as BrainBackend
    from nrp_core.brain.backend import BrainOptions as BrainOptions
    from nrp_core.brain.capabilities import BrainCapabilities as BrainCapabilities
    from nrp_core.brain.capabilities import Fact as Fact
    from nrp_core.brain.capabilities import Quantity as Quantity
    from nrp_core.brain.capabilities import Report as Report
    from nrp_core.brain.capabilities import Table as Table
    from nrp_core.brain.devices.ports import SourcePort as SourcePort
    from nrp_core.brain.devices.ports import SourceSpec as SourceSpec
    from nrp_core.brain.devices.sinks import ConductanceRecorder as ConductanceRecorder
    from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha as LeakyIntegratorAlpha
    from nrp_core.brain.devices.sinks import LeakyIntegratorExp as LeakyIntegratorExp
    from nrp_core.brain.devices.sinks import PopulationRate as PopulationRate
    from nrp_core.brain.devices.sinks import SinkPort as SinkPort
    from nrp_core.brain.devices.sinks import SinkSpec as SinkSpec
    from nrp_core.brain.devices.sinks import SpikeRecorder as SpikeRecorder
    from nrp_core.brain.devices.sinks import SpikeRecorderPort as SpikeRecorderPort
    from nrp_core.brain.devices.sinks import StateRecorder as StateRecorder
    from nrp_core.brain.devices.sinks import StateRecorderPort as StateRecorderPort
    from nrp_core.brain.devices.sinks import VoltageRecorder as VoltageRecorder
    from nrp_core.brain.devices.source_cells import TrainQueue as TrainQueue
    from nrp_core.brain.devices.sources import ACSource as ACSource
    from nrp_core.brain.devices.sources import DCSource as DCSource
    from nrp_core.brain.devices.sources import FixedFrequencySource as FixedFrequencySource
    from nrp_core.brain.devices.sources import NoisyCurrentSource as NoisyCurrentSource
    from nrp_core.brain.devices.sources import PoissonSource as PoissonSource
    from nrp_core.brain.devices.sources import SpikeInjector as SpikeInjector
    from nrp_core.brain.interface import Brain as Brain
    from nrp_core.brain.remote import ProcessLock as ProcessLock
    from nrp_core.brain.remote import RemoteBrain as RemoteBrain
    from nrp_core.brain.remote import RemoteOptions as RemoteOptions
    from nrp_core.brain.spikes import Spikes as Spikes
    from nrp_core.brain.spikes import SynapticEvents as SynapticEvents
    from nrp_core.findings import Code as Code
    from nrp_core.findings import Finding as Finding
    from nrp_core.findings import Findings as Findings
    from nrp_core.findings import Level as Level
    from nrp_core.findings import Weight as Weight
    from nrp_core.findings.refusals import no_variable as no_variable
    from nrp_core.network.changes import DOPAMINE as DOPAMINE
    from nrp_core.network.changes import ELIGIBILITY as ELIGIBILITY
    from nrp_core.network.changes import PARAMETERS as PARAMETERS
    from nrp_core.network.changes import PLASTICITY as PLASTICITY
    from nrp_core.network.changes import WEIGHTS as WEIGHTS
    from nrp_core.network.changes import ParameterChange as ParameterChange
    from nrp_core.network.changes import Synapses as Synapses
    from nrp_core.network.currents import InjectedCurrent as InjectedCurrent
    from nrp_core.network.data import RECEPTORS as RECEPTORS
    from nrp_core.network.data import Network as Network
    from nrp_core.network.data import Origin as Origin
    from nrp_core.network.data import Population as Population
    from nrp_core.network.data import Projection as Projection
    from nrp_core.network.grid import Grid as Grid
    from nrp_core.network.grid import same_order as same_order
    from nrp_core.network.modulations import modulations_of as modulations_of
    from nrp_core.network.motoneurons import MotoneuronPool as MotoneuronPool
    from nrp_core.network.pynn import builder as builder
    from nrp_core.network.pynn.export import network_of as network_of
    from nrp_core.network.rewiring import Neuromodulation as Neuromodulation
    from nrp_core.network.synapses import STATIC as STATIC
    from nrp_core.network.synapses import STDP as STDP
    from nrp_core.network.synapses import TSODYKS_MARKRAM as TSODYKS_MARKRAM
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
