"""The curves of muscles and their activations, for engines that have no muscles of their own.

The equations are those of MuJoCo (``engine_util_misc.c``), so that a muscle is the same in all engines.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.drives.muscles import Muscle

LENGTH, VELOCITY, TENSION, ACTIVATION = range(4)
_FORCE, _OPTIMAL, _SLACK, _LMIN, _LMAX, _VMAX, _FPMAX, _FVMAX, _RISE, _FALL, _SMOOTH = range(11)
_PARAMETERS = ("force", "optimal_length", "slack_length", "lmin", "lmax", "vmax", "fpmax", "fvmax",
               "activation_s", "deactivation_s", "smoothing")  # fmt: skip


def parameters_of(muscles: Iterable[Muscle]) -> FloatArray:
    """Return the parameters of muscles for :func:`exert` and :func:`activate`, shape ``(n, 11)``."""
    numbers = [[getattr(muscle, name) for name in _PARAMETERS] for muscle in muscles]
    return np.array(numbers, float).reshape(-1, len(_PARAMETERS))


@inlined
def force_length(length: float, lmin: float, lmax: float) -> float:
    """Return the active force at a normalised length, a share of the peak force."""
    if length < lmin or length > lmax:
        return 0.0
    a, b = 0.5 * (lmin + 1.0), 0.5 * (1.0 + lmax)
    if length <= a:
        x = (length - lmin) / (a - lmin)
        return 0.5 * x * x
    if length <= 1.0:
        x = (1.0 - length) / (1.0 - a)
        return 1.0 - 0.5 * x * x
    if length <= b:
        x = (length - 1.0) / (b - 1.0)
        return 1.0 - 0.5 * x * x
    x = (lmax - length) / (lmax - b)
    return 0.5 * x * x


@inlined
def force_velocity(velocity: float, fvmax: float) -> float:
    """Return the factor of the active force at a normalised velocity."""
    y = fvmax - 1.0
    if velocity <= -1.0:
        return 0.0
    if velocity <= 0.0:
        return (velocity + 1.0) * (velocity + 1.0)
    if velocity <= y:
        return fvmax - (y - velocity) * (y - velocity) / y
    return fvmax


@inlined
def force_velocity_slope(velocity: float, fvmax: float) -> float:
    """Return the derivative of :func:`force_velocity`."""
    y = fvmax - 1.0
    if velocity <= -1.0 or velocity > y:
        return 0.0
    return 2.0 * (velocity + 1.0) if velocity <= 0.0 else 2.0 * (y - velocity) / y


@inlined
def passive_force(length: float, lmax: float, fpmax: float) -> float:
    """Return the passive force at a normalised length, a share of the peak force."""
    b = 0.5 * (1.0 + lmax)
    if length <= 1.0:
        return 0.0
    if length <= b:
        x = (length - 1.0) / (b - 1.0)
        return 0.5 * fpmax * x * x
    return fpmax * (0.5 + (length - b) / (b - 1.0))


@inlined
def activation_rate(control: float, activation: float, rise: float, fall: float, smooth: float) -> float:
    """Return the derivative of an activation, 1/s."""
    excitation = min(max(control, 0.0), 1.0)
    factor = 0.5 + 1.5 * min(max(activation, 0.0), 1.0)
    difference = excitation - activation
    up, down = rise * factor, fall / factor
    if smooth > 0.0:
        x = min(max(difference / smooth + 0.5, 0.0), 1.0)
        constant = down + (up - down) * x * x * x * (3.0 * x * (2.0 * x - 5.0) + 10.0)
    else:
        constant = up if difference > 0.0 else down
    return difference / constant


@jit
def exert(parameters: FloatArray, states: FloatArray, slopes: FloatArray) -> None:
    """Compute the tensions of muscles.

    Args:
        parameters: of each muscle, shape ``(n, 11)``.
        states: the states of the muscles, shape ``(4, n)``; receives the tensions.
        slopes: receives the derivatives of the tensions by the velocities, N s/m, shape ``(n,)``.
    """
    for n in range(len(parameters)):
        p = parameters[n]
        relative, fastest = (states[LENGTH, n] - p[_SLACK]) / p[_OPTIMAL], p[_OPTIMAL] * p[_VMAX]
        rate = states[VELOCITY, n] / fastest
        active = p[_FORCE] * force_length(relative, p[_LMIN], p[_LMAX]) * states[ACTIVATION, n]
        tension = active * force_velocity(rate, p[_FVMAX])
        tension += p[_FORCE] * passive_force(relative, p[_LMAX], p[_FPMAX])
        slopes[n] = active * force_velocity_slope(rate, p[_FVMAX]) / fastest
        states[TENSION, n] = tension


@jit
def activate(controls: FloatArray, parameters: FloatArray, states: FloatArray, step_s: float) -> None:
    """Advance activations by a step of Euler's method, as MuJoCo does; the arrays are those of `exert`."""
    for n in range(len(controls)):
        p, now = parameters[n], states[ACTIVATION, n]
        states[ACTIVATION, n] += step_s * activation_rate(controls[n], now, p[_RISE], p[_FALL], p[_SMOOTH])
