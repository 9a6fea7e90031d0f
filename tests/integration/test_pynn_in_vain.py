"""A script is told what it sets in vain: overwritten before a run, after the last run, or too late."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from nrp_spynnaker.live import run_script

from nrp_core.pynn import new_simulator

SCRIPT = """
noise = sim.Population(4, sim.SpikeSourcePoisson(rate=50.0), label="noise")
kind = sim.IF_curr_exp()
cells = sim.Population(4, kind, label="cells")
wires = sim.Projection(noise, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1), label="w")
"""

IN_VAIN = {
    "cells.set(i_offset=0.1); cells.set(i_offset=0.2); sim.run(5.0)": "i_offset of 'cells' is set twice",
    "cells[:2].set(cm=0.5); cells[:3].set(cm=0.7); sim.run(5.0)": "cm of 'cells' is set twice",
    "sim.run(5.0); cells.set(i_offset=0.1); cells.set(i_offset=0.2); sim.run(5.0)": "is set twice",
    "wires.set(weight=0.2); wires.set(weight=0.3); sim.run(5.0)": "weight of 'w' is set twice",
    "sim.run(5.0); wires.set(weight=0.2)": "weight of 'w' is set after the last run",
    "sim.run(5.0); cells.set(i_offset=0.2)": "i_offset of 'cells' is set after the last run",
    "sim.run(5.0); sim.DCSource(amplitude=1.0, start=1.0, stop=4.0).inject_into(cells); sim.run(5.0)":
        "a DCSource from 1 to 4 ms never had an effect: it is injected at 5 ms",
    "sim.StepCurrentSource(times=[8.0], amplitudes=[1.0]).inject_into(cells); sim.run(5.0)":
        "a StepCurrentSource from 8 ms never had an effect",
}  # fmt: skip

RIGHT = [
    "cells.set(i_offset=0.1); cells[0:1].set(i_offset=0.2); sim.run(5.0)",
    "cells.set(i_offset=0.1)\nfor i, cell in enumerate(cells): cell.i_offset = 0.2 + i\nsim.run(5.0)",
    "cells.set(i_offset=0.1); cells.set(i_offset=0.1); sim.run(5.0)",
    "cells.set(i_offset=0.1); cells.set(cm=0.2); sim.run(5.0)",
    "cells.set(i_offset=0.1); cells.set(i_offset=2 * cells.get('i_offset')); sim.run(5.0)",
    "wires.set(weight=0.1); wires.set(weight=2 * wires.get('weight', 'array')); sim.run(5.0)",
    "for i in range(3): sim.run(5.0); wires.set(weight=wires.get('weight', 'array') + 0.01)",
    "for i in range(3): cells.set(i_offset=0.1 * i); sim.run(5.0); sim.reset()",
    "cells.set(i_offset=0.2); sim.run(5.0); cells.set(i_offset=0.0)",
    "sim.run(5.0); sim.DCSource(amplitude=1.0, start=6.0).inject_into(cells); sim.run(5.0)",
    "sim.run(5.0); sim.StepCurrentSource(times=[2.0], amplitudes=[1.0]).inject_into(cells); sim.run(5.0)",
    "sim.NoisyCurrentSource(mean=0.0, stdev=0.1).inject_into(cells); sim.run(5.0)",
    "kind.parameter_space['cm'] = 3.0; sim.Population(4, kind, label='more'); sim.run(5.0)",
    "sim.run(5.0); print(cells.get('cm'), wires.get('weight', 'list'))",
]


def told(tail: str, caplog: pytest.LogCaptureFixture) -> list[str]:
    sim: Any = new_simulator()
    sim.setup(timestep=0.1)
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        exec(SCRIPT + tail, {"sim": sim})
        sim.end()
    return [one.getMessage() for one in caplog.records]


@pytest.mark.parametrize("tail", IN_VAIN)
def test_what_is_set_in_vain_is_told(tail: str, caplog: pytest.LogCaptureFixture) -> None:
    (text,) = told(tail, caplog)
    assert IN_VAIN[tail] in text


@pytest.mark.parametrize("tail", RIGHT)
def test_what_has_an_effect_is_not_doubted(tail: str, caplog: pytest.LogCaptureFixture) -> None:
    assert told(tail, caplog) == []


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("", True),
        ("sim.external_devices.SpynnakerLiveSpikesConnection(send_labels=['b'])\n", False),
    ],
)
def test_an_injector_into_which_nobody_sends_is_told(
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
    doubt = "no spike was sent into 'b': it has no port, and no connection has it in send_labels"
    assert [text for text in caplog.messages if "'b'" in text] == ([doubt] if says else [])


def test_a_script_is_told_of_calls_without_parentheses(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "script.py"
    path.write_text(
        "import pyNN.spiNNaker as sim\nsim.setup(1.0)\n"
        f"{SCRIPT}try:\n    sim.nothing\nexcept AttributeError:\n    pass\nsim.run(2.0)\nsim.end\n"
    )
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        run_script(path)
    (told,) = [one.getMessage() for one in caplog.records if "alone" in one.getMessage()]
    assert told == "line 13: 'sim.end' alone has no effect: it is not called, assigned or returned"
