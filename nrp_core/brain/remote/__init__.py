"""A brain in its own process: for another Python, other versions, or a simulator that allows one brain only.

A backend that supports this derives its options from :class:`RemoteOptions` and begins its ``open`` with::

    python = options.elsewhere("NEST")
    if python is not None:
        return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)

A simulator that can run once in a process is guarded by a :class:`ProcessLock` of its name; a second brain
then automatically runs in another process. The named Python needs nrp-core and the backend installed. Both
sides advance in lockstep, with one request and one reply for each step of the loop. If the process dies, or
neither answers nor computes for the option ``time_limit``, one error is raised. The process of a closed brain
is reused for the next one.
"""

from nrp_core.brain.remote.brain import RemoteBrain, RemoteOptions
from nrp_core.brain.remote.process import ProcessLock

__all__ = ["ProcessLock", "RemoteBrain", "RemoteOptions"]
