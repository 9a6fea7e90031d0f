"""The decorators that bind the parameters of a transfer function."""

from __future__ import annotations

import copy
import csv
from collections.abc import Callable, Iterable, Sequence, Sized
from io import StringIO
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.files import replacing
from nrp_core.dsl.device_kinds import KINDS, CustomDevice, DeviceKind
from nrp_core.dsl.devices import Device, DeviceGroup
from nrp_core.dsl.functions import Flow, Neuron2Robot, Robot2Neuron, TransferFunction
from nrp_core.dsl.parameters import (
    Adapter,
    Binding,
    ParameterMapping,
    PublishedTopic,
    SubscribedTopic,
    Topic,
    brief,
)
from nrp_core.dsl.selection import Selection, evaluate, select
from nrp_core.errors import OutsideFolderError, did_you_mean

GLOBAL = "global_scope"
"""The scope of a variable that all transfer functions of an experiment share."""
TRANSFER_FUNCTION_LOCAL = "transfer_function_scope"
"""The scope of a variable of one transfer function."""
SCOPES = (GLOBAL, TRANSFER_FUNCTION_LOCAL)


class Variable(Adapter):
    """A value that persists between runs.

    Args:
        name: for messages.
        initial: the value at time 0; it is copied, so that changes in place are undone by a reset.
            An object that cannot be copied, such as an open file, remains the same object.

    Attributes:
        value: the current value.
    """

    __slots__ = ("_initial", "name", "value")

    def __init__(self, name: str, initial: Any = None) -> None:
        self.name = name
        self._initial = _copy(initial)
        self.reset()

    def begin_with(self, initial: Any) -> None:
        """Set the initial value, unless it is set."""
        if self._initial is None and initial is not None:
            self._initial = _copy(initial)
            self.reset()

    def reset(self) -> None:
        self.value: Any = _copy(self._initial)

    def save(self) -> Any:
        return self.value

    def restore(self, saved: Any) -> None:
        self.value = saved

    @property
    def is_lost(self) -> bool:
        """Whether a number of the value has become NaN, so that all results computed from it are NaN."""
        return _has_nan(self.value) and not _has_nan(self._initial)

    def value_text(self) -> str:
        return f"value = {brief(self.value)}"


def _has_nan(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return any(_has_nan(one) for one in value)
    is_real = isinstance(value, float | np.floating | np.ndarray) and np.asarray(value).dtype.kind == "f"
    return is_real and bool(np.isnan(value).any())


def _copy(value: Any) -> Any:
    try:
        return copy.deepcopy(value)
    except (TypeError, copy.Error):
        return value


RESET = "RESET"
RESET_HEADER = "Simulation_reset"


class CSVRecorder(Adapter):
    """The rows of one parameter.

    Args:
        filename: name of the file.
        headers: headers of its columns.
        erase_on_reset: whether a reset erases the rows; otherwise the next row is marked ``RESET``.

    Attributes:
        rows: the cells of each row, as text.
    """

    __slots__ = ("_erase_on_reset", "_is_first_after_reset", "filename", "headers", "rows")

    def __init__(self, filename: str, headers: Sequence[str], *, erase_on_reset: bool = False) -> None:
        self.filename, self.headers = filename, tuple(headers)
        self.rows: list[list[str]] = []
        self._erase_on_reset = erase_on_reset
        self._is_first_after_reset = False

    def record_entry(self, *values: object) -> None:
        """Add a row; its cells are the values as ``str`` shows them."""
        mark = [RESET] if self._is_first_after_reset else []
        self.rows.append([*map(str, values), *mark])
        self._is_first_after_reset = False

    def reset(self) -> None:
        if self._erase_on_reset:
            self.rows.clear()
        else:
            self._is_first_after_reset = bool(self.rows)

    def save(self) -> Any:
        return list(self.rows), self._is_first_after_reset

    def restore(self, saved: Any) -> None:
        rows, self._is_first_after_reset = saved
        self.rows[:] = rows

    def value_text(self) -> str:
        return f"{len(self.rows)} rows"


def csv_texts(functions: Iterable[TransferFunction], folder: Path) -> dict[Path, str]:
    """Return the texts of the files into which all recorders of transfer functions write, in a folder."""
    found = [
        one for function in functions for one in function.adapters.values() if isinstance(one, CSVRecorder)
    ]
    texts: dict[Path, str] = {}
    for recorder in found:
        path = folder / inside(recorder.filename)
        texts[path] = texts.get(path, "") + _text(recorder, with_headers=path not in texts)
    return texts


def write_csv(functions: Iterable[TransferFunction], folder: Path) -> list[Path]:
    """Write the rows of all recorders of transfer functions into a folder; return its files.

    Raises:
        OSError: a file cannot be written.
    """
    texts = csv_texts(functions, folder)
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as draft:
            draft.write_text(text, encoding="utf-8", newline="")
    return list(texts)


def _text(recorder: CSVRecorder, *, with_headers: bool) -> str:
    marked = RESET_HEADER not in recorder.headers and any(row[-1:] == [RESET] for row in recorder.rows)
    headers = [*recorder.headers, RESET_HEADER] if marked else recorder.headers
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(
        [headers, *recorder.rows] if with_headers else recorder.rows
    )
    return text.getvalue()


def inside(filename: str) -> str:
    """Return the name of a recorder's file below the folder of the run, which it never leaves."""
    parts = [part for part in PurePosixPath(filename.replace("\\", "/")).parts if part not in ("/", "..")]
    return "/".join(parts) or "records.csv"


class MappingDecorator(ParameterMapping):
    """A mapping used as a decorator; without another decorator it creates the transfer function."""

    flow: ClassVar[Flow]

    def __call__(self, function: Callable[..., Any] | TransferFunction) -> TransferFunction:
        """Return the transfer function with the mapping added."""
        if not isinstance(function, TransferFunction):
            makes = Neuron2Robot if self.flow is Flow.NEURON_TO_ROBOT else Robot2Neuron
            function = makes()(function)
        function.add(self)
        return function


class _DeviceMapping(MappingDecorator):
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


class MapRobotSubscriber(MappingDecorator):
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
        return SubscribedTopic(binding.world, self.reads, self.initial_value, binding.function)

    def __str__(self) -> str:
        return f"reads {self.reads}"


class MapRobotPublisher(MappingDecorator):
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


class MapVariable(MappingDecorator):
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


class MapCSVRecorder(MappingDecorator):
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
