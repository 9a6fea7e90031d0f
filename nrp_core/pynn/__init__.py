"""A PyNN simulator: ``import nrp_core.pynn as sim``.

It implements PyNN's simulator interface and runs the network in any installed brain backend::

    import nrp_core.pynn as sim

    sim.setup(timestep=0.1, backend="event")
    cells = sim.Population(10, sim.IF_cond_exp(i_offset=0.6))
    cells.record(["spikes", "v"])
    sim.run(100.0)
    spiketrains = cells.get_data().segments[0].spiketrains

Beyond PyNN, ``setup`` takes ``backend`` (its name), ``options`` (of the backend) and ``seed``, and
``network()`` returns the network as a :class:`~nrp_core.network.data.Network`. In a brain script
of an experiment the same import gives a simulator that only builds: there the experiment runs the network.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_core.network.pynn.api import programming_interface
from nrp_core.network.pynn.simulator import Simulator
from nrp_core.pynn.recorder import Recorder
from nrp_core.pynn.running import RunningState, control


def new_simulator(state: RunningState | None = None, recorder: type = Recorder) -> ModuleType:
    """Return a further simulator, independent of this module and of all others.

    Args:
        state: where its network runs, by default a new state.
        recorder: the class that stores the recordings of populations.
    """
    state = state or RunningState()
    api = programming_interface(Simulator(state), recorder)
    vars(api).update(control(api, state))
    return api


_api = new_simulator()
globals().update({name: value for name, value in vars(_api).items() if not name.startswith("__")})


def __getattr__(name: str) -> Any:
    """Suggest the name that was probably meant."""
    return getattr(_api, name)
