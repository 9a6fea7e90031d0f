"""A brain in a process of its own: another Python, other versions, or a simulator that is one to a process.

A backend that offers this derives its options from :class:`RemoteOptions` and begins its ``open`` with::

    python = options.elsewhere("NEST")
    if python is not None:
        return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)

A simulator that is one to a process is held as a :class:`Sole` of that name; the second brain then goes to
another process by itself. The Python that is named needs nrp-core and the backend installed. Both sides
advance in lockstep, with one message there and one back for each step of the loop. A process that dies, or
that neither answers nor computes for the option ``time_limit``, is one error.
"""

from nrp_core.brain.remote.brain import RemoteBrain, RemoteOptions
from nrp_core.brain.remote.sole import Sole

__all__ = ["RemoteBrain", "RemoteOptions", "Sole"]
