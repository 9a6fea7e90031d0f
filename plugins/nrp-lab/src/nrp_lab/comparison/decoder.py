"""The decoder alone: a brain without cells that predicts the values of sinks from those of sources.

A ridge regression on the settings of all sources in the last 200 ms, fitted to recorded runs with the
intact brain. If a behaviour survives it, a linear function of the brain's inputs is enough.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nrp_core.brain import (
    Brain,
    BrainBackend,
    BrainCapabilities,
    BrainOptions,
    FloatArray,
    IntArray,
    Network,
    Population,
    Projection,
    Spikes,
    SynapticEvents,
)
from nrp_core.dsl import spike_recorder
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Plan
from nrp_core.recording import Role
from nrp_core.recording.layout import device_topic
from nrp_core.simulation import Determinism
from nrp_lab.comparison.signals import RunSignals

REACH_S = 0.2
"""How far back the inputs count."""
PENALTIES = np.logspace(-6, 4, 41)
"""Penalties of the regression, relative to the variance of an input; the best one has the least error by
generalised cross-validation: Golub, Heath and Wahba 1979, Technometrics 21:215."""

VOLTAGE = "v"
MOST_INPUTS, MOST_VALUES = 20_000, 20_000_000
"""Columns and size of the matrix of a fit, of 160 MB; the fit takes a few times that."""


@dataclass(frozen=True)
class Decoder:
    """A linear map from the recent settings of sources to the values of sinks.

    Args:
        sources: number of values of each source, by its topic in a recording.
        sinks: the same of each sink, and of the recorded voltages of each population.
        cells: the population and the indices of the cells of each topic of voltages.
        lags: number of loop steps that are used.
        weights: shape ``(lags * n_inputs, n_outputs)``, the latest step first.
        offsets: each output without inputs.
        low, high: smallest and largest value of each output in the fitted runs; they clip predictions.
        explained: share of the variance of each output that the fit explains; NaN for a constant one.
    """

    sources: Mapping[str, int]
    sinks: Mapping[str, int]
    cells: Mapping[str, tuple[str, IntArray]]
    lags: int
    weights: FloatArray
    offsets: FloatArray
    low: FloatArray
    high: FloatArray
    explained: FloatArray

    @classmethod
    def fit(cls, runs: Iterable[RunSignals]) -> Decoder:
        """Return the decoder of some runs.

        Raises:
            ExperimentError: functions do not set a source or do not read a value of a sink, or set too many.
        """
        runs = list(runs)
        sources, sinks = (
            {one.name: one for run in runs for one in run.numbers.with_role(*roles)}
            for roles in ([Role.SOURCE], [Role.SINK, Role.VOLTAGE])
        )
        if not sources or not sinks:
            what = "set no source" if not sources else "read no value of a sink"
            raise ExperimentError(f"the functions {what}, so a decoder has nothing to learn from")
        given, read = (
            {name: max(_values(run, name).shape[1] for run in runs) for name in sorted(names)}
            for names in (sources, sinks)
        )
        cells = {
            name: (one.about["population"], np.array(json.loads(one.about["elements"]), int))
            for name, one in sinks.items()
            if one.role == Role.VOLTAGE
        }
        lags = max(1, round(REACH_S / runs[0].step_s))
        every = thinning(sum(len(run.times_s) for run in runs), lags * sum(given.values()))
        inputs = np.concatenate([_lagged(_table(run, given)[:-1], lags, every) for run in runs])
        values = np.concatenate([_table(run, read)[1::every] for run in runs])
        weights, offsets, explained = ridge(inputs, values)
        low, high = values.min(axis=0), values.max(axis=0)
        return cls(given, read, cells, lags, weights, offsets, low, high, explained)

    @property
    def digest(self) -> str:
        """A text that differs between decoders."""
        return hashlib.blake2b(self.weights.tobytes() + self.offsets.tobytes(), digest_size=8).hexdigest()

    def guess(self, history: FloatArray) -> dict[str, FloatArray]:
        """Return the values of each sink.

        Args:
            history: settings of the sources, shape ``(lags, n_inputs)``, the latest first.
        """
        return self._by_sink(np.clip(history.ravel() @ self.weights + self.offsets, self.low, self.high))

    @property
    def explained_by_sink(self) -> dict[str, float]:
        """The share of the variance of each sink that the fit explains, averaged over values that vary."""
        shares = {name: values[~np.isnan(values)] for name, values in self._by_sink(self.explained).items()}
        return {name: float(values.mean()) if len(values) else 1.0 for name, values in shares.items()}

    def _by_sink(self, values: FloatArray) -> dict[str, FloatArray]:
        ends = np.cumsum(list(self.sinks.values()))
        return dict(zip(self.sinks, np.split(values, ends[:-1]), strict=True))


def thinning(n_steps: int, n_inputs: int) -> int:
    """Return which steps are fitted, every first, second or later one, so that they fit in memory.

    Raises:
        ExperimentError: there are too many inputs.
    """
    if n_inputs > MOST_INPUTS:
        raise ExperimentError(
            f"the sources have {n_inputs} values in {REACH_S:g} s, more than {MOST_INPUTS} for a decoder"
        )
    return max(1, -(-n_steps * n_inputs // MOST_VALUES))


def ridge(inputs: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return weights, offsets and explained shares of variance of a regression of values on inputs.

    The penalty is the same for all values, which count alike whatever their units.

    Args:
        inputs: shape ``(n, n_inputs)``.
        values: shape ``(n, n_values)``.
    """
    centre, scale = inputs.mean(axis=0), inputs.std(axis=0)
    scale[scale == 0.0] = np.inf
    offset = values.mean(axis=0)
    standard = (inputs - centre) / scale
    size, n = values.std(axis=0), len(values)
    target = (values - offset) / np.where(size > 0, size, np.inf)
    if len(standard) < standard.shape[1]:
        _, singular, rows = np.linalg.svd(standard, full_matrices=False)
        variances, axes = singular**2, rows.T
    else:  # a tenth of the work
        variances, axes = np.linalg.eigh(standard.T @ standard)
        variances = np.maximum(variances, 0.0)
    projected = axes.T @ (standard.T @ target)
    total = (target**2).sum()
    errors = []
    for penalty in n * PENALTIES:
        shrunk = variances + penalty
        residual = total - (((shrunk + penalty) / shrunk**2)[:, np.newaxis] * projected**2).sum()
        errors.append(residual / max(n - 1 - (variances / shrunk).sum(), 1e-9) ** 2)
    penalty = n * PENALTIES[int(np.argmin(errors))]
    weights = axes @ (projected / (variances + penalty)[:, np.newaxis])
    weights *= size / scale[:, np.newaxis]
    offsets = offset - centre @ weights
    residuals = values - inputs @ weights - offsets
    explained = np.where(size > 0, 1 - residuals.var(axis=0) / np.where(size > 0, size**2, 1), np.nan)
    return weights, offsets, explained


def _values(run: RunSignals, name: str) -> FloatArray:
    """Return a series at the ends of all steps, 0 before its first value, shape ``(n_times, n_values)``."""
    found = run.numbers.series.get(name)
    return np.zeros((len(run.times_s), 1)) if found is None else np.nan_to_num(run.held(found))


def _table(run: RunSignals, widths: Mapping[str, int]) -> FloatArray:
    """Return several series side by side; one value may apply to all neurons."""
    return np.concatenate(
        [np.broadcast_to(_values(run, name), (len(run.times_s), width)) for name, width in widths.items()],
        axis=1,
    )


def _lagged(inputs: FloatArray, lags: int, every: int = 1) -> FloatArray:
    """Return for each time, or k-th, the inputs of the last steps, the latest first; 0 before the start."""
    n, width = inputs.shape
    padded = np.concatenate([np.zeros((lags - 1, width)), inputs])
    return np.concatenate(
        [padded[lags - 1 - lag : lags - 1 - lag + n : every] for lag in range(lags)], axis=1
    )


# -- as a brain


def with_decoder(plan: Plan, decoder: Decoder) -> Plan:
    """Return a plan with a decoder in the place of the simulator.

    Raises:
        ExperimentError: a function reads spikes, which a decoder does not have.
    """
    for function in plan.functions:
        for parameter, mapping in function.mappings.items():
            if getattr(mapping, "kind", None) is spike_recorder:
                raise ExperimentError(
                    f"'{function.name}' reads spikes with its parameter '{parameter}', and a decoder has none"
                )
    backend = DecoderBackend(decoder, plan.brain.capabilities)
    options = BrainOptions()
    side = replace(plan.brain, backend=backend, options=options, capabilities=backend.capabilities(options))
    return replace(plan, brain=side)


class DecoderBackend(BrainBackend):
    """Opens a decoder.

    Args:
        decoder: the decoder.
        capabilities: those of the brain that it replaces.
    """

    def __init__(self, decoder: Decoder, capabilities: BrainCapabilities) -> None:
        self._decoder = decoder
        self._capabilities = replace(
            capabilities, determinism=Determinism.BITWISE, changes=frozenset(),
            state_variables=capabilities.state_variables & {VOLTAGE},
            rewiring=False, rewards=False, synapse_state=frozenset(), snapshot=False, releases_gil=False,
        )  # fmt: skip

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return self._capabilities

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return DecoderBrain(self._decoder, network, seed, self._capabilities)


class DecoderBrain(Brain):
    """A network whose cells never fire; its sinks and voltages have the values that a decoder predicts."""

    def __init__(
        self, decoder: Decoder, network: Network, seed: int, capabilities: BrainCapabilities
    ) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities, identity="decoder")
        self._decoder = decoder
        self._clear()

    def _clear(self) -> None:
        self._history = np.zeros((self._decoder.lags, sum(self._decoder.sources.values())))
        self._voltages = np.zeros(self.network.size)
        for label, population in self.network.populations.items():
            self._voltages[self.network.ids_of(label)] = population.initial_values.get(VOLTAGE, 0.0)

    def _emits(self, population: Population) -> bool:
        return True

    def _run_under_currents(self, t_ns: int) -> None:
        """Guess once a step of the loop, not at each change of a current: none flows here."""
        self._run_recording(self.now_ns, t_ns, self.capabilities.resolution_ns or 1)

    def _do_run_recording(self, t_ns: int, traces: Sequence[Any], samples: FloatArray) -> None:
        self._do_run_until(t_ns)
        values = [np.tile(self._voltages[trace.neurons], len(trace.times_ns)) for trace in traces]
        samples[:] = np.concatenate(values)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self._voltages[neurons]

    def _do_run_until(self, t_ns: int) -> None:
        ports = dict(_by_topic(self.devices))
        given = [
            np.broadcast_to(np.asarray(getattr(ports[name], ports[name].quantity), float), width)
            if name in ports
            else np.zeros(width)
            for name, width in self._decoder.sources.items()
        ]
        self._history = np.roll(self._history, 1, axis=0)
        self._history[0] = np.concatenate(given)
        for name, values in self._decoder.guess(self._history).items():
            if name in self._decoder.cells:
                label, cells = self._decoder.cells[name]
                self._voltages[self.network.offsets[label] + cells] = values
            elif name in ports:
                _show(ports[name], float(values[0]))

    def _do_take_spikes(self) -> Spikes:
        return Spikes()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None: ...

    def _do_inject(self, events: SynapticEvents) -> None: ...

    def _do_set_current(self, currents_na: FloatArray) -> None: ...

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return projection.weight.copy()

    def _do_reset(self, seed: int) -> None:
        self._clear()

    def _do_close(self) -> None: ...


def _by_topic(ports: Iterable[Any]) -> Iterator[tuple[str, Any]]:
    """Yield the devices with a value, by their topics in a recording."""
    taken: set[str] = set()
    for port in ports:
        if port.quantity is not None:
            topic = first = device_topic(port.name, port.quantity)
            number = 1
            while topic in taken:
                number += 1
                topic = f"{first}_{number}"
            taken.add(topic)
            yield topic, port


def _show(port: Any, value: float) -> None:
    """Set the value of a sink, whatever it receives."""
    if not hasattr(port, "guessed"):
        kind = type(port)
        port.__class__ = type(kind.__name__, (kind,), {kind.quantity: property(lambda self: self.guessed)})
    port.guessed = value
