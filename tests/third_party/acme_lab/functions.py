"""A device of transfer functions, and functions in files of rules."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_core.brain import Brain, PopulationRate
from nrp_core.dsl import CustomDevice, Listing, PythonSource, TransferFunction, load_transfer_functions


class MeanRate(CustomDevice):
    """The mean rate of neurons, Hz."""

    def apply(self, neurons: Any, brain: Brain) -> None:
        self._sink: Any = brain.add_sink(PopulationRate(tau_fall=50.0), neurons.ids, name="mean_rate")

    @property
    def value(self) -> float:
        """The rate, Hz."""
        return float(self._sink.rate / len(self._sink.neurons))


RULE = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

@nrp.MapSpikeSink("rate", nrp.brain.{population}, nrp.device("AcmeRate"))
@nrp.Neuron2Robot(nrp.Topic("{topic}", Float64))
def rule_{number}(t, rate):
    return Float64({gain} * rate.value)
"""


def _source(path: Path) -> PythonSource:
    """Return the Python of a file with lines ``topic = gain * population``."""
    rules = [line.replace("=", " ").replace("*", " ").split() for line in path.read_text().splitlines()]
    code = "".join(
        RULE.format(topic=topic, gain=float(gain), population=population, number=i)
        for i, (topic, gain, population) in enumerate(rules)
    )
    return PythonSource.of(code, path)


def load_rules(path: Path) -> list[TransferFunction]:
    """Return a transfer function for each rule."""
    return load_transfer_functions(path, code=compile(_source(path).tree, path, "exec"))


def list_rules(path: Path) -> Listing:
    """Return the Python of the rules, without executing it."""
    return Listing((_source(path),))
