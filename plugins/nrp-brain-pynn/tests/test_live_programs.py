"""A connection of sPyNNaker, outside the script, takes part in a network that nrp-core runs."""

from threading import Event

import pytest
from nrp_spynnaker.live import run_script

NETWORK = """
import pyNN.spiNNaker as p
p.setup(timestep=1.0)
injector = p.Population(3, p.external_devices.SpikeInjector(), label="injector")
cells = p.Population(3, p.IF_curr_exp(tau_refrac=500.0), label="cells")
p.Projection(injector, cells, p.OneToOneConnector(), p.StaticSynapse(weight=60.0, delay=2.0))
p.external_devices.activate_live_output_for(cells, database_notify_port_num={port})
injector.record("spikes")
p.run(1000)
spikes = [train.magnitude.tolist() for train in injector.get_data().segments[0].spiketrains]
p.end()
"""


@pytest.mark.simulator("spinnaker")
def test_the_connection_of_spynnaker_sends_and_receives_spikes(tmp_path):
    from spynnaker.pyNN.connections import SpynnakerLiveSpikesConnection

    connection = SpynnakerLiveSpikesConnection(["cells"], ["injector"], local_port=None)
    heard, sizes, stopped = [], [], Event()
    connection.add_init_callback("cells", lambda *given: sizes.append(given))
    connection.add_start_resume_callback("injector", lambda label, to: to.send_spikes(label, [0, 2], True))
    connection.add_receive_callback("cells", lambda label, step, cells: heard.append((step, list(cells))))
    connection.add_pause_stop_callback("cells", lambda *_: stopped.set())
    (tmp_path / "script.py").write_text(NETWORK.format(port=connection.local_port))
    script = run_script(tmp_path / "script.py")
    assert stopped.wait(60.0)
    connection.close()
    (first,), none, (third,) = script.spikes
    assert (none, first) == ([], third)
    assert sizes == [("cells", 3, 1000.0, 1.0)]
    assert heard == [(pytest.approx(first + 3), [0, 2])]
