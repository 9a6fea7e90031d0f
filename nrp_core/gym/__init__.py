"""Experiments as environments of Gymnasium. Importing this module registers the shipped ones.

::

    import gymnasium
    import nrp_core.gym

    env = gymnasium.make("nrp/SlalomPioneer-v0")

The names are imported lazily; to use environments by id, ``import nrp_core.gym`` is enough.
"""

from nrp_core._support.extras import require_extra

require_extra("gymnasium", "gym", "nrp_core.gym")

from nrp_core.gym.agent_run import Reward, Terminate  # noqa: E402
from nrp_core.gym.env import NrpEnv, make_env  # noqa: E402
from nrp_core.gym.registered import register_shipped  # noqa: E402
from nrp_core.gym.vector import NrpVectorEnv  # noqa: E402
from nrp_core.gym.vector_processes import NrpProcessesEnv, make_vec  # noqa: E402

__all__ = ["NrpEnv", "NrpProcessesEnv", "NrpVectorEnv", "Reward", "Terminate", "make_env", "make_vec"]

register_shipped()
