"""Every synapse law with its parameters and state, independent of simulators.

Limits, PyNN's classes, file readers and conformance tests follow the table :data:`LAWS`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NetworkError
from nrp_core.network.parameters import (
    DELAY,
    FRACTION,
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INFINITE,
    NUMBER,
    POSITIVE,
    WHOLE,
    Parameter,
)

_ROUNDING: Final = 1e-9

EVERY_SYNAPSE: Final = {"weight": Parameter(0.0, "uS, nA or mV"), "delay": Parameter(0.0, "ms", DELAY)}
"""Parameters of the synapses of every law."""


@dataclass(frozen=True, slots=True)
class SynapseLaw:
    """How synapses transmit spikes.

    Args:
        name: its name in a network and in network files.
        pynn: PyNN's class, also in SONATA's ``pynn:`` models.
        summary: one sentence, for scripts and documentation.
        parameters: the parameters of all parts, besides those of :data:`EVERY_SYNAPSE`.
        state: state variables of each synapse, with their values at rest.
        shares: the state variables that are shares of one whole, so that their sum is at most 1.
        complements: further names of initial values: a state variable, and the parameter less which it is.
        parts: the parts that PyNN composes the law from: PyNN's argument, its classes and their parameters.
        plastic: whether spikes change the weight itself, not only the share of it that one spike transmits.
        continuous: whether the voltage of the source acts all the time, without a delay, instead of its
            spikes.
        stands_for: unsupported PyNN classes whose nearest equivalent this is.
    """

    name: str
    pynn: str
    summary: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    state: Mapping[str, Parameter] = field(default_factory=dict)
    shares: tuple[str, ...] = ()
    complements: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    parts: Mapping[str, Mapping[str, RulePart]] = field(default_factory=dict)
    plastic: bool = False
    continuous: bool = False
    stands_for: tuple[str, ...] = ()

    @property
    def defaults(self) -> dict[str, float]:
        """Default of every parameter by name."""
        return {name: parameter.default for name, parameter in self.parameters.items()}

    def require_shares(self, where: str, initial_values: Mapping[str, FloatArray]) -> None:
        """Refuse states at time 0 in which shares of one whole are more than it.

        Raises:
            NetworkError: such a synapse exists.
        """
        given = [initial_values[name] for name in self.shares if name in initial_values]
        most = float(np.max(sum(given), initial=0.0)) if given else 0.0
        if most > 1.0 + _ROUNDING:
            names = " and ".join(self.shares)
            raise NetworkError(
                f"{where}: the initial {names} are shares of one whole, and their sum is {most:g}"
            )

    @property
    def in_units_of_weight(self) -> frozenset[str]:
        """The parameters that scale with the weights."""
        unit = EVERY_SYNAPSE["weight"].unit
        return frozenset(name for name, parameter in self.parameters.items() if parameter.unit == unit)

    @property
    def first_parts(self) -> dict[str, str]:
        """The first class of each part, in the form of :attr:`Projection.plasticity`."""
        return {part: next(iter(classes)) for part, classes in self.parts.items()}

    def chosen_parts(self, names: Collection[str]) -> list[tuple[str, RulePart]] | None:
        """Return the named class of each part, in the order of the parts; None unless each has just one."""
        chosen = [[(name, part) for name, part in of.items() if name in names] for of in self.parts.values()]
        complete = all(len(classes) == 1 for classes in chosen) and len(set(names)) == len(chosen)
        return [classes[0] for classes in chosen] if complete else None


@dataclass(frozen=True, slots=True)
class RulePart:
    """A part of a law that PyNN composes from parts.

    Args:
        summary: one sentence, for scripts and documentation.
        parameters: parameters by PyNN name.
        implied: values of other parameters of the law that this part fixes.
        requires: the only class of each other part with which this one is composed, if there is just one.
        stands_for: as in :class:`SynapseLaw`.
    """

    summary: str
    parameters: tuple[str, ...]
    implied: Mapping[str, float] = field(default_factory=dict)
    requires: Mapping[str, str] = field(default_factory=dict)
    stands_for: tuple[str, ...] = ()


# Synapses with a constant weight.

STATIC: Final = "static"

STATIC_LAW: Final = SynapseLaw(STATIC, pynn="StaticSynapse", summary="A constant weight and delay (ms).")

# Short-term plasticity of Tsodyks, Uziel & Markram (2000, J Neurosci 20:RC50).
#
# The fraction x of a synapse's resources is recovered, y active and z inactive; y decays into z with the
# time constant of the target's synapse, z recovers with ``tau_rec``. A spike first lets u jump by
# ``U (1 - u)`` (u decays with ``tau_facil``; without facilitation it is U), then releases u x: the spike
# arrives with the weight times u x. So the first spike from rest arrives with U times the weight.

TSODYKS_MARKRAM: Final = "tsodyks_markram"

TSODYKS_MARKRAM_LAW: Final = SynapseLaw(
    TSODYKS_MARKRAM,
    pynn="TsodyksMarkramSynapse",
    summary="A synapse with depression (``U``, ``tau_rec``) and facilitation (``tau_facil``); times in ms.",
    parameters={
        "U": Parameter(0.5, limit=FRACTION),
        "tau_rec": Parameter(100.0, "ms", POSITIVE),
        "tau_facil": Parameter(0.0, "ms", NOT_NEGATIVE_OR_INFINITE),
    },
    state={name: Parameter(0.0, limit=FRACTION) for name in ("u", "y", "z")},
    shares=("y", "z"),
)

# Synapses that transmit each spike with a fixed probability.

SIMPLE_STOCHASTIC: Final = "simple_stochastic"

SIMPLE_STOCHASTIC_LAW: Final = SynapseLaw(
    SIMPLE_STOCHASTIC,
    pynn="SimpleStochasticSynapse",
    summary="Each spike is transmitted with the probability ``p``.",
    parameters={"p": Parameter(0.5, limit=FRACTION)},
)

# Short-term plasticity in the stochastic form of Fuhrmann et al. (2002, J Neurophysiol 87:140).
#
# One vesicle is there, or not; a spike releases it with the probability u of the deterministic law and
# then arrives with the whole weight. A released vesicle comes back at the rate ``1 / tau_rec``.

STOCHASTIC_TSODYKS_MARKRAM: Final = "stochastic_tsodyks_markram"

STOCHASTIC_TSODYKS_MARKRAM_LAW: Final = SynapseLaw(
    STOCHASTIC_TSODYKS_MARKRAM,
    pynn="StochasticTsodyksMarkramSynapse",
    summary="Depression and facilitation of one vesicle that a spike releases or not; times in ms.",
    parameters=TSODYKS_MARKRAM_LAW.parameters,
    state={name: Parameter(0.0, limit=FRACTION) for name in ("u", "empty")},
)

# Short-term plasticity of several release sites, each with one quantum.
#
# The law is that of Loebel et al. (2009, Front Comput Neurosci 3:27), as PyNN has it in NEURON: a spike
# releases each of the filled sites with the probability u, and arrives with the share of the ``n`` sites that
# released; an empty site is filled again at the rate ``1 / tau_rec``. A spike lets u jump by ``U (1 - u)``;
# between spikes u decays with ``tau_facil``. PyNN's initial value ``a`` is the number of filled sites.

MULTIQUANTAL: Final = "multiquantal"
_SHARED: Final = TSODYKS_MARKRAM_LAW.parameters

MULTIQUANTAL_LAW: Final = SynapseLaw(
    MULTIQUANTAL,
    pynn="MultiQuantalSynapse",
    summary="Depression and facilitation of ``n`` sites, each of which a spike empties or not; times in ms.",
    parameters={
        **_SHARED,
        "tau_rec": Parameter(800.0, _SHARED["tau_rec"].unit, _SHARED["tau_rec"].limit),
        "n": Parameter(1.0, limit=WHOLE),
    },
    state={"u": Parameter(0.0, limit=FRACTION), "empty": Parameter(0.0, limit=NOT_NEGATIVE)},
    complements={"a": ("empty", "n")},
)

# Spike-timing-dependent plasticity, composed of a rule for times and one for weights.

STDP: Final = "stdp"

_LIMITS: Final = ("w_min", "w_max")
_PAIRS: Final = ("tau_plus", "tau_minus", "A_plus", "A_minus")
_ADDITIVE: Final = {"weight_dependence": "AdditiveWeightDependence"}

STDP_LAW: Final = SynapseLaw(
    STDP,
    pynn="STDPMechanism",
    summary="Plasticity by the times of the spikes of both sides.",
    parameters={
        "A_plus": Parameter(0.01),
        "A_minus": Parameter(0.01),
        "tau_plus": Parameter(20.0, "ms", POSITIVE),
        "tau_minus": Parameter(20.0, "ms", POSITIVE),
        "A3_plus": Parameter(0.01),
        "A3_minus": Parameter(0.0),
        "tau_x": Parameter(100.0, "ms", POSITIVE),
        "tau_y": Parameter(100.0, "ms", POSITIVE),
        "eta": Parameter(1e-10, "uS, nA or mV"),
        "rho": Parameter(3.0, "Hz", NOT_NEGATIVE),
        "tau": Parameter(20.0, "ms", POSITIVE),
        "w_min": Parameter(0.0, "uS, nA or mV", NUMBER),
        "w_max": Parameter(1.0, "uS, nA or mV", NUMBER),
        "mu_plus": Parameter(0.5, limit=NOT_NEGATIVE),
        "mu_minus": Parameter(0.5, limit=NOT_NEGATIVE),
        "dendritic_delay_fraction": Parameter(1.0, limit=FRACTION),
    },
    parts={
        "timing_dependence": {
            "SpikePairRule": RulePart(
                "Weight changes by the time between pairs of spikes; time constants in ms.", _PAIRS
            ),
            "Vogels2011Rule": RulePart(
                "Inhibitory plasticity (Vogels et al. 2011, Science 334:1569): each pair of spikes, in any "
                "order, strengthens by ``eta`` within ``tau`` (ms); each spike of the source weakens, which "
                "keeps the target near ``rho`` (Hz).",
                ("tau", "eta", "rho"),
                requires=_ADDITIVE,
            ),
            "PfisterSpikeTripletRule": RulePart(
                "Weight changes by pairs and triplets of spikes (Pfister & Gerstner 2006, J Neurosci "
                "26:9673); ``tau_x`` and ``tau_y`` (ms) of earlier spikes of the source and of the target.",
                (*_PAIRS, "tau_x", "tau_y", "A3_plus", "A3_minus"),
                requires=_ADDITIVE,
            ),
        },
        "weight_dependence": {
            "AdditiveWeightDependence": RulePart(
                "Weight changes that do not depend on the weight, within ``w_min`` and ``w_max``.",
                _LIMITS,
                implied={"mu_plus": 0.0, "mu_minus": 0.0},
            ),
            "MultiplicativeWeightDependence": RulePart(
                "Weight changes in proportion to the distance from ``w_min`` or ``w_max``.",
                _LIMITS,
                implied={"mu_plus": 1.0, "mu_minus": 1.0},
            ),
            "AdditivePotentiationMultiplicativeDepression": RulePart(
                "Increases that do not depend on the weight, decreases in proportion to the distance "
                "from ``w_min``.",
                _LIMITS,
                implied={"mu_plus": 0.0, "mu_minus": 1.0},
            ),
            "GutigWeightDependence": RulePart(
                "Weight changes by powers ``mu_plus`` and ``mu_minus`` of the distance from ``w_max`` and "
                "``w_min``, as a share of ``w_max`` (Gütig et al. 2003, J Neurosci 23:3697).",
                (*_LIMITS, "mu_plus", "mu_minus"),
            ),
        },
    },
    state=dict.fromkeys(("pre_trace", "post_trace", "pre_slow", "post_slow"), Parameter(0.0)),
    plastic=True,
)

# Gap junctions: the current ``weight (v_pre - v_post)`` into the target, and its opposite into the source.

ELECTRICAL: Final = "electrical"

ELECTRICAL_LAW: Final = SynapseLaw(
    ELECTRICAL,
    pynn="ElectricalSynapse",
    summary="A gap junction: a conductance (uS) between two cells, through which current flows both ways.",
    continuous=True,
)

# Graded release: what acts is the share s of the weight. It follows a function of the voltage v of the source
# with the time constant ``tau_s``, or at once if that is 0. The function is a sigmoid, ``1 / (1 + exp((v_th -
# v) / slope))``, as between cells of the worm (Kunert et al. 2014, Phys Rev E 89:052805), or ``(v - v_th) /
# slope``, but not less than 0, as between cells of the fly's eye (Lappalainen et al. 2024, Nature 634:1132).

GRADED: Final = "graded"
RECTIFIED: Final = "rectified"
_RELEASE: Final = {
    "v_th": Parameter(-40.0, "mV"),
    "slope": Parameter(5.0, "mV", POSITIVE),
    "tau_s": Parameter(0.0, "ms", NOT_NEGATIVE),
}

GRADED_LAW: Final = SynapseLaw(
    GRADED,
    pynn="GradedSynapse",
    summary="Graded release: the share of the weight that acts is a sigmoid of the source's voltage, half at "
    "``v_th``, steeper for a smaller ``slope``; it follows with ``tau_s`` (ms).",
    parameters=_RELEASE,
    continuous=True,
)

RECTIFIED_LAW: Final = SynapseLaw(
    RECTIFIED,
    pynn="RectifiedSynapse",
    summary="Graded release: the share of the weight that acts is 0 below ``v_th`` and rises by 1 for each "
    "``slope`` (mV) of the source's voltage above it; it follows with ``tau_s`` (ms).",
    parameters=_RELEASE,
    continuous=True,
)

LAWS: Final[Mapping[str, SynapseLaw]] = {
    law.name: law
    for law in (
        STATIC_LAW,
        TSODYKS_MARKRAM_LAW,
        SIMPLE_STOCHASTIC_LAW,
        STOCHASTIC_TSODYKS_MARKRAM_LAW,
        MULTIQUANTAL_LAW,
        STDP_LAW,
        ELECTRICAL_LAW,
        GRADED_LAW,
        RECTIFIED_LAW,
    )
}
PLASTIC: Final = frozenset(law.name for law in LAWS.values() if law.plastic)
"""The laws whose weights change by themselves."""
CONTINUOUS: Final = frozenset(law.name for law in LAWS.values() if law.continuous)
"""The laws that transmit voltages."""
