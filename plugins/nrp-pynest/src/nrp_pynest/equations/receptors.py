"""The currents of receptors as equations: exponential, alpha-shaped, or a difference of exponentials."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Receptor:
    """A receptor, whose current is ``I_syn_NAME``.

    Args:
        equations: its equations.
        effect: the effect of a spike.
        units: the units of its parameters.
    """

    equations: str
    effect: str
    units: dict[str, str] = field(default_factory=dict)


def exponential_current(name: str) -> Receptor:
    """Return a current that jumps by the weight and decays."""
    return Receptor(
        f"dI_syn_{name}/dt = -I_syn_{name}/tau_syn_{name} : pA",
        f"I_syn_{name} += weight",
        {f"tau_syn_{name}": "ms"},
    )


def alpha_current(name: str) -> Receptor:
    """Return a current that peaks at the weight after the time constant."""
    return Receptor(
        f"dI_syn_{name}/dt = (exp(1.0)*y_{name} - I_syn_{name})/tau_syn_{name} : pA\n"
        f"dy_{name}/dt = -y_{name}/tau_syn_{name} : pA",
        f"y_{name} += weight",
        {f"tau_syn_{name}": "ms"},
    )


def two_alpha_currents(name: str) -> Receptor:
    """Return a fast current that peaks at the weight, and a slow one that peaks at a fraction of it."""
    return Receptor(
        f"dfast_{name}/dt = (exp(1.0)*y_{name} - fast_{name})/tau_syn_fast_{name} : pA\n"
        f"dy_{name}/dt = -y_{name}/tau_syn_fast_{name} : pA\n"
        f"dslow_{name}/dt = (exp(1.0)*z_{name} - slow_{name})/tau_syn_slow_{name} : pA\n"
        f"dz_{name}/dt = -z_{name}/tau_syn_slow_{name} : pA\n"
        f"darrived_{name}/dt = 0.0*pA/ms : pA\n"
        f"I_syn_{name} = fast_{name} + slow_{name} : pA",
        f"arrived_{name} += weight",
        {f"tau_syn_fast_{name}": "ms", f"tau_syn_slow_{name}": "ms", f"amp_slow_{name}": "1"},
    )


def spread_arrived(name: str) -> str:
    """Return what :func:`two_alpha_currents` does at each grid point."""
    return (
        f"y_{name} += arrived_{name}; z_{name} += amp_slow_{name}*arrived_{name}; arrived_{name} = 0.0*pA; "
    )


def exponential_conductance(name: str) -> Receptor:
    """Return the current of a conductance that jumps by the weight and decays."""
    return Receptor(
        f"dg_{name}/dt = -g_{name}/tau_syn_{name} : nS\nI_syn_{name} = g_{name}*(E_rev_{name} - v) : pA",
        f"g_{name} += weight",
        {f"tau_syn_{name}": "ms", f"E_rev_{name}": "mV"},
    )


def alpha_conductance(name: str) -> Receptor:
    """Return the current of a conductance that peaks at the weight after the time constant."""
    return Receptor(
        f"dg_{name}/dt = (exp(1.0)*y_{name} - g_{name})/tau_syn_{name} : nS\n"
        f"dy_{name}/dt = -y_{name}/tau_syn_{name} : nS\n"
        f"I_syn_{name} = g_{name}*(E_rev_{name} - v) : pA",
        f"y_{name} += weight",
        {f"tau_syn_{name}": "ms", f"E_rev_{name}": "mV"},
    )


def beta_conductance(name: str) -> Receptor:
    """Return the current of a conductance that peaks at the weight, with a time constant of its rise."""
    return Receptor(
        f"dg_{name}/dt = unit_peak_{name}*y_{name} - g_{name}/tau_decay_{name} : nS\n"
        f"dy_{name}/dt = -y_{name}/tau_rise_{name} : nS\n"
        f"I_syn_{name} = g_{name}*(E_rev_{name} - v) : pA",
        f"y_{name} += weight",
        {f"tau_rise_{name}": "ms", f"tau_decay_{name}": "ms", f"E_rev_{name}": "mV",
         f"unit_peak_{name}": "1/ms"},
    )  # fmt: skip


def lines_of(receptors: Iterable[Receptor]) -> str:
    """Return the equations of receptors."""
    return "\n".join(one.equations for one in receptors)


def every(kind: Callable[[str], Receptor], names: Iterable[str]) -> dict[str, Receptor]:
    """Return receptors of one kind, by their names in a network."""
    return {_IN_NETWORK.get(name, f"receptor{name}"): kind(name) for name in names}


_IN_NETWORK = {"ex": "excitatory", "in": "inhibitory"}
