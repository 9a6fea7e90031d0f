"""The whole conformance test: three lines."""

from nrp_brain_minimal import MinimalBackend
from nrp_conformance import BrainBackendTests


class TestMinimal(BrainBackendTests):
    @classmethod
    def make_backend(cls) -> MinimalBackend:
        return MinimalBackend()
