"""The ways from muscles to their afferents and from motoneurons to muscles, each as one statement."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.dsl.afferents import NormalizedSpindle, NormalizedTendonOrgan, Spindle, TendonOrgan
from nrp_core.dsl.device_kinds import poisson, population_rate
from nrp_core.dsl.functions import Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.mappings import (
    MapRobotPublisher,
    MapRobotSubscriber,
    MapSpikeSink,
    MapSpikeSource,
    MapVariable,
)
from nrp_core.dsl.parameters import Topic
from nrp_core.dsl.selection import map_neurons
from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.messages.nrp_msgs import MuscleStates
from nrp_core.messages.std_msgs import Float64MultiArray

Afferent = Literal["Ia", "II", "Ib"]
_ALMOST_ALWAYS = 0.9
"""A share of samples."""


@checks_arguments()
def map_afferents(
    kind: Afferent,
    group: str,
    populations: Mapping[str, Any],
    *,
    model: Spindle | TendonOrgan | None = None,
    rest: Mapping[str, float] | None = None,
    name: str = "",
    device: Any = poisson,
    **options: Any,
) -> TransferFunction:
    """Let the fibres of afferents of muscles fire, each at the mean rate of its muscle.

    One statement maps a group of muscles::

        nrp.map_afferents("Ia", "/arm/muscles", {"biceps": nrp.brain.biceps_ia}, weight=0.1, delay=16.0)

    Args:
        kind: ``Ia``, ``II`` or ``Ib``.
        group: the topic of the group without ``/state``.
        populations: the neurons that the fibres of a muscle excite, by the name of the muscle.
        model: a :class:`Spindle`, or a :class:`TendonOrgan` for ``Ib``; by default
            :class:`NormalizedSpindle` and :class:`NormalizedTendonOrgan`, which use the optimal length and
            the peak force of each muscle.
        rest: for each muscle its length without stretch, m, or in optimal lengths if the model is normalised;
            by default the length of the first state, or the ``rest`` of a normalised model.
        name: the name of the function; by default it is made of the kind and the group.
        device: the kind of the devices, of which each muscle has one; their noise is that of the device.
        options: options of the devices: ``weight``, ``delay`` for the conduction (ms), and so on.

    Raises:
        TransferFunctionError: no muscle is given, the model does not fit the kind, or a muscle has no rest.
    """
    chosen = model or (NormalizedTendonOrgan() if kind == "Ib" else NormalizedSpindle())
    if not populations or isinstance(chosen, TendonOrgan) != (kind == "Ib"):
        wrong = (
            "needs a population of a muscle" if not populations else f"is not by a {type(chosen).__name__}"
        )
        raise TransferFunctionError(f"map_afferents: {kind} of '{group}' {wrong}")
    muscles, targets = tuple(populations), list(populations.values())
    for muscle in muscles:
        if rest is not None and muscle not in rest:
            raise TransferFunctionError(f"map_afferents: the rest of '{group}' lacks '{muscle}'")

    def afferents(t, states, fibres, memory):  # type: ignore[no-untyped-def]
        message = states.value
        if message is None:
            return
        rows = _rows(tuple(message.name), muscles, group)
        last = memory.value or AfferentRates(kind, muscles, None, t - 0.001)
        fibres.rate, memory.value = _rates(chosen, message, rows, rest, last, t)

    afferents.__name__ = afferents.__qualname__ = name or _named(f"{kind}_of", group)
    function = Robot2Neuron()(afferents)
    function = MapRobotSubscriber("states", Topic(f"{group}/state", MuscleStates))(function)
    neurons = map_neurons(len(targets), targets.__getitem__)
    function = MapSpikeSource("fibres", neurons, device, **options)(function)
    return MapVariable("memory", initial_value=None)(function)


def _named(prefix: str, group: str) -> str:
    return f"{prefix}{group.replace('/', '_')}"


@lru_cache  # the names are the same in each message
def _rows(names: tuple[str, ...], muscles: tuple[str, ...], group: str) -> IntArray:
    """Return the rows of muscles in a message."""
    for muscle in muscles:
        if muscle not in names:
            raise TransferFunctionError(f"'{group}' has no muscle '{muscle}'{did_you_mean(muscle, names)}")
    return np.array([names.index(muscle) for muscle in muscles])


class AfferentRates(NamedTuple):
    """The last state of the afferents of a group, and how often their rates were at a limit.

    Args:
        kind: ``Ia``, ``II`` or ``Ib``.
        muscles: their names.
        state: lengths at rest, or the state of filters; None at the start.
        t: the time of this state, s.
        lowest, highest: the number of samples in which the rate of each muscle was 0, or ``highest``.
        samples: the number of all samples.
    """

    kind: Afferent
    muscles: tuple[str, ...]
    state: Any
    t: float
    lowest: Any = 0
    highest: Any = 0
    samples: int = 0

    def limited(self) -> dict[str, str]:
        """Return the muscles whose rate was at a limit almost always, each with the limit.

        A rate of 0 while a muscle shortens, as in half of a movement, is normal.
        """
        most = _ALMOST_ALWAYS * self.samples
        ends = (("0", self.lowest), ("at its highest", self.highest))
        shares = {end: np.broadcast_to(count, len(self.muscles)) for end, count in ends}
        found = ((n, end) for end, each in shares.items() for n in np.flatnonzero(each > most).tolist())
        return {self.muscles[n]: end for n, end in found}


def _rates(
    model: Spindle | TendonOrgan,
    message: MuscleStates,
    rows: IntArray,
    rest: Mapping[str, float] | None,
    last: AfferentRates,
    t: float,
) -> tuple[list[float], AfferentRates]:
    """Return the rates of muscles (Hz), and their new state."""
    state = last.state
    if isinstance(model, TendonOrgan):
        tension = (message.normalized_force if model.normalized else message.force)[rows]
        rates, state = model.filtered(tension, state, max(t - last.t, 1e-6))
        low = (rates <= 0.0) & (tension > 0.0)
    else:
        length = (message.normalized_length if model.normalized else message.length)[rows]
        if rest is not None:
            state = np.array([rest[message.name[row]] for row in rows])
        elif state is None:
            state = np.full(len(rows), model.rest) if isinstance(model, NormalizedSpindle) else length
        rates = _spindle_rates(model, last.kind, message, rows, length - state, state)
        low = rates <= 0.0
    counts = last.lowest + low, last.highest + (rates >= model.highest), last.samples + 1
    return rates.tolist(), AfferentRates(last.kind, last.muscles, state, t, *counts)


def _spindle_rates(
    model: Spindle,
    kind: Afferent,
    message: MuscleStates,
    rows: IntArray,
    stretch: FloatArray,
    rest: FloatArray,
) -> FloatArray:
    velocity = (message.normalized_velocity if model.normalized else message.velocity)[rows]
    if isinstance(model, NormalizedSpindle) and model.by_rest:
        stretch, velocity = np.maximum(stretch / rest, 0.0), velocity / rest
    activation = message.activation[rows]
    found = model.ia(stretch, velocity, activation) if kind == "Ia" else model.ii(stretch, activation)
    return np.asarray(found, float)


@checks_arguments()
def map_motoneurons(
    group: str, populations: Mapping[str, Any], *, saturation: float = 40.0, name: str = "", **options: Any
) -> TransferFunction:
    """Let pools of motoneurons command the muscles of a group.

    The control of a muscle is the mean rate of its pool divided by the rate at which its units are fused, at
    most 1. Muscles follow it by their own activation, so the rate has a short time constant. Several muscles
    can share a pool: give the same neurons to each of them.

    Args:
        group: the topic of the group without ``/cmd``.
        populations: the pool of each muscle of the group, by its name; a pool can occur several times.
        saturation: the rate at which all units of a pool give full activation, Hz.
        name: the name of the function; by default it is made of the group.
        options: options of the devices, as ``tau_fall`` (ms).

    Raises:
        TransferFunctionError: no muscle is given, or the saturation is not positive; in a run, a muscle of
            the group has no pool, or there is no such muscle.
    """
    if not populations or saturation <= 0:
        wrong = "needs a pool of each muscle" if not populations else f"saturates at {saturation:g} Hz"
        raise TransferFunctionError(f"map_motoneurons: '{group}' {wrong}")
    muscles, pools = tuple(populations), list(populations.values())

    def motoneurons(t, rates, states, controls):  # type: ignore[no-untyped-def]  # noqa: ARG001
        if states.value is None:
            return
        names = tuple(states.value.name)
        rows = _rows(names, muscles, group)
        if len(rows) < len(names):
            lacking = next(name for name in names if name not in muscles)
            raise TransferFunctionError(f"map_motoneurons: '{lacking}' of '{group}' has no pool")
        shares = np.empty(len(names))
        shares[rows] = [each.rate / (saturation * len(each.selection.ids)) for each in rates]
        controls.send_message(Float64MultiArray(data=np.clip(shares, 0.0, 1.0)))

    motoneurons.__name__ = motoneurons.__qualname__ = name or _named("motoneurons_of", group)
    function = Neuron2Robot()(motoneurons)
    function = MapRobotSubscriber("states", Topic(f"{group}/state", MuscleStates))(function)  # their order
    function = MapRobotPublisher("controls", Topic(f"{group}/cmd", Float64MultiArray))(function)
    neurons = map_neurons(len(pools), pools.__getitem__)
    given = {"tau_rise": 5.0, "tau_fall": 25.0, **options}
    return MapSpikeSink("rates", neurons, population_rate, **given)(function)
