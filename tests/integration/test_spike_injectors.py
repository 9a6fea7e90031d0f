"""A script is warned of an injector that receives no spikes."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_spynnaker.live import run_script


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("", True),
        ("sim.external_devices.SpynnakerLiveSpikesConnection(send_labels=['b'])\n", False),
    ],
)
def test_an_injector_without_a_sender_is_reported(
    more: str, says: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import pyNN.spiNNaker as sim\nsim.setup(timestep=1.0)\n"
        "b = sim.Population(3, sim.external_devices.SpikeInjector(), label='b')\n"
        "cells = sim.Population(3, sim.IF_curr_exp(), label='cells')\n"
        "sim.Projection(b, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=5.0, delay=1.0))\n"
        f"{more}sim.run(10.0)\nsim.end()\n"
    )
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        run_script(script)
    warning = "no spike was sent into 'b': it has no port, and no connection has it in send_labels"
    assert [text for text in caplog.messages if "'b'" in text] == ([warning] if says else [])
