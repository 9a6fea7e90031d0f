"""A transfer function that is called once for all copies of an experiment, if that is proved to be the same.

The compiled code of the function has to be free of side effects, and its parameters of the kinds below. In
its first runs the results are compared, bit for bit, with those of a call for each copy. What it sets and
sends is collected and takes effect after the call; if anything is wrong, nothing has happened, and the
function is called for one copy after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.dsl.across import BUILTINS, Across, NotTogetherError
from nrp_core.dsl.copies.purity import obstacle
from nrp_core.dsl.devices import (
    Device,
    LeakyIntegratorDevice,
    PopulationRateDevice,
    ReadOnlyAttribute,
    SettableAttribute,
    SpikeGenerator,
)
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.parameters import Adapter, PublishedTopic, SubscribedTopic
from nrp_core.world.batch import publish_rows
from nrp_core.world.messages.base import find_layout

MIN_COPIES: Final = 32
"""Of fewer copies, a call for each takes less time."""
_PROVED_BY: Final = 5
"""Runs that are compared with calls for each copy."""
_GIVEN_UP_AFTER: Final = 5
"""Runs in a row that cannot be taken together."""


class _Device:
    """A device of a parameter in all copies: it reads what they show, and collects what is set."""

    def __init__(self, devices: Sequence[Device]) -> None:
        object.__setattr__(self, "devices", devices)
        object.__setattr__(self, "collected", {})
        object.__setattr__(self, "shown", {})

    def __getattr__(self, name: str) -> Any:
        if name not in self.shown:
            if type(getattr(type(self.devices[0]), name, None)) is not ReadOnlyAttribute:
                raise NotTogetherError(f"it reads '{name}' of a device")
            self.shown[name] = Across.of([getattr(device.port, name) for device in self.devices])
        return self.shown[name]

    def __setattr__(self, name: str, value: Any) -> None:
        if not isinstance(getattr(type(self.devices[0]), name, None), SettableAttribute):
            raise NotTogetherError(f"it sets '{name}' of a device")
        self.collected[name] = _numbers(value, len(self.devices))

    def take_effect(self) -> None:
        for name, values in self.collected.items():
            for device, value in zip(self.devices, values.tolist(), strict=True):
                setattr(device, name, value)


class _Subscribed:
    """The last messages on a topic in all copies."""

    def __init__(self, topics: Sequence[SubscribedTopic]) -> None:
        self._topics = topics
        self.collected: dict[str, FloatArray] = {}

    @property
    def value(self) -> Any:
        return Across.of([topic.value for topic in self._topics])

    @property
    def changed(self) -> Any:
        return Across.of([topic.changed for topic in self._topics])

    def take_effect(self) -> None:
        pass


class _Published:
    """A topic in all copies: it collects one message for each."""

    def __init__(self, topics: Sequence[PublishedTopic]) -> None:
        self._publications = [topic.publication for topic in topics]
        first = self._publications[0]
        self._layout = self._type = None
        if first is not None and (first.topic.limits is None or first.topic.clips):
            self._type = first.topic.type
            self._layout = find_layout(self._type)
        self.collected: dict[str, FloatArray] = {}

    def send_message(self, message: Any) -> None:
        if self._type is None or self._layout is None or self.collected:
            raise NotTogetherError("it sends several messages, or one with more than numbers")
        if type(message) is not self._type:
            if len(self._layout.paths) != 1 or isinstance(message, np.ndarray | np.generic):
                raise NotTogetherError("it sends a message of another type")
            message = self._type(message)
        numbers = self._layout.read(message)
        rows = [_numbers(number, len(self._publications)) for number in numbers]
        self.collected[""] = np.stack(rows, axis=1)

    def take_effect(self) -> None:
        for rows in self.collected.values():
            publish_rows(self._publications, rows)  # type: ignore[arg-type]


_KINDS: Final[dict[type[Adapter], Callable[[Any], Any]]] = {
    SpikeGenerator: _Device,
    LeakyIntegratorDevice: _Device,
    PopulationRateDevice: _Device,
    SubscribedTopic: _Subscribed,
    PublishedTopic: _Published,
}


def _numbers(value: Any, copies: int) -> FloatArray:
    """Return one finite number for each copy."""
    numbers = value.values if isinstance(value, Across) else value
    if isinstance(numbers, bool) or not isinstance(numbers, float | int | np.float64 | np.ndarray):
        raise NotTogetherError(f"it sets or sends {type(numbers).__name__}")
    is_float = (
        not isinstance(value, np.ndarray) and np.ndim(numbers) <= 1 and np.asarray(numbers).dtype == float
    )
    if not (is_float or isinstance(numbers, int)):
        raise NotTogetherError("it sets or sends an array")
    rows = np.broadcast_to(np.asarray(numbers, float), copies)
    if not np.isfinite(rows).all():
        raise NotTogetherError("it sets or sends numbers that are not finite")
    return rows


class _Call:
    """One call of a function for some copies, and what it sets and sends."""

    def __init__(
        self, functions: Sequence[TransferFunction], call: Callable[..., Any], times_s: Sequence[float]
    ) -> None:
        kinds = [_KINDS[type(adapter)] for adapter in functions[0].adapters.values()]
        columns = zip(*(function.adapters.values() for function in functions), strict=True)
        self.parts = [kind(column) for kind, column in zip(kinds, columns, strict=True)]
        publishers = [function.publisher for function in functions]
        result = call(Across.of(times_s), *self.parts)
        if result is not None and publishers[0] is not None:
            self.parts.append(_Published(publishers))  # type: ignore[arg-type]
            self.parts[-1].send_message(result)

    def results(self, copy: int) -> list[tuple[int, str, bytes]]:
        """Return what is set and sent in a copy."""
        return [
            (place, name, values[copy].tobytes())
            for place, part in enumerate(self.parts)
            for name, values in part.collected.items()
        ]

    def take_effect(self) -> bool:
        """Set and send what was collected; return False, with nothing sent, if a device refuses a value."""
        devices = [part for part in self.parts if isinstance(part, _Device)]
        try:
            for device in devices:
                device.take_effect()
        except ValueError:
            return False  # calls for each copy set the devices again, and one of them raises the error
        for part in self.parts:
            if part not in devices:
                part.take_effect()
        return True


class FunctionTogether:
    """One transfer function in all copies of an experiment.

    Args:
        functions: the function of each copy, bound.

    Attributes:
        reason: why it is called for one copy after the other; empty if it is not.
    """

    def __init__(self, functions: Sequence[TransferFunction]) -> None:
        self.reason = self._obstacle(functions)
        self._proofs = self._failures = 0
        function = functions[0].function
        self._call: Callable[..., Any] = function
        if not self.reason:
            names = {**function.__globals__, "__builtins__": BUILTINS}
            self._call = FunctionType(function.__code__, names, function.__name__, function.__defaults__)

    @staticmethod
    def _obstacle(functions: Sequence[TransferFunction]) -> str:
        if any(type(function).run is not TransferFunction.run for function in functions):
            return f"it is a {type(functions[0]).__name__}"
        for parameter, adapter in functions[0].adapters.items():
            if type(adapter) not in _KINDS:
                return f"its parameter '{parameter}' is a {type(adapter).__name__}"
        kinds = [[type(adapter) for adapter in function.adapters.values()] for function in functions]
        if any(each != kinds[0] for each in kinds):
            return "its parameters differ between copies"
        if not all(isinstance(function.function, FunctionType) for function in functions):
            return "it is not a plain function"
        return obstacle([function.function for function in functions])  # type: ignore[misc]

    def run(self, functions: Sequence[TransferFunction], times_s: Sequence[float]) -> bool:
        """Call the function once for copies, whose parameters are up to date, and let it take effect.

        Args:
            functions: the function of each of these copies.
            times_s: the time in seconds that is passed to it, in each of them.

        Returns:
            Whether that was done; if not, nothing has been sent.
        """
        if self.reason or len(functions) < MIN_COPIES:
            return False
        try:
            together = _Call(functions, self._call, times_s)
            if self._proofs < _PROVED_BY:
                self._prove(together, functions, times_s)
        except Exception as error:  # noqa: BLE001 - each copy alone raises what is an error of the function
            self._failures += 1
            if self._failures == _GIVEN_UP_AFTER:
                self.reason = str(error) or type(error).__name__
            return False
        self._failures = 0
        return together.take_effect()

    def _prove(
        self, together: _Call, functions: Sequence[TransferFunction], times_s: Sequence[float]
    ) -> None:
        """Compare with a call for each copy.

        Raises:
            NotTogetherError: a result differs.
        """
        for copy, (function, t_s) in enumerate(zip(functions, times_s, strict=True)):
            alone = _Call([function], function.function, [t_s])
            if alone.results(0) != together.results(copy):
                self.reason = "its results differ from those for a copy alone"
                raise NotTogetherError(self.reason)
        self._proofs += 1
