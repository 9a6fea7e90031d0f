"""Scripts of Brian2 as brains of nrp-core."""

from nrp_brain_brian2.backend import Brian2Backend

__all__ = ["Brian2Backend"]
