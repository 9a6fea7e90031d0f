"""The errors of sensors: white noise, a bias that lasts or drifts, and steps of a digital reading."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, expm1, sqrt

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.scene.devices import Noise
from nrp_core.seeds import Seeds


class Errors:
    """The errors of what one sensor measures, which depend on the seed, a name and the times of its readings.

    A bias is drawn once, with either sign. One that drifts is an Ornstein-Uhlenbeck process from there, with
    the exact solution from reading to reading, as in Gazebo: after ``dt`` it is ``exp(-dt / tau)`` of itself
    and normal with the variance ``-sigma^2 tau / 2 expm1(-2 dt / tau)``.

    Args:
        seed: returns that of the run, which may change.
    """

    def __init__(self, seed: Callable[[], int]) -> None:
        self._seed = seed
        self.biases: dict[str, tuple[int, FloatArray]] = {}

    def on(self, name: str, now_ns: int, numbers: FloatArray, noises: Noise | Sequence[Noise]) -> FloatArray:
        """Return numbers with errors.

        Args:
            name: of the numbers, such as their topic.
            now_ns: the time of the reading.
            numbers: of any shape.
            noises: one for all numbers, with a common bias, or one for each number, in their order.
        """
        if isinstance(noises, Noise):
            return self._on(name, now_ns, numbers, (noises,), ())
        return self._on(name, now_ns, numbers, noises, numbers.shape)

    def _on(
        self, name: str, now_ns: int, numbers: FloatArray, noises: Sequence[Noise], shape: tuple[int, ...]
    ) -> FloatArray:
        if not any(noises):
            return numbers
        means, deviations, steps = (
            np.reshape([getattr(each, field) for each in noises], shape)
            for field in ("mean", "stddev", "precision")
        )
        stream = self._stream(f"{name}@{now_ns}")
        measured = numbers + stream.normal(means, deviations, numbers.shape)
        measured = measured + np.reshape(self._biases(name, now_ns, noises), shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(steps > 0, np.rint(measured / steps) * steps, measured)

    def _biases(self, name: str, now_ns: int, noises: Sequence[Noise]) -> FloatArray:
        if not any(each.bias_mean or each.bias_stddev or each.drifts for each in noises):
            return np.zeros(len(noises))
        if name not in self.biases:
            stream = self._stream(f"{name}@bias")
            values = stream.normal([each.bias_mean for each in noises], [each.bias_stddev for each in noises])
            self.biases[name] = now_ns, values * stream.choice((-1.0, 1.0), len(noises))
        then_ns, values = self.biases[name]
        if now_ns > then_ns and any(each.drifts for each in noises):
            steps = self._stream(f"{name}@{now_ns}/drift").standard_normal(len(noises))
            pairs = zip(noises, values.tolist(), steps.tolist(), strict=True)
            values = np.array([_drifted(*pair, (now_ns - then_ns) * 1e-9) for pair in pairs])
            self.biases[name] = now_ns, values
        return values

    def _stream(self, name: str) -> np.random.Generator:
        return Seeds(self._seed()).child("world/noise").stream(name)


def _drifted(noise: Noise, bias: float, normal: float, dt: float) -> float:
    if not noise.drifts:
        return bias
    tau = noise.drift_time_s
    return exp(-dt / tau) * bias + normal * noise.drift_stddev * sqrt(-tau / 2 * expm1(-2 * dt / tau))
