"""Experiments as environments of Gymnasium. Importing this module registers the shipped ones.

::

    import gymnasium
    import nrp_lab.gym

    env = gymnasium.make("nrp/SlalomPioneer-v0")

The names are imported lazily; to use environments by id, ``import nrp_lab.gym`` is enough.
"""

from nrp_core.utilities import require_extra

require_extra("gymnasium", "nrp-lab[gym]", "nrp_lab.gym")

from nrp_lab.gym.agent_run import Reward, Terminate  # noqa: E402
from nrp_lab.gym.env import (  # noqa: E402
    NrpEnv,
    make_env,
    register_shipped,
)
from nrp_lab.gym.vector import NrpVectorEnv  # noqa: E402
from nrp_lab.gym.vector_processes import NrpProcessesEnv, make_vec  # noqa: E402

__all__ = ["NrpEnv", "NrpProcessesEnv", "NrpVectorEnv", "Reward", "Terminate", "make_env", "make_vec"]

register_shipped()
