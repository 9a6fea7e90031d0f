"""A brain that consists of brains: the populations of one network on several backends."""

from nrp_brain_composite.backend import CompositeBackend

__all__ = ["CompositeBackend"]
