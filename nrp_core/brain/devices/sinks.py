"""Devices that record neurons: exact functions of their spikes, the same on every backend, or of their state.

Names, units and defaults are those of the Neurorobotics Platform and PyNN (ms, mV, nF, nA).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, prod
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.membrane import LeakyMembrane
from nrp_core.brain.spikes import NO_SPIKES, Spikes
from nrp_core.clock import NS_PER_MS, nanoseconds
from nrp_core.errors import CapabilityError
from nrp_core.network.filters import MembraneKernel

if TYPE_CHECKING:
    from nrp_core.brain.devices.short_term import ShortTermSynapses


@dataclass(frozen=True, slots=True)
class SinkSpec(ABC):
    """The specification of a sink; :meth:`open` connects it to neurons."""

    @abstractmethod
    def open(self, neurons: IntArray, n_neurons: int, name: str) -> SinkPort:
        """Return a sink connected to ``neurons`` (global ids) of a network with ``n_neurons``."""


class SinkPort(ABC):
    """A connected sink. With ``active = False`` it ignores spikes.

    Attributes:
        quantity: the name of the attribute with its current value, for recorders; None if it has none.
        unit: the unit of that value.
        passing: whether it only forwards spikes; it is then not part of a snapshot.
    """

    quantity: ClassVar[str | None] = None
    unit: ClassVar[str] = ""
    passing: ClassVar[bool] = False

    @property
    def filtering(self) -> int:
        """The address of the membrane that filters all its spikes; 0 if there is none."""
        return 0

    @property
    def counted(self) -> IntArray | None:
        """The number of spikes of each neuron of the network, if it only counts them."""
        return None

    def __init__(self, neurons: IntArray, n_neurons: int, name: str) -> None:
        self.neurons = neurons
        self.name = name
        self.active = True
        self._received = np.zeros(n_neurons, bool)
        self._received[neurons] = True
        self._receives_all = bool(self._received.all())

    def receive(self, spikes: Spikes, until_ms: float) -> None:
        """Receive the spikes of all neurons in the window that ends at ``until_ms``."""
        if not self.active:
            spikes = NO_SPIKES
        elif not self._receives_all and len(spikes):
            spikes = spikes.among(self._received)
        self._absorb(spikes, until_ms)

    @abstractmethod
    def _absorb(self, spikes: Spikes, until_ms: float) -> None: ...

    @abstractmethod
    def reset(self) -> None:
        """Restart at time 0."""

    @abstractmethod
    def save(self) -> object:
        """Return all state that changes while running."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""


@dataclass(frozen=True, slots=True)
class LeakyIntegrator(SinkSpec):
    """A neuron with infinite threshold that receives the spikes of all chosen neurons.

    Args:
        weight: nA; negative on the inhibitory receptor. None: +0.01 or -0.01, by receptor.
        delay: ms.
        receptor_type: ``excitatory`` or ``inhibitory``.
        cm, tau_m, tau_syn_E, tau_syn_I, v_rest, i_offset: as PyNN's IF_curr_alpha and IF_curr_exp.
        v_thresh: always infinity, since an integrator never fires.
        synapse_type: for short-term plasticity, see
            :class:`~nrp_core.brain.devices.short_term.ShortTermSynapses`.
    """

    weight: float | None = None
    delay: float = 0.1
    receptor_type: str = "excitatory"
    cm: float = 1.0
    tau_m: float = 10.0
    tau_syn_E: float = 2.0
    tau_syn_I: float = 2.0
    v_rest: float = 0.0
    v_reset: float = 0.0
    v_thresh: float = inf
    tau_refrac: float = 0.1
    i_offset: float = 0.0
    synapse_type: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        for name in ("cm", "tau_m", "tau_syn_E", "tau_syn_I"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ValueError(f"{name} must be positive, not {value}")
        if self.delay < 0 or not isfinite(self.delay):
            raise ValueError(f"delay must be 0 ms or more, not {self.delay}")
        if self.v_thresh != inf:
            raise CapabilityError(f"a leaky integrator never fires: v_thresh is inf, not {self.v_thresh}")

    def _open(
        self, kernel: MembraneKernel, neurons: IntArray, n_neurons: int, name: str
    ) -> LeakyIntegratorPort:
        port = LeakyIntegratorPort(kernel, self._weight(), self.delay, neurons, n_neurons, name)
        if self.synapse_type is not None:
            port.tire(self.synapse_type)
        return port

    def _kernel(self, alpha: bool) -> MembraneKernel:
        tau_syn = self.tau_syn_E if self.receptor_type == "excitatory" else self.tau_syn_I
        return MembraneKernel(alpha, self.tau_m, tau_syn, self.cm, self.v_rest, self.i_offset)

    def _weight(self) -> float:
        if self.weight is not None:
            return self.weight
        return 0.01 if self.receptor_type == "excitatory" else -0.01


@dataclass(frozen=True, slots=True)
class LeakyIntegratorAlpha(LeakyIntegrator):
    """Alpha-shaped currents, tau_m 10 ms, tau_syn 2 ms."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> LeakyIntegratorPort:
        return self._open(self._kernel(True), neurons, n_neurons, name)


@dataclass(frozen=True, slots=True)
class LeakyIntegratorExp(LeakyIntegrator):
    """Exponential currents, tau_m 20 ms, tau_syn 0.5 ms."""

    tau_m: float = 20.0
    tau_syn_E: float = 0.5
    tau_syn_I: float = 0.5

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> LeakyIntegratorPort:
        return self._open(self._kernel(False), neurons, n_neurons, name)


@dataclass(frozen=True, slots=True)
class PopulationRate(SinkSpec):
    """The summed firing rate of all chosen neurons, smoothed.

    A spike adds a difference of exponentials of unit area, so the mean is the sum of the rates in Hz.

    Args:
        tau_fall, tau_rise: ms; exchanged if the rise is slower than the fall.
    """

    tau_fall: float = 20.0
    tau_rise: float = 10.0

    def __post_init__(self) -> None:
        if not (self.tau_fall > 0 and self.tau_rise > 0):
            raise ValueError(f"tau_fall and tau_rise must be positive, not {self.tau_fall}, {self.tau_rise}")

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> PopulationRatePort:
        slow, fast = max(self.tau_fall, self.tau_rise), min(self.tau_fall, self.tau_rise)
        kernel = MembraneKernel(alpha=False, tau_m_ms=slow, tau_syn_ms=fast)
        return PopulationRatePort(kernel, 1000.0 / kernel.area, 0.0, neurons, n_neurons, name)


@dataclass(frozen=True, slots=True)
class SpikeRecorder(SinkSpec):
    """All spikes of the chosen neurons.

    Args:
        keep_ms: how long spikes are kept, ms; by default forever.
    """

    keep_ms: float = inf

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> SpikeRecorderPort:
        return SpikeRecorderPort(self.keep_ms, neurons, n_neurons, name)


class _FilterPort(SinkPort):
    """A linear filter of the spikes of all chosen neurons together.

    Attributes:
        place: the address of its state for compiled code.
    """

    def __init__(
        self,
        kernel: MembraneKernel,
        weight: float,
        delay_ms: float,
        neurons: IntArray,
        n_neurons: int,
        name: str,
    ) -> None:
        self._kernel, self._delay_ms, self._membrane = kernel, delay_ms, LeakyMembrane(kernel)
        self.place = self._membrane.place
        super().__init__(neurons, n_neurons, name)
        # A neuron that is chosen twice counts twice, as two synapses would.
        self._weights = np.bincount(neurons, minlength=n_neurons).astype(np.float64) * weight
        self._membrane.connect(self._weights, self._received, delay_ms)
        self._synapses: ShortTermSynapses | None = None

    @property
    def active(self) -> bool:
        """Whether it receives spikes."""
        return bool(self._membrane.record["active"][0])

    @active.setter
    def active(self, active: bool) -> None:
        self._membrane.record["active"] = active

    @property
    def filtering(self) -> int:
        return 0 if self._synapses is not None else self._membrane.place_for_spikes()

    @property
    def _now_ms(self) -> float:
        now_ms: float = self._membrane.record["now_ms"].item(0)
        return now_ms

    @_now_ms.setter
    def _now_ms(self, now_ms: float) -> None:
        self._membrane.record["now_ms"] = now_ms

    def make_room(self) -> None:
        """Make room for more waiting spikes."""
        self._membrane.grow()

    def tire(self, synapse_type: Mapping[str, Any]) -> None:
        """Give each neuron a synapse with short-term plasticity."""
        # imported here since it loads a compiler
        from nrp_core.brain.devices.short_term import ShortTermSynapses

        self._synapses = ShortTermSynapses(
            synapse_type, np.full(len(self._received), self._kernel.tau_syn_ms)
        )

    def reset(self) -> None:
        if self._synapses is not None:
            self._synapses.reset()
        self._membrane.reset()

    def receive(self, spikes: Spikes, until_ms: float) -> None:
        if self._synapses is not None:
            super().receive(spikes, until_ms)
            return
        self._now_ms = until_ms
        if self.active and len(spikes):
            self._membrane.receive(spikes.neurons, spikes.times_ms)

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        assert self._synapses is not None
        self._now_ms = until_ms
        if len(spikes):
            shares = self._synapses.released(spikes.neurons, spikes.times_ms)
            self._membrane.push(spikes.times_ms + self._delay_ms, self._weights[spikes.neurons] * shares)

    def save(self) -> object:
        synapses = None if self._synapses is None else self._synapses.save()
        return self._now_ms, self.active, self._membrane.state(), synapses

    def restore(self, saved: Any) -> None:
        self._now_ms, self.active, state, synapses = saved
        self._membrane.restore(state)
        if self._synapses is not None:
            self._synapses.restore(synapses)


class LeakyIntegratorPort(_FilterPort):
    """A connected leaky integrator."""

    quantity, unit = "voltage", "mV"

    @property
    def voltage(self) -> float:
        """Current membrane voltage, mV."""
        return self._membrane.voltage_mv(self._now_ms)


class PopulationRatePort(_FilterPort):
    """A connected population rate."""

    quantity, unit = "rate", "Hz"

    @property
    def rate(self) -> float:
        """Current smoothed sum of the firing rates, Hz."""
        return self._membrane.voltage_mv(self._now_ms)


class SpikeRecorderPort(SinkPort):
    """A connected spike recorder."""

    def __init__(self, keep_ms: float, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._keep_ms = keep_ms
        self.reset()

    def reset(self) -> None:
        self._parts: list[Spikes] = []

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        if len(spikes):
            self._parts.append(spikes)
        while self._parts and self._parts[0].times_ms[-1] <= until_ms - self._keep_ms:
            self._parts.pop(0)

    def spikes(self, since_ms: float = -inf, until_ms: float = inf) -> Spikes:
        """Return the spikes with ``since_ms < t <= until_ms``, ascending in time."""
        first = len(self._parts)
        while first and self._parts[first - 1].times_ms[-1] > since_ms:
            first -= 1
        return Spikes.merged(self._parts[first:]).within(since_ms, until_ms)

    def save(self) -> object:
        return self.active, list(self._parts)

    def restore(self, saved: Any) -> None:
        self.active, parts = saved
        self._parts = list(parts)


@dataclass(frozen=True, slots=True)
class StateRecorder(SinkSpec):
    """Samples of a state variable of each chosen neuron.

    Args:
        variable: its name, e.g. ``v`` (mV), ``gsyn_exc`` or ``gsyn_inh`` (uS).
        dt: ms between two samples, which lie at multiples of it after ``begin``, or at the brain's next grid
            point; the first sample is taken when the recorder is added.
        keep_ms: how long samples are kept, ms; by default forever.
        begin: ms; the time from which multiples are counted.
    """

    variable: str = "v"
    dt: float = 1.0
    keep_ms: float = inf
    begin: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.dt) and nanoseconds(self.dt) > 0):
            raise ValueError(f"dt must be at least 1 ns (1e-6 ms), not {self.dt} ms")

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> StateRecorderPort:
        return StateRecorderPort(self, neurons, n_neurons, name)


@dataclass(frozen=True, slots=True)
class VoltageRecorder(StateRecorder):
    """Membrane voltages, mV."""


@dataclass(frozen=True, slots=True)
class ConductanceRecorder(StateRecorder):
    """Conductances of the excitatory synapses, or with ``variable="gsyn_inh"`` of the inhibitory ones, uS."""

    variable: str = "gsyn_exc"


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """The samples that a recorder needs of a run.

    Args:
        variable: the state variable.
        neurons: global ids, shape ``(m,)``.
        times_ns: ascending times within the run, shape ``(n,)``.
    """

    variable: str
    neurons: IntArray
    times_ns: IntArray

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the samples: one row a time."""
        return len(self.times_ns), len(self.neurons)

    def earlier(self, by_ns: int) -> Trace:
        """Return the same samples with times counted from ``by_ns``."""
        return replace(self, times_ns=self.times_ns - by_ns)


def split_samples(samples: FloatArray, traces: Sequence[Trace]) -> list[FloatArray]:
    """Return the samples of each trace, which are contiguous, as views of shape ``(n, m)``."""
    ends = np.cumsum([prod(trace.shape) for trace in traces])
    return [part.reshape(trace.shape) for part, trace in zip(np.split(samples, ends), traces, strict=False)]


def run_halting(
    t_ns: int,
    traces: Sequence[Trace],
    samples: FloatArray,
    run: Callable[[int], None],
    read: Callable[[str, IntArray], FloatArray],
) -> None:
    """Run to a time with a halt at each sample, which is read and stored."""
    values, row = split_samples(samples, traces), [0] * len(traces)
    for stop_ns in np.unique(np.concatenate([[t_ns], *(trace.times_ns for trace in traces)])).tolist():
        run(stop_ns)
        for k, trace in enumerate(traces):
            if row[k] < len(trace.times_ns) and trace.times_ns[row[k]] == stop_ns:
                values[k][row[k]] = read(trace.variable, trace.neurons)
                row[k] += 1


class StateRecorderPort(SinkPort):
    """A connected state recorder."""

    def __init__(self, spec: StateRecorder, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._spec = spec
        self._interval_ns, self._begin_ns = nanoseconds([spec.dt, spec.begin]).tolist()
        self.reset()

    @property
    def variable(self) -> str:
        """The recorded variable."""
        return self._spec.variable

    def due(self, since_ns: int, until_ns: int, grid_ns: int) -> Trace:
        """Return the samples to be taken, ``since < t <= until``, each at a point of the brain's grid."""
        first, last = ((t_ns - self._begin_ns) // self._interval_ns + 1 for t_ns in (since_ns, until_ns))
        exact_ns = self._begin_ns + np.arange(first, last) * self._interval_ns
        times_ns = np.minimum(-(-exact_ns // grid_ns) * grid_ns, until_ns)
        if len(times_ns) > 1:  # they ascend
            times_ns = times_ns[np.append(True, np.diff(times_ns) > 0)]
        return Trace(self.variable, self.neurons, times_ns)

    def take(self, times_ns: IntArray, values: FloatArray) -> None:
        """Store samples of each neuron, shape ``(n, n_neurons)``, if the recorder is active."""
        if self.active and len(times_ns):
            self._samples.append((times_ns / NS_PER_MS, values))

    def samples(self, since_ms: float = -inf, until_ms: float = inf) -> tuple[FloatArray, FloatArray]:
        """Return times (ms) with ``since < t <= until``, shape ``(n,)``, and values, ``(n, n_neurons)``."""
        begin = len(self._samples)
        while begin and self._samples[begin - 1][0][-1] > since_ms - 1 / NS_PER_MS:
            begin -= 1
        parts = self._samples[begin:] or [(np.empty(0), np.empty((0, len(self.neurons))))]
        times, values = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
        first, last = np.searchsorted(nanoseconds(times), nanoseconds([since_ms, until_ms]), side="right")
        return times[first:last], values[first:last]

    def parts(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield all times (ms) and values in the pieces in which they were stored, without a copy."""
        yield from self._samples

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        oldest_ms = until_ms - self._spec.keep_ms
        while self._samples and self._samples[0][0][0] <= oldest_ms:
            times, values = self._samples.pop(0)
            first = int(np.searchsorted(times, oldest_ms, side="right"))
            if first < len(times):
                self._samples.insert(0, (times[first:], values[first:].copy()))

    def reset(self) -> None:
        self._samples: list[tuple[FloatArray, FloatArray]] = []

    def save(self) -> object:
        return self.active, list(self._samples)

    def restore(self, saved: Any) -> None:
        self.active, samples = saved
        self._samples = list(samples)
