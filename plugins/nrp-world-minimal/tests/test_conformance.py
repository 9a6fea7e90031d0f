"""The whole conformance test: three lines."""

from nrp_world_minimal import MinimalBackend

from nrp_core.conformance import WorldBackendTests


class TestMinimal(WorldBackendTests):
    @classmethod
    def make_backend(cls) -> MinimalBackend:
        return MinimalBackend()
