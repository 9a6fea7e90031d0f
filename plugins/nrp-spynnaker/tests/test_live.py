"""Live input and output of scripts of sPyNNaker, and runs that are stopped from elsewhere."""

import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_spynnaker.live.clock import stops_elsewhere
from spynnaker_scripts import HEAD, run


def trains(population: Any) -> list[list[float]]:
    return [train.magnitude.tolist() for train in population.get_data("spikes").segments[0].spiketrains]


LIVE = (
    HEAD
    + """
import random
from time import sleep
heard, order = [], []
random.seed(3)
def send(label, sender):
    for cell in (0, 1):
        sleep(random.choice([0.03, 0.05]))
        sender.send_spike(label, cell, send_full_keys=True)
def answer(label, time, cells):
    heard.append((label, time, cells))
    if label == "cells":
        connection.send_spikes("echo", cells)
connection = p.external_devices.SpynnakerLiveSpikesConnection(
    receive_labels=["cells", "answers"], send_labels=["injector", "echo"], local_port=19996)
injector = p.Population(2, p.external_devices.SpikeInjector(notify=True), label="injector")
echo = p.Population(2, p.external_devices.SpikeInjector, label="echo")
cells, answers = (
    p.Population(2, p.IF_curr_exp(tau_refrac=250.0), label=label) for label in ("cells", "answers"))
for source, target in ((injector, cells), (echo, answers)):
    p.Projection(source, target, p.OneToOneConnector(), p.StaticSynapse(weight=60.0, delay=2.0))
    p.external_devices.activate_live_output_for(
        target, port=12346, message_type=p.external_devices.EIEIOType.KEY_32_BIT)
injector.record("spikes")
connection.add_init_callback("injector", lambda label, n, t_ms, dt_ms: order.append(("init", n, t_ms, dt_ms)))
connection.add_start_callback("injector", send)
connection.add_start_resume_callback("injector", lambda label, sender: order.append("resume"))
connection.add_pause_stop_callback("injector", lambda label, sender: order.append("stop"))
for label in ("cells", "answers"):
    connection.add_receive_callback(label, answer)
p.run(60)
p.run(140)
"""
)


def test_callbacks_send_and_hear_spikes_in_simulated_time(tmp_path: Path) -> None:
    script = run(tmp_path, LIVE)
    sent = [times[0] for times in trains(script.injector)]
    slept = [round(1000 * each) for each in _sleeps()]
    assert sent == pytest.approx([slept[0], slept[0] + slept[1]])
    # to a cell: a delay of two steps, and the step of its update; its echo goes out in the next step
    expected = [event for cell, at in enumerate(np.round(sent).astype(int).tolist())
                for event in (("cells", at + 3, [cell]), ("answers", at + 6, [cell]))]  # fmt: skip
    assert sorted(script.heard, key=lambda event: event[1]) == expected
    assert not script.p.network().remarks
    assert script.order == [("init", 2, 60.0, 1.0), "resume", "stop", "resume", "stop"]


def _sleeps() -> list[float]:
    import random

    generator = random.Random(3)
    return [generator.choice([0.03, 0.05]) for _ in range(2)]


def test_threads_that_a_callback_starts_send_in_simulated_time(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD
        + """
import threading
from time import sleep
def work(label, sender):
    for _ in range(3):
        sleep(0.1)
        sender.send_spike(label, 0)
def send(label, sender):
    threading.Thread(target=work, args=(label, sender)).start()
injector = p.Population(1, p.external_devices.SpikeInjector(), label="injector")
injector.record("spikes")
connection = p.external_devices.SpynnakerLiveSpikesConnection(send_labels=["injector"])
connection.add_start_resume_callback("injector", send)
p.run(500)
""",
    )
    assert trains(script.injector) == [[100.0, 200.0, 300.0]]


def test_a_thread_that_the_script_itself_starts_sleeps_in_real_time(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "import threading, time\nended = []\n"
        "thread = threading.Thread(target=lambda: (time.sleep(0.1), ended.append(time.monotonic())))\n"
        "cells = p.Population(1, p.IF_curr_exp())\n"
        "began = time.monotonic()\nthread.start()\np.run(1)\nthread.join()\n",
    )
    assert script.ended[0] - script.began >= 0.099


UDP = (
    "import socket, struct\n"
    + HEAD
    + """
sender, viewer, free = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3))
viewer.bind(("127.0.0.1", 0))
viewer.settimeout(60)
free.bind(("127.0.0.1", 0))
port = free.getsockname()[1]
free.close()
injector = p.Population(3, p.external_devices.SpikeInjector(), label="injector", additional_parameters={
    "port": port, "virtual_key": 0x70000})
cells, others = (
    p.Population(3, p.IF_curr_exp(tau_refrac=50.0), label=label) for label in ("cells", "others"))
for target in (cells, others):
    p.Projection(injector, target, p.OneToOneConnector(), p.StaticSynapse(weight=60.0, delay=2.0))
    p.external_devices.activate_live_output_for(target, port=viewer.getsockname()[1])
injector.record("spikes")
"""
)


def test_other_programs_send_and_hear_spikes_over_udp(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        UDP + "p.run(5)\n"
        "for data in (struct.pack('<BBII', 2, 0x08, 0x70000, 0x70002), struct.pack('<BBH', 1, 0x00, 1),\n"
        "             struct.pack('<BBI', 1, 0x08, 0x70003), b'?'):\n"
        "    sender.sendto(data, ('127.0.0.1', port))\n"
        "p.run(10)\nheard = [viewer.recv(999) for _ in range(2)]\nend = p.end()\n"
        "free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)\nfree.bind(('127.0.0.1', port))\n"
        "for each in (sender, viewer, free):\n    each.close()\n",
    )
    sent = 0x38  # a time for all keys, which have 32 bits
    assert script.heard == [
        struct.pack("<BBIIII", 3, sent, 8, first, first + 1, first + 2) for first in (0, 1 << 16)
    ]


def test_a_network_that_receives_spikes_from_programs_runs_in_real_time(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        UDP + "import time\np.run(1)\nbegan = time.monotonic()\np.run(150)\nt = time.monotonic() - began\n"
        "for each in (sender, viewer):\n    each.close()\n",
    )
    assert script.t > 0.149


def test_rates_of_poisson_sources_are_set_while_the_network_runs(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD
        + "cells = p.Population(3, p.SpikeSourcePoisson(rate=0.0), label='noise')\ncells.record('spikes')\n"
        "p.external_devices.add_poisson_live_rate_control(cells)\n"
        "control = p.external_devices.SpynnakerPoissonControlConnection(poisson_labels=['noise'])\n"
        "rates = [(1, 400), (2, 200)]\naddress = control.local_ip_address, control.local_port, None\n"
        "p.external_devices.add_database_socket_address(*address)\n"
        "control.add_start_resume_callback('noise', lambda label, c: c.set_rates(label, rates))\n"
        "p.run(2000)\n",
    )
    counts = [len(train) for train in trains(script.cells)]
    assert counts[0] == 0
    assert counts[1:] == pytest.approx([800, 400], abs=6 * 800**0.5)


@pytest.mark.parametrize("label", ["noise", "others"])
def test_a_connection_of_an_ended_network_serves_a_later_one_that_has_its_labels(
    tmp_path: Path, label: str
) -> None:
    """The tests of a file of sPyNNaker, such as ``test_poisson_spike_source.py``, run one after the other."""
    script = run(
        tmp_path,
        "import pyNN.spiNNaker as p\n"
        "control = p.external_devices.SpynnakerPoissonControlConnection(poisson_labels=['noise'])\n"
        "control.add_start_resume_callback('noise', lambda label, c: c.set_rates(label, [(0, 500)]))\n"
        "counts = []\n"
        f"for label in ('noise', '{label}'):\n"
        "    p.setup(1.0)\n    cells = p.Population(1, p.SpikeSourcePoisson(rate=0.0), label=label)\n"
        "    cells.record('spikes')\n    p.external_devices.add_poisson_live_rate_control(cells)\n"
        "    p.run(200)\n    counts.append(len(cells.get_data().segments[0].spiketrains[0]))\n    p.end()\n",
    )
    assert script.counts[0] > 0
    assert (script.counts[1] > 0) == (label == "noise")


def test_a_network_runs_beside_its_script_until_it_is_stopped(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "import time\ncells = p.Population(1, p.IF_curr_exp(i_offset=1.0))\ncells.record('spikes')\n"
        "began = time.monotonic()\np.external_devices.run_forever()\n"
        "while p.get_current_time() < 100.0:\n    time.sleep(0.01)\n"
        "p.external_devices.request_stop()\nlasted_ms = 1e3 * (time.monotonic() - began)\n"
        "t, n = p.get_current_time(), len(cells.get_data().segments[0].spiketrains[0])\n",
    )
    assert 100.0 <= script.t <= script.lasted_ms + 1.0  # the step that is done ahead
    assert script.n == pytest.approx(script.t / 28.5, abs=2.5)  # 20 ms ln(20 / 5) and the refractory step


@pytest.mark.parametrize(
    "last", ["p.external_devices.request_stop()\nthread.join()", "p.end()\nthread.join()"]
)
def test_a_thread_of_the_script_that_runs_forever_waits_for_the_end(tmp_path: Path, last: str) -> None:
    script = run(
        tmp_path,
        HEAD
        + f"""
from threading import Thread
from time import sleep
times, ended = [], []
sent = False
def work(label, sender):
    global sent
    for _ in range(3):
        sleep(0.01)
        sender.send_spike(label, 0)
    sleep(0.01)
    sent = True
def wait():
    p.external_devices.run_forever()
    ended.append(sent)
injector = p.Population(1, p.external_devices.SpikeInjector(), label="in")
p.external_devices.activate_live_output_for(injector)
connection = p.external_devices.SpynnakerLiveSpikesConnection(send_labels=["in"], receive_labels=["in"])
connection.add_start_callback("in", work)
connection.add_receive_callback("in", lambda label, time, ids: times.append(time))
thread = Thread(target=wait)
thread.start()
while not sent and not ended:
    sleep(0.01)
{last}
""",
    )
    assert script.ended == [True]
    assert len(script.times) == 3


@pytest.mark.parametrize("stop", ["p.external_devices.request_stop()", "stop()"])
def test_a_run_that_a_callback_stops_returns_when_it_is_stopped(tmp_path: Path, stop: str) -> None:
    script = run(
        tmp_path,
        HEAD
        + f"""
from time import sleep
def stop():
    p.external_devices.request_stop()
def work(label, sender):
    sleep(0.03)
    sender.send_spike(label, 0)
    sleep(0.03)
    {stop}
injector = p.Population(1, p.external_devices.SpikeInjector(), label="in")
injector.record("spikes")
connection = p.external_devices.SpynnakerLiveSpikesConnection(send_labels=["in"])
connection.add_start_resume_callback("in", work)
ends = []
for _ in range(2):
    p.external_devices.run_forever()
    ends.append((p.get_current_time(), len(injector.get_data().segments[0].spiketrains[0])))
""",
    )
    assert [n for _, n in script.ends] == [1, 2]
    assert script.ends[0][0] >= 60.0
    assert script.ends[1][0] >= script.ends[0][0] + 60.0


def test_a_run_that_nothing_in_the_script_stops_goes_on_until_ctrl_c(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        HEAD
        + """
import os, signal
from time import sleep
def hear(label, time, ids):
    print("heard", time)
    if time == 300:
        os.kill(os.getpid(), signal.SIGINT)
        sleep(0.02)  # in a callback, it does not tell that the script goes on
source = p.Population(1, p.SpikeSourceArray([200.0, 300.0]), label="source")
source.record("spikes")
p.external_devices.activate_live_output_for(source)
connection = p.external_devices.SpynnakerLiveSpikesConnection(receive_labels=["source"])
connection.add_receive_callback("source", hear)
p.external_devices.run_forever()
print(source.get_data().segments[0].spiketrains[0].magnitude[:1], p.get_current_time() >= 300.0)
"""
    )
    command = [sys.executable, "-m", "nrp_core.pynn", "--as", "spinnaker", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout == "heard 200\nheard 300\n[200.] True\n", done.stderr
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("lines", "waits"),
    [
        ("run_forever()", True),
        ("def main():\n    run_forever()\nmain()", True),
        ("run_forever()\nrequest_stop()", False),
        ("run_forever()\ninput()\nend()", False),
        ("def main():\n    run_forever()\n    sleep(1)\nmain()", False),
        ("def send():\n    sleep(1)\nrun_forever()", True),
        ("def stop():\n    request_stop()\nrun_forever()\nsleep(1)", True),
        ("run(10)", False),
    ],
)
def test_a_script_shows_whether_it_waits_for_the_end_of_its_run(lines: str, waits: bool) -> None:
    assert stops_elsewhere(lines.encode()) is waits
