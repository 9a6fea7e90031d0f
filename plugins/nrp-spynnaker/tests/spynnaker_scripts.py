"""Scripts of sPyNNaker, run and read in tests."""

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from nrp_brain_spinnaker import SpinnakerOptions
from nrp_spynnaker.live import run_script

from nrp_core.errors import NrpError

HEAD = "import pyNN.spiNNaker as p\np.setup(timestep=1.0, min_delay=1.0, n_chips_required=1)\n"


def run(folder: Path, script: str) -> ModuleType:
    path = folder / "script.py"
    path.write_text(script)
    return run_script(path)


def refused(folder: Path, line: str) -> NrpError:
    names = "cell, live = p.IF_curr_exp(), p.external_devices.SpynnakerLiveSpikesConnection\n"
    with pytest.raises(NrpError) as caught:
        run(folder, f"{HEAD}{names}{line}")
    assert "script.py:4" in str(caught.value)
    return caught.value


def mapped(network: Any) -> Any:
    from nrp_brain_spinnaker.loader import lay_out
    from nrp_brain_spinnaker.mapping.plan import map_network

    cells, wires, _ = lay_out(network, SpinnakerOptions())
    return map_network(network, cells, wires, SpinnakerOptions()).vertices
