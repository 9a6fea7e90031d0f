"""The decorators that bind the parameters of a transfer function."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence, Sized
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar

import numpy as np

from nrp_core.dsl.devices.custom import CustomDevice
from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.devices.groups import DeviceGroup
from nrp_core.dsl.devices.kinds import KINDS, DeviceKind
from nrp_core.dsl.functions.csv_recorder import CSVRecorder
from nrp_core.dsl.functions.decorators import Neuron2Robot, Robot2Neuron
from nrp_core.dsl.functions.function import Flow, TransferFunction
from nrp_core.dsl.functions.variables import GLOBAL, SCOPES, TRANSFER_FUNCTION_LOCAL, Variable
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.binding import Binding, Mapping
from nrp_core.dsl.parameters.topics import PublishedTopic, SubscribedTopic, Topic
from nrp_core.dsl.selection.selection import Selection
from nrp_core.dsl.selection.selectors import evaluate, select
from nrp_core.errors import OutsideFolderError, did_you_mean


class _MappingDecorator(Mapping):
    """A mapping used as a decorator; without another decorator it creates the transfer function."""

    flow: ClassVar[Flow]

    def __call__(self, function: Callable[..., Any] | TransferFunction) -> TransferFunction:
        """Return the transfer function with the mapping added."""
        if not isinstance(function, TransferFunction):
            makes = Neuron2Robot if self.flow is Flow.NEURON_TO_ROBOT else Robot2Neuron
            function = makes()(function)
        function.add(self)
        return function


class _DeviceMapping(_MappingDecorator):
    """Binds a parameter to a device, or to a device group if the selector gives a list.

    Args:
        key: name of the parameter.
        value: the neurons, e.g. ``nrp.brain.actors[0]``.
        device_type: the kind of device, e.g. ``nrp.leaky_integrator_alpha``, or a custom device.
        kwargs: settings of the device; in a group, a list gives each device its own.

    Raises:
        TransferFunctionError: the kind does not fit, or a setting is missing.
    """

    drives: ClassVar[bool]

    def __init__(self, key: str, value: Any, device_type: DeviceKind | CustomDevice, **kwargs: Any) -> None:
        super().__init__(key)
        self.selector, self.kind, self.options = value, device_type, kwargs
        if not isinstance(device_type, CustomDevice):
            self._check(key, device_type, kwargs)

    def _check(self, key: str, device_type: DeviceKind, options: Iterable[str]) -> None:
        fitting = [kind.name for kind in KINDS if kind.drives is self.drives]
        if not isinstance(device_type, DeviceKind) or device_type.drives is not self.drives:
            verb = "drive" if self.drives else "read"
            raise self.place.error(
                f"parameter '{key}': {device_type!r:.60} does not {verb} neurons, "
                f"as {type(self).__name__} needs; valid: {', '.join(fitting)}"
            )
        for name in options:
            if name not in device_type.options:
                hint = did_you_mean(name, device_type.options)
                message = f"parameter '{key}': {device_type} has no setting '{name}'{hint}"
                raise self.place.error(message, hint.instead)

    def _do_bind(self, binding: Binding) -> Adapter:
        selected = select(self.selector, binding.root)
        options = {key: evaluate(value, binding.root) for key, value in self.options.items()}
        if isinstance(self.kind, CustomDevice):
            return self.kind.bound(selected, binding.brain, options)
        name = f"{binding.function}/{self.parameter}"
        if isinstance(selected, Selection):
            return self.kind.open(binding, selected, options, parameter=self.parameter, name=name)
        devices: list[Device] = []
        try:
            for i, selection in enumerate(selected):
                own = {key: _share(key, value, i, len(selected)) for key, value in options.items()}
                parameter = f"{self.parameter}[{i}]"
                opened = self.kind.open(binding, selection, own, parameter=parameter, name=f"{name}/{i}")
                devices.append(opened)
        except BaseException:
            DeviceGroup(devices).release()
            raise
        return DeviceGroup(devices)

    def __str__(self) -> str:
        settings = "".join(f", {key}={value!r}" for key, value in self.options.items())
        return f"{self.kind} on {self.selector!r}{settings}"


class MapSpikeSink(_DeviceMapping):
    """Binds a parameter to a device that reads neurons."""

    drives = False
    flow = Flow.NEURON_TO_ROBOT


class MapSpikeSource(_DeviceMapping):
    """Binds a parameter to a device that drives neurons."""

    drives = True
    flow = Flow.ROBOT_TO_NEURON


class MapRobotSubscriber(_MappingDecorator):
    """Binds a parameter to the messages of a topic.

    Args:
        key: name of the parameter.
        value: the topic.
        initial_value: the value before the first message.
        queue_size, buff_size: accepted for users of ROS, without effect: in lockstep nothing is queued.
    """

    flow = Flow.ROBOT_TO_NEURON

    def __init__(
        self,
        key: str,
        value: Topic | str,
        *,
        initial_value: Any = None,
        queue_size: int = 1,
        buff_size: int = 65536,
    ) -> None:
        super().__init__(key)
        self.reads: Topic = Topic.of(value)
        self.initial_value = initial_value

    def _do_bind(self, binding: Binding) -> SubscribedTopic:
        return SubscribedTopic(binding.world, self.reads, self.initial_value)

    def __str__(self) -> str:
        return f"reads {self.reads}"


class MapRobotPublisher(_MappingDecorator):
    """Binds a parameter to a topic that the function publishes on with ``send_message``.

    Args:
        key: name of the parameter.
        value: the topic.
        queue_size: accepted for users of ROS, without effect: in lockstep nothing is queued.
    """

    flow = Flow.NEURON_TO_ROBOT

    def __init__(self, key: str, value: Topic | str, *, queue_size: int = 10) -> None:
        super().__init__(key)
        self.writes: Topic = Topic.of(value)

    def _do_bind(self, binding: Binding) -> PublishedTopic:
        return PublishedTopic(binding.world, self.writes)

    def __str__(self) -> str:
        return f"publishes on {self.writes}"


class MapVariable(_MappingDecorator):
    """Binds a parameter to a variable that keeps its value between runs of the function.

    Args:
        parameter_name: name of the parameter.
        global_key: name of a shared variable; by default the name of the parameter.
        initial_value: its value at time 0; it may depend on the brain. If several functions share it,
            the first function with an initial value sets it.
        scope: ``nrp.GLOBAL`` (shared by all functions of an experiment) or
            ``nrp.TRANSFER_FUNCTION_LOCAL``.

    Raises:
        TransferFunctionError: the scope does not exist.
    """

    flow = Flow.ROBOT_TO_NEURON

    def __init__(
        self,
        parameter_name: str,
        global_key: str | None = None,
        initial_value: Any = None,
        scope: str = TRANSFER_FUNCTION_LOCAL,
    ) -> None:
        super().__init__(parameter_name)
        if scope not in SCOPES:
            raise self.place.error(f"unknown scope {scope!r}; valid: nrp.GLOBAL, nrp.TRANSFER_FUNCTION_LOCAL")
        self.global_key = (global_key or parameter_name) if scope == GLOBAL else None
        self.initial_value = initial_value

    def _do_bind(self, binding: Binding) -> Variable:
        initial = evaluate(self.initial_value, binding.root)
        if self.global_key is None:
            return Variable(self.parameter, initial)
        shared: Variable = binding.variables.setdefault(self.global_key, Variable(self.global_key))
        shared.begin_with(initial)
        return shared

    def __str__(self) -> str:
        return "variable" if self.global_key is None else f"shared variable '{self.global_key}'"


class MapCSVRecorder(_MappingDecorator):
    """Binds a parameter to a recorder of rows of a CSV file.

    Args:
        parameter_name: name of the parameter.
        filename: name of the file; recorders with the same name share the file and append their rows in turn.
        headers: headers of the columns.
        erase_on_reset: whether a reset erases the rows; otherwise the next row is marked ``RESET``.
    """

    flow = Flow.NEURON_TO_ROBOT

    def __init__(
        self, parameter_name: str, filename: str, headers: Sequence[str], erase_on_reset: bool = False
    ) -> None:
        super().__init__(parameter_name)
        if not isinstance(filename, str) or not filename.strip():
            raise self.place.error(
                f"parameter '{parameter_name}': the file name must be a string, not {filename!r}"
            )
        self.filename, self.headers, self.erase_on_reset = filename, tuple(map(str, headers)), erase_on_reset

    def _do_bind(self, binding: Binding) -> CSVRecorder:
        parts = PurePosixPath(self.filename.replace("\\", "/")).parts
        if ".." in parts or parts[0] == "/":
            message = f"'{self.filename}' is outside the folder of the run; write a name relative to it"
            raise OutsideFolderError(message, path=Path(self.place.path), line=self.place.line)
        return CSVRecorder(self.filename, self.headers, erase_on_reset=self.erase_on_reset)

    def __str__(self) -> str:
        return f"records {', '.join(self.headers)} in {self.filename}"


def _share(name: str, value: Any, i: int, n: int) -> Any:
    """Return the value of a setting for device ``i`` of a group of ``n``."""
    if np.ndim(value) == 0 or not isinstance(value, Sized):
        return value
    if len(value) != n:
        raise ValueError(f"setting '{name}' has {len(value)} values for {n} devices")
    return value[i]  # type: ignore[index]
