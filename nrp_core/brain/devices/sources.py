"""Devices that drive neurons. The core draws their spikes, so that every backend gets the same spikes.

Names, units and defaults are those of the Neurorobotics Platform and PyNN (ms, Hz, nA, uS).
A source acts on its neurons from outside; it is not part of the network and does not change it.
"""

from nrp_core.brain.devices.currents import (
    ACPort,
    ACSource,
    DCPort,
    DCSource,
    NoisyCurrentPort,
    NoisyCurrentSource,
)  # fmt: skip
from nrp_core.brain.devices.injector import SpikeInjector, SpikeInjectorPort
from nrp_core.brain.devices.ports import SourcePort, SourceSpec
from nrp_core.brain.devices.trains import (
    FixedFrequencyPort,
    FixedFrequencySource,
    PoissonPort,
    PoissonSource,
    SpikeSourceSpec,
    TrainPort,
)  # fmt: skip

__all__ = [
    "ACPort",
    "ACSource",
    "DCPort",
    "DCSource",
    "FixedFrequencyPort",
    "FixedFrequencySource",
    "NoisyCurrentPort",
    "NoisyCurrentSource",
    "PoissonPort",
    "PoissonSource",
    "SourcePort",
    "SourceSpec",
    "SpikeInjector",
    "SpikeInjectorPort",
    "SpikeSourceSpec",
    "TrainPort",
]
