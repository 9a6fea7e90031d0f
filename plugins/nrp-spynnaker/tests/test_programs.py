"""Another program takes part in a run by sPyNNaker's database and the port of a board, as theirs do."""

from __future__ import annotations

import socket
import sqlite3
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any

import pytest
from golden import Golden
from nrp_spynnaker.dialect.connections import KEY_32_BIT, Hub, LiveInput, LiveOutput
from nrp_spynnaker.live import programs, run_script
from nrp_spynnaker.live.packets import Sockets

from nrp_core.errors import NetworkError

NETWORK = """
import pyNN.spiNNaker as p
p.setup(timestep=1.0)
keys = {{"virtual_key": {key}, "port": {injected}}} if {injected} else {{}}
injector = p.Population(3, p.external_devices.SpikeInjector(), label="injector", additional_parameters=keys)
others, cells = (p.Population(3, p.IF_curr_exp(tau_refrac=500.0), label=each) for each in ("others", "cells"))
p.Projection(injector, cells, p.OneToOneConnector(), p.StaticSynapse(weight=60.0, delay=2.0))
{more}
for heard in {heard}:
    p.external_devices.activate_live_output_for(heard, database_notify_port_num={port})
injector.record("spikes")
for _ in range({runs}):
    p.run({time_ms})
spikes = [train.magnitude.tolist() for train in injector.get_data().segments[0].spiketrains]
p.end()
"""
PATIENCE_S = 120.0
RUNS = 2
COMMAND = {"database": 0x4001, "stopped": 0x400A, "begins": 0x400B}


class Program:
    """A program that hears and sends spikes."""

    def __init__(self) -> None:
        self.notified, self.spikes = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        for each in (self.notified, self.spikes):
            each.settimeout(PATIENCE_S)
            each.bind(("127.0.0.1", 0))
        self.port = int(self.notified.getsockname()[1])
        self.heard: list[dict[int, tuple[str, int]]] = []
        self.said: list[bytes] = []
        self.commands: list[int] = []

    def take_part(self) -> None:
        """Send a spike of the last injected cell in each run, and hear what follows."""
        for _ in range(RUNS):
            message, toolchain = self.notified.recvfrom(999)
            database = sqlite3.connect(f"file:{message[2:].decode()}?mode=ro", uri=True)
            rows = database.execute("SELECT event, label, atom FROM label_event_atom_view")
            keys = {event: (label, atom) for event, label, atom in rows}
            tag, address = database.execute(
                "SELECT tag, board_address FROM app_output_tag_view "
                "WHERE pre_vertex_label = 'cells' AND post_vertex_label LIKE 'LiveSpikeReceiver%'"
            ).fetchone()
            x, y, core = database.execute(
                "SELECT x, y, p FROM application_vertex_placements WHERE vertex_label = 'injector'"
            ).fetchone()
            database.close()
            board = (address, 17893)
            set_tag = struct.pack("<HHIII", 26, 7, 1 << 30 | 1 << 28 | 1 << 16 | tag, 0, 0)
            for command in (struct.pack("<HHIII", 99, 7, 0, 0, 0), set_tag):
                self.spikes.sendto(bytes([0, 0, 0x87, 0xFF, 0, 0xFF, 0, 0, 0, 0]) + command, board)
                self.said.append(self.spikes.recv(999))
            self.notified.sendto(struct.pack("<H", COMMAND["database"]), toolchain)
            self.commands.append(int.from_bytes(self.notified.recv(999)[:2], "little"))
            header = bytes([0, 0, 0x07, 0xFF, 1 << 5 | core, 0xFF, y, x, 0, 0])
            self.spikes.sendto(header + struct.pack("<BBH", 1, 0, 2), board)
            count, _, time, key = struct.unpack("<BBII", self.spikes.recv(999))
            assert count == 1
            self.heard.append({time: keys[key]})
            self.commands.append(int.from_bytes(self.notified.recv(999)[:2], "little"))

    def close(self) -> None:
        self.notified.close()
        self.spikes.close()


@pytest.fixture
def program() -> Iterator[Program]:
    made = Program()
    yield made
    made.close()


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., Any]:
    """Run the network with some settings, and return its script."""

    def run(port: int, **settings: Any) -> Any:
        defaults = {
            "heard": "(others, cells)",
            "runs": 1,
            "time_ms": 60,
            "key": 0,
            "injected": None,
            "more": "",
        }
        (tmp_path / "script.py").write_text(NETWORK.format(port=port, **{**defaults, **settings}))
        return run_script(tmp_path / "script.py")

    return run


def test_a_connection_receives_and_sends_spikes_in_every_run(
    program: Program, run: Callable[..., Any]
) -> None:
    thread = Thread(target=program.take_part, daemon=True)
    thread.start()
    spikes = run(program.port, runs=RUNS, time_ms=600).spikes
    thread.join(PATIENCE_S)
    assert [len(train) for train in spikes] == [0, 0, RUNS]
    times = [step for heard in program.heard for step in heard]
    assert [heard[step] for heard, step in zip(program.heard, times, strict=True)] == [("cells", 2)] * RUNS
    assert times == pytest.approx([time + 3 for time in spikes[2]])  # 2 ms of delay, and 1 ms to fire
    assert program.commands == [COMMAND["begins"], COMMAND["stopped"]] * RUNS
    for refused, done in zip(program.said[::2], program.said[1::2], strict=True):
        assert len(done) == 18
        assert (done[2], done[4]) == (0x07, 0xFF)
        assert struct.unpack_from("<HH", done, 10) == (0x80, 7)
        assert struct.unpack_from("<H", refused, 10) == (0x83,)


def test_without_a_program_the_network_runs_as_fast_as_it_can(
    program: Program, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    program.close()
    monkeypatch.setattr("nrp_spynnaker.live.state._Pace", None)  # which would fail
    assert run(program.port, time_ms=20_000).spikes == [[], [], []]


def test_a_program_that_does_not_confirm_is_named(
    program: Program, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setattr(programs, "_PATIENCE_S", 0.1)
    with golden.raises(NetworkError, match=f"UDP.*{program.port}"):
        run(program.port)


@pytest.mark.parametrize("event", ["start", "receive"])
def test_a_connection_learns_that_the_run_has_stopped_if_a_callback_raises(
    program: Program, run: Callable[..., Any], event: str
) -> None:
    fails = f"""
live = p.external_devices.SpynnakerLiveSpikesConnection(["cells"], ["injector"], local_port=1)
live.add_{event}_callback("cells", lambda *_: [][0])
live.add_start_resume_callback("injector", lambda label, sender: sender.send_spike(label, 0))
"""

    def confirm() -> None:
        _, toolchain = program.notified.recvfrom(999)
        program.notified.sendto(struct.pack("<H", COMMAND["database"]), toolchain)
        program.commands += [int.from_bytes(program.notified.recv(999)[:2], "little") for _ in range(2)]

    thread = Thread(target=confirm, daemon=True)
    program.notified.settimeout(PATIENCE_S)
    thread.start()
    with pytest.raises(IndexError):
        run(program.port, more=fails)
    thread.join(PATIENCE_S)
    assert program.commands == [COMMAND["begins"], COMMAND["stopped"]]


def test_a_port_is_given_back_if_the_database_cannot_be_written(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(**_: Any) -> None:
        raise OSError(28, "No space left on device")

    port = program.port
    program.close()
    cells = SimpleNamespace(size=3)
    hub = Hub(injectors={"injector": cells}, inputs={"injector": LiveInput(port, 0)}, notified={port})
    monkeypatch.setattr(programs, "TemporaryDirectory", full)
    with pytest.raises(OSError, match="No space") as raised:
        Sockets(hub)
    assert raised.tb  # the frames keep the sockets, which would be closed with them
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", port))


def test_a_population_of_many_cells_has_keys_of_its_own(program: Program) -> None:
    heard = {"many": SimpleNamespace(size=70_000), "cells": SimpleNamespace(size=3)}
    outputs = {"cells": LiveOutput("localhost", program.port, KEY_32_BIT)}
    sockets = Sockets(Hub(live_outputs=heard, outputs=outputs))
    sockets.send("cells", 7, [1])
    sockets.close()
    assert program.notified.recv(999)[-4:] == struct.pack("<I", 0x20001)


def test_keys_that_two_populations_have_are_refused(
    program: Program, run: Callable[..., Any], golden: Golden
) -> None:
    with golden.raises(NetworkError, match="'injector'.*'others'.*0x2"):
        run(program.port, heard="(others, injector)", key=2, injected=program.port)


def test_a_port_that_cannot_be_one_is_refused(run: Callable[..., Any], golden: Golden) -> None:
    with golden.raises(NetworkError):
        run(0)
