"""The synapses of a projection as transfer functions read, set and freeze them."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core.brain.interface import Brain
from nrp_core.dsl.functions import Flow
from nrp_core.dsl.mappings import MappingDecorator
from nrp_core.dsl.parameters import Adapter, Binding
from nrp_core.dsl.selection import select_projection
from nrp_core.network.changes import lasting, learning, synapse_parameters
from nrp_core.network.data import Projection
from nrp_core.network.equations.synapse import SYNAPSE_TYPE


class Weights(Adapter):
    """The weights of a projection.

    Args:
        parameter: the parameter that it is bound to, for messages.
        brain: the brain.
        projection: the projection.
    """

    def __init__(self, parameter: str, brain: Brain, projection: Projection) -> None:
        self._parameter, self._brain, self._projection = parameter, brain, projection
        self._values: FloatArray | None = None
        self._read: FloatArray | None = None
        self._parameters: dict[str, FloatArray] = {}
        self._plastic: bool | None = None
        self._given_values: FloatArray | None = None
        self._given_parameters: dict[str, FloatArray] = {}
        self._given_plastic: bool | None = None

    @property
    def values(self) -> FloatArray:
        """The weights in PyNN's units, one for each synapse, shape ``(n,)``.

        It is an ordinary array. When all functions of the step have run, the weights that the function has
        changed in the array are those of the synapses; if it raises an error, no weight changes. Spikes in
        transit keep the weights with which they were sent.
        """
        if self._values is None:
            given = self._given_values
            self._read = self._brain.read_weights(self._projection.label) if given is None else given
            self._values = self._read.copy()
        return self._values

    @values.setter
    def values(self, values: npt.ArrayLike) -> None:
        n = self._projection.size
        try:
            given = np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            given = np.empty((0, 0))
        if given.shape not in ((), (n,)):
            raise ValueError(
                f"{self._parameter}.values: projection '{self._projection.label}' takes one weight for all, "
                f"or {n}, one for each synapse, not {_described(values)}"
            )
        self._values, self._read = np.broadcast_to(given, (n,)).copy(), None

    @property
    def plastic(self) -> bool:
        """Whether the weights change by themselves; setting it stops or continues learning.

        It acts when all functions of the step have run. See :meth:`nrp_core.brain.Brain.set_plastic`.
        """
        given = self._given_plastic if self._plastic is None else self._plastic
        return self._brain.is_plastic(self._projection.label) if given is None else given

    @plastic.setter
    def plastic(self, plastic: bool) -> None:
        learning(self._projection)
        self._plastic = bool(plastic)

    def state(self, variable: str) -> FloatArray:
        """Return a state variable of the synapses, one value for each, shape ``(n,)``.

        See :meth:`nrp_core.brain.Brain.read_synapse_state`.

        Raises:
            NetworkError: the synapses have no such variable.
        """
        return self._brain.read_synapse_state(self._projection.label, variable)

    def set_parameters(self, **values: npt.ArrayLike) -> None:
        """Change parameters of synapses in equations when all functions of the step have run.

        See :meth:`nrp_core.brain.Brain.set_synapse_parameters`.

        Raises:
            NetworkError: the synapses have no such parameter, or a value is impossible.
        """
        _, each = synapse_parameters(self._brain.network, self._projection.label, values)
        self._parameters |= each

    @cached_property
    def pre_index(self) -> IndexArray:
        """The cell in the source population that each synapse begins at, shape ``(n,)``."""
        return _read_only(self._projection.pre_index)

    @cached_property
    def post_index(self) -> IndexArray:
        """The cell in the target population that each synapse ends on, shape ``(n,)``."""
        return _read_only(self._projection.post_index)

    @property
    def is_stand_in(self) -> bool:
        """Whether the synapses' law is given by equations that are absent, as in a dry run."""
        return self._projection.synapse_type == SYNAPSE_TYPE and self._projection.equations is None

    def refresh(self, now_ns: int) -> None:
        self._values = self._read = self._plastic = None
        self._parameters = {}

    def commit(self) -> None:
        values, read = self._values, self._read
        if values is not None and (read is None or not np.array_equal(values, read)):
            self._given_values = values
        self._given_parameters |= self._parameters
        self._given_plastic = self._given_plastic if self._plastic is None else self._plastic
        self.refresh(self._brain.now_ns)

    def deliver(self) -> None:
        values, plastic, parameters = self._given_values, self._given_plastic, self._given_parameters
        self.reset()
        if plastic is not None:
            self._brain.set_plastic(self._projection.label, plastic)
        if parameters:
            self._brain.set_synapse_parameters(self._projection.label, parameters)
        if values is not None:
            self._brain.set_weights(self._projection.label, values)

    def reset(self) -> None:
        self._given_values, self._given_plastic, self._given_parameters = None, None, {}
        self.refresh(0)

    def value_text(self) -> str:
        return "" if self._values is None else f"{len(self._values)} weights"

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in ("values", "plastic", "pre_index", "post_index"):
            raise AttributeError(f"the weights '{self._parameter}' have no attribute '{name}'")
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"<weights {self._parameter} of {self._projection.label}>"


def _read_only(index: IndexArray) -> IndexArray:
    index = np.array(index)
    index.flags.writeable = False
    return index


def _described(values: object) -> str:
    shape = np.shape(values) if isinstance(values, (np.ndarray, list, tuple)) else ()
    return f"an array of shape {shape}" if shape else repr(values)[:60]


class MapWeights(MappingDecorator):
    """Binds a parameter to the weights of a projection.

    Args:
        key: name of the parameter.
        value: the projection, e.g. ``nrp.brain.projection("eyes -> motors")``.
    """

    flow = Flow.ROBOT_TO_NEURON

    def __init__(self, key: str, value: Any) -> None:
        super().__init__(key)
        self.selector = value

    def _do_bind(self, binding: Binding) -> Weights:
        projection = lasting(select_projection(self.selector, binding.root))
        return Weights(self.parameter, binding.brain, projection)

    def __str__(self) -> str:
        return f"weights of {self.selector!r}"
