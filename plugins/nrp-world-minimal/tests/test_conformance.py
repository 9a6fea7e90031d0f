"""The whole conformance test: three lines."""

from nrp_conformance import WorldBackendTests
from nrp_world_minimal import MinimalBackend


class TestMinimal(WorldBackendTests):
    @classmethod
    def make_backend(cls) -> MinimalBackend:
        return MinimalBackend()
