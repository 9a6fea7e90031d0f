"""The mean rates of afferents of muscles, in Hz.

The parameters of :class:`Spindle` and :class:`TendonOrgan` are in mm and N, those of a cat. The normalised
ones are in optimal lengths and peak forces of each muscle, so that they fit a body of any size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Spindle:
    """Mean rates of the endings of a muscle spindle, in the form of Prochazka.

    ``Ia = bias + stretch * x + velocity * sign(v) * |v|^exponent + emg * activation`` and
    ``II = bias + stretch * x + emg * activation``, at least 0, with the stretch x (mm) and its rate v (mm/s).
    The form is that of A. Prochazka and M. Gorassini, J. Physiol. 507:277 (1998). The default numbers are
    those of E. M. Moraud et al., Neuron 89:814 (2016), as public code has them; other authors have other
    biases.

    Args:
        ia_bias, ii_bias: rates at rest, Hz.
        ia_stretch, ii_stretch: Hz/mm.
        ia_velocity, ia_exponent: factor and exponent of the velocity.
        ia_emg, ii_emg: rates that alpha-gamma coactivation adds with the muscle's activation, Hz.
        gamma_dynamic: factor of the velocity term; 1 is the drive of the published numbers.
        gamma_static: the same factor for the bias and stretch terms.
        dead_zone: velocities below have no effect, mm/s; the slope of the velocity term is infinite at 0.
        highest: the highest rate, Hz.
    """

    normalized: ClassVar[bool] = False
    _units: ClassVar[float] = 1e3
    """Length unit of the parameters, per unit of the arguments: mm per m."""

    ia_bias: float = 50.0
    ia_stretch: float = 2.0
    ia_velocity: float = 4.3
    ia_exponent: float = 0.6
    ia_emg: float = 50.0
    ii_bias: float = 80.0
    ii_stretch: float = 13.5
    ii_emg: float = 20.0
    gamma_dynamic: float = 1.0
    gamma_static: float = 1.0
    dead_zone: float = 0.0
    highest: float = 300.0

    def ia(self, stretch: Any, velocity: Any, activation: Any = 0.0) -> Any:
        """Return the rate of primary endings, Hz.

        Args:
            stretch: length beyond that at rest, m.
            velocity: m/s, positive where the muscle lengthens.
            activation: 0 to 1.
        """
        speed = np.abs(np.multiply(velocity, self._units))
        speed = np.where(speed > self.dead_zone, speed, 0.0) ** self.ia_exponent
        moving = self.gamma_dynamic * self.ia_velocity * np.sign(velocity) * speed
        held = self.gamma_static * (self.ia_bias + self.ia_stretch * np.multiply(stretch, self._units))
        return np.clip(held + moving + np.multiply(activation, self.ia_emg), 0.0, self.highest)

    def ii(self, stretch: Any, activation: Any = 0.0) -> Any:
        """Return the rate of secondary endings, Hz; arguments as in :meth:`ia`."""
        held = self.gamma_static * (self.ii_bias + self.ii_stretch * np.multiply(stretch, self._units))
        return np.clip(held + np.multiply(activation, self.ii_emg), 0.0, self.highest)


@dataclass(frozen=True, slots=True)
class NormalizedSpindle(Spindle):
    """The same form with stretches in optimal lengths (L0) and velocities in L0/s.

    ``Ia = 200 x + 65 sign(v) |v|^0.5`` has the slopes and the exponent that two public codes attribute to
    A. Prochazka, Prog. Brain Res. 123:133 (1999), which was not read; II has the slope of Ia. There is no
    bias: stretches are measured from ``rest``, which is below the lengths at which muscles pull. The effect
    of the activation is that of :class:`Spindle`.

    Args:
        rest: the length without stretch, L0.
        by_rest: stretches and velocities are in lengths at rest, not optimal ones, and muscles that are
            shorter than at rest have a stretch of 0. S. N. Markin et al., Ann. N. Y. Acad. Sci. 1198:21
            (2010), have such a threshold; their numbers were not read, so give your own.
    """

    normalized: ClassVar[bool] = True
    _units: ClassVar[float] = 1.0

    ia_bias: float = 0.0
    ia_stretch: float = 200.0
    ia_velocity: float = 65.0
    ia_exponent: float = 0.5
    ii_bias: float = 0.0
    ii_stretch: float = 200.0
    rest: float = 0.4
    by_rest: bool = False


@dataclass(frozen=True, slots=True)
class TendonOrgan:
    """Mean rates of Golgi tendon organs: a logarithm of the tension, and a filter for its changes.

    The static rate is ``gain * ln(F / scale + 1)``. The filter is ``(1.7 s^2 + 2.58 s + 0.4) / (s^2 + 2.2 s +
    0.4)``, whose gain is 1 for constant and 1.7 for fast tensions: C. K. Lin and P. E. Crago, Ann. Biomed.
    Eng. 30:54 (2002).

    Args:
        gain: Hz.
        scale: N.
        highest: the highest rate, Hz.
    """

    normalized: ClassVar[bool] = False

    gain: float = 60.0
    scale: float = 4.0
    highest: float = 250.0

    def static(self, tension: Any) -> Any:
        """Return the rate for a constant tension (N), Hz."""
        return self.gain * np.log(np.maximum(tension, 0.0) / self.scale + 1.0)

    def filtered(
        self, tension: Any, state: FloatArray | None, step_s: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the rates after a step of the filter (Hz), and its new state.

        Args:
            tension: now, N, shape ``(n,)``.
            state: the previous state; None at the start, when the tension was constant before.
            step_s: time since the previous state, s.
        """
        now = np.asarray(self.static(tension), float)
        if state is None:
            state = np.stack([now, now, now, now])
        b, a = _bilinear((1.7, 2.58, 0.4), step_s), _bilinear((1.0, 2.2, 0.4), step_s)
        last, before, out, earlier = state
        rate = (b[0] * now + b[1] * last + b[2] * before - a[1] * out - a[2] * earlier) / a[0]
        return np.clip(rate, 0.0, self.highest), np.stack([now, last, rate, out])


@dataclass(frozen=True, slots=True)
class NormalizedTendonOrgan(TendonOrgan):
    """Rates that are proportional to the tension in peak forces (F0), with the same filter.

    The static rate is ``gain * (F / F0 - threshold)``, at least 0. By definition, the default gain gives
    the highest rate at the peak force.

    Args:
        gain: Hz.
        scale: not used.
        threshold: the share of the peak force above which the organs fire.
    """

    normalized: ClassVar[bool] = True

    gain: float = 250.0
    threshold: float = 0.0

    def static(self, tension: Any) -> Any:
        """Return the rate for a constant tension (peak forces), Hz."""
        return self.gain * np.maximum(np.subtract(tension, self.threshold), 0.0)


def _bilinear(polynomial: tuple[float, float, float], step_s: float) -> tuple[float, float, float]:
    """Return a quadratic in s as one in 1/z, by Tustin's method."""
    p, q, r = polynomial
    k = 2.0 / step_s
    return p * k * k + q * k + r, 2.0 * (r - p * k * k), p * k * k - q * k + r
