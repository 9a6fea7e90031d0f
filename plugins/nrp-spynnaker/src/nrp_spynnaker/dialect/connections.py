"""Live connections of a script: callbacks that receive and send spikes while the network runs.

A connection only holds callbacks and sent spikes. :mod:`nrp_spynnaker.live` runs them, and opens the
UDP ports that populations name; when an experiment runs the network, they have no effect.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import numpy as np

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.pynn.arguments import InvalidValueError, refuse_misspelt, require_kind
from nrp_core.network.pynn.populations import Population
from nrp_spynnaker.dialect.unsupported import CONNECTIONS, refuse_attribute

_logger = logging.getLogger(__name__)
Callback: TypeAlias = Callable[..., Any]
_LIVE_OUTPUT: Final = (
    "database_notify_host", "database_notify_port_num", "database_ack_port_num", "board_address", "port",
    "host", "tag", "strip_sdp", "use_prefix", "key_prefix", "prefix_type", "message_type", "right_shift",
    "payload_as_time_stamps", "notify", "use_payload_prefix", "payload_prefix", "payload_right_shift",
    "number_of_packets_sent_per_time_step",
)  # fmt: skip
"""The arguments of sPyNNaker; those that are not used here concern packets of the machine."""
_ALIKE: Final = 0.8
_EVENTS = ("start", "start_resume", "pause_stop", "init")
_PORTS: Final = range(1, 1 << 16)
_KEYS: Final = range(1 << 32)
_THIS_MACHINE: Final = ("localhost", "127.0.0.1")
NOTIFY_PORT: Final = 19999
"""The UDP port at which a program is told of the database, unless it has another."""
KEY_32_BIT: Final = 2
"""The number of the usual kind of packets."""


@dataclass(frozen=True, slots=True)
class LiveOutput:
    """Where the spikes of a population are sent: a host, a UDP port, and the kind of packets."""

    host: str
    port: int
    kind: int


@dataclass(frozen=True, slots=True)
class LiveInput:
    """The UDP port at which an injector receives spikes, and the key of its first cell."""

    port: int
    key: int


@dataclass
class Hub:
    """All live connections of a script, and the populations that take part.

    Attributes:
        connections: in the order in which they were made.
        live_outputs: the populations with live output, by label.
        injectors: the populations into which connections send spikes, by label.
        controlled: the Poisson populations whose rates connections set, by label.
        sent: spikes to emit: label, and indices of cells.
        rates: rates to set: label, indices of cells, and rates in Hz.
        outputs: where live output is sent over UDP, by label.
        inputs: where injectors receive spikes over UDP, by label.
        notified: the UDP ports of programs that are notified of the database.
        is_run: whether the script runs the network, so that ports have an effect.
        ended: connections of earlier networks.
    """

    connections: list[Connection] = field(default_factory=list)
    live_outputs: dict[str, Any] = field(default_factory=dict)
    injectors: dict[str, Any] = field(default_factory=dict)
    controlled: dict[str, Any] = field(default_factory=dict)
    sent: deque[tuple[str, list[int]]] = field(default_factory=deque)
    rates: deque[tuple[str, list[int], list[float]]] = field(default_factory=deque)
    outputs: dict[str, LiveOutput] = field(default_factory=dict)
    inputs: dict[str, LiveInput] = field(default_factory=dict)
    notified: set[int] = field(default_factory=set)
    is_run: bool = False
    ended: list[Connection] = field(default_factory=list)

    @property
    def is_used(self) -> bool:
        """Whether something happens while the network runs."""
        return bool(self.connections or self.outputs or self.inputs)

    @property
    def ports(self) -> list[int]:
        """The UDP ports of notified programs, without those of the script's own connections."""
        return sorted(self.notified - {connection.local_port for connection in self.connections})

    def notify(self, port: Any = None, host: str | None = None) -> None:
        """Tell a program of the database.

        Raises:
            InvalidValueError: a port that cannot be one.
        """
        port = NOTIFY_PORT if port is None else port
        _require_number("the database of keys", "the port of a program", port, _PORTS)
        if host is None or host in _THIS_MACHINE:
            self.notified.add(int(port))
        else:
            _logger.warning(
                "a program at %s is not told of the database of keys: only those of this machine are", host
            )

    def clear(self) -> None:
        """Forget the populations, which ``setup`` discards; connections may be older, and stay."""
        for known in (
            self.live_outputs, self.injectors, self.controlled, self.sent, self.rates, self.outputs,
            self.inputs, self.notified,
        ):  # fmt: skip
            known.clear()

    def activate_live_output_for(
        self, population: Any, database_notify_host: str | None = None,
        database_notify_port_num: int | None = None, *_: Any, port: int | None = None,
        host: str | None = None, message_type: int = KEY_32_BIT, **others: Any,
    ) -> None:  # fmt: skip
        """Send the spikes of a population to connections, and to a UDP port if one is given.

        A program that listens at ``database_notify_port_num`` receives them too; it is notified of the
        database.

        Raises:
            InvalidValueError: a port that cannot be one.
        """
        require_kind("activate_live_output_for", "population", population, Population, "a population")
        refuse_misspelt("activate_live_output_for", "argument", others, _LIVE_OUTPUT, _ALIKE)
        label = population.label
        self.live_outputs[label] = population
        self.notify(database_notify_port_num, database_notify_host)
        if port is None:
            return
        _require_number(f"live output of '{label}'", "port", port, _PORTS)
        if self.is_run:
            self.outputs[label] = LiveOutput(host or "localhost", int(port), int(message_type))
        else:
            population._simulator.state.remark(
                f"live output of '{label}' is not sent to UDP port {port}: an experiment runs the network"
            )

    def inject_into(self, population: Any, port: int | None, virtual_key: int | None) -> None:
        """Let connections send spikes into a population, and other programs over a UDP port if there is one.

        Args:
            population: its cells are those of a ``SpikeInjector``.
            port: the UDP port of this machine.
            virtual_key: the key of the first cell, by default 0.

        Raises:
            InvalidValueError: a port or a key that cannot be one.
        """
        label = population.label
        self.injectors[label] = population
        if port is None:
            return
        owner, key = f"population '{label}'", 0 if virtual_key is None else virtual_key
        _require_number(owner, "port", port, _PORTS)
        _require_number(owner, "virtual_key", key, _KEYS)
        if self.is_run:
            self.inputs[label] = LiveInput(int(port), int(key))
        else:
            population._simulator.state.remark(
                f"{owner} receives no spikes at UDP port {port}: an experiment runs the network"
            )

    def add_poisson_live_rate_control(self, poisson_population: Any, *_: Any, **__: Any) -> None:
        """Let connections set the rates of a Poisson population.

        Raises:
            NetworkError: its cells have no rate.
        """
        owner = "add_poisson_live_rate_control"
        require_kind(owner, "population", poisson_population, Population, "a population")
        if "rate" not in poisson_population.parameter_arrays:
            raise NetworkError(
                f"population '{poisson_population.label}' has no rate to control: its cells are "
                f"{type(poisson_population.celltype).__name__}"
            )
        self.controlled[poisson_population.label] = poisson_population

    def end(self) -> None:
        """Set the connections aside; they do not concern a later network without their labels."""
        self.ended += self.connections
        self.connections.clear()

    def resume(self) -> None:
        """Take the connections of earlier networks whose labels the present one has."""
        for connection in [*self.ended]:
            known = self.controlled if connection.sets_rates else self.injectors
            if {*connection.receive_labels} <= {*self.live_outputs} and {*connection.send_labels} <= {*known}:
                self.ended.remove(connection)
                self.connections.append(connection)

    def require_labels(self) -> None:
        """Check that all labels of connections are those of populations that take part.

        Raises:
            NetworkError: one is not.
        """
        for connection in self.connections:
            for label in connection.receive_labels:
                _require(label, self.live_outputs, "live output: call activate_live_output_for(population)")
            for label in connection.send_labels:
                known, remedy = (
                    (self.controlled, "live rates: call add_poisson_live_rate_control(population)")
                    if connection.sets_rates
                    else (self.injectors, "injected spikes: its cells must be a SpikeInjector()")
                )
                _require(label, known, remedy)


def _require_number(owner: str, name: str, value: Any, valid: range) -> None:
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or int(value) not in valid:
        raise InvalidValueError(
            f"{owner}: {name} is {value!r}; it must be a whole number from {valid[0]} to {valid[-1]}"
        )


class Connection:
    """Callbacks for the spikes of some populations, and a way to send spikes into others.

    Args:
        hub: the script's connections.
        receive_labels: labels of populations with live output.
        send_labels: labels of populations of ``SpikeInjector`` cells.
        local_port: the UDP port at which no other program is notified of the database.
    """

    sets_rates = False
    local_ip_address = "127.0.0.1"

    def __init__(
        self, hub: Hub, receive_labels: Iterable[str] | None = None, send_labels: Iterable[str] | None = None,
        local_port: int | None = None,
    ) -> None:  # fmt: skip
        self.local_port = NOTIFY_PORT if local_port is None else local_port
        self.receive_labels, self.send_labels = list(receive_labels or ()), list(send_labels or ())
        self.receivers: list[tuple[str, Callback, bool]] = []
        self.callbacks: dict[str, list[tuple[str, Callback]]] = {event: [] for event in _EVENTS}
        self._hub = hub
        hub.connections.append(self)

    def add_receive_label(self, label: str) -> None:
        """Hear a further population."""
        self.receive_labels.append(label)

    def add_send_label(self, label: str) -> None:
        """Send spikes into a further population."""
        self.send_labels.append(label)

    def add_receive_callback(
        self, label: str, live_event_callback: Callback, translate_key: bool = True
    ) -> None:
        """Call ``callback(label, time, neuron_ids)`` in each time step with spikes; the time is in steps."""
        self._require(label, self.receive_labels)
        self.receivers.append((label, live_event_callback, True))

    def add_receive_no_time_callback(
        self, label: str, live_event_callback: Callback, translate_key: bool = True
    ) -> None:
        """Call ``callback(label, neuron_ids)`` in each time step with spikes."""
        self._require(label, self.receive_labels)
        self.receivers.append((label, live_event_callback, False))

    def add_start_callback(self, label: str, start_callback: Callback) -> None:
        """Call ``callback(label, connection)`` when the network first runs."""
        self._add("start", label, start_callback)

    def add_start_resume_callback(self, label: str, start_resume_callback: Callback) -> None:
        """Call ``callback(label, connection)`` at the beginning of each run."""
        self._add("start_resume", label, start_resume_callback)

    def add_pause_stop_callback(self, label: str, pause_stop_callback: Callback) -> None:
        """Call ``callback(label, connection)`` at the end of each run."""
        self._add("pause_stop", label, pause_stop_callback)

    def add_init_callback(self, label: str, init_callback: Callback) -> None:
        """Call ``callback(label, n_neurons, run_time_ms, timestep_ms)`` before the network first runs."""
        self._add("init", label, init_callback)

    def __getattr__(self, name: str) -> Any:
        refuse_attribute(type(self), name, CONNECTIONS)

    def close(self) -> None:
        """Take the connection away."""
        if self in self._hub.connections:
            self._hub.connections.remove(self)

    def _add(self, event: str, label: str, callback: Callback) -> None:
        self._require(label, [*self.send_labels, *self.receive_labels])
        self.callbacks[event].append((label, callback))

    def _require(self, label: str, known: Sequence[str]) -> None:
        if label not in known:
            raise NetworkError(f"the connection has no label '{label}'{did_you_mean(label, known)}")


class SpikesConnection(Connection):
    """sPyNNaker's ``SpynnakerLiveSpikesConnection``, within this process: an address has no effect."""

    def __init__(
        self, hub: Hub, receive_labels: Iterable[str] | None = None, send_labels: Iterable[str] | None = None,
        local_host: Any = None, local_port: int | None = None, live_packet_gather_label: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(hub, receive_labels, send_labels, local_port)

    def send_spike(self, label: str, neuron_id: int, send_full_keys: bool = False) -> None:
        """Let a cell emit a spike in the next time step."""
        self.send_spikes(label, [neuron_id], send_full_keys)

    def send_spikes(self, label: str, neuron_ids: Iterable[int], send_full_keys: bool = False) -> None:
        """Let cells emit a spike in the next time step.

        Raises:
            NetworkError: the connection does not send to the population, or the population has no such cell.
        """
        self._require(label, self.send_labels)
        self._hub.sent.append((label, _cells(self._hub.injectors, label, neuron_ids)))


class RatesConnection(Connection):
    """sPyNNaker's ``SpynnakerPoissonControlConnection``."""

    sets_rates = True

    def __init__(
        self, hub: Hub, poisson_labels: Iterable[str] | None = None, local_host: Any = None,
        local_port: int | None = None, control_label_extension: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(hub, send_labels=poisson_labels, local_port=local_port)

    def add_poisson_label(self, label: str) -> None:
        """Control the rates of a further population."""
        self.add_send_label(label)

    def set_rate(self, label: str, neuron_id: int, rate: float) -> None:
        """Set the rate of a source cell (Hz) from the next time step on."""
        self.set_rates(label, [(neuron_id, rate)])

    def set_rates(self, label: str, neuron_id_rates: Iterable[tuple[int, float]]) -> None:
        """Set the rates of source cells, pairs of cell and Hz, from the next time step on.

        Raises:
            NetworkError: the connection does not control the population, or the population has no such cell.
        """
        self._require(label, self.send_labels)
        pairs = list(neuron_id_rates)
        cells = _cells(self._hub.controlled, label, [cell for cell, _ in pairs])
        self._hub.rates.append((label, cells, [float(rate) for _, rate in pairs]))


def _cells(known: dict[str, Any], label: str, given: Iterable[int]) -> list[int]:
    cells = [int(cell) for cell in np.atleast_1d(np.asarray(list(given), dtype=np.int64))]
    size = known[label].size if label in known else 0
    for cell in cells:
        if label in known and not 0 <= cell < size:
            raise NetworkError(f"population '{label}' has no cell {cell}; they are numbered 0..{size - 1}")
    return cells


def _require(label: str, known: dict[str, Any], remedy: str) -> None:
    if label not in known:
        hint = did_you_mean(label, known)
        raise NetworkError(f"a live connection names '{label}', which has no {remedy}{hint}")
