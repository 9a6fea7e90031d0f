"""The constants that a core derives from the parameters of its neurons when it starts.

All come from s16.15 parameters by the machine's truncating division and tabulated exponential.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal, localcontext

from nrp_brain_spinnaker.host.conversion import exact_exp, to_fraction
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.exponential import exp_accum, exp_fraction
from nrp_brain_spinnaker.machine.fixed_point import FRACTION_LARGEST, ONE, ceiling, div, mul
from nrp_brain_spinnaker.machine.hodgkin_huxley import LIFT_BITS, OPEN, gate_rates


def synapse_constants(kind: int, step: int, tau: int) -> tuple[int, int, int]:
    """Return decay, init and gain of a synapse.

    Args:
        kind: the synapse.
        step: length of a (sub-)step, ms, s16.15.
        tau: time constant, ms, s16.15.
    """
    if kind == kinds.DELTA:
        return 0, 0, 0
    if kind == kinds.PEAKED_ALPHA:
        return _peaked_constants(step, tau)
    decay = exp_fraction(-div(step, tau))
    if kind == kinds.ALPHA:  # the integer part of the slope is lost, as on the machine
        return decay, 0, div(step, mul(tau, tau)) & (ONE - 1)
    init = ((div(tau, step) * (FRACTION_LARGEST - decay)) >> 15) & FRACTION_LARGEST
    return decay, init, 0


def _peaked_constants(step: int, tau: int) -> tuple[int, int, int]:
    """Return the constants of an alpha function with peak 1, averaged over each step."""
    with localcontext(prec=40):
        x, e = Decimal(step) / Decimal(tau), exact_exp(Decimal(1))
        decay = exact_exp(-x)
        first_mean = e / x * (1 - decay * (1 + x))
        return to_fraction(decay), to_fraction(first_mean), to_fraction(e * decay * (1 - decay))


def membrane_constants(kind: int, step: int, raw: Mapping[str, int]) -> dict[int, int]:
    """Return the constants of a membrane by row, from s16.15 parameters and the (sub-)step."""
    if kind == kinds.IZHIKEVICH:
        parameters = zip((kinds.IZK_A, kinds.IZK_B, kinds.IZK_C, kinds.IZK_D), "abcd", strict=True)
        return {row: raw[name] for row, name in parameters} | {kinds.H_RESET: step}
    if kind == kinds.HODGKIN_HUXLEY:
        return _hodgkin_huxley(step, raw)
    if kind == kinds.ADAPTIVE_EXPONENTIAL:
        return _leaky(step, raw, raw["v_spike"]) | _adaptive(step, raw)
    return _leaky(step, raw, raw["v_thresh"])


def _leaky(step: int, raw: Mapping[str, int], threshold: int) -> dict[int, int]:
    return {
        kinds.R_MEMBRANE: div(raw["tau_m"], raw["cm"]),
        kinds.EXP_TC: exp_accum(-div(step, raw["tau_m"])),
        kinds.V_REST: raw["v_rest"],
        kinds.V_RESET: raw["v_reset"],
        kinds.V_THRESH: threshold,
        kinds.T_REFRACTORY: ceiling(div(raw["tau_refrac"], step)),
    }


def _adaptive(step: int, raw: Mapping[str, int]) -> dict[int, int]:
    """Return further constants of adaptive exponential cells; without a slope they fire at ``v_thresh``."""
    slope = raw["delta_T"]
    return {
        kinds.V_THRESH: raw["v_spike"] if slope else raw["v_thresh"],
        kinds.V_SOFT: raw["v_thresh"],
        kinds.SLOPE: slope,
        kinds.INVERSE_SLOPE: div(ONE, slope) if slope else 0,
        kinds.MEMBRANE_DECAY: _exact_decay(step, raw["tau_m"]),
        kinds.ADAPTATION: raw["a"],
        kinds.ADAPTATION_DECAY: _exact_decay(step, raw["tau_w"]),
        kinds.ADAPTATION_JUMP: raw["b"],
    }


def _exact_decay(step: int, tau: int) -> int:
    return to_fraction(exact_exp(-Decimal(step) / Decimal(tau)))


def _hodgkin_huxley(step: int, raw: Mapping[str, int]) -> dict[int, int]:
    names = {
        kinds.G_SODIUM: "gbar_Na", kinds.G_POTASSIUM: "gbar_K", kinds.G_LEAK: "g_leak",
        kinds.E_SODIUM: "e_rev_Na", kinds.E_POTASSIUM: "e_rev_K", kinds.E_LEAK: "e_rev_leak",
        kinds.V_OFFSET: "v_offset",
    }  # fmt: skip
    lift = (step << LIFT_BITS) // raw["cm"]
    return {row: raw[name] for row, name in names.items()} | {kinds.LIFT: lift, kinds.STEP: step}


def resting_gates(v_above_offset: int) -> tuple[int, int, int]:
    """Return the steady-state gates m, h and n at a voltage, s16.15, in units of 2**-30."""
    rates = gate_rates(v_above_offset)
    m, h, n = (OPEN * rates[k] // (rates[k] + rates[k + 1]) for k in (0, 2, 4))
    return m, h, n
