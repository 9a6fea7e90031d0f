"""The curves of muscles, for engines that apply wrenches to bodies.

The equations are those of MuJoCo (``engine_util_misc.c``), so that a muscle is the same in all engines.
"""

from __future__ import annotations

from nrp_core._support.jit import inlined


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
